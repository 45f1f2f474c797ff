// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "example_map.h"
#include "sql.h"
#include "temporary_folder.h"

#include <facetloc/io/map_database.h>
#include <facetloc/testing/changed_views.h>

namespace facetloc::test {

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

inline void expectEqual(const View& a, const View& b) {
  EXPECT_EQ(a.intrinsics, b.intrinsics);
  ASSERT_EQ(a.segments.size(), b.segments.size());
  for (std::size_t i = 0; i < a.segments.size(); ++i) expectEqual(a.segments[i], b.segments[i]);
  EXPECT_EQ(a.depth.camera, b.depth.camera);
  EXPECT_EQ(a.depth.inverse_depth, b.depth.inverse_depth);
  EXPECT_TRUE(a.depth.extremes == b.depth.extremes);
  if (!a.depth.empty()) {
    EXPECT_EQ(a.depth.noise.inverse_depth_std, b.depth.noise.inverse_depth_std);
    EXPECT_EQ(a.depth.noise.depth_std, b.depth.noise.depth_std);
    EXPECT_EQ(a.depth.noise.depth_std_slope, b.depth.noise.depth_std_slope);
  }
}

/** \brief The local models of two maps, with their views. */
inline void expectEqualModels(const Map& a, const Map& b) {
  ASSERT_EQ(a.models.size(), b.models.size());
  for (std::size_t i = 0; i < a.models.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(a.models[i].name, b.models[i].name);
    EXPECT_EQ(a.models[i].stamp, b.models[i].stamp);
    const auto of_a = a.models[i].givenPose(), of_b = b.models[i].givenPose();
    ASSERT_EQ(of_a.has_value(), of_b.has_value());
    if (of_a) expectEqual(*of_a, *of_b);
    EXPECT_EQ(a.models[i].hasPicture(), b.models[i].hasPicture());
    expectEqual(*a.view(static_cast<int>(i)), *b.view(static_cast<int>(i)));
  }
}

/** \brief A map file that each test writes and reads. */
class MapFile : public InAFolder {
protected:
  std::string readError() const {
    return ioErrorOf([this] { readMap(path_); });
  }
  void writeExample(int models = 3) const { writeMap(path_, ExampleMap().map(models)); }

  std::filesystem::path path_ = folder_ / "room.flmap";
};

}  // namespace facetloc::test
