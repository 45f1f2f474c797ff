// SPDX-License-Identifier: BSD-3-Clause
// The live tool as a user runs it: a process of its own, with the real OpenNI2 and our driver.
#include "base/text.h"
#include "cli/findings_file.h"
#include "live_tool.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/testing/organized_clouds.h>
#include <facetloc/testing/places.h>

#include <pcl/io/lzf_image_io.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>

namespace facetloc::test {

std::vector<std::string> liveCommand(const std::vector<std::string>& arguments, const std::string& display) {
  std::vector<std::string> command = {"/usr/bin/env"};
  if (display.empty())
    command.insert(command.end(), {"-u", "DISPLAY"});
  else
    command.push_back("DISPLAY=" + display);
  command.push_back(kLiveTool);
  return command + arguments;
}

ToolRun runLive(const std::vector<std::string>& arguments) { return LiveProcess(arguments).wait(); }

std::vector<std::string> linesOf(const std::string& path) { return linesIn(contentOf(path)); }

std::vector<std::string> namesIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const fs::path& path : filesOf(folder)) names.push_back(path.filename().string());
  return names;
}

void expectWholeResults(const std::string& folder, std::size_t least_frames) {
  const auto rows = readHypotheses(folder);
  const auto states = linesOf(folder + "/states.csv");
  ASSERT_FALSE(states.empty());
  EXPECT_EQ(states[0], "frame,stamp,state,reason,received,dropped,age_ms");
  EXPECT_GE(rows.size(), least_frames);
  EXPECT_EQ(states.size() - 1, rows.size());
  EXPECT_EQ(readTiming(folder).size(), rows.size());
  const auto localized =
      std::count_if(rows.begin(), rows.end(), [](const ResultRow& row) { return row.rank == 1; });
  EXPECT_EQ(readTrajectory(folder + "/poses_tum.txt").poses().size(), static_cast<std::size_t>(localized));
  EXPECT_THAT(contentOf(folder + "/params.ini"), HasSubstr("width = 320"));
}

std::unique_ptr<TemporaryFolder> LiveTool::room_;

void LiveTool::SetUpTestSuite() {
  room_ = std::make_unique<TemporaryFolder>();
  ok(runTool<simulateApp>({"room", "-o", *room_ / "", "--seed", "5", "--frames", "40", "--width", "320",
                           "--drive.turn_deg", "3", "--drive.step", "0.05"}));
  ok(captured([](const Console& console) {
    return mapProgram().run({"build", *room_ / "map", "-o", map(), "--map.distance", "0.2"}, console);
  }));
}

std::string LiveTool::writeClouds(std::size_t n) const {
  const std::string clouds = folder_ / "clouds";
  fs::create_directories(clouds);
  const DepthSequence images = DepthSequence::open(sequence());
  for (std::size_t i = 0; i < n; ++i) {
    const auto cloud = organizedCloud<pcl::PointXYZ>(images.load(i));
    pcl::io::savePCDFileBinaryCompressed(clouds + "/" + images.frames()[i].name + ".pcd", *cloud);
  }
  return clouds;
}

std::string LiveTool::writePclzf(std::size_t n) const {
  const fs::path folder = folder_ / "pclzf";
  fs::create_directories(folder);
  const DepthSequence images = DepthSequence::open(sequence());
  for (std::size_t i = 0; i < n; ++i) {
    const DepthImage image = images.load(i);
    std::vector<std::uint16_t> millimetres;
    for (const float z : image.depth) millimetres.push_back(static_cast<std::uint16_t>(1000 * z + 0.5f));
    const Intrinsics& k = image.camera;
    const std::string name = "frame_20200101T000000." + std::to_string(i) + "00000";  // each 0.1 s
    pcl::io::LZFDepth16ImageWriter writer;
    EXPECT_TRUE(writer.write(reinterpret_cast<const char*>(millimetres.data()),
                             static_cast<std::uint32_t>(k.width), static_cast<std::uint32_t>(k.height),
                             (folder / (name + "_depth.pclzf")).string()));
    EXPECT_TRUE(writer.writeParameters({k.fx, k.fy, k.cx, k.cy}, (folder / (name + ".xml")).string()));
  }
  return folder.string();
}

