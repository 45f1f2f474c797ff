// SPDX-License-Identifier: BSD-3-Clause
// facetloc_check and facetloc_convert on one recording in several states.
#include "cli/findings_file.h"
#include "example_room.h"
#include "inputs/recording_run.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/png.h>
#include <facetloc/testing/example_bag.h>
#include <facetloc/testing/organized_clouds.h>

#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

namespace facetloc::test {
namespace {

class RecordingTools : public Tools {
protected:
  std::string copyOf(const std::string& run) { return folder_.copyOf(run, "copy"); }
  static ToolRun check(const std::string& input, const Arguments& options = {}) {
    return runTool<checkApp>(Arguments{input} + options);
  }
  ToolRun convert(const std::string& input, const std::string& output, const Arguments& options = {}) const {
    return runTool<convertApp>(Arguments{input, "-o", folder_ / output} + options);
  }
};

TEST_F(RecordingTools, CheckDescribesARecording) {
  const ToolRun run = ok(check(map_run()));
  EXPECT_THAT(run.out, HasAll("recording 12 images, images named by their times", "12 images of 12 have one",
                              "mounted 1.000 m above the floor", "inverse_depth_std = 0.0015",
                              "next: facetloc_map build"));
  EXPECT_THAT(run.out, Not(HasSubstr("note\n"))) << "there is nothing to note";
}

TEST_F(RecordingTools, CheckTakesThePosesItIsGiven) {
  const std::string input = copyOf(map_run()), poses = folder_ / "poses.txt";
  fs::rename(input + "/groundtruth.txt", poses);
  EXPECT_THAT(ok(check(input, {"--poses", poses})).out, HasSubstr("12 images of 12 have one"));
}

TEST_F(RecordingTools, CheckFindsTheMountingByTheFloor) {
  ok(runTool<simulateApp>(
      {"office", "-o", folder_ / "", "--seed", "2", "--runs", "query", "--frames", "60", "--width", "320"}));
  const std::string input = folder_ / "query";
  CameraFile file = readCameraFile(input + "/camera.ini");
  const CameraMounting truth = *file.camera.mounting;
  EXPECT_THAT(check(input).out, Not(HasSubstr("mount_height=")));
  file.camera.mounting->height = 0.5;
  writeCameraFile(input + "/camera.ini", file);
  EXPECT_THAT(check(input).out, HasSubstr("not mounted as camera.ini says"));
  file.camera.mounting.reset();
  writeCameraFile(input + "/camera.ini", file);
  const ToolRun run = check(input);
  ASSERT_THAT(run.out, HasSubstr("for camera.ini: mount_height="));
  const auto valueOf = [&](const std::string& key) {
    return std::stod(run.out.substr(run.out.find(key) + key.size()));
  };
  EXPECT_NEAR(valueOf("mount_height="), truth.height, 0.02);
  EXPECT_NEAR(valueOf("mount_tilt_deg="), truth.tilt_deg, 1);
}

TEST_F(RecordingTools, CheckDoubtsAScaleThatNoRoomHas) {
  EXPECT_THAT(check(map_run(), {"--depth-scale", "200"}).out, HasSubstr("is depth_scale right?"));
  EXPECT_THAT(check(map_run(), {"--depth-scale", "200000"}).out, HasSubstr("depth_scale"));
}

TEST_F(RecordingTools, AllToolsWriteTheirFindings) {
  const std::string file = folder_ / "findings.json";
  EXPECT_EQ(check(map_run(), {"--depth-scale", "200000", "--findings", file}).code, kFailed);
  const auto scale = [&] {
    const Findings found = readFindings(file);
    const auto finding =
        std::find_if(found.begin(), found.end(), [](const Finding& f) { return f.id == "values.scale"; });
    return finding == found.end() ? Finding() : *finding;
  };
  EXPECT_EQ(scale().severity, Severity::refusal);
  ASSERT_FALSE(scale().evidence.empty());
  EXPECT_LT(scale().evidence.front().value, 0.1) << "metres";
  const std::string words = scale().words;
  EXPECT_THAT(runMap({"build", map_run(), "-o", folder_ / "small.flmap", "--depth-scale", "200000",
                      "--findings", file}),
              fails(words, "--force"));
  EXPECT_EQ(scale().words, words) << "one judge";
  writeContent(file, "{");
  EXPECT_THROW(readFindings(file), IoError);
}

TEST_F(RecordingTools, ARunIsJudgedAsByTheTool) {
  const DepthSequence sequence = DepthSequence::open(map_run());
  const auto made = [&](const Findings& read) {
    MapMaking making(sequence.camera()->camera);
    addImages(sequence, sequence.groundTruth(), {}, making);
    checkRun(sequence, read, making);
    return making;
  };
  const std::string file = folder_ / "findings.json";
  ok(check(map_run(), {"--findings", file}));
  std::set<std::string> of_tool;
  for (const Finding& finding : readFindings(file)) of_tool.insert(finding.text());
  const Findings found = made({}).findings().list();
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.front().id, PoseCheck::kAccuracy);
  for (const Finding& finding : found) EXPECT_EQ(of_tool.count(finding.text()), 1u) << finding.text();
  EXPECT_FALSE(made({{"values.scale", Severity::refusal, "", ""}}).findings().geometry)
      << "nothing is derived from a refused recording";
}

TEST_F(RecordingTools, CheckDerivesNothingFromImagesInDoubt) {
  const std::string input = copyOf(map_run());
  for (const fs::path& path : filesOf(input + "/depth")) {
    Raster<std::uint16_t> image = readGreyPng(path, 16);
    for (std::uint16_t& value : image.data)
      value = static_cast<std::uint16_t>((value >> 8) | ((value & 0xff) << 8));
    writePng(path, image);
  }
  const ToolRun run = check(input);
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.out, HasAll("bytes of the PNG values are swapped",
                              "not known while the images are in doubt", Not(HasSubstr("mount_height="))));
  EXPECT_THAT(runMap({"build", input, "-o", folder_ / "swapped.flmap"}),
              fails("cannot be right as it is read", "--force"));
  EXPECT_FALSE(fs::exists(folder_ / "swapped.flmap"));
}

