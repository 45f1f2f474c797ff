// SPDX-License-Identifier: BSD-3-Clause
// Folders of images that the live tool plays as a camera, good and bad ones.
#include "live_tool.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/testing/example_bag.h>

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <map>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using test::expectWholeResults;
using test::lastLine;
using test::LiveTool;
using test::namesIn;
using test::runLive;
using test::ToolRun;
using testing::HasSubstr;

TEST_F(LiveTool, PlaysAFolderOfClouds) {
  const std::string clouds = writeClouds(10), results = folder_ / "results";
  const ToolRun run =
      runLive({"--device", clouds, "--map", map(), "--headless", "--results", results, "--every-frame"});
  EXPECT_EQ(run.code, kOk) << run.err;
  expectWholeResults(results, 10);
  EXPECT_EQ(readHypotheses(results).front().frame, DepthSequence::open(sequence()).frames()[0].name);
}

TEST_F(LiveTool, LeavesOutCloudsThatCannotBeRead) {
  const std::string clouds = writeClouds(10), results = folder_ / "results";
  const auto names = namesIn(clouds);
  for (const int bad : {0, 4}) test::writeContent(clouds + "/" + names[bad], "no PCD at all");
  const ToolRun run = runLive({"--device", clouds, "--map", map(), "--headless", "--results", results});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.err, HasSubstr("frames are missing: "));
  const Trajectory truth = readTumTrajectory(sequence() + "/groundtruth.txt");
  const auto poses = readTumTrajectory(results + "/poses_tum.txt").poses();
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
  const ToolRun run = runLive({"--device", folder, "--map", map(), "--headless", "--results", results});
  EXPECT_EQ(run.code, kOk) << run.err;
  expectWholeResults(results, 5);
  EXPECT_THAT(lastLine(run.out), HasSubstr("tracking"));
  const ToolRun record = runLive({"--device", folder, "--headless", "--record", folder_ / "x.oni"});
  EXPECT_EQ(record.code, kFailed);
  EXPECT_THAT(record.err, HasSubstr("only devices of OpenNI2 can be recorded"));
}

TEST_F(LiveTool, RefusesPclzfThatPclDoesNotSurvive) {
  const std::string folder = writePclzf(3), image = folder + "/frame_20200101T000000.200000_depth.pclzf";
  const std::string sound = test::contentOf(image);
  const auto error = [&] {
    const ToolRun run = runLive({"--device", folder, "--headless"});
    EXPECT_EQ(run.code, kFailed);
    return run.err;
  };
  const auto withByte = [&](std::size_t at, char value) {
    std::string bytes = sound;
    bytes[at] = value;
    test::writeContent(image, bytes);
    return error();
  };
  EXPECT_THAT(withByte(0, 'Q'), HasSubstr(image + ": is no PCLZF file"));
  EXPECT_THAT(withByte(8, 0x40), HasSubstr(image + ": its size of"));  // the highest byte of its width
  EXPECT_THAT(withByte(5, static_cast<char>(sound[5] + 1)), HasSubstr("do not fit each other"));
  EXPECT_THAT(withByte(13, 'r'), HasSubstr("is no 16-bit depth image"));
  test::writeContent(image, std::string(sound).replace(29, 4, std::string{1, 0, 0, 0}));  // its packed size
  EXPECT_THAT(error(), HasSubstr("its packed size does not fit"));
  fs::remove(image);
  test::writeContent(folder + "/frame_7_depth.pclzf", sound);
  EXPECT_THAT(error(), HasSubstr("frame_7_depth.pclzf: its name tells no time"));
}

TEST_F(LiveTool, SaysThatPclzfFilesCannotBeRead) {
  const std::string folder = writePclzf(10), image = folder + "/frame_20200101T000000.300000_depth.pclzf",
                    camera = folder + "/frame_20200101T000000.500000.xml";
  fs::resize_file(image, fs::file_size(image) / 2);
  const ToolRun run = runLive({"--device", folder, "--headless"});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.err, HasSubstr("frames are missing: 1 of the images cannot be read"));
  EXPECT_THAT(lastLine(run.out), HasSubstr("9 frames received"));

  for (const char* content : {"", "<depth><focal_length_x>", "no XML"}) {
    test::writeContent(camera, content);
    const ToolRun torn = runLive({"--device", folder, "--headless"});
    EXPECT_EQ(torn.code, kFailed);
    EXPECT_THAT(torn.err, HasSubstr(camera + ": no camera parameters"));
  }
  fs::remove(camera);
  const ToolRun missing = runLive({"--device", folder, "--headless"});
  EXPECT_EQ(missing.code, kFailed);
  EXPECT_THAT(missing.err, HasSubstr("10 depth images, but only 9 .xml"));
}