namespace {

// Slow enough for a busy machine, which would drop most of the frames otherwise.
constexpr const char* kSlowly = "0.3";

TEST_F(LiveTool, PlaysASequenceAsACamera) {
  const std::string results = folder_ / "results";
  const ToolRun run =
      ok(runLive({"--device", sequence(), "--headless", "--results", results, "--speed", kSlowly}));
  expectWholeResults(results, 5);
  EXPECT_THAT(lastLine(run.out), HasAll(" frames received", "segmenting 100.0 %", results));
  for (const ResultRow& row : readHypotheses(results)) EXPECT_EQ(row.rank, 0);
}

TEST_F(LiveTool, LocalizesInAMap) {
  const std::string results = folder_ / "results";
  const ToolRun run = ok(runLive(
      {"--device", sequence(), "--map", map(), "--headless", "--results", results, "--speed", kSlowly}));
  expectWholeResults(results, 5);
  const Trajectory truth = readTrajectory(sequence() + "/groundtruth.txt");
  const auto poses = readTrajectory(results + "/poses_tum.txt").poses();
  EXPECT_GE(poses.size(), 5u) << run.out;
  for (const StampedPose& pose : poses) {
    const auto true_pose = truth.at(pose.stamp);
    ASSERT_TRUE(true_pose) << "the stamps are those of the sequence: " << pose.stamp;
    EXPECT_LT((pose.T_w_c.translation() - true_pose->translation()).norm(), 0.1) << pose.stamp;
  }
  // No frame older than 100 ms is processed.
  for (const std::string& line : linesOf(results + "/states.csv")) {
    const auto age = text::to<double>(line.substr(line.rfind(',') + 1));
    if (age) {
      EXPECT_LE(*age, 100.0) << line;
    }
  }
}

TEST_F(LiveTool, NamesWhatIsWrongWithItsRecording) {
  const std::string copy = folder_.copyOf(sequence(), "copy"), results = folder_ / "results";
  CameraFile camera = *DepthSequence::open(copy).camera();
  camera.depth_scale *= 40;
  writeCameraFile(copy + "/camera.ini", camera);
  const ToolRun run = ok(
      runLive({"--device", copy, "--headless", "--every-frame", "--max-frames", "3", "--results", results}));
  const Findings found = readFindings(results + "/" + kFindingsFile);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.front().id, "values.scale");
  EXPECT_THAT(run.err, HasSubstr(found.front().text())) << "the words of facetloc_check";
}

TEST_F(LiveTool, TakesItsOwnParameters) {
  const std::string results = folder_ / "results";
  ok(runLive({"--device", sequence(), "--map", map(), "--headless", "--results", results, "--max-frames", "2",
              "--localizer.odometry.key_distance", "0.4"}));
  EXPECT_THAT(contentOf(results + "/params.ini"), HasSubstr("key_distance = 0.4"));
  ok(runLive(
      {"--device", sequence(), "--headless", "--max-frames", "1", "--params", results + "/params.ini"}));
}

TEST_F(LiveTool, RecordsItsImages) {
  const std::string file = folder_ / "run.oni";
  EXPECT_THAT(ok(runLive({"--device", sequence(), "--headless", "--record", file})).err,
              HasSubstr("recorded to " + file));
  const ToolRun played =
      ok(runLive({"--device", file, "--headless", "--results", folder_ / "played", "--speed", kSlowly}));
  expectWholeResults(folder_ / "played", 5);
}

TEST_F(LiveTool, OverwritesNoInputs) {
  const std::string copy = folder_.copyOf(sequence(), "copy"), file = folder_ / "run.oni";
  const auto names = namesIn(copy + "/depth");
  EXPECT_THAT(runLive({"--device", copy, "--headless", "--screenshots", copy + "/depth"}),
              refuses("among the images"));
  EXPECT_EQ(namesIn(copy + "/depth"), names);

  ok(runLive({"--device", sequence(), "--headless", "--record", file, "--max-frames", "3"}));
  const std::string recorded = contentOf(file);
  for (const std::string& device : {file, sequence()}) {
    EXPECT_THAT(runLive({"--device", device, "--headless", "--record", file}),
                fails(file + ": exists already"));
    EXPECT_TRUE(contentOf(file) == recorded);
  }
}

TEST_F(LiveTool, NamesFaultsOfFiles) {
  EXPECT_THAT(runLive({"--device", sequence(), "--map", folder_ / "no.flmap", "--headless"}),
              fails("no.flmap"));
  EXPECT_THAT(runLive({"--device", sequence(), "--camera", folder_ / "no.ini", "--headless"}),
              fails("no.ini"));
  fs::create_directories(folder_ / "empty");
  EXPECT_THAT(runLive({"--device", folder_ / "empty", "--headless"}), fails("empty"));
}

TEST(LiveApp, RefusesSenselessOptions) {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"--every", "0"}, {"--max-frames", "-1"}, {"--duration", "-1"}, {"--speed", "-2"}, {"--foo"}}) {
    EXPECT_EQ(runTool<liveApp>(arguments).code, kUsage) << arguments.front();
  }
}

TEST(LiveApp, HelpListsTheKeys) {
  const ToolRun run = ok(runTool<liveApp>({"--help"}));
  for (const char* key : {"screenshot", "record", "pause", "relocalize", "quit"})
    EXPECT_THAT(run.out, HasSubstr(key));
}

/** Recordings of real sensors lie next to the checkout, or where the environment says. */
TEST(LiveApp, PlaysRealRecordings) {
  const fs::path folder = dataFolder("oni");
  if (!fs::is_directory(folder)) GTEST_SKIP() << folder << " is not there";
  TemporaryFolder results;
  int recordings = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".oni") continue;
    ++recordings;
    const std::string out = results / entry.path().stem().string();
    const ToolRun run = runLive({"--device", entry.path().string(), "--headless", "--results", out});
    EXPECT_EQ(run.code, kOk) << entry.path() << run.err;
    expectWholeResults(out, 5);
  }
  EXPECT_EQ(recordings, 3);
}

}  // namespace
}  // namespace facetloc::test
