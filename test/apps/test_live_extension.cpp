// SPDX-License-Identifier: BSD-3-Clause
// Effects of a live run on the next one: a map that was made or has grown, and the last sure pose.
#include "inputs/robot_line.h"
#include "live/remembered_pose.h"
#include "live_tool.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>

#include <json/json.h>

namespace facetloc::test {
namespace {

FrameResult sureAt(double x, AnswerState state = AnswerState::sure) {
  FrameResult frame;
  ResultRow row;
  row.frame = "1";
  row.rank = 1;
  row.state = state;
  row.T_w_c = Eigen::Isometry3d(Eigen::Translation3d(x, 2, 3));
  row.P_w_c = 1e-6 * Matrix6d::Identity();
  frame.rows = {row};
  return frame;
}

/** Local models in a row, 1 m apart. */
std::shared_ptr<Map> rowOfModels(int n, double y = 2) {
  auto map = std::make_shared<Map>();
  for (int i = 0; i < n; ++i)
    map->models.emplace_back(std::to_string(i), i, Eigen::Isometry3d(Eigen::Translation3d(i, y, 3)));
  return map;
}

TEST(RememberedPose, IsTheLastSureOne) {
  TemporaryFolder folder;
  const auto map = rowOfModels(10);
  const std::string file = folder / "last";
  {
    RememberedPose pose(file, map, {});
    EXPECT_EQ(pose.start(), "");
    pose.put(sureAt(1));
    pose.put(sureAt(4));
    pose.put(sureAt(7, AnswerState::doubtful));
  }
  const RobotLine line = parseRobotLine(RememberedPose(file, map, {}).start(), {});
  ASSERT_TRUE(line.start);
  EXPECT_TRUE(line.start->T_w_c.T.isApprox(*sureAt(4).rows[0].T_w_c, 1e-9));
  EXPECT_TRUE(line.start->T_w_c.P.isApprox(startCovariance(1, 30 * kDegree)))
      << "it may have been moved since";
}

TEST(RememberedPose, IsOfOneMapAlone) {
  TemporaryFolder folder;
  const std::string file = folder / "last";
  const auto map = rowOfModels(100);
  RememberedPose(file, map, {}).put(sureAt(40));
  const auto refusal = [&](const std::shared_ptr<const Map>& other) -> std::string {
    try {
      return RememberedPose(file, other, {}).start().empty() ? "no pose" : "";
    } catch (const IoError& e) {
      return e.cause();
    }
  };
  EXPECT_EQ("", refusal(map));
  EXPECT_THAT(refusal(rowOfModels(100, 3)), HasSubstr("another map")) << "of the same names";
  EXPECT_THAT(refusal(rowOfModels(10)), HasSubstr("another map"));
  EXPECT_THAT(refusal(std::make_shared<Map>()), HasSubstr("another map"));
  auto extended = std::make_shared<Map>(*map);
  for (std::size_t i = 36; i < 42; ++i) extended->models[i].name += " of today";
  EXPECT_EQ("", refusal(extended)) << "a few have been replaced";
  Json::Value line;
  std::istringstream(contentOf(file)) >> line;
  for (const Json::Value& near : {Json::Value(), Json::Value(7), Json::Value(Json::objectValue)}) {
    line["near"] = near;
    std::ofstream(file) << line;
    EXPECT_THAT(refusal(map), HasSubstr("another map"));
  }
}

TEST(RememberedPose, AnotherKindOfFileIsNamed) {
  TemporaryFolder folder;
  const std::string file = folder / "last";
  for (const std::string& text : {std::string("no pose"), std::string("[1]"), std::string("{}"),
                                  std::string(1 << 20, '{'), std::string(R"({"T_w_c":{"position":[1]}})")}) {
    std::ofstream(file) << text;
    EXPECT_THROW(RememberedPose(file, rowOfModels(1), {}).start(), IoError) << text.substr(0, 40);
  }
}

class LiveExtensionTool : public LiveTool {
protected:
  /** A map of the first images of the sequence. */
  std::string mapOfBegin(std::size_t images) const {
    const fs::path part = folder_ / "part";
    fs::create_directories(part / "depth");
    const DepthSequence all = DepthSequence::open(sequence());
    for (std::size_t i = 0; i < images; ++i)
      fs::copy_file(all.frames()[i].path, part / "depth" / all.frames()[i].path.filename());
    for (const char* name : {"camera.ini", "groundtruth.txt"})
      fs::copy_file(fs::path(sequence()) / name, part / name);
    const std::string made = folder_ / "begin.flmap";
    ok(captured([&](const Console& console) {
      return mapProgram().run({"build", part.string(), "-o", made, "--map.distance", "0.2"}, console);
    }));
    return made;
  }
  std::vector<std::string> extend(const std::string& map_file, const char* speed) const {
    return {"--device", sequence(), "--extend", map_file, "--headless", "--every-frame", "--speed", speed};
  }
};

TEST_F(LiveExtensionTool, AddsPlacesThatTheMapLacks) {
  const std::string grown = mapOfBegin(16);
  const std::size_t before = openMap(grown).models.size();
  const ToolRun run = ok(runLive(extend(grown, "0")));
  EXPECT_THAT(run.out + run.err, HasSubstr("is brought up to date with"));
  EXPECT_FALSE(fs::exists(grown + ".session"));
  const Map map = readMap(grown);
  EXPECT_GT(map.models.size(), before) << run.out << run.err;
  EXPECT_TRUE(checkMap(grown).empty());
  const DepthSequence all = DepthSequence::open(sequence());
  for (const LocalModel& model : map.models) {
    const auto truth = all.groundTruth().at(model.stamp, 0.001);
    if (!truth || !model.T_w_m) continue;
    EXPECT_TRUE(isNear(*truth, *model.T_w_m, 0.05, 1)) << model.name;
  }
  // The same again shows nothing new.
  const ToolRun again = ok(runLive(extend(grown, "0")));
  EXPECT_LE(openMap(grown).models.size(), map.models.size() + 1) << again.out;
}

TEST_F(LiveExtensionTool, TakesUpTheImagesOfAKilledRun) {
  const std::string grown = mapOfBegin(16);
  const std::size_t before = openMap(grown).models.size();
  const fs::path images = grown + ".session/depth";
  {
    LiveProcess killed(extend(grown, "0.2"));
    ASSERT_TRUE(eventually([&] {
      return fs::exists(images) &&
             std::distance(fs::directory_iterator(images), fs::directory_iterator()) >= 6;
    })) << killed.err();
    killed.signal(SIGKILL);
    killed.wait();
  }
  EXPECT_EQ(openMap(grown).models.size(), before) << "and the map is as it was";
  ASSERT_TRUE(fs::exists(images));
  const ToolRun next = ok(runLive(extend(grown, "0")));
  const std::string words = next.out + next.err;
  const auto first = words.find("is brought up to date with");
  ASSERT_NE(first, std::string::npos) << words;
  EXPECT_NE(words.find("is brought up to date with", first + 1), std::string::npos) << "both runs";
  EXPECT_TRUE(checkMap(grown).empty());
}

TEST_F(LiveExtensionTool, RemembersItsPose) {
  const std::string file = folder_ / "last.json";
  const std::vector<std::string> arguments = {"--device",   sequence(),   "--map", map(),
                                              "--headless", "--remember", file,    "--every-frame",
                                              "--speed",    "0"};
  ASSERT_EQ(runLive(arguments).code, 0);
  Json::Value pose;
  std::istringstream(contentOf(file)) >> pose;
  EXPECT_EQ(pose["state"].asString(), "sure");
  EXPECT_THAT(runLive(arguments).err, Not(HasSubstr("pose")));
  pose["part"] = "cellar";
  std::ofstream(file) << pose;
  EXPECT_THAT(runLive(arguments).err, HasSubstr("the map has no part 'cellar'")) << "so it is begun there";
  std::ofstream(file) << "torn";
  const ToolRun run = ok(runLive(arguments));
  EXPECT_THAT(run.err, HasSubstr("last.json: holds no pose of an earlier run"));
}

std::string stateOf(const std::string& map) { return readMap(map).meta.at("state"); }

TEST_F(LiveTool, MakesAMapInWhichTheCameraIsFound) {
  const std::string made = folder_ / "made.flmap", results = folder_ / "results", again = folder_ / "again";
  const ToolRun run =
      ok(runLive({"--device", sequence(), "--headless", "--build", made, "--results", results}));
  EXPECT_THAT(run.out, HasAll("mapping", "map in " + made));
  expectWholeResults(results, 20);
  EXPECT_THAT(checkMap(made), IsEmpty());
  EXPECT_EQ(stateOf(made), "whole");

  const Map map = readMap(made);
  ASSERT_GE(map.models.size(), 5u);
  EXPECT_GE(map.links.size(), map.models.size() - 1);
  const Trajectory truth = readTrajectory(sequence() + "/groundtruth.txt");
  const auto trueAt = [&](double stamp) { return *truth.at(stamp, 1e-3); };
  const Eigen::Isometry3d T_true_w = trueAt(map.models.front().stamp) * map.models.front().T_w_m->inverse();
  for (const LocalModel& model : map.models) {
    ASSERT_TRUE(model.T_w_m) << model.name;
    const Eigen::Isometry3d T = T_true_w * *model.T_w_m;
    EXPECT_LT((T.translation() - trueAt(model.stamp).translation()).norm(), 0.1) << model.name;
  }

  ok(runLive({"--device", sequence(), "--headless", "--map", made, "--results", again}));
  const auto found = readTrajectory(again + "/poses_tum.txt").poses();
  EXPECT_GE(found.size(), 20u);
  for (const StampedPose& pose : found) {
    const Eigen::Isometry3d T = T_true_w * pose.T_w_c;
    EXPECT_LT((T.translation() - trueAt(pose.stamp).translation()).norm(), 0.1) << pose.stamp;
  }
}

TEST_F(LiveTool, LeavesAMapAloneUnlessItIsToBeReplaced) {
  const std::string made = folder_ / "made.flmap";
  const auto build = [&](std::vector<std::string> more) {
    return runLive(Arguments{"--device", sequence(), "--headless", "--build", made, "--speed", "4"} + more);
  };
  ok(build({}));
  const std::string before = contentOf(made);
  EXPECT_THAT(build({}), fails("exists already; --overwrite replaces it"));
  EXPECT_EQ(contentOf(made), before);
  ok(build({"--overwrite"}));
  EXPECT_THAT(checkMap(made), IsEmpty());
  EXPECT_EQ(build({"--map", map()}).code, kUsage);
}

TEST_F(LiveTool, AMapWhoseMakerIsStoppedIsWhole) {
  const std::string made = folder_ / "made.flmap", results = folder_ / "results";
  LiveProcess process(
      {"--device", sequence(), "--headless", "--repeat", "--build", made, "--results", results});
  ASSERT_TRUE(eventually([&] { return linesOf(results + "/states.csv").size() > 20; }));
  process.signal(SIGINT);
  ok(process.wait());
  EXPECT_THAT(checkMap(made), IsEmpty());
  EXPECT_EQ(stateOf(made), "whole");
  EXPECT_GE(readMap(made).models.size(), 2u);
}

TEST_F(LiveTool, AMapWhoseMakerIsKilledIsSound) {
  const std::string made = folder_ / "made.flmap", results = folder_ / "results";
  LiveProcess process(
      {"--device", sequence(), "--headless", "--repeat", "--build", made, "--results", results});
  ASSERT_TRUE(eventually([&] { return linesOf(results + "/states.csv").size() > 30; }));
  process.signal(SIGKILL);
  EXPECT_EQ(process.wait().code, 128 + SIGKILL);
  EXPECT_THAT(checkMap(made), IsEmpty());
  EXPECT_EQ(stateOf(made), "under way");
  EXPECT_GE(readMap(made).models.size(), 2u);
}

}  // namespace
}  // namespace facetloc::test
