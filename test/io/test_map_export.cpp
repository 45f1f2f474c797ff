// SPDX-License-Identifier: BSD-3-Clause
#include "example_map.h"
#include "temporary_folder.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/features/segment_frame.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/testing/changed_views.h>
#include <facetloc/testing/pose_matchers.h>

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
  EXPECT_EQ(readTrajectory(folder_ / "poses_tum.txt").poses().size(), 2u);
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

class MapGraph : public InAFolder {
protected:
  /** A map whose poses all follow from links. */
  static Map byLinks(int models) {
    Map map = ExampleMap().map(models);
    for (LocalModel& model : map.models) model.T_w_m.reset();
    placeByLinks(map);
    return map;
  }
  std::string faultOf(const std::string& graph, Map map = ExampleMap().map(2)) const {
    putBytes(path_, graph);
    return ioErrorOf([&] { readGraphPoses(path_, map); });
  }

  const std::filesystem::path path_ = folder_ / "graph.g2o";
};

TEST_F(MapGraph, PosesComeBackAsGivenOnes) {
  const Map optimized = ExampleMap(8).map(3);
  writeGraph(path_, optimized);
  for (Map map : {ExampleMap().map(3), byLinks(3)}) {
    const Link link = map.links[1];
    readGraphPoses(path_, map);
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(map.models[i].givenPose());
      EXPECT_THAT(*map.models[i].T_w_m, PoseNear(*optimized.models[i].T_w_m, 1e-7, 1e-5));
    }
    EXPECT_EQ(map.links[1].T_from_to.T.matrix(), link.T_from_to.T.matrix());
  }
}

