// SPDX-License-Identifier: BSD-3-Clause
#include "example_map.h"
#include "temporary_folder.h"

#include <facetloc/features/segment_frame.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/testing/changed_views.h>

#include <Eigen/LU>
#include <pcl/io/pcd_io.h>

#include <sstream>

namespace facetloc::test {
namespace {

std::vector<std::string> linesOf(const fs::path& path, const std::string& beginning) {
  std::istringstream in(bytesOf(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);)
    if (line.rfind(beginning, 0) == 0) lines.push_back(line);
  return lines;
}

using MapExport = InAFolder;

TEST_F(MapExport, SegmentsBecomeClouds) {
  const Map map = ExampleMap().map(3);
  exportMap(map, folder_ / "out/put");
  pcl::PointCloud<SegmentFrame> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile((folder_ / "out/put/models/frame_1.pcd").string(), cloud), 0);
  ASSERT_EQ(cloud.size(), map.view(1)->segments.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Segment segment;
    ASSERT_TRUE(toSegment(cloud[i], segment));
    EXPECT_TRUE(segment.t.isApprox(map.view(1)->segments[i].t, 1e-6));
    EXPECT_TRUE(segment.R.isApprox(map.view(1)->segments[i].R, 1e-6));
    EXPECT_EQ(segment.num_points, 1234);
  }
}

TEST_F(MapExport, PosesBecomeATrajectory) {
  Map map = ExampleMap().map(3);
  map.models[1].T_w_m.reset();
  exportMap(map, folder_.path());
  EXPECT_EQ(readTumTrajectory(folder_ / "poses_tum.txt").poses().size(), 2u);
  const auto vertices = linesOf(folder_ / "graph.g2o", "VERTEX_SE3:QUAT ");
  ASSERT_EQ(vertices.size(), 3u);
  EXPECT_EQ(vertices[1], "VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1");
  EXPECT_EQ(linesOf(folder_ / "graph.g2o", "#").size(), 1u);
}

/** g2o's error of an edge: translation and quaternion vector of Z^-1 X. */
Vector6d g2oError(const Eigen::Isometry3d& Z, const Eigen::Isometry3d& X) {
  const Eigen::Isometry3d delta = Z.inverse() * X;
  Eigen::Quaterniond q(delta.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  Vector6d e;
  e << delta.translation(), q.vec();
  return e;
}

TEST_F(MapExport, TheInformationOfAnEdgeIsThatOfG2osError) {
  const Map map = ExampleMap().map(2);
  exportMap(map, folder_.path());
  const auto edges = linesOf(folder_ / "graph.g2o", "EDGE_SE3:QUAT ");
  ASSERT_EQ(edges.size(), 1u);
  std::istringstream in(edges[0]);
  std::string tag;
  int from = -1, to = -1;
  in >> tag >> from >> to;
  EXPECT_EQ(from, 0);
  EXPECT_EQ(to, 1);
  double number;
  for (int i = 0; i < 7; ++i) in >> number;
  Matrix6d information;
  for (int row = 0; row < 6; ++row)
    for (int col = row; col < 6; ++col) {
      ASSERT_TRUE(in >> number);
      information(row, col) = information(col, row) = number;
    }
  EXPECT_FALSE(in >> number);

  // A small perturbation must cost the same in both conventions.
  const PoseWithCovariance& link = map.links[0].T_from_to;
  for (int axis = 0; axis < 6; ++axis) {
    Vector6d d = Vector6d::Constant(1e-5);
    d[axis] = -5e-5;
    const Vector6d e = g2oError(link.T, boxplus(link.T, d));
    const double ours = d.dot(link.P.inverse() * d), theirs = e.dot(information * e);
    EXPECT_NEAR(theirs, ours, 1e-3 * ours);
  }
}

TEST_F(MapExport, LinksThatAreKnownExactlyHaveFiniteInformation) {
  Map map = ExampleMap().map(2);
  map.links[0].T_from_to.P.setZero();
  exportMap(map, folder_.path());
  EXPECT_THAT(bytesOf(folder_ / "graph.g2o"), HasAll(Not(HasSubstr("inf")), Not(HasSubstr("nan"))));
}

TEST_F(MapExport, NamesBecomeDistinctFileNames) {
  ExampleMap example;
  Map map;
  for (const char* name : {"a/b", "a_b", "..", "empty"}) map.models.push_back(example.seen(name, 1));
  changeView(map, 3, [](View& view) { view.segments.clear(); });
  exportMap(map, folder_.path());
  for (const char* name : {"a_b.pcd", "a_b_.pcd", "_...pcd"})
    EXPECT_TRUE(fs::exists(folder_ / "models" / name)) << name;
  EXPECT_FALSE(fs::exists(folder_ / "models/empty.pcd"));
}

TEST_F(MapExport, SameMapSameBytes) {
  for (const char* name : {"a", "b"}) exportMap(ExampleMap().map(2), folder_ / name);
  for (const char* file : {"graph.g2o", "poses_tum.txt", "models/frame_0.pcd"})
    EXPECT_EQ(bytesOf(folder_ / "a" / file), bytesOf(folder_ / "b" / file)) << file;
}

TEST_F(MapExport, AFileInTheWayIsAnError) {
  putBytes(folder_ / "out", "a file");
  EXPECT_THAT(ioErrorOf([&] { exportMap(Map(), folder_ / "out"); }), HasSubstr("out"));
}

}  // namespace
}  // namespace facetloc::test
