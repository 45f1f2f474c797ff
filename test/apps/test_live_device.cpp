// SPDX-License-Identifier: BSD-3-Clause
// Devices that are missing, come later or send nothing; folders of images that are played as a camera, good
// and bad ones; the end of a run, and its files.
#include "live_tool.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/testing/example_bag.h>

#include <map>

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

TEST_F(LiveTool, SaysThatADeviceIsMissing) {
  const auto start = Clock::now();
  EXPECT_THAT(runLive({"--device", "vanished://camera", "--headless"}),
              fails("facetloc_live: vanished://camera"));
  EXPECT_LT(Clock::now() - start, kPatience / 2);
  EXPECT_THAT(runLive({"--device", folder_ / "nothing.oni", "--headless"}), fails("nothing.oni"));
  EXPECT_THAT(runLive({"--device", "runs/mistyped", "--headless"}), fails("runs/mistyped: does not exist"));
}

TEST_F(LiveTool, WaitsForADeviceUntilStopped) {
  LiveProcess process({"--device", folder_ / "later.oni", "--headless", "--wait"});
  ASSERT_TRUE(eventually([&] { return process.err().find("waiting for it") != std::string::npos; }));
  std::this_thread::sleep_for(2500ms);  // it looks again, and says nothing
  process.signal(SIGINT);
  const ToolRun run = ok(process.wait());
  EXPECT_EQ(run.err.find("waiting"), run.err.rfind("waiting")) << run.err;
}

TEST_F(LiveTool, WaitsForADeviceForALimitedTime) {
  const auto start = Clock::now();
  ok(runLive({"--device", folder_ / "never.oni", "--headless", "--wait", "--duration", "1.5"}));
  EXPECT_GE(Clock::now() - start, 1500ms);
}

TEST_F(LiveTool, SaysThatNoFrameComes) {
  const std::string images = writePclzf(3), results = folder_ / "results";
  const Arguments slow = {"--device", images, "--headless", "--speed", "0.001"};
  const ToolRun run = runLive(slow + Arguments{"--results", results});
  EXPECT_THAT(run, fails("no frame for 3 s"));
  EXPECT_THAT(lastLine(run.out), HasSubstr("1 processed"));
  expectWholeResults(results, 1);

  LiveProcess patient(slow + Arguments{"--wait"});
  ASSERT_TRUE(eventually([&] { return patient.err().find("waiting for it") != std::string::npos; }));
  patient.signal(SIGINT);
  ok(patient.wait());
}

TEST_F(LiveTool, FindsADeviceThatComesLater) {
  const std::string folder = folder_ / "camera.oni";
  LiveProcess process({"--device", folder, "--headless", "--wait"});
  ASSERT_TRUE(eventually([&] { return process.err().find("waiting for it") != std::string::npos; }));
  // A recording in the place where it is waited for.
  ok(runLive({"--device", sequence(), "--headless", "--record", folder_ / "new.oni", "--max-frames", "3"}));
  fs::rename(folder_ / "new.oni", folder);
  const ToolRun run = ok(process.wait());
  EXPECT_THAT(lastLine(run.out), HasSubstr("segmenting 100.0 %"));
}

TEST_F(LiveTool, EndsAfterTheGivenFrames) {
  const std::string results = folder_ / "results";
  ok(runLive({"--device", sequence(), "--headless", "--results", results, "--max-frames", "5", "--repeat"}));
  EXPECT_EQ(readHypotheses(results).size(), 5u);
}

TEST_F(LiveTool, EndsAfterTheGivenTime) {
  const auto start = Clock::now();
  ok(runLive({"--device", sequence(), "--headless", "--duration", "0.5", "--repeat"}));
  EXPECT_GE(Clock::now() - start, 500ms);
}

TEST_F(LiveTool, CtrlCEndsInPeaceAndLosesNothing) {
  for (const int number : {SIGINT, SIGTERM}) {
    const std::string results = folder_ / std::to_string(number);
    LiveProcess process(
        {"--device", sequence(), "--map", map(), "--headless", "--repeat", "--results", results});
    ASSERT_TRUE(eventually([&] { return linesOf(results + "/states.csv").size() > 5; }));
    process.signal(number);
    const ToolRun run = ok(process.wait());
    EXPECT_THAT(lastLine(run.out), HasSubstr("processed"));
    expectWholeResults(results, 5);
  }
}