TEST_F(RecordingTools, CheckAndBuildNameAScaleByThePoses) {
  const std::string input = copyOf(map_run());
  CameraFile file = readCameraFile(input + "/camera.ini");
  file.depth_scale *= 0.8;
  file.camera.mounting.reset();
  writeCameraFile(input + "/camera.ini", file);
  const ToolRun run = check(input);
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.out, HasAll("depth_scale", Not(HasSubstr("mount_height="))));
  EXPECT_EQ(runMap({"build", input, "-o", folder_ / "scaled.flmap"}).code, kFailed);
  ok(runMap({"build", input, "-o", folder_ / "scaled.flmap", "--force"}));
}

TEST_F(RecordingTools, CheckDoubtsPosesThatAreNotTheImages) {
  const std::string input = copyOf(map_run());
  std::vector<StampedPose> poses = readTrajectory(input + "/groundtruth.txt").poses();
  for (StampedPose& pose : poses) pose.stamp += 1000;
  writeTumTrajectory(input + "/groundtruth.txt", poses);
  EXPECT_THAT(check(input).out, HasAll("0 images of 12 have one", "--time-offset"));
  writeContent(input + "/groundtruth.txt", "nonsense\n");
  EXPECT_THAT(check(input).out, HasAll("cannot be read", "groundtruth.txt: line 1"));
  fs::remove(input + "/groundtruth.txt");
  EXPECT_THAT(check(input).out, HasAll("poses     none", "from the images"));
}

TEST_F(RecordingTools, CheckNamesImagesThatCannotBeRead) {
  const ToolRun run = check(withOneCorruptImage());
  EXPECT_THAT(run, fails("is not a PNG file"));
  EXPECT_THAT(run.out, HasSubstr("next: "));
  const std::string input = copyOf(query());
  for (const fs::path& image : filesOf(input + "/depth")) writeContent(image, "no PNG");
  EXPECT_THAT(check(input).err, HasSubstr("none of its images can be read"));
}

TEST_F(RecordingTools, CheckOfImagesWithoutADepth) {
  const std::string input = copyOf(query());
  const Raster<std::uint16_t> empty{320, 240, 1, std::vector<std::uint16_t>(320 * 240, 65535)};
  for (const fs::path& image : filesOf(input + "/depth")) writePng(image, empty);
  EXPECT_THAT(check(input).out, HasAll("nothing is measured", "no pixel is measured"));
}

