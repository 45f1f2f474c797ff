// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"
#include "tools/simulate_app.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/depth_sequence.h>

#include <gmock/gmock.h>

#include <algorithm>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using test::contentOf;
using test::kFrames;
using test::lastLine;
using test::runTool;
using test::ToolRun;
using test::Tools;
using testing::HasSubstr;

TEST_F(Tools, SimulateIsReproducible) {
  for (const std::string scene : {"room", "office", "home", "hall"}) {
    for (const std::string threads : {"1", "2"}) {
      const ToolRun run = runTool<SimulateApp>({scene, "--seed", "9", "--frames", "2", "--width", "160", "-o",
                                                folder_ / scene + threads, "--threads", threads});
      ASSERT_EQ(run.code, kOk) << run.err;
      EXPECT_THAT(lastLine(run.out), HasSubstr(folder_ / scene + threads));
    }
    const fs::path one = folder_ / scene + "1", two = folder_ / scene + "2";
    int compared = 0;
    for (const auto& entry : fs::recursive_directory_iterator(one)) {
      if (!entry.is_regular_file()) continue;
      EXPECT_EQ(contentOf(entry.path()), contentOf(two / fs::relative(entry.path(), one))) << entry.path();
      ++compared;
    }
    // Two runs of camera.ini, groundtruth.txt, planes.csv, depth and labels; unmapped.txt.
    EXPECT_EQ(compared, 2 * (3 + 2 * 2) + 1);
  }
}

TEST_F(Tools, SimulateRefusesWhatThereIsNot) {
  const ToolRun run = runTool<SimulateApp>({"palace", "-o", folder_ / "x"});
  EXPECT_EQ(run.code, kUsage);
  for (const char* scene : {"office", "home", "hall", "room"}) EXPECT_THAT(run.err, HasSubstr(scene));
}

TEST_F(Tools, SimulateTakesAnotherCamera) {
  const ToolRun run =
      runTool<SimulateApp>({"room", "--camera", "phone_lidar", "--frames", "1", "-o", folder_ / "lidar"});
  ASSERT_EQ(run.code, kOk) << run.err;
  const CameraFile lidar = *DepthSequence::open(folder_ / "lidar/map").camera();
  EXPECT_EQ(lidar.preset, "phone_lidar");
  EXPECT_EQ(lidar.camera.intrinsics, findCameraPreset("phone_lidar")->intrinsics);
  EXPECT_EQ(lidar.camera.max_depth, 5);

  // An option counts more than the camera: here all pixels are lost.
  const ToolRun blind =
      runTool<SimulateApp>({"room", "--camera", "phone_lidar", "--sensor.random_dropout", "1", "--frames",
                            "1", "--width", "128", "-o", folder_ / "blind"});
  ASSERT_EQ(blind.code, kOk) << blind.err;
  const DepthSequence sequence = DepthSequence::open(folder_ / "blind/map");
  const DepthImage image = sequence.load(0);
  EXPECT_EQ(image.camera.height, 96) << "3 to 4, as its camera";
  EXPECT_EQ(std::count(image.depth.begin(), image.depth.end(), 0.f), 128 * 96);
}

TEST_F(Tools, SimulateRefusesAnUnknownCamera) {
  const ToolRun run = runTool<SimulateApp>({"room", "--camera", "nikon", "-o", folder_ / "x"});
  EXPECT_EQ(run.code, kUsage);
  EXPECT_THAT(run.err, HasSubstr("unknown camera 'nikon'"));
  EXPECT_THAT(run.err, HasSubstr("realsense_d435"));
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

TEST_F(Tools, SimulateWritesASequenceWithItsTruth) {
  const DepthSequence sequence = DepthSequence::open(map_run());
  EXPECT_EQ(sequence.frames().size(), static_cast<std::size_t>(kFrames));
  ASSERT_TRUE(sequence.camera() && sequence.camera()->camera.mounting);
  EXPECT_EQ(sequence.camera()->camera.intrinsics, scaledKinect(320));
  for (const FrameFile& frame : sequence.frames()) {
    EXPECT_TRUE(sequence.groundTruth().nearest(frame.stamp, 1e-6));
    EXPECT_TRUE(fs::exists(map_run() + "/labels/" + frame.path.filename().string()));
  }
}

TEST_F(Tools, SimulateDrivesInRealTime) {
  const std::vector<std::string> common = {"room", "--seed",  "5",   "--frames",    "2", "--width",
                                           "80",   "--drive", "1.5", "--pace.rate", "10"};
  const auto simulate = [&](const std::string& folder, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = common;
    arguments.insert(arguments.end(), more.begin(), more.end());
    arguments.insert(arguments.end(), {"-o", folder_ / folder});
    return runTool<SimulateApp>(arguments);
  };
  ASSERT_EQ(simulate("all", {"--threads", "2"}).code, kOk);
  for (const char* run : {"map", "query", "drive"}) EXPECT_TRUE(fs::exists(folder_ / "all/" + run)) << run;
  const ToolRun alone = simulate("alone", {"--runs", "drive"});
  ASSERT_EQ(alone.code, kOk) << alone.err;
  EXPECT_THAT(alone.out, HasSubstr("15 images"));
  EXPECT_FALSE(fs::exists(folder_ / "alone/map"));
  EXPECT_FALSE(fs::exists(folder_ / "alone/query"));

  const DepthSequence drive = DepthSequence::open(folder_ / "alone/drive");
  ASSERT_EQ(drive.frames().size(), 15u);
  EXPECT_EQ(drive.groundTruth().poses().size(), 15u);
  for (std::size_t i = 0; i < drive.frames().size(); ++i) {
    EXPECT_NEAR(drive.frames()[i].stamp, drive.frames()[0].stamp + 0.1 * static_cast<double>(i), 1e-6);
    EXPECT_TRUE(drive.groundTruth().nearest(drive.frames()[i].stamp, 1e-6));
    const fs::path file = drive.frames()[i].path.filename();
    EXPECT_EQ(contentOf(drive.frames()[i].path), contentOf(fs::path(folder_ / "all/drive/depth") / file));
  }
  EXPECT_FALSE(fs::exists(folder_ / "alone/drive/labels"));

  EXPECT_EQ(simulate("alone", {"--runs", "drive"}).code, kFailed);  // is there already
  EXPECT_EQ(simulate("alone", {"--runs", "map"}).code, kOk);        // beside it
  EXPECT_THAT(simulate("other", {"--runs", "flight"}).err, HasSubstr("map query drive"));
  EXPECT_EQ(simulate("other", {"--pace.rate", "0"}).code, kUsage);
}

}  // namespace
}  // namespace facetloc