TEST_F(LiveTool, AKilledRunHasLostNothing) {
  const std::string results = folder_ / "results";
  LiveProcess process(
      {"--device", sequence(), "--map", map(), "--headless", "--repeat", "--results", results});
  ASSERT_TRUE(eventually([&] { return linesOf(results + "/states.csv").size() > 5; }));
  process.signal(SIGKILL);
  EXPECT_EQ(process.wait().code, 128 + SIGKILL);
  EXPECT_GE(readHypotheses(results).size(), 5u);
  EXPECT_NO_THROW(readTrajectory(results + "/poses_tum.txt"));
}

TEST_F(LiveTool, PlaysAFolderOfClouds) {
  const std::string clouds = writeClouds(10), results = folder_ / "results";
  ok(runLive({"--device", clouds, "--map", map(), "--headless", "--results", results, "--every-frame"}));
  expectWholeResults(results, 10);
  EXPECT_EQ(readHypotheses(results).front().frame, DepthSequence::open(sequence()).frames()[0].name);
}

TEST_F(LiveTool, LeavesOutCloudsThatCannotBeRead) {
  const std::string clouds = writeClouds(10), results = folder_ / "results";
  const auto names = namesIn(clouds);
  for (const int bad : {0, 4}) writeContent(clouds + "/" + names[bad], "no PCD at all");
  EXPECT_THAT(ok(runLive({"--device", clouds, "--map", map(), "--headless", "--results", results})).err,
              HasSubstr("frames are missing: "));
  const Trajectory truth = readTrajectory(sequence() + "/groundtruth.txt");
  const auto poses = readTrajectory(results + "/poses_tum.txt").poses();
  EXPECT_GE(poses.size(), 3u);
  for (const StampedPose& pose : poses) {
    const auto true_pose = truth.at(pose.stamp, 1e-6);
    ASSERT_TRUE(true_pose) << pose.stamp;
    EXPECT_LT((pose.T_w_c.translation() - true_pose->translation()).norm(), 0.05) << pose.stamp;
  }
}

TEST_F(LiveTool, PlaysAFolderOfPclzf) {
  const std::string folder = writePclzf(10);
  const std::string results = folder_ / "results";
  const ToolRun run = ok(runLive({"--device", folder, "--map", map(), "--headless", "--results", results}));
  expectWholeResults(results, 5);
  EXPECT_THAT(lastLine(run.out), HasSubstr("tracking"));
  EXPECT_THAT(runLive({"--device", folder, "--headless", "--record", folder_ / "x.oni"}),
              fails("only devices of OpenNI2 can be recorded"));
}

TEST_F(LiveTool, SaysThatImagesCannotBeRead) {
  const std::string copy = folder_.copyOf(sequence(), "copy"), results = folder_ / "results";
  const auto names = namesIn(copy + "/depth");
  writeContent(copy + "/depth/" + names[7], "no PNG at all");
  const std::vector<std::string> arguments = {"--device", copy, "--headless", "--results", results};
  const ToolRun run = ok(runLive(arguments));
  EXPECT_THAT(run.err, HasAll("frames are missing: ", names[7]));
  EXPECT_THAT(lastLine(run.out), HasSubstr("39 frames received"));
  EXPECT_THAT(ok(runLive({"--device", copy, "--headless", "--max-frames", "30"})).err, HasSubstr(names[7]));

  for (const std::string& name : names) writeContent(copy + "/depth/" + name, "no PNG at all");
  EXPECT_THAT(runLive(arguments), fails("ended without a frame: "));
}