TEST_F(MapGraph, ExtraColumnsOfAVertexAreIgnored) {
  Map map = ExampleMap().map(2);
  const std::string graph = "# words\nFIX 0\nVERTEX_SE3:QUAT 1 1 2 3 0 0 0 1\r\n\n"
                            "VERTEX_SE3:QUAT 0 4 5 6 0 0 1 0 # more\nEDGE_SE3:QUAT 0 1 nonsense\n";
  EXPECT_EQ(faultOf(graph, map), "");
  readGraphPoses(path_, map);
  EXPECT_EQ(map.models[1].T_w_m->translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(map.models[0].T_w_m->translation(), Eigen::Vector3d(4, 5, 6));
}

TEST_F(MapGraph, FaultsNameTheirLine) {
  const std::string first = "VERTEX_SE3:QUAT 0 1 2 3 0 0 0 1\n";
  EXPECT_THAT(faultOf(first), HasAll("no vertex", "frame 1"));
  EXPECT_THAT(faultOf(first + first), HasAll("line 2", "already"));
  EXPECT_THAT(faultOf(first + "VERTEX_SE3:QUAT 2 1 2 3 0 0 0 1\n"), HasSubstr("no local model 2"));
  EXPECT_THAT(faultOf(first + "VERTEX_SE3:QUAT -1 1 2 3 0 0 0 1\n"), HasSubstr("no local model -1"));
  EXPECT_THAT(faultOf(first + "VERTEX_SE3:QUAT x 1 2 3 0 0 0 1\n"), HasSubstr("'x'"));
  EXPECT_THAT(faultOf(first + "VERTEX_SE3:QUAT 1 1 2 3 0 0 1\n"), HasSubstr("8 words"));
  EXPECT_THAT(faultOf(first + "VERTEX_SE3:QUAT 1 1 nan 3 0 0 0 1\n"), HasSubstr("not finite"));
  EXPECT_THAT(faultOf(first + "VERTEX_SE3:QUAT 1 1 2 3 0 0 0 2\n"), HasSubstr("not a rotation"));
  EXPECT_THAT(faultOf("", byLinks(2)), HasSubstr("no vertex"));
}

TEST_F(MapGraph, PartsKeepTheirFrames) {
  Map map = ExampleMap().map(4);
  map.links = {map.links[0], map.links[2]};
  for (const int i : {1, 2, 3}) map.models[i].T_w_m.reset();
  placeByLinks(map);
  writeGraph(path_, map);
  EXPECT_THAT(bytesOf(path_),
              HasAll("next vertex follows from links\nVERTEX_SE3:QUAT 1 ",
                     "in the frame of part 1\nVERTEX_SE3:QUAT 2 ", Not(HasSubstr("unknown"))));
  const Map before = map;
  readGraphPoses(path_, map);
  EXPECT_TRUE(map.models[1].givenPose());
  for (const int i : {2, 3}) {
    EXPECT_FALSE(map.models[i].givenPose());
    EXPECT_EQ(map.partOf(i), before.partOf(i));
    EXPECT_THAT(*map.models[i].T_w_m, PoseNear(*before.models[i].T_w_m, 1e-9, 1e-6));
  }

  for (LocalModel& model : map.models) model.T_w_m.reset();
  placeByLinks(map);
  EXPECT_THAT(ioErrorOf([&] { readGraphPoses(path_, map); }), HasSubstr("parts"));
}

Camera mountedCamera() {
  Camera camera;
  camera.intrinsics = {640, 480, 525, 526, 319, 239};
  camera.noise.inverse_depth_std = 0.002;
  camera.mounting = CameraMounting{0.9, 12};
  camera.max_depth = 6;
  return camera;
}

using MapCamera = InAFolder;

TEST_F(MapCamera, IsThatOfTheMap) {
  MapDatabase::create(folder_ / "a.flmap").setCamera(mountedCamera());
  EXPECT_TRUE(isMapFile(folder_ / "a.flmap"));
  CameraFile stored;
  stored.depth_scale = 5000;
  stored.lens.k1 = 0.1;
  stored.camera.intrinsics = {320, 240, 250, 250, 159, 119};
  stored.preset = "kinect";
  const CameraFile file = cameraOfMap(folder_ / "a.flmap", stored);
  EXPECT_EQ(file.camera.intrinsics, mountedCamera().intrinsics);
  EXPECT_EQ(file.camera.noise.inverse_depth_std, 0.002);
  EXPECT_EQ(file.camera.max_depth, 6);
  ASSERT_TRUE(file.camera.mounting);
  EXPECT_EQ(file.camera.mounting->tilt_deg, 12);
  EXPECT_EQ(file.depth_scale, 5000) << "how images are stored is not of the map";
  EXPECT_EQ(file.lens.k1, 0.1);
}

TEST_F(MapCamera, NeedsIntrinsicsFromSomewhere) {
  Camera camera = mountedCamera();
  camera.intrinsics = {};
  MapDatabase::create(folder_ / "a.flmap").setCamera(camera);
  CameraFile stored;
  stored.camera.intrinsics = {320, 240, 250, 250, 159, 119};
  EXPECT_EQ(cameraOfMap(folder_ / "a.flmap", stored).camera.intrinsics, stored.camera.intrinsics);
  EXPECT_THAT(ioErrorOf([&] { cameraOfMap(folder_ / "a.flmap"); }),
              HasSubstr("a.flmap: does not say the intrinsics"));
}

TEST_F(MapCamera, OfNoMapIsAnError) {
  std::ofstream(folder_ / "short.flmap") << "SQL";
  std::ofstream(folder_ / "torn.flmap") << "SQLite format 3, and nothing more";
  EXPECT_FALSE(isMapFile(folder_ / "short.flmap"));
  EXPECT_FALSE(isMapFile(folder_ / "none.flmap"));
  EXPECT_FALSE(isMapFile(folder_ / ""));
  EXPECT_TRUE(isMapFile(folder_ / "torn.flmap"));
  EXPECT_THROW(cameraOfMap(folder_ / "torn.flmap"), IoError);
}

}  // namespace
}  // namespace facetloc::test
