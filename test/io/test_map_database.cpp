// SPDX-License-Identifier: BSD-3-Clause
// Writing a map file, and reading it again.
#include "map_file.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

namespace facetloc::test {
namespace {

TEST_F(MapFile, HoldsTheGravityOfItsImages) {
  Map map = ExampleMap().map(3);
  const Gravity gravity = gravityAlong({0.1, 0.9, 0.3}, 2 * kDegree);
  changeView(map, 1, [&](View& view) { view.gravity = gravity; });
  writeMap(path_, map);
  for (const Map& read : {readMap(path_), openMap(path_, 0)}) {
    EXPECT_FALSE(read.view(0)->gravity);
    ASSERT_TRUE(read.view(1)->gravity);
    EXPECT_EQ(read.view(1)->gravity->down, gravity.down);
    EXPECT_EQ(read.view(1)->gravity->std, gravity.std);
  }
  EXPECT_THAT(checkMap(path_), IsEmpty());
  vandalize(path_, "UPDATE gravity SET std = 100");
  EXPECT_THAT(ioErrorOf([&] { readMap(path_); }), HasSubstr("gravity"));

  changeView(map, 1, [](View& view) { view.gravity = Gravity{{0, 0, 0}, 1}; });
  EXPECT_THAT(ioErrorOf([&] { writeMap(folder_ / "impossible", map); }), HasSubstr("gravity"));
}

TEST_F(MapFile, RoundTripsExactly) {
  Map map = ExampleMap().map(3);
  map.models[1].T_w_m.reset();
  changeView(map, 2, [](View& view) { view.depth = {}, view.segments[0].hull.size = 0; });
  map.models.push_back(ExampleMap(5).seen("nothing seen; 'quotes' and Umlaute \xC3\xA4", 0));
  ASSERT_GE(map.links.size(), 2u);
  writeMap(path_, map);
  EXPECT_EQ(folder_.count(), 1);

  const Map read = readMap(path_);
  ASSERT_TRUE(read.camera.mounting);
  EXPECT_EQ(read.camera.mounting->height, 0.98);
  EXPECT_EQ(read.camera.mounting->tilt_deg, 10.1);
  EXPECT_FALSE(read.camera.intrinsics.valid());
  EXPECT_EQ(toIni(read.camera.noise), toIni(map.camera.noise));
  EXPECT_EQ(read.camera.max_depth, map.camera.max_depth);
  for (const auto& [key, value] : map.meta) EXPECT_EQ(read.meta.at(key), value);
  EXPECT_EQ(read.meta.at("format"), "facetloc map 1.0");
  EXPECT_THAT(read.meta.at("conventions"), HasSubstr("T_a_b"));
  expectEqualModels(map, read);
  ASSERT_EQ(read.links.size(), map.links.size());
  for (std::size_t i = 0; i < map.links.size(); ++i) {
    EXPECT_EQ(read.links[i].from, map.links[i].from);
    EXPECT_EQ(read.links[i].to, map.links[i].to);
    expectEqual(map.links[i].T_from_to.T, read.links[i].T_from_to.T);
    EXPECT_EQ(read.links[i].T_from_to.P, map.links[i].T_from_to.P);
  }
}

TEST_F(MapFile, PosesThatFollowFromLinksAreFoundAnewAndNeverWritten) {
  Map map = ExampleMap().map(4);
  for (const int i : {0, 2, 3}) map.models[i].T_w_m.reset();
  map.links = {ExampleMap().link(1, 0), ExampleMap(2).link(2, 3)};
  writeMap(path_, map);
  for (int repetition = 0; repetition < 2; ++repetition) {
    for (const Map& read : {readMap(path_), openMap(path_, 0)}) {
      EXPECT_THAT(read.parts, ElementsAre("", map.models[2].name));
      const LocalModel& placed = read.models[0];
      ASSERT_TRUE(placed.T_w_m);
      EXPECT_FALSE(placed.givenPose());
      EXPECT_TRUE(placed.T_w_m->isApprox(*map.models[1].T_w_m * map.links[0].T_from_to.T, 1e-9));
      EXPECT_EQ(read.models[3].part, 1);
    }
    writeMap(path_, readMap(path_));
  }
}

DepthDistortion exampleDistortion() {
  DepthDistortion::Values values;
  for (int i = 0; i < DepthDistortion::kNodes; ++i) values[i] = 1e-3 * std::sin(i);
  return DepthDistortion(DepthDistortion::extentOf(kinectIntrinsics()), values);
}

TEST_F(MapFile, TheDistortionRoundTripsExactly) {
  Map map = ExampleMap().map(2);
  map.camera.distortion = exampleDistortion();
  writeMap(path_, map);
  for (const Map& read : {readMap(path_), openMap(path_, 0)}) {
    ASSERT_TRUE(read.camera.distortion);
    EXPECT_EQ(read.camera.distortion->extent().min(), map.camera.distortion->extent().min());
    EXPECT_EQ(read.camera.distortion->extent().max(), map.camera.distortion->extent().max());
    EXPECT_EQ(read.camera.distortion->values(), map.camera.distortion->values());
  }
  EXPECT_THAT(checkMap(path_), IsEmpty());
  MapDatabase::create(path_, true).setCamera(map.camera);
  EXPECT_EQ(readMap(path_).camera.distortion->values(), map.camera.distortion->values());
  writeExample();
  EXPECT_FALSE(readMap(path_).camera.distortion);
}

TEST_F(MapFile, TheAmbiguityRoundTripsUntilAModelIsAdded) {
  writeExample();
  EXPECT_FALSE(readMap(path_).ambiguity);
  MapDatabase::open(path_).setAmbiguity({-12.5, 142}, {3.5, {}, -7.0});
  EXPECT_THROW(MapDatabase::open(path_).setAmbiguity({-12.5, 142}, {3.5}), std::invalid_argument);
  EXPECT_THROW(MapDatabase::open(path_).setAmbiguity({-12.5, 142}, {3.5, 1e9, {}}), IoError);
  for (const Map& read : {readMap(path_), openMap(path_, 0)}) {
    ASSERT_TRUE(read.ambiguity);
    EXPECT_EQ(read.ambiguity->score, -12.5);
    EXPECT_EQ(read.ambiguity->views, 142);
    EXPECT_EQ(read.models[0].alias_score, 3.5);
    EXPECT_FALSE(read.models[1].alias_score);
    EXPECT_EQ(read.models[2].alias_score, -7.0);
  }
  const Map map = readMap(path_);
  writeMap(path_, map);
  EXPECT_TRUE(readMap(path_).ambiguity);
  EXPECT_EQ(readMap(path_).models[2].alias_score, -7.0);
  MapDatabase::open(path_).add(ExampleMap(9).model("more"), ExampleMap(9).view());
  EXPECT_FALSE(readMap(path_).ambiguity);
  EXPECT_FALSE(readMap(path_).models[2].alias_score);
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, PosesAndLinksOfAMapThatMovesAreSetAnew) {
  Map map = ExampleMap().map(3);
  map.ambiguity = MapAmbiguity{12.5, 3};
  writeMap(path_, map);
  std::vector<std::optional<Eigen::Isometry3d>> poses(3);
  poses[0] = Eigen::Isometry3d::Identity();
  poses[2] = map.models[1].T_w_m;
  Link link = map.links.front();
  link.from = 0, link.to = 2;
  {
    MapDatabase database = MapDatabase::open(path_);
    database.setPoses(poses, {link});
    EXPECT_THROW(database.setPoses({poses[0]}, {}), std::invalid_argument);
    Link impossible = link;
    impossible.T_from_to.P.setZero();
    EXPECT_THROW(database.setPoses(std::vector<std::optional<Eigen::Isometry3d>>(3), {impossible}), IoError);
  }
  EXPECT_THAT(checkMap(path_), IsEmpty());
  const Map read = readMap(path_);
  ASSERT_EQ(read.links.size(), 1u);
  EXPECT_EQ(read.links[0].to, 2);
  EXPECT_FALSE(read.ambiguity);
  for (std::size_t i = 0; i < 3; ++i) map.models[i].T_w_m = poses[i];
  expectEqualModels(map, read);
}

TEST_F(MapFile, TheIntrinsicsOfTheCameraRoundTrip) {
  Map map = ExampleMap().map();
  map.camera.intrinsics = kinectIntrinsics();
  writeMap(path_, map);
  EXPECT_EQ(readMap(path_).camera.intrinsics, kinectIntrinsics());
  EXPECT_EQ(openMap(path_, 0).camera.intrinsics, kinectIntrinsics());
}

TEST_F(MapFile, ViewsWithoutAPictureHaveTheNoiseOfTheCamera) {
  Map map = ExampleMap().map();
  changeView(map, 1, [](View& view) { view.depth = {}; });
  writeMap(path_, map);
  const double of_camera = map.camera.noise.ofInverseDepth(DepthNoise::kUsualDepth);
  for (const Map& read : {readMap(path_), openMap(path_, 0)}) {
    EXPECT_EQ(read.view(1)->noise(), of_camera);
    EXPECT_EQ(read.view(2)->noise(), map.view(2)->noise());
  }
}

TEST_F(MapFile, ImpossibleNoiseIsAFault) {
  for (const char* damage :
       {"UPDATE camera SET inverse_depth_std = 2", "UPDATE camera SET distortion_slope = 9e999",
        "UPDATE camera SET width = -3, height = 2, fx = 1, fy = 1, cx = 0, cy = 0",
        "UPDATE camera SET depth_std = 2", "UPDATE camera SET depth_std_slope = 9e999"}) {
    writeExample();
    sql(path_, damage);
    EXPECT_THAT(readError(), HasSubstr("the camera")) << damage;
    std::filesystem::remove(path_);
  }
  for (const char* damage : {"UPDATE depth_picture SET inverse_depth_std = 1e-9 WHERE model_id = 2",
                             "UPDATE depth_picture SET inverse_depth_std = 9e999 WHERE model_id = 2",
                             "UPDATE depth_picture SET depth_std = 2 WHERE model_id = 2",
                             "UPDATE depth_picture SET depth_std_slope = 9e999 WHERE model_id = 2"}) {
    writeExample();
    sql(path_, damage);
    EXPECT_THAT(readError(), HasSubstr("noise")) << damage;
    EXPECT_THAT(ioErrorOf([this] { openMap(path_, 0).view(2); }), HasSubstr("noise")) << damage;
    std::filesystem::remove(path_);
  }
  writeExample();
  vandalize(path_, "UPDATE camera SET max_depth = 0");
  EXPECT_THAT(readError(), HasSubstr("largest depth"));
  std::filesystem::remove(path_);
  Map map = ExampleMap().map();
  changeView(map, 0, [](View& view) { view.depth.noise.inverse_depth_std = 0; });
  EXPECT_THAT(ioErrorOf([&] { writeMap(path_, map); }), HasSubstr("noise"));
}

TEST_F(MapFile, ATornDistortionIsAFault) {
  Map map = ExampleMap().map(1);
  map.camera.distortion = exampleDistortion();
  std::string infinite = "SET distortion = x'";
  for (int i = 0; i < DepthDistortion::kNodes; ++i) infinite += "000000000000F07F";
  infinite += "'";
  for (const std::string& damage : std::vector<std::string>{
           "SET distortion = x'00'", "SET distortion = zeroblob(512)", "SET distortion = NULL",
           "SET distortion_right = -9", "SET distortion_bottom = 9e999", infinite}) {
    writeMap(path_, map);
    vandalize(path_, "UPDATE camera " + damage);
    EXPECT_NE(readError(), "") << damage;
    EXPECT_THAT(checkMap(path_), Contains(HasSubstr("the camera"))) << damage;
  }
}

TEST_F(MapFile, AMountingMayBeTurnedAndMoved) {
  Map map = ExampleMap().map(1);
  map.camera.mounting = CameraMounting{0.98, 10, -3.5, 90, 0.25, -0.125};
  writeMap(path_, map);
  EXPECT_THAT(checkMap(path_), IsEmpty());
  EXPECT_EQ(readMap(path_).camera.mounting->T_b_c().matrix(), map.camera.mounting->T_b_c().matrix());
  // Set anew, nothing is left of it.
  Camera straight = map.camera;
  straight.mounting = CameraMounting{1, 5};
  MapDatabase::open(path_).setCamera(straight);
  EXPECT_EQ(readMap(path_).camera.mounting->T_b_c().matrix(), straight.mounting->T_b_c().matrix());
  MapDatabase::open(path_).setCamera(map.camera);
  sql(path_, "UPDATE camera SET mount_pan_deg = 400");
  EXPECT_THAT(readError(), HasSubstr("mounting"));
}

TEST_F(MapFile, AnEmptyMapIsLegal) {
  writeMap(path_, Map());
  EXPECT_THAT(readMap(path_).models, IsEmpty());
  EXPECT_FALSE(readMap(path_).camera.mounting);
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, SameMapSameBytes) {
  writeExample();
  writeMap(folder_ / "b.flmap", ExampleMap().map(3));
  EXPECT_EQ(bytesOf(path_), bytesOf(folder_ / "b.flmap"));
}

TEST_F(MapFile, IsTheSameWhetherBuiltStepByStepOrAtOnce) {
  const Map map = ExampleMap().map(3);
  {
    MapDatabase db = MapDatabase::create(path_);
    for (const auto& [key, value] : map.meta) db.setMeta(key, value);
    db.setCamera(Camera());
    db.setCamera(map.camera);  // takes the place of the other
    for (int i = 0; i < 3; ++i) EXPECT_EQ(db.add(map.models[i], *map.view(i)), i);
    for (const Link& link : map.links) db.add(link);
  }
  EXPECT_EQ(folder_.count(), 1) << "no journal is left";
  const Map read = readMap(path_);
  expectEqualModels(map, read);
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, IsTheSameForAnyPackingThread) {
  View flat = ExampleMap().view();
  flat.depth = {};
  const auto other = folder_ / "b.flmap";
  {
    MapDatabase mine = MapDatabase::create(path_), theirs = MapDatabase::create(other);
    for (const View& view : {ExampleMap().view(), flat}) {
      const LocalModel model = ExampleMap().model(view.depth.empty() ? "flat" : "a");
      mine.add(model, view);
      theirs.add(packed(model, view));
    }
  }
  EXPECT_EQ(bytesOf(path_), bytesOf(other));
}

TEST_F(MapFile, ABuildCanBeResumed) {
  ExampleMap example;
  MapDatabase::create(path_).add(example.model("a"), example.view());
  MapDatabase db = MapDatabase::open(path_);
  EXPECT_THAT(db.modelNames(), ElementsAre("a"));
  EXPECT_EQ(db.add(example.model("b"), example.view()), 1);
  db.add(example.link(1, 0));
  EXPECT_THAT(db.modelNames(), ElementsAre("a", "b"));
}

TEST_F(MapFile, AFailedAddLeavesTheMapAsItWas) {
  ExampleMap example;
  MapDatabase db = MapDatabase::create(path_);
  db.add(example.model("a"), example.view());
  EXPECT_THAT(ioErrorOf([&] { db.add(example.model("a"), example.view()); }), HasSubstr("UNIQUE"));
  View bad = example.view();
  bad.segments[2].Sigma_q(0, 0) = -1;
  EXPECT_THAT(ioErrorOf([&] { db.add(example.model("b"), bad); }),
              HasAll("room.flmap", "segment 2 of model 1 ('b')", "positive definite"));
  EXPECT_NE(ioErrorOf([&] { db.add(example.link(0, 5)); }), "");
  EXPECT_NE(ioErrorOf([&] { db.add(example.link(0, 0)); }), "");
  EXPECT_THAT(db.modelNames(), ElementsAre("a"));
  EXPECT_EQ(db.add(example.model("b"), example.view()), 1);
  EXPECT_THAT(checkMap(path_), IsEmpty());
}

TEST_F(MapFile, NonsenseIsNotWritten) {
  const auto errorWith = [this](const std::function<void(LocalModel&, View&)>& spoil) {
    Map map = ExampleMap().map(1);
    changeView(map, 0, [&](View& view) { spoil(map.models[0], view); });
    return ioErrorOf([&] { writeMap(path_, map); });
  };
  EXPECT_THAT(errorWith([](LocalModel&, View& view) { view.segments[0].t.x() = NAN; }),
              HasSubstr("centroid"));
  EXPECT_THAT(errorWith([](LocalModel&, View& view) { view.segments[0].R *= 2; }), HasSubstr("rotation"));
  EXPECT_THAT(errorWith([](LocalModel&, View& view) { view.segments[0].R *= -1; }), HasSubstr("rotation"));
  EXPECT_THAT(errorWith([](LocalModel&, View& view) { view.segments[0].lambda << 1, 2; }),
              HasSubstr("lambda"));
  EXPECT_THAT(errorWith([](LocalModel&, View& view) { view.segments[0].hull.size = 25; }), HasSubstr("hull"));
  EXPECT_THAT(errorWith([](LocalModel&, View& view) {
                ConvexHull& hull = view.segments[0].hull;
                std::reverse(hull.vertex.data(), hull.vertex.data() + hull.size);
              }),
              HasSubstr("its hull is not counter-clockwise"));
  EXPECT_THAT(errorWith([](LocalModel&, View& view) { view.intrinsics.fx = 0; }), HasSubstr("intrinsics"));
  EXPECT_THAT(errorWith([](LocalModel& m, View&) { m.stamp = INFINITY; }), HasSubstr("stamp"));
  EXPECT_THAT(errorWith([](LocalModel& m, View&) { m.T_w_m->translation().z() = NAN; }), HasSubstr("pose"));
  EXPECT_THAT(errorWith([](LocalModel&, View& view) { view.depth.inverse_depth.pop_back(); }),
              HasSubstr("depth picture"));
  EXPECT_EQ(folder_.count(), 0);
}

TEST_F(MapFile, PicturesThatCouldNotBeReadAreNotWritten) {
  PackedModel model = packed(ExampleMap().model("a"), ExampleMap().view());
  ASSERT_FALSE(model.depth.empty());
  model.view.depth.camera.width = 5000;
  MapDatabase db = MapDatabase::create(path_);
  EXPECT_THAT(ioErrorOf([&] { db.add(model); }), HasSubstr("its depth picture is larger than its image"));
  EXPECT_THAT(db.modelNames(), IsEmpty());
}

TEST_F(MapFile, ExistingFilesAreNotOverwrittenByAccident) {
  writeExample();
  EXPECT_THAT(ioErrorOf([&] { MapDatabase::create(path_); }), HasSubstr("exists"));
  EXPECT_EQ(readMap(path_).models.size(), 3u);
  MapDatabase::create(path_, true).add(ExampleMap().model("new"), ExampleMap().view());
  EXPECT_EQ(readMap(path_).models.size(), 1u);
}

TEST_F(MapFile, AStaleJournalDoesNotHarmANewMap) {
  writeExample();
  putBytes(path_.string() + "-journal", "not a journal");
  writeExample(2);
  EXPECT_EQ(readMap(path_).models.size(), 2u);
  EXPECT_EQ(folder_.count(), 1);
}

TEST_F(MapFile, MissingFoldersAndFilesAreErrors) {
  EXPECT_THAT(ioErrorOf([&] { writeMap(folder_ / "none/a.flmap", Map()); }), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { MapDatabase::create(folder_ / "none/a.flmap"); }), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { MapDatabase::open(path_); }), HasSubstr("does not exist"));
  EXPECT_THAT(readError(), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { checkMap(path_); }), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { readMap(folder_.path()); }), HasSubstr("folder"));
  EXPECT_NE(ioErrorOf([&] { MapDatabase::create(folder_.path(), true); }), "");
  EXPECT_EQ(folder_.count(), 0);
}

TEST_F(MapFile, ReservedMetaBelongsToTheFormat) {
  MapDatabase db = MapDatabase::create(path_);
  EXPECT_THROW(db.setMeta("format", "mine"), std::invalid_argument);
  db.setMeta("a", "1");
  db.setMeta("a", "2");
  EXPECT_EQ(readMap(path_).meta.at("a"), "2");
}

}  // namespace
}  // namespace facetloc::test