/** As fast as possible, which drops most frames otherwise. */
TEST_F(LiveTool, PlaysEveryFrameOfARecording) {
  const std::string oni = folder_ / "run.oni", list = folder_ / "list.txt", bag = folder_ / "walk.bag";
  const DepthSequence images = DepthSequence::open(sequence());
  std::ofstream lines(list);
  for (const FrameFile& frame : images.frames()) lines << frame.stamp << " " << frame.path.string() << "\n";
  lines.close();
  fs::copy(sequence() + "/camera.ini", folder_ / "camera.ini");
  std::map<std::string, std::size_t> recordings = {
      {sequence(), 40}, {writeClouds(10), 10}, {writePclzf(10), 10}, {list, 40}};
  if (hasBags()) {
    ASSERT_TRUE(writeBag(images, bag, "uint16"));
    recordings[bag] = 40;
  }
  for (const char* words : {"db3", "mcap lz4", "db3 split", "rtabmap"}) {
    if (!hasRecordings()) break;
    const std::string container = words, ending = container == "rtabmap" ? "db" : container.substr(0, 4);
    const std::string recording = folder_ / ("walk_of_" + std::to_string(recordings.size()) + "." + ending);
    ASSERT_TRUE(writeRecording(images, recording, words)) << words;
    recordings[recording] = 40;
  }
  ok(runLive({"--device", sequence(), "--headless", "--record", oni, "--speed", "0.3"}));
  recordings[oni] = DepthSequence::open(oni).frames().size();
  int number = 0;
  for (const auto& [device, frames] : recordings) {
    const std::string results = folder_ / std::to_string(number++);
    const ToolRun run = runLive({"--device", device, "--map", map(), "--headless", "--results", results,
                                 "--every-frame", "--speed", "0"});
    EXPECT_EQ(run.code, kOk) << device << run.err;
    expectWholeResults(results, frames);
    EXPECT_EQ(readHypotheses(results).size(), frames) << device;
    EXPECT_THAT(lastLine(run.out), HasSubstr(" 0 dropped")) << device;
  }
}

TEST_F(LiveTool, EveryFrameSkipsImagesThatCannotBeRead) {
  const std::string copy = folder_.copyOf(sequence(), "copy");
  const auto names = namesIn(copy + "/depth");
  for (const std::size_t bad : {0u, 7u, 39u}) writeContent(copy + "/depth/" + names[bad], "no PNG at all");
  const ToolRun run = ok(runLive({"--device", copy, "--headless", "--every-frame", "--speed", "0"}));
  EXPECT_THAT(run.err, HasSubstr("frames are missing: "));
  EXPECT_THAT(lastLine(run.out), HasSubstr("37 frames received, 37 processed"));

  for (const std::string& name : names) writeContent(copy + "/depth/" + name, "no PNG at all");
  for (const bool repeat : {false, true}) {
    std::vector<std::string> arguments = {"--device", copy, "--headless", "--every-frame"};
    if (repeat) arguments.push_back("--repeat");
    EXPECT_THAT(runLive(arguments), fails("ended without a frame: "));
  }
}

TEST_F(LiveTool, EveryFrameNeedsAFile) {
  for (const std::vector<std::string>& device : {std::vector<std::string>{}, {"--device", "#1"}}) {
    EXPECT_THAT(runLive(Arguments{"--headless", "--every-frame"} + device),
                refuses("every-frame belongs to a recording"));
  }
  EXPECT_THAT(runLive({"--device", folder_ / "no.bag", "--headless", "--every-frame"}), fails("no.bag"));
}

TEST_F(LiveTool, PlaysABagAsOtherRecordings) {
  if (!hasBags()) GTEST_SKIP() << "no python3-rosbag to write bags with";
  const std::string bag = folder_ / "walk.bag", results = folder_ / "results";
  ASSERT_TRUE(writeBag(DepthSequence::open(sequence()), bag, "uint16"));
  const ToolRun run = ok(runLive({"--device", bag, "--map", map(), "--headless", "--results", results,
                                  "--max-frames", "60", "--repeat"}));
  expectWholeResults(results, 60);
  EXPECT_THAT(lastLine(run.out), HasSubstr("tracking"));
  EXPECT_THAT(runLive({"--device", bag, "--headless", "--topic", "/nothing"}), fails("/nothing"));
}

TEST_F(LiveTool, TakesTheCameraOfAMap) {
  const std::string bare = folder_ / "bare", results = folder_ / "results";
  fs::create_directories(bare);
  const DepthSequence images = DepthSequence::open(sequence());
  for (std::size_t i = 0; i < 10; ++i)
    writeDepthPng(fs::path(bare) / (images.frames()[i].name + ".png"), images.load(i), 1000);
  const ToolRun run = ok(runLive({"--device", bare, "--camera", map(), "--map", map(), "--headless",
                                  "--results", results, "--every-frame"}));
  EXPECT_THAT(run.err, HasSubstr("assumed to be millimetres"));
  EXPECT_THAT(lastLine(run.out), HasSubstr("tracking"));
  // The map's camera also replaces the one of a device.
  const std::vector<std::string> of_device = {"--device", sequence(),   "--camera",     map(), "--map",
                                              map(),      "--headless", "--max-frames", "3"};
  EXPECT_THAT(ok(runLive(of_device)).err, Not(HasSubstr("mounted")));
}

}  // namespace
}  // namespace facetloc::test
