// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "example_map.h"
#include "temporary_folder.h"

#include <facetloc/io/map_database.h>

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <string>

namespace facetloc::test {

/** \brief Does to a map file what another program might. */
inline void sql(const std::filesystem::path& path, const std::string& statement) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  char* message = nullptr;
  sqlite3_exec(db, statement.c_str(), nullptr, nullptr, &message);
  EXPECT_STREQ(message, nullptr);
  sqlite3_free(message);
  sqlite3_close(db);
}

/** \brief The same against the CHECKs of the tables. */
inline void vandalize(const std::filesystem::path& path, const std::string& statement) {
  sql(path, "PRAGMA ignore_check_constraints = ON; PRAGMA foreign_keys = OFF; " + statement);
}

inline void expectEqual(const Segment& a, const Segment& b) {
  EXPECT_EQ(a.t, b.t);
  EXPECT_LT((a.R - b.R).cwiseAbs().maxCoeff(), 2e-15);
  EXPECT_LT((b.R.transpose() * b.R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 2e-15);
  EXPECT_EQ(a.Sigma_q, b.Sigma_q);
  EXPECT_EQ(a.lambda, b.lambda);
  EXPECT_EQ(a.num_points, b.num_points);
  ASSERT_EQ(a.hull.size, b.hull.size);
  for (int i = 0; i < a.hull.size; ++i) EXPECT_EQ(a.hull.vertex[i], b.hull.vertex[i]);
}

inline void expectEqual(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  EXPECT_EQ(a.translation(), b.translation());
  EXPECT_LT((a.linear() - b.linear()).cwiseAbs().maxCoeff(), 2e-15);
}

inline void expectEqual(const LocalModel& a, const LocalModel& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.stamp, b.stamp);
  ASSERT_EQ(a.givenPose().has_value(), b.givenPose().has_value());
  if (a.givenPose()) expectEqual(*a.T_w_m, *b.T_w_m);
  EXPECT_EQ(a.view.intrinsics, b.view.intrinsics);
  ASSERT_EQ(a.view.segments.size(), b.view.segments.size());
  for (std::size_t i = 0; i < a.view.segments.size(); ++i)
    expectEqual(a.view.segments[i], b.view.segments[i]);
  EXPECT_EQ(a.view.depth.camera, b.view.depth.camera);
  EXPECT_EQ(a.view.depth.inverse_depth, b.view.depth.inverse_depth);
  EXPECT_EQ(a.view.depth.lowest, b.view.depth.lowest);
  if (!a.view.depth.empty()) {
    EXPECT_EQ(a.view.depth.noise.inverse_depth_std, b.view.depth.noise.inverse_depth_std);
    EXPECT_EQ(a.view.depth.noise.depth_std, b.view.depth.noise.depth_std);
    EXPECT_EQ(a.view.depth.noise.depth_std_slope, b.view.depth.noise.depth_std_slope);
  }
}

/** \brief A map file that each test writes and reads. */
class MapFile : public testing::Test {
protected:
  std::string readError() const {
    return ioErrorOf([this] { readMap(path_); });
  }
  void writeExample(int models = 3) const { writeMap(path_, ExampleMap().map(models)); }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "room.flmap";
};

}  // namespace facetloc::test
