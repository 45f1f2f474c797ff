// SPDX-License-Identifier: BSD-3-Clause
#include "example_map.h"
#include "temporary_folder.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/map_database.h>
#include <facetloc/testing/pose_matchers.h>

namespace facetloc::test {
namespace {

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

}  // namespace
}  // namespace facetloc::test
