// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "evaluation/evaluation.h"
#include "evaluation/trajectory_errors.h"
#include "example_room.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/testing/full_disk.h>

namespace facetloc::test {
namespace {

TEST_F(Tools, MapBuildRemovesTheDepthDistortion) {
  constexpr double kStrength = 3;  // [DU]: a bad camera
  ok(runTool<simulateApp>({"room", "-o", folder_ / "", "--seed", "8", "--map-frames", "60", "--query-frames",
                           "20", "--width", "320", "--drive.turn_deg", "8", "--sensor.distortion",
                           text::decimals(kStrength, 0)}));
  const auto meanError = [&](const std::string& name, const std::vector<std::string>& options) {
    const std::string map = folder_ / name + ".flmap", results = folder_ / name;
    ok(runMap(Arguments{"build", folder_ / "map", "-o", map} + options));
    ok(runTool<localizeApp>({map, folder_ / "query", "-o", results}));
    const Evaluation evaluation =
        evaluate(readHypotheses(results), readTrajectory(folder_ / "query/groundtruth.txt"), {}, {});
    return summarize("", evaluation.frames).translation_mm.mean;
  };
  const double raw = meanError("raw", {"--raw-depth"}), corrected = meanError("corrected", {});
  EXPECT_LT(corrected, 0.5 * raw);
  EXPECT_FALSE(readMap(folder_ / "raw.flmap").camera.distortion);
  const auto distortion = readMap(folder_ / "corrected.flmap").camera.distortion;
  ASSERT_TRUE(distortion);
  EXPECT_NEAR(distortion->rms() * kKinectGain, kStrength, 0.4 * kStrength);
  EXPECT_THAT(runMap({"info", folder_ / "raw.flmap"}).out, HasSubstr("distortion taken out"));
  EXPECT_THAT(runMap({"info", folder_ / "corrected.flmap"}).out, HasSubstr("disparity units"));

  EXPECT_THAT(ok(runMap({"merge", folder_ / "corrected.flmap", map(), "-o", folder_ / "both.flmap",
                         "--same-coordinates"}))
                  .err,
              HasSubstr("differ in the distortion that was taken out; the merged one has the one of " +
                        (folder_ / "corrected.flmap")));
  EXPECT_EQ(readMap(folder_ / "both.flmap").camera.distortion->values(), distortion->values());
  // Going on with a map leaves its distortion as it is.
  ok(runMap({"build", folder_ / "map", "-o", folder_ / "corrected.flmap", "--resume"}));
  EXPECT_EQ(readMap(folder_ / "corrected.flmap").camera.distortion->values(), distortion->values());
}

TEST_F(Tools, MapBuildRefusesToOverwriteAndResumes) {
  const std::string path = folder_ / "m.flmap";
  ok(runMap({"build", map_run(), "-o", path, "--every", "3"}));
  EXPECT_EQ(readMap(path).models.size(), 4u);
  EXPECT_EQ(readMap(path).links.size(), 3u);
  EXPECT_EQ(runMap({"build", map_run(), "-o", path, "--every", "3"}).code, kFailed);
  EXPECT_EQ(runMap({"build", map_run(), "-o", path, "--every", "3", "--resume", "--overwrite"}).code, kUsage);
  EXPECT_THAT(ok(runMap({"build", map_run(), "-o", path, "--every", "3", "--resume"})).out,
              HasSubstr("0 local models added from 12 images, 4 in all"));
  EXPECT_EQ(readMap(path).links.size(), 3u);
  EXPECT_EQ(runMap({"build", map_run(), "-o", path, "--every", "4", "--resume"}).code,
            kFailed);  // other parameters
  ok(runMap({"build", map_run(), "-o", path, "--every", "4", "--overwrite"}));
  EXPECT_EQ(readMap(path).models.size(), 3u);
}

TEST_F(Tools, MapBuildTakesAnEmptyFileForNone) {
  const std::string path = folder_ / "m.flmap";
  for (const char* how : {"", "--resume", "--overwrite"}) {
    writeContent(path, "");
    std::vector<std::string> arguments = {"build", map_run(), "-o", path, "--every", "3"};
    if (*how) arguments.push_back(how);
    const ToolRun run = runMap(arguments);
    EXPECT_EQ(run.code, kOk) << how << ": " << run.err;
    EXPECT_EQ(readMap(path).models.size(), 4u);
  }
}

TEST_F(Tools, AnInterruptedMapIsDistinguishedFromAWholeOne) {
  const std::string path = folder_ / "m.flmap";
  const std::vector<std::string> build = {"build", map_run(), "-o", path, "--every", "3", "--resume"};
  const auto told = [&](const ToolRun& run) {
    EXPECT_EQ(run.code, kOk) << run.err;
    return run.err.find("its build has not ended") != std::string::npos;
  };
  ok(runMap(build));
  EXPECT_FALSE(told(runMap({"check", path})));
  EXPECT_THAT(runMap({"info", path}).out, HasSubstr("state: whole"));
  MapDatabase::open(path).setMeta("state", "under way");  // as until the build ends
  EXPECT_TRUE(told(runMap({"check", path})));
  EXPECT_TRUE(told(runTool<localizeApp>({path, firstImage(), "-o", folder_ / "results"})));
  EXPECT_TRUE(told(runMap({"merge", path, map(), "-o", folder_ / "both.flmap"})));
  ok(runMap(build));
  EXPECT_FALSE(told(runMap({"check", path})));
}

TEST_F(Tools, MapBuildLeavesTheOldMapUntilTheNewOneIsThere) {
  const std::string input = folder_.copyOf(query(), "input"), path = folder_ / "m.flmap";
  ok(runMap({"build", input, "-o", path, "--every", "3"}));
  const std::string old = contentOf(path);
  for (const fs::path& image : filesOf(input + "/depth")) writeContent(image, "no PNG at all");
  EXPECT_THAT(runMap({"build", input, "-o", path, "--every", "3", "--overwrite"}),
              fails("4 of 4 items failed", "m.flmap: is not written"));
  EXPECT_EQ(contentOf(path), old);
  {
    const FullDisk full(old.size() / 2);
    EXPECT_THAT(runMap({"build", query(), "-o", path, "--every", "3", "--overwrite"}),
                fails("m.flmap: cannot be written: "));
  }
  EXPECT_EQ(contentOf(path), old);
  EXPECT_EQ(filesOf(folder_ / "").size(), 2u) << "nothing else is left";

  EXPECT_EQ(runMap({"build", input, "-o", folder_ / "new.flmap", "--every", "3"}).code, kFailed);
  EXPECT_FALSE(fs::exists(folder_ / "new.flmap"));
}

TEST_F(Tools, MapBuildResumesNothingOfOtherInputs) {
  const std::string input = folder_.copyOf(query(), "input"), path = folder_ / "m.flmap";
  const auto resume = [&] { return runMap({"build", input, "-o", path, "--every", "3", "--resume"}); };
  ok(resume());
  ok(resume());
  std::vector<StampedPose> poses = readTrajectory(query() + "/groundtruth.txt").poses();
  for (StampedPose& pose : poses) pose.T_w_c.translation().x() += 0.01;
  writeTumTrajectory(input + "/groundtruth.txt", poses);
  EXPECT_EQ(resume().code, kFailed);
  fs::copy(query(), input, kReplace);
  ok(resume());
  giveOtherImages(input);
  EXPECT_THAT(resume(), fails("was built of other images, with other poses or other parameters"));
  EXPECT_THAT(runMap({"info", path}).out, Not(HasSubstr("images:")));
}

TEST_F(Tools, MapBuildReportsABadImage) {
  const std::string input = withOneCorruptImage(), path = folder_ / "m.flmap";
  EXPECT_THAT(runMap({"build", input, "-o", path, "--every", "1"}), fails("1 of 12 items failed"));
  EXPECT_EQ(readMap(path).models.size(), 11u);
  fs::copy(query() + "/depth", input + "/depth", kReplace);
  ok(runMap({"build", input, "-o", path, "--every", "1", "--resume"}));
  EXPECT_EQ(readMap(path).models.size(), 12u);
}

TEST_F(Tools, MapBuildEstimatesTheTrajectory) {
  const std::string input = folder_.copyOf(map_run(), "input"), path = folder_ / "m.flmap",
                    found = folder_ / "found.txt";
  fs::remove(input + "/groundtruth.txt");
  EXPECT_THAT(ok(runMap({"build", input, "-o", path, "--trajectory", found})).out,
              HasAll("trajectory: way", "1 piece"));
  const Map map = readMap(path);
  ASSERT_GT(map.models.size(), 5u);
  const Trajectory truth = readTrajectory(map_run() + "/groundtruth.txt");
  const Eigen::Isometry3d T = *truth.at(map.models[0].stamp) * map.models[0].T_w_m->inverse();
  for (const LocalModel& model : map.models)
    EXPECT_LT((T * model.T_w_m->translation() - truth.at(model.stamp)->translation()).norm(), 0.1)
        << model.name;
  EXPECT_GE(map.links.size(), map.models.size() - 1);
  EXPECT_EQ(readTrajectory(found).poses().size(), truth.poses().size());

  const std::string again = folder_ / "again.flmap";
  ok(runMap({"build", map_run(), "-o", again, "--without-poses", "--threads", "1"}));
  const Map other = readMap(again);
  ASSERT_EQ(other.models.size(), map.models.size());
  for (std::size_t i = 0; i < map.models.size(); ++i)
    EXPECT_EQ(other.models[i].T_w_m->matrix(), map.models[i].T_w_m->matrix()) << i;
  ok(runMap({"build", map_run(), "-o", again, "--without-poses", "--resume"}));
  EXPECT_EQ(readMap(again).models.size(), map.models.size());
}

TEST_F(Tools, MapBuildUsesAnOdometryThatDrifts) {
  const std::string odometry = folder_ / "odometry.txt";
  std::vector<StampedPose> poses = readTrajectory(map_run() + "/groundtruth.txt").poses();
  const CameraMounting mounting = *DepthSequence::open(map_run()).camera()->camera.mounting;
  Eigen::Isometry3d drift = Eigen::Isometry3d::Identity();
  for (StampedPose& pose : poses) {
    drift.linear() = expSO3({0, 0, 0.1 * kDegree}) * drift.linear();
    pose.T_w_c = drift * pose.T_w_c * mounting.T_b_c().inverse();  // pose of the robot
  }
  writeTumTrajectory(odometry, poses);
  EXPECT_THAT(
      ok(runMap({"build", map_run(), "-o", folder_ / "m.flmap", "--without-poses", "--odometry", odometry}))
          .err,
      HasSubstr("odometry and images disagree by"));
  for (const LocalModel& model : readMap(folder_ / "m.flmap").models) EXPECT_TRUE(model.T_w_m);

  EXPECT_THAT(runMap({"build", map_run(), "-o", folder_ / "n.flmap", "--without-poses", "--odometry",
                      folder_ / "none.txt"})
                  .err,
              HasSubstr("none.txt"));
}

TEST_F(Tools, MapBuildAllowsForTheUnknownLeanOfARobotOnWheels) {
  ok(runTool<simulateApp>({"room", "-o", folder_ / "", "--seed", "8", "--map-frames", "120", "--query-frames",
                           "2", "--width", "320", "--odometry"}));
  const Trajectory truth = readTrajectory(folder_ / "map/groundtruth.txt");
  const auto errorWith = [&](const std::vector<std::string>& options) {
    const std::string found = folder_ / "found.txt";
    ok(runMap(Arguments{"build", folder_ / "map", "-o", folder_ / "m.flmap", "--without-poses",
                        "--trajectory", found, "--overwrite"} +
              options));
    return trajectoryErrors(readTrajectory(found), truth, 0.02).absolute.rmse;
  };
  const double without = errorWith({}), with = errorWith({"--odometry", folder_ / "map/odometry.txt"});
  EXPECT_LT(with, 1.2 * without);
}

TEST_F(Tools, MapBuildByEveryNeedsNoPoses) {
  const std::string input = folder_.copyOf(map_run(), "input");
  fs::remove(input + "/groundtruth.txt");
  ok(runMap({"build", input, "-o", folder_ / "m.flmap", "--every", "6"}));
  EXPECT_FALSE(hasGivenPose(readMap(folder_ / "m.flmap")));
  ok(runMap({"build", input, "-o", folder_ / "n.flmap", "--poses", map_run() + "/groundtruth.txt"}));
}

TEST_F(Tools, MapBuildNamesPosesOfAnotherConvention) {
  std::vector<StampedPose> inverted = readTrajectory(map_run() + "/groundtruth.txt").poses();
  for (StampedPose& pose : inverted) pose.T_w_c = pose.T_w_c.inverse();
  writeTumTrajectory(folder_ / "inverted.txt", inverted);
  const std::string path = folder_ / "m.flmap";
  std::vector<std::string> build = {"build", map_run(), "-o", path, "--poses", folder_ / "inverted.txt"};
  EXPECT_THAT(runMap(build), fails("they are inverted", "--force"));
  EXPECT_FALSE(fs::exists(path));
  build.emplace_back("--force");
  EXPECT_THAT(ok(runMap(build)).err, HasSubstr("they are inverted"));
  const ToolRun good = runMap({"build", map_run(), "-o", path, "--overwrite"});
  EXPECT_THAT(good.out, HasSubstr("poses and images disagree by 0."));
  EXPECT_EQ(good.err, "");
  EXPECT_THAT(runMap({"info", path}).out, HasSubstr("poses disagree with images by: 0."));
}

TEST_F(Tools, MapBuildMatchesNoPosesWithNamesWithoutNumbers) {
  const std::string input = folder_.copyOf(query(), "input"), truth = query() + "/groundtruth.txt";
  int number = 0;
  for (const fs::path& image : filesOf(input + "/depth"))
    fs::rename(image, input + "/depth/frame_" + std::string(1, static_cast<char>('a' + number++)) + ".png");
  const std::string made = folder_ / "m.flmap";
  EXPECT_THAT(runMap({"build", input, "-o", made, "--poses", truth}).err,
              HasSubstr("no time stamps: poses cannot be matched"));
  EXPECT_THAT(runMap({"build", input, "-o", made}).err, HasSubstr("the trajectory is found from the images"));
  ok(runMap({"build", input, "-o", made, "--every", "6", "--overwrite"}));
  ok(runTool<localizeApp>({map(), input, "-o", folder_ / "results"}));
  EXPECT_THAT(runTool<evaluateApp>({folder_ / "results", truth}), fails("is no time stamp"));
}

TEST_F(Tools, AFileThatIsNoMapIsNotReplaced) {
  const std::string truth = folder_ / "truth.txt";
  fs::copy_file(query() + "/groundtruth.txt", truth);
  const std::string before = contentOf(truth);
  EXPECT_EQ(runMap({"build", query(), "-o", truth, "--overwrite"}).code, kFailed);
  EXPECT_EQ(contentOf(truth), before);
}

TEST_F(Tools, ALinkToAMapStaysOne) {
  const std::string map_file = folder_ / "kept/m.flmap", link = folder_ / "link.flmap";
  fs::create_directories(folder_ / "kept");
  ok(runMap({"build", query(), "-o", map_file, "--every", "6"}));
  fs::create_symlink(map_file, link);
  ok(runMap({"build", query(), "-o", link, "--every", "3", "--overwrite"}));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(readMap(map_file).models.size(), 4u);
}

}  // namespace
}  // namespace facetloc::test
