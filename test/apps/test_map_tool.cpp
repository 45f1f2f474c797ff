// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"

#include <facetloc/io/map_database.h>
#include <facetloc/mapping/densified_map.h>

#include <pcl/conversions.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cmath>

namespace facetloc::test {
namespace {

TEST_F(Tools, MapMergeAndExport) {
  const std::string twin = folder_ / "twin.flmap", merged = folder_ / "merged.flmap";
  fs::copy_file(map(), twin);
  ok(runMap({"merge", map(), twin, "-o", merged}));
  const Map one = readMap(map()), both = readMap(merged);
  ASSERT_EQ(both.models.size(), 2 * one.models.size());
  EXPECT_EQ(both.links.size(), 2 * one.links.size());
  EXPECT_EQ(both.models[0].name, "map_" + one.models[0].name);
  EXPECT_EQ(both.models[one.models.size()].name, "twin_" + one.models[0].name);
  EXPECT_TRUE(both.camera.mounting);
  EXPECT_EQ(runMap({"merge", map(), "-o", merged}).code, kFailed);  // exists
  EXPECT_EQ(runMap({"merge", map(), map(), "-o", folder_ / "x.flmap"}).code, kFailed);

  const std::string other = folder_ / "other/map.flmap";
  fs::create_directories(folder_ / "other");
  ok(runMap({"build", query(), "-o", other, "--every", "6"}));
  ok(runMap({"merge", map(), other, "-o", folder_ / "both.flmap", "--same-coordinates"}));
  const Map of_both = readMap(folder_ / "both.flmap");
  EXPECT_NE(of_both.meta.at("map.source"), of_both.meta.at("map_2.source"));

  ok(runMap({"export", map(), "-o", folder_ / "export"}));
  const auto exported = [this] { return filesOf(folder_ / "export/models").size(); };
  const std::size_t models = exported();
  ok(runMap({"export", other, "-o", folder_ / "export"}));
  EXPECT_EQ(exported(), 2u);
  EXPECT_GT(models, 2u);
  EXPECT_TRUE(fs::exists(folder_ / "export/graph.g2o"));
  EXPECT_THAT(runMap({"export", map(), "-o", query()}), fails("holds other files already"));
}

TEST_F(Tools, MapIsExportedAsAMesh) {
  const std::string ply = folder_ / "map.ply";
  ok(runMap({"export", map(), "--ply", ply}));
  pcl::PolygonMesh mesh;
  ASSERT_EQ(pcl::io::loadPLYFile(ply, mesh), 0);
  const Map posed = readMap(map());
  std::size_t segments = 0;
  for (std::size_t i = 0; i < posed.models.size(); ++i) segments += posed.view(i)->segments.size();
  EXPECT_EQ(mesh.polygons.size(), segments);
  pcl::PointCloud<pcl::PointXYZRGB> vertices;
  pcl::fromPCLPointCloud2(mesh.cloud, vertices);
  // The floor of the room: level, seen from above, in the colour of a normal that points down.
  std::size_t of_floor = 0;
  for (const pcl::PointXYZRGB& p : vertices) of_floor += std::abs(p.z) < 0.02 && p.b < 5;
  EXPECT_GT(of_floor, 0u);

  Map bare = posed;
  for (LocalModel& model : bare.models) model.T_w_m.reset();
  bare.links.clear();
  writeMap(folder_ / "bare.flmap", bare);
  ok(runMap({"export", folder_ / "bare.flmap", "--ply", ply}));  // its first part
}

TEST_F(Tools, MapTakesThePosesOfAGraph) {
  const std::string graph = folder_ / "map.g2o", moved = folder_ / "moved.flmap";
  ok(runMap({"export", map(), "--g2o", graph}));
  std::string optimized;
  for (const std::string& line : linesIn(contentOf(graph))) {
    std::istringstream words(line);
    std::string tag, id, rest;
    double x = 0;
    words >> tag >> id >> x;
    std::getline(words, rest);
    optimized +=
        tag == "VERTEX_SE3:QUAT" ? tag + " " + id + " " + std::to_string(x + 1) + rest + "\n" : line + "\n";
  }
  writeContent(graph, optimized);
  ok(runMap({"import", map(), "--g2o", graph, "-o", moved}));
  const Map before = readMap(map()), after = readMap(moved);
  ASSERT_EQ(after.models.size(), before.models.size());
  for (std::size_t i = 0; i < after.models.size(); ++i)
    EXPECT_NEAR(after.models[i].givenPose()->translation().x(), before.models[i].T_w_m->translation().x() + 1,
                1e-5);
  ok(runMap({"check", moved}));
  EXPECT_EQ(runMap({"import", map(), "--g2o", graph, "-o", moved}).code, kFailed);  // exists
  EXPECT_EQ(runMap({"import", map(), "-o", moved}).code, kUsage);
  EXPECT_EQ(runMap({"export", map()}).code, kUsage);
}

TEST_F(Tools, MapInfoListsThePartsOfATopologicalMap) {
  Map bare = readMap(map());
  const auto models = std::to_string(bare.models.size());
  for (LocalModel& model : bare.models) model.T_w_m.reset();
  writeMap(folder_ / "bare.flmap", bare);
  EXPECT_THAT(runMap({"info", folder_ / "bare.flmap"}).out, HasSubstr(models + ", in 1 part\n"));
  bare.links.erase(bare.links.begin());
  writeMap(folder_ / "parts.flmap", bare);
  EXPECT_THAT(runMap({"info", folder_ / "parts.flmap"}).out,
              HasAll(models + ", in 2 parts\n", bare.models[0].name, "1 local model\n"));
}

TEST_F(Tools, MapInfoLocalizesItsOwnImages) {
  const ToolRun run = ok(runMap({"info", map(), "--self", "--threads", "2"}));
  EXPECT_THAT(run.out, HasAll("own images, each without itself", "rank 1 right", "inside 95 %", "aliases",
                              "\nthe world ", "\nall "));
  EXPECT_THAT(lastLine(run.out), HasSubstr("map: " + map()));
  EXPECT_EQ(run.out, ok(runMap({"info", map(), "--self", "--threads", "1"})).out);
  EXPECT_THAT(ok(runMap({"info", map()})).out, Not(HasSubstr("own images")));

  Map parts = readMap(map());
  for (LocalModel& model : parts.models) model.T_w_m.reset();
  parts.links.erase(parts.links.begin());
  writeMap(folder_ / "parts.flmap", parts);
  EXPECT_THAT(ok(runMap({"info", folder_ / "parts.flmap", "--self"})).out,
              HasAll("\n" + parts.models[0].name + " ", "\n" + parts.models[1].name + " ", "\nall "));
}

/** A map of few images gets no advice; one whose images show nothing in common is to be recorded anew. */
TEST_F(Tools, MapInfoAdvisesWhereToRecordMore) {
  const Map whole = readMap(map());
  Map lonely = whole;
  lonely.links.clear();
  lonely.models.clear();
  for (int i = 0; i < 10; ++i) {
    LocalModel model = whole.models[0];
    model.name = "image" + std::to_string(i);
    model.T_w_m = Eigen::Translation3d(i < 9 ? 50 : 90, 0.01 * i, 0) * *model.T_w_m;  // 9 within 0.35 m
    lonely.models.push_back(model);
  }
  const std::string path = folder_ / "lonely.flmap";
  writeMap(path, lonely);
  EXPECT_THAT(
      runMap({"info", path, "--self"}).out,
      HasAll("record more around image image0 at (", "9 of 9 images within 2 m are not sure and right"));
  lonely.models.pop_back();
  writeMap(path, lonely);
  EXPECT_THAT(runMap({"info", path, "--self"}).out, Not(HasSubstr("record more")));
}

TEST_F(Tools, MapCommandsAreKnown) {
  EXPECT_THAT(runMap({"biuld"}), refuses("unknown command 'biuld'; did you mean 'build'?"));
  EXPECT_THAT(runMap({"fly"}), refuses("unknown command 'fly'", "Commands:"));
  const std::string list = ok(runMap({})).out;
  for (const Command& command : mapProgram().commands) {
    EXPECT_THAT(list, HasSubstr("\n  " + command.name + " "));
    EXPECT_EQ(ok(runMap({"help", command.name})).out, ok(runMap({command.name, "--help"})).out);
    EXPECT_THAT(runMap({"help", command.name}).out, StartsWith("Usage: facetloc_map " + command.name + " "));
  }
  for (const char* option : {"--help", "-help", "-h", "--version", "-version"}) {
    EXPECT_EQ(runMap({option}).code, kOk) << option;
    std::ostringstream full, err;
    full.setstate(std::ios::badbit);
    EXPECT_EQ(mapProgram().run({option}, Console{full, err, false, false, {}}), kFailed) << option;
    EXPECT_THAT(err.str(), HasSubstr("cannot be written"));
  }
  writeContent(folder_ / "broken.flmap", "not a map");
  EXPECT_EQ(runMap({"check", folder_ / "broken.flmap"}).code, kFailed);
  EXPECT_EQ(runMap({"info", folder_ / "broken.flmap"}).code, kFailed);
}

const std::vector<std::string> kFew = {"--densify.rotation_deg", "40"};

Arguments densifying(const Arguments& arguments) { return Arguments{"densify"} + arguments + kFew; }

TEST_F(Tools, DensifiedMapIsSoundAndSaysSo) {
  const std::string dense = folder_ / "dense.flmap", again = folder_ / "again.flmap";
  const auto run = ok(runMap(densifying({map(), "-o", dense})));
  EXPECT_THAT(run.out, HasSubstr("rendered from the depth pictures of"));
  ok(runMap({"check", dense}));
  const Map before = readMap(map()), after = readMap(dense);
  const std::vector<char> rendered = renderedViews(after);
  const auto n = static_cast<std::size_t>(std::count(rendered.begin(), rendered.end(), 1));
  ASSERT_GE(n, 1u);
  EXPECT_EQ(after.models.size(), before.models.size() + n);
  EXPECT_TRUE(after.ambiguity) << "it has been asked again";
  EXPECT_THAT(runMap({"info", dense}).out, HasSubstr("rendered beside the drive  " + std::to_string(n)));
  EXPECT_THAT(runMap({"info", map()}).out, Not(HasSubstr("rendered beside")));

  ok(runMap(densifying({dense, "-o", again})));
  const Map twice = readMap(again);
  ASSERT_EQ(twice.models.size(), after.models.size());
  EXPECT_EQ(twice.links.size(), after.links.size());
  for (std::size_t i = 0; i < twice.models.size(); ++i) {
    EXPECT_EQ(twice.models[i].name, after.models[i].name);
    EXPECT_TRUE(twice.models[i].T_w_m->isApprox(*after.models[i].T_w_m, 1e-9))
        << "not of rendered views again";
  }
}

TEST_F(Tools, DensifyLeavesMapsAloneThatItCannotUse) {
  const std::string copy = folder_ / "copy.flmap", broken = folder_ / "broken.flmap";
  EXPECT_THAT(runMap({"densify", folder_ / "none.flmap"}).err, HasSubstr("is not there"));
  fs::copy_file(map(), copy);
  EXPECT_THAT(runMap({"densify", map(), "-o", copy}).err, HasSubstr("exists already"));
  EXPECT_EQ(contentOf(copy), contentOf(map()));
  fs::copy_file(firstImage(), broken);
  const std::string bytes = contentOf(broken);
  EXPECT_EQ(runMap({"densify", broken}).code, kFailed);
  EXPECT_EQ(contentOf(broken), bytes);
  EXPECT_EQ(runMap({"densify", copy, "--densify.reach", "-1"}).code, kUsage);
  EXPECT_THAT(runMap({"densify", copy, "--overwrite"}).err, HasSubstr("overwrite belongs to --output"));

  Map unposed = readMap(map());
  for (LocalModel& model : unposed.models) {
    View view = *unposed.view(0);
    view.depth = {};
    model.setView(std::move(view));
  }
  writeMap(copy, unposed);
  const std::string before = contentOf(copy);
  EXPECT_THAT(runMap({"densify", copy}), fails("no local model with a pose and a depth picture"));
  EXPECT_EQ(contentOf(copy), before);
}

}  // namespace
}  // namespace facetloc::test