TEST_F(RecordingTools, ConvertKeepsImagesCameraAndPoses) {
  const ToolRun run = ok(convert(map_run(), "out"));
  EXPECT_THAT(lastLine(run.out), HasAll("12 images", "recording in"));
  const DepthSequence before = DepthSequence::open(map_run()), after = DepthSequence::open(folder_ / "out");
  ASSERT_EQ(after.frames().size(), before.frames().size());
  for (std::size_t i = 0; i < before.frames().size(); ++i) {
    EXPECT_EQ(after.frames()[i].name, before.frames()[i].name);
    EXPECT_EQ(after.load(i).depth, before.load(i).depth);
  }
  EXPECT_EQ(after.camera()->camera.intrinsics, before.camera()->camera.intrinsics);
  EXPECT_EQ(after.groundTruth().poses().size(), before.groundTruth().poses().size());
  // An existing folder is not touched.
  EXPECT_THAT(convert(query(), "out"), fails("exists already"));
}

TEST_F(RecordingTools, ConvertTakesEveryNthImage) {
  ok(convert(map_run(), "out", {"--every", "5"}));
  EXPECT_EQ(DepthSequence::open(folder_ / "out").frames().size(), 3u);
  EXPECT_EQ(convert(map_run(), "other", {"--every", "0"}).code, kUsage);
}

TEST_F(RecordingTools, ConvertWritesCloudsWithTheirIntrinsics) {
  const DepthSequence walk = DepthSequence::open(map_run());
  const DepthImage image = walk.load(0);
  pcl::PointCloud<pcl::PointXYZ> cloud = *organizedCloud<pcl::PointXYZ>(image);
  cloud(3, 3) = {0, 0, 20};  // farther than fits
  fs::create_directories(folder_ / "clouds");
  pcl::io::savePCDFileBinary(folder_ / "clouds/frame_20121214T142255.814212.pcd", cloud);
  EXPECT_THAT(ok(convert(folder_ / "clouds", "out")).err, HasSubstr("1 pixel farther than 13.1 m"));
  const DepthSequence after = DepthSequence::open(folder_ / "out");
  EXPECT_EQ(after.frames()[0].name, "1355494975.814212");
  EXPECT_NEAR(after.camera()->camera.intrinsics.fx, image.camera.fx, 0.1);
  EXPECT_NEAR(after.load(0).at(100, 100), image.at(100, 100), 1e-4);
}

TEST_F(RecordingTools, ConvertWritesTheOdometryOfABag) {
  if (!hasBags()) GTEST_SKIP() << "no python3-rosbag to write bags with";
  const DepthSequence walk = DepthSequence::open(map_run());
  ASSERT_TRUE(writeBag(walk, folder_ / "walk.bag", "uint16", walk.groundTruth()));
  EXPECT_THAT(ok(convert(folder_ / "walk.bag", "out")).out, HasSubstr("12 poses in odometry.txt"));
  EXPECT_EQ(readTrajectory(folder_ / "out/odometry.txt").poses().size(), 12u);
  EXPECT_EQ(DepthSequence::open(folder_ / "out").frames().size(), 12u);
}

TEST_F(RecordingTools, ConvertWritesThePosesAndGravityOfRos2Messages) {
  if (!hasRecordings()) GTEST_SKIP() << "no Python to write recordings with";
  const DepthSequence walk = DepthSequence::open(map_run());
  ASSERT_TRUE(writeRecording(walk, folder_ / "walk.mcap", "mcap zstd imu=camera_depth_optical_frame",
                             walk.groundTruth()));
  EXPECT_THAT(ok(convert(folder_ / "walk.mcap", "out")).out,
              HasSubstr("12 poses in odometry.txt, gravity.txt"));
  EXPECT_EQ(readTrajectory(folder_ / "out/odometry.txt").poses().size(), 12u);
  const GravityRecord gravity = readGravity(folder_ / "out/gravity.txt", kDegree);
  ASSERT_EQ(gravity.samples().size(), 12u);
  EXPECT_LT((gravity.samples()[5].gravity.down - Eigen::Vector3d::UnitY()).norm(), 1e-6);
}

TEST_F(RecordingTools, ConvertOfAnInvalidRecordingLeavesNothing) {
  EXPECT_EQ(convert(folder_ / "none", "out").code, kFailed);
  EXPECT_FALSE(fs::exists(folder_ / "out"));
  EXPECT_EQ(runTool<convertApp>({map_run()}).code, kUsage);
}

}  // namespace
}  // namespace facetloc::test