TEST_F(LiveTool, SaysThatImagesCannotBeRead) {
  const std::string copy = folder_ / "copy", results = folder_ / "results";
  fs::copy(sequence(), copy, fs::copy_options::recursive);
  const auto names = namesIn(copy + "/depth");
  test::writeContent(copy + "/depth/" + names[7], "no PNG at all");
  const std::vector<std::string> arguments = {"--device", copy, "--headless", "--results", results};
  const ToolRun run = runLive(arguments);
  EXPECT_EQ(run.code, kOk);
  EXPECT_THAT(run.err, HasSubstr("frames are missing: "));
  EXPECT_THAT(run.err, HasSubstr(names[7]));
  EXPECT_THAT(lastLine(run.out), HasSubstr("39 frames received"));
  const ToolRun stopped = runLive({"--device", copy, "--headless", "--max-frames", "30"});
  EXPECT_EQ(stopped.code, kOk);
  EXPECT_THAT(stopped.err, HasSubstr(names[7]));

  for (const std::string& name : names) test::writeContent(copy + "/depth/" + name, "no PNG at all");
  const ToolRun none = runLive(arguments);
  EXPECT_EQ(none.code, kFailed);
  EXPECT_THAT(none.err, HasSubstr("ended without a frame: "));
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
  if (test::hasBags()) {
    ASSERT_TRUE(test::writeBag(images, bag, "uint16"));
    recordings[bag] = 40;
  }
  for (const char* words : {"db3", "mcap lz4", "db3 split", "rtabmap"}) {
    if (!test::hasRecordings()) break;
    const std::string container = words, ending = container == "rtabmap" ? "db" : container.substr(0, 4);
    const std::string recording = folder_ / ("walk_of_" + std::to_string(recordings.size()) + "." + ending);
    ASSERT_TRUE(test::writeRecording(images, recording, words)) << words;
    recordings[recording] = 40;
  }
  ASSERT_EQ(runLive({"--device", sequence(), "--headless", "--record", oni, "--speed", "0.3"}).code, kOk);
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
  const std::string copy = folder_ / "copy";
  fs::copy(sequence(), copy, fs::copy_options::recursive);
  const auto names = namesIn(copy + "/depth");
  for (const std::size_t bad : {0u, 7u, 39u})
    test::writeContent(copy + "/depth/" + names[bad], "no PNG at all");
  const ToolRun run = runLive({"--device", copy, "--headless", "--every-frame", "--speed", "0"});
  EXPECT_EQ(run.code, kOk);
  EXPECT_THAT(run.err, HasSubstr("frames are missing: "));
  EXPECT_THAT(lastLine(run.out), HasSubstr("37 frames received, 37 processed"));

  for (const std::string& name : names) test::writeContent(copy + "/depth/" + name, "no PNG at all");
  for (const bool repeat : {false, true}) {
    std::vector<std::string> arguments = {"--device", copy, "--headless", "--every-frame"};
    if (repeat) arguments.push_back("--repeat");
    const ToolRun none = runLive(arguments);
    EXPECT_EQ(none.code, kFailed);
    EXPECT_THAT(none.err, HasSubstr("ended without a frame: "));
  }
}

TEST_F(LiveTool, EveryFrameNeedsAFile) {
  for (const std::vector<std::string>& device : {std::vector<std::string>{}, {"--device", "#1"}}) {
    std::vector<std::string> arguments = {"--headless", "--every-frame"};
    arguments.insert(arguments.end(), device.begin(), device.end());
    const ToolRun run = runLive(arguments);
    EXPECT_EQ(run.code, kUsage);
    EXPECT_THAT(run.err, HasSubstr("every-frame belongs to a recording"));
  }
  const ToolRun missing = runLive({"--device", folder_ / "no.bag", "--headless", "--every-frame"});
  EXPECT_EQ(missing.code, kFailed);
  EXPECT_THAT(missing.err, HasSubstr("no.bag"));
}

TEST_F(LiveTool, PlaysABagAsOtherRecordings) {
  if (!test::hasBags()) GTEST_SKIP() << "no python3-rosbag to write bags with, or a build that reads none";
  const std::string bag = folder_ / "walk.bag", results = folder_ / "results";
  ASSERT_TRUE(test::writeBag(DepthSequence::open(sequence()), bag, "uint16"));
  const ToolRun run = runLive({"--device", bag, "--map", map(), "--headless", "--results", results,
                               "--max-frames", "60", "--repeat"});
  EXPECT_EQ(run.code, kOk) << run.err;
  expectWholeResults(results, 60);
  EXPECT_THAT(lastLine(run.out), HasSubstr("tracking"));
  const ToolRun topic = runLive({"--device", bag, "--headless", "--topic", "/nothing"});
  EXPECT_EQ(topic.code, kFailed);
  EXPECT_THAT(topic.err, HasSubstr("/nothing"));
}

TEST_F(LiveTool, TakesTheCameraOfAMap) {
  const std::string bare = folder_ / "bare", results = folder_ / "results";
  fs::create_directories(bare);
  const DepthSequence images = DepthSequence::open(sequence());
  for (std::size_t i = 0; i < 10; ++i)
    writeDepthPng(fs::path(bare) / (images.frames()[i].name + ".png"), images.load(i), 1000);
  const ToolRun run = runLive({"--device", bare, "--camera", map(), "--map", map(), "--headless", "--results",
                               results, "--every-frame"});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.err, HasSubstr("assumed to be millimetres"));
  EXPECT_THAT(lastLine(run.out), HasSubstr("tracking"));
  // The map's camera also replaces the one of a device.
  const std::vector<std::string> of_device = {"--device", sequence(),   "--camera",     map(), "--map",
                                              map(),      "--headless", "--max-frames", "3"};
  const ToolRun device = runLive(of_device);
  EXPECT_EQ(device.code, kOk) << device.err;
  EXPECT_THAT(device.err, testing::Not(HasSubstr("mounted")));
}

}  // namespace
}  // namespace facetloc
