// SPDX-License-Identifier: BSD-3-Clause
// The tools one after the other, as a user runs them, on a small simulated room.
#include "drawing/offscreen_display.h"
#include "evaluation/evaluate_app.h"
#include "tool_runner.h"
#include "tools/localize_app.h"
#include "tools/map_apps.h"
#include "tools/register_app.h"
#include "tools/render_app.h"
#include "tools/segment_app.h"
#include "tools/simulate_app.h"

#include <facetloc/features/segment_frame.h>
#include <facetloc/io/png.h>
#include <facetloc/io/text.h>

#include <gmock/gmock.h>
#include <pcl/impl/pcl_base.hpp>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <sstream>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using test::contentOf;
using test::lastLine;
using test::runTool;
using test::TemporaryFolder;
using test::ToolRun;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr int kFrames = 12;
constexpr auto kReplace = fs::copy_options::recursive | fs::copy_options::overwrite_existing;

ToolRun runMap(const std::vector<std::string>& arguments) {
  return test::captured([&](const Console& console) { return runMapTool(arguments, console); });
}

std::vector<fs::path> filesOf(const std::string& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/** One simulated room for all tests of this file; each test writes to a folder of its own. */
class Tools : public testing::Test {
protected:
  static void SetUpTestSuite() {
    room_ = std::make_unique<TemporaryFolder>();
    const ToolRun run = runTool<SimulateApp>({"room", "-o", *room_ / "", "--seed", "5", "--frames",
                                              std::to_string(kFrames), "--width", "320", "--turn_deg", "8"});
    ASSERT_EQ(run.code, kOk) << run.err;
    const ToolRun build = runMap({"build", map_run(), "-o", map(), "--model_distance", "0.1"});
    ASSERT_EQ(build.code, kOk) << build.err;
  }
  static void TearDownTestSuite() { room_.reset(); }

  static std::string map_run() { return *room_ / "map"; }
  static std::string query() { return *room_ / "query"; }
  static std::string map() { return *room_ / "map.flmap"; }
  static std::string firstImage() { return filesOf(query() + "/depth").front().string(); }

  /** A folder of good images, one corrupt among them. */
  std::string withOneCorruptImage() const {
    const std::string folder = folder_ / "input";
    fs::create_directories(folder);
    fs::copy(query(), folder, fs::copy_options::recursive);
    test::writeContent(filesOf(folder + "/depth")[4], "no PNG at all");
    return folder;
  }

  /** Those of the other run, under the names that are there. */
  static void giveOtherImages(const std::string& input) {
    const auto names = filesOf(input + "/depth"), images = filesOf(map_run() + "/depth");
    for (std::size_t i = 0; i < names.size(); ++i)
      fs::copy_file(images[i], names[i], fs::copy_options::overwrite_existing);
  }

  TemporaryFolder folder_;

private:
  static std::unique_ptr<TemporaryFolder> room_;
};
std::unique_ptr<TemporaryFolder> Tools::room_;

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

TEST_F(Tools, RefuseOptionsThatMakeNoSense) {
  const std::string out = folder_ / "out";
  for (const char* width : {"-5", "1", "39"})
    EXPECT_EQ(runTool<SegmentApp>({query(), "-o", out, "--width", width}).code, kUsage) << width;
  EXPECT_EQ(runTool<SegmentApp>({firstImage(), "-o", out, "--width", "0"}).code, kOk);
  for (const char* tolerance : {"-1", "nan"}) {
    EXPECT_EQ(runMap({"build", query(), "-o", out + ".flmap", "--pose-tolerance", tolerance}).code, kUsage);
    EXPECT_EQ(runTool<EvaluateApp>({out, query(), "--pose-tolerance", tolerance}).code, kUsage);
  }
  EXPECT_EQ(runTool<SimulateApp>({"room", "-o", folder_ / "x", "--drive", "0.001"}).code, kUsage);
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

TEST_F(Tools, SimulateWritesASequenceWithItsTruth) {
  const DepthSequence sequence = DepthSequence::open(map_run());
  EXPECT_EQ(sequence.frames().size(), static_cast<std::size_t>(kFrames));
  ASSERT_TRUE(sequence.camera() && sequence.camera()->mounting);
  EXPECT_EQ(sequence.camera()->intrinsics, scaledKinect(320));
  for (const FrameFile& frame : sequence.frames()) {
    EXPECT_TRUE(sequence.groundTruth().nearest(frame.stamp, 1e-6));
    EXPECT_TRUE(fs::exists(map_run() + "/labels/" + frame.path.filename().string()));
  }
}

TEST_F(Tools, SimulateDrivesInRealTime) {
  const std::vector<std::string> common = {"room", "--seed",  "5",   "--frames", "2", "--width",
                                           "80",   "--drive", "1.5", "--rate",   "10"};
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
  EXPECT_EQ(simulate("other", {"--rate", "0"}).code, kUsage);
}

TEST_F(Tools, FromMapToEvaluation) {
  const ToolRun info = runMap({"info", map()});
  EXPECT_EQ(info.code, kOk);
  EXPECT_THAT(info.out,
              AllOf(HasSubstr("local models"), HasSubstr("model_distance = 0.1"), HasSubstr("facetloc 0")));
  EXPECT_EQ(runMap({"check", map()}).code, kOk);

  for (const char* threads : {"1", "2"}) {
    const ToolRun run = runTool<LocalizeApp>({map(), query(), "-o", folder_ / threads, "--threads", threads});
    ASSERT_EQ(run.code, kOk) << run.err;
    EXPECT_THAT(lastLine(run.out), AllOf(HasSubstr("12 images"), HasSubstr(folder_ / threads)));
  }
  for (const char* file : {"/hypotheses.csv", "/poses_tum.txt", "/params.ini"}) {
    EXPECT_FALSE(contentOf(folder_ / "1" + file).empty());
    EXPECT_EQ(contentOf(folder_ / "1" + file), contentOf(folder_ / "2" + file)) << file;
  }
  EXPECT_FALSE(fs::exists(folder_ / "1/partial.txt"));

  const ToolRun run = runTool<EvaluateApp>({folder_ / "1", query() + "/groundtruth.txt", "--map", map()});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("TABLE I."), HasSubstr("TABLE II."), HasSubstr("12 (100.00 %)")));
  for (const char* file : {"evaluation.txt", "tables.csv", "frames.csv", "fig6.csv"})
    EXPECT_TRUE(fs::exists(folder_ / "1/evaluation/" + file)) << file;
}

TEST_F(Tools, MapImagesAreFoundInTheirMap) {
  ASSERT_EQ(runTool<LocalizeApp>({map(), map_run(), "-o", folder_ / "results"}).code, kOk);
  const auto rows = readHypotheses(folder_ / "results");
  const Trajectory truth = readTumTrajectory(map_run() + "/groundtruth.txt");
  const Evaluation evaluation = evaluate(rows, truth, {}, {});
  int localized = 0;
  for (const FrameEvaluation& f : evaluation.frames) localized += f.first_correct == 1;
  EXPECT_GE(localized, kFrames * 2 / 3);
}

TEST_F(Tools, ParametersOfResultsCanBeUsedAgain) {
  ASSERT_EQ(
      runTool<LocalizeApp>({map(), firstImage(), "-o", folder_ / "a", "--null_score", "-5", "--width=160"})
          .code,
      kOk);
  ASSERT_EQ(
      runTool<LocalizeApp>({map(), firstImage(), "-o", folder_ / "b", "--params", folder_ / "a/params.ini"})
          .code,
      kOk);
  EXPECT_EQ(contentOf(folder_ / "a/params.ini"), contentOf(folder_ / "b/params.ini"));
  EXPECT_EQ(contentOf(folder_ / "a/hypotheses.csv"), contentOf(folder_ / "b/hypotheses.csv"));
}

TEST_F(Tools, LocalizeResumes) {
  const std::string input = withOneCorruptImage();
  const std::string results = folder_ / "results";
  const ToolRun failed = runTool<LocalizeApp>({map(), input, "-o", results});
  EXPECT_EQ(failed.code, kFailed);
  EXPECT_THAT(failed.err, AllOf(HasSubstr(".png: "), HasSubstr("1 of 12 items failed")));
  EXPECT_EQ(readTiming(results).size(),
            static_cast<std::size_t>(kFrames));  // the corrupt one with its reason

  fs::copy(query() + "/depth", input + "/depth", kReplace);
  ASSERT_EQ(runTool<LocalizeApp>({map(), input, "-o", results, "--resume"}).code, kOk);
  ASSERT_EQ(runTool<LocalizeApp>({map(), input, "-o", folder_ / "at_once"}).code, kOk);
  EXPECT_EQ(contentOf(results + "/hypotheses.csv"), contentOf(folder_ / "at_once/hypotheses.csv"));

  const auto before = fs::last_write_time(results + "/hypotheses.csv");
  EXPECT_EQ(runTool<LocalizeApp>({map(), input, "-o", results, "--resume"}).code, kOk);
  EXPECT_EQ(fs::last_write_time(results + "/hypotheses.csv"), before);

  const ToolRun other =
      runTool<LocalizeApp>({map(), input, "-o", results, "--resume", "--min_support", "99"});
  EXPECT_EQ(other.code, kFailed);
  EXPECT_THAT(other.err, HasSubstr("other parameters"));
}

TEST_F(Tools, LocalizeResumesNothingOfOtherInputs) {
  const std::string input = folder_ / "input", copy = folder_ / "m.flmap", results = folder_ / "results";
  const auto restore = [&] {
    fs::copy(query(), input, kReplace);
    fs::copy_file(map(), copy, fs::copy_options::overwrite_existing);
  };
  const auto resume = [&] { return runTool<LocalizeApp>({copy, input, "-o", results, "--resume"}); };
  const auto expectRefused = [&] {
    const ToolRun run = resume();
    EXPECT_EQ(run.code, kFailed);
    EXPECT_THAT(run.err, HasSubstr("was begun with another map, other images or other parameters"));
  };
  restore();
  ASSERT_EQ(resume().code, kOk);
  EXPECT_EQ(resume().code, kOk);
  MapDatabase::open(copy).setMeta("changed", "yes");
  expectRefused();
  restore();
  giveOtherImages(input);
  expectRefused();
  restore();
  std::ofstream(input + "/camera.ini", std::ios::app) << "\ninverse_depth_std = 0.002\n";
  expectRefused();
  restore();
  EXPECT_EQ(resume().code, kOk);
}

TEST_F(Tools, LocalizeResumesWithFewerImages) {
  const std::string input = folder_ / "input", results = folder_ / "results";
  fs::copy(query(), input, fs::copy_options::recursive);
  ASSERT_EQ(runTool<LocalizeApp>({map(), input, "-o", results}).code, kOk);
  const fs::path gone = filesOf(input + "/depth").front();
  fs::remove(gone);
  const ToolRun run = runTool<LocalizeApp>({map(), input, "-o", results, "--resume"});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_EQ(readTiming(results).size(), kFrames - 1u);
  for (const ResultRow& row : readHypotheses(results)) EXPECT_NE(row.frame, gone.stem());
  EXPECT_THAT(contentOf(results + "/images.txt"), Not(HasSubstr(gone.stem().string())));
}

TEST_F(Tools, ATrajectoryThatCannotBeReadStopsOnlyWhoNeedsIt) {
  const std::string input = folder_ / "input", path = folder_ / "m.flmap";
  fs::copy(query(), input, fs::copy_options::recursive);
  test::writeContent(input + "/groundtruth.txt", "timestamp tx ty tz qx qy qz qw\n");
  EXPECT_EQ(runTool<LocalizeApp>({map(), input, "-o", folder_ / "results"}).code, kOk);
  EXPECT_EQ(runTool<SegmentApp>({input, "-o", folder_ / "out"}).code, kOk);
  EXPECT_EQ(runMap({"build", input, "-o", path, "--poses", query() + "/groundtruth.txt"}).code, kOk);
  const ToolRun run = runMap({"build", input, "-o", folder_ / "other.flmap"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, AllOf(HasSubstr("groundtruth.txt"), HasSubstr("line 1")));
}

TEST_F(Tools, LocalizeResumesWhereItsFilesDiffer) {
  const std::string results = folder_ / "results";
  ASSERT_EQ(runTool<LocalizeApp>({map(), query(), "-o", results}).code, kOk);
  std::vector<std::string> frames;
  for (const TimingRow& row : readTiming(results)) frames.push_back(row.frame);
  const auto removeFrame = [&](const std::string& file, const std::string& frame) {
    std::istringstream in(contentOf(results + file));
    std::string kept;
    for (std::string line; std::getline(in, line);)
      if (line.rfind(frame + ",", 0) != 0) kept += line + "\n";
    test::writeContent(results + file, kept);
  };
  removeFrame("/hypotheses.csv", frames[2]);
  removeFrame("/timing.csv", frames[5]);
  const ToolRun run = runTool<LocalizeApp>({map(), query(), "-o", results, "--resume"});
  EXPECT_EQ(run.code, kOk) << run.err;
  std::vector<std::string> timed;
  for (const TimingRow& row : readTiming(results)) timed.push_back(row.frame);
  EXPECT_EQ(timed, frames);
  std::set<std::string> answered;
  for (const ResultRow& row : readHypotheses(results)) answered.insert(row.frame);
  EXPECT_EQ(answered, std::set<std::string>(frames.begin(), frames.end()));
}

TEST_F(Tools, LocalizeBeginsAnewWithNothingOfAnEarlierRun) {
  const std::string results = folder_ / "results";
  ASSERT_EQ(runTool<LocalizeApp>({map(), query(), "-o", results}).code, kOk);
  fs::create_directories(results + "/params.ini.tmp");  // as if it were interrupted there
  EXPECT_EQ(runTool<LocalizeApp>({map(), query(), "-o", results, "--min_support", "99"}).code, kFailed);
  for (const char* file : {"/hypotheses.csv", "/poses_tum.txt", "/timing.csv"})
    EXPECT_FALSE(fs::exists(results + file)) << file;
}

TEST_F(Tools, ResultsReplaceNoInputs) {
  const std::string list = folder_ / "images.txt", params = folder_ / "params.ini";
  test::writeContent(list, firstImage() + "\n");
  test::writeContent(params, "# mine\nwidth = 320\n");
  const std::string here = folder_ / "";
  const auto refuses = [&](const ToolRun& run, const std::string& input) {
    EXPECT_EQ(run.code, kUsage);
    EXPECT_THAT(run.err, HasSubstr("the results would replace " + input));
  };
  refuses(runTool<LocalizeApp>({map(), list, "-o", here}), list);
  refuses(runTool<LocalizeApp>({map(), firstImage(), "-o", here, "--params", params}), params);
  refuses(runTool<SegmentApp>({list, "-o", here}), list);
  refuses(runTool<SegmentApp>({firstImage(), "-o", here, "--params", params}), params);
  EXPECT_EQ(runTool<LocalizeApp>({map(), firstImage(), "-o", here, "--params", params, "--resume"}).code,
            kFailed);
  EXPECT_EQ(runTool<SegmentApp>({firstImage(), "-o", here, "--params", params, "--resume"}).code, kFailed);
  EXPECT_EQ(contentOf(list), firstImage() + "\n");
  EXPECT_EQ(contentOf(params), "# mine\nwidth = 320\n");

  const std::string results = folder_ / "results";
  ASSERT_EQ(runTool<LocalizeApp>({map(), firstImage(), "-o", results}).code, kOk);
  EXPECT_EQ(runTool<LocalizeApp>(
                {map(), firstImage(), "-o", results, "--params", results + "/params.ini", "--resume"})
                .code,
            kOk);
}

TEST_F(Tools, LocalizeSaysWhatIsMissing) {
  EXPECT_EQ(runTool<LocalizeApp>({map(), query()}).code, kUsage);
  EXPECT_EQ(runTool<LocalizeApp>({folder_ / "nowhere.flmap", query(), "-o", folder_ / "x"}).code, kFailed);
  const ToolRun run = runTool<LocalizeApp>({map(), folder_ / "nowhere", "-o", folder_ / "x"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_EQ(run.err, "facetloc_localize: " + (folder_ / "nowhere") + ": does not exist\n");
}

TEST_F(Tools, MapBuildTakesOutWhatTheCameraAlwaysMeasuresWrongly) {
  constexpr double kStrength = 3;  // [DU]: a bad camera
  ASSERT_EQ(runTool<SimulateApp>({"room", "-o", folder_ / "", "--seed", "8", "--map-frames", "60",
                                  "--query-frames", "20", "--width", "320", "--turn_deg", "8", "--distortion",
                                  text::decimals(kStrength, 0)})
                .code,
            kOk);
  const auto meanError = [&](const std::string& name, const std::vector<std::string>& options) {
    const std::string map = folder_ / name + ".flmap", results = folder_ / name;
    std::vector<std::string> build{"build", folder_ / "map", "-o", map};
    build.insert(build.end(), options.begin(), options.end());
    EXPECT_EQ(runMap(build).code, kOk);
    EXPECT_EQ(runTool<LocalizeApp>({map, folder_ / "query", "-o", results}).code, kOk);
    const Evaluation evaluation =
        evaluate(readHypotheses(results), readTumTrajectory(folder_ / "query/groundtruth.txt"), {}, {});
    return summarize("", evaluation.frames).translation_stats.mean;
  };
  const double raw = meanError("raw", {"--raw-depth"}), corrected = meanError("corrected", {});
  EXPECT_LT(corrected, 0.5 * raw);
  EXPECT_FALSE(readMap(folder_ / "raw.flmap").distortion);
  const auto distortion = readMap(folder_ / "corrected.flmap").distortion;
  ASSERT_TRUE(distortion);
  EXPECT_NEAR(distortion->rms() * kKinectGain, kStrength, 0.4 * kStrength);
  EXPECT_THAT(runMap({"info", folder_ / "raw.flmap"}).out, HasSubstr("distortion taken out"));
  EXPECT_THAT(runMap({"info", folder_ / "corrected.flmap"}).out, HasSubstr("disparity units"));

  const ToolRun merge = runMap({"merge", folder_ / "corrected.flmap", map(), "-o", folder_ / "both.flmap"});
  ASSERT_EQ(merge.code, kOk) << merge.err;
  EXPECT_THAT(merge.err,
              HasSubstr("differ in the distortion that was taken out; the merged one has that of " +
                        (folder_ / "corrected.flmap")));
  EXPECT_EQ(readMap(folder_ / "both.flmap").distortion->values(), distortion->values());
  // Going on with a map leaves its distortion as it is.
  ASSERT_EQ(runMap({"build", folder_ / "map", "-o", folder_ / "corrected.flmap", "--resume"}).code, kOk);
  EXPECT_EQ(readMap(folder_ / "corrected.flmap").distortion->values(), distortion->values());
}

TEST_F(Tools, SmoothNoiseIsFoundAndToldOf) {
  const std::string room = folder_ / "room";
  const ToolRun simulate =
      runTool<SimulateApp>({"room", "-o", room, "--seed", "5", "--frames", std::to_string(kFrames), "--width",
                            "320", "--turn_deg", "8", "--disparity_std", "2", "--correlation_px", "3"});
  ASSERT_EQ(simulate.code, kOk) << simulate.err;
  const std::string images = room + "/query";
  const std::string noisy_map = folder_ / "noisy.flmap";
  const auto tells = HasSubstr("the images are noisier than told: inverse_depth_std is about 0.00");
  const ToolRun build = runMap({"build", room + "/map", "-o", noisy_map, "--model_distance", "0.1"});
  ASSERT_EQ(build.code, kOk) << build.err;
  EXPECT_THAT(build.err, tells);
  const ToolRun run = runTool<LocalizeApp>({noisy_map, images, "-o", folder_ / "results"});
  ASSERT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.err, tells);
  EXPECT_THAT(run.out, HasSubstr("12 images, 12 with hypotheses"));
  const ToolRun told =
      runTool<LocalizeApp>({noisy_map, images, "-o", folder_ / "told", "--inverse_depth_std", "0.006"});
  EXPECT_THAT(told.err, Not(HasSubstr("noisier")));
  const ToolRun kinect = runTool<LocalizeApp>({map(), query(), "-o", folder_ / "kinect"});
  EXPECT_THAT(kinect.err, Not(HasSubstr("noisier")));
}

TEST_F(Tools, MapBuildRefusesToOverwriteAndResumes) {
  const std::string path = folder_ / "m.flmap";
  ASSERT_EQ(runMap({"build", map_run(), "-o", path, "--every", "3"}).code, kOk);
  EXPECT_EQ(readMap(path).models.size(), 4u);
  EXPECT_EQ(readMap(path).links.size(), 3u);
  EXPECT_EQ(runMap({"build", map_run(), "-o", path, "--every", "3"}).code, kFailed);
  EXPECT_EQ(runMap({"build", map_run(), "-o", path, "--every", "3", "--resume", "--overwrite"}).code, kUsage);
  const ToolRun resumed = runMap({"build", map_run(), "-o", path, "--every", "3", "--resume"});
  EXPECT_EQ(resumed.code, kOk) << resumed.err;
  EXPECT_THAT(resumed.out, HasSubstr("0 local models added from 12 images, 4 in all"));
  EXPECT_EQ(readMap(path).links.size(), 3u);
  EXPECT_EQ(runMap({"build", map_run(), "-o", path, "--every", "4", "--resume"}).code,
            kFailed);  // other parameters
  EXPECT_EQ(runMap({"build", map_run(), "-o", path, "--every", "4", "--overwrite"}).code, kOk);
  EXPECT_EQ(readMap(path).models.size(), 3u);
}

TEST_F(Tools, MapBuildTakesAnEmptyFileForNone) {
  const std::string path = folder_ / "m.flmap";
  for (const char* how : {"", "--resume", "--overwrite"}) {
    test::writeContent(path, "");
    std::vector<std::string> arguments = {"build", map_run(), "-o", path, "--every", "3"};
    if (*how) arguments.push_back(how);
    const ToolRun run = runMap(arguments);
    EXPECT_EQ(run.code, kOk) << how << ": " << run.err;
    EXPECT_EQ(readMap(path).models.size(), 4u);
  }
}

TEST_F(Tools, AMapWhoseBuildWasInterruptedIsToldFromAWholeOne) {
  const std::string path = folder_ / "m.flmap";
  const std::vector<std::string> build = {"build", map_run(), "-o", path, "--every", "3", "--resume"};
  const auto told = [&](const ToolRun& run) {
    EXPECT_EQ(run.code, kOk) << run.err;
    return run.err.find("its build has not ended") != std::string::npos;
  };
  ASSERT_EQ(runMap(build).code, kOk);
  EXPECT_FALSE(told(runMap({"check", path})));
  EXPECT_THAT(runMap({"info", path}).out, HasSubstr("state: whole"));
  MapDatabase::open(path).setMeta("state", "under way");  // as until the build ends
  EXPECT_TRUE(told(runMap({"check", path})));
  EXPECT_TRUE(told(runTool<LocalizeApp>({path, firstImage(), "-o", folder_ / "results"})));
  EXPECT_TRUE(told(runMap({"merge", path, map(), "-o", folder_ / "both.flmap"})));
  EXPECT_EQ(runMap(build).code, kOk);
  EXPECT_FALSE(told(runMap({"check", path})));
}

TEST_F(Tools, MapBuildLeavesTheOldMapUntilTheNewOneIsThere) {
  const std::string input = folder_ / "input", path = folder_ / "m.flmap";
  fs::copy(query(), input, fs::copy_options::recursive);
  ASSERT_EQ(runMap({"build", input, "-o", path, "--every", "3"}).code, kOk);
  const std::string old = contentOf(path);
  for (const fs::path& image : filesOf(input + "/depth")) test::writeContent(image, "no PNG at all");
  const ToolRun failed = runMap({"build", input, "-o", path, "--every", "3", "--overwrite"});
  EXPECT_EQ(failed.code, kFailed);
  EXPECT_THAT(failed.err, AllOf(HasSubstr("4 of 4 items failed"), HasSubstr("m.flmap: is not written")));
  EXPECT_EQ(contentOf(path), old);
  EXPECT_FALSE(fs::exists(path + ".tmp"));

  fs::create_directories(path + ".tmp/in the way");  // the new map is made there, and cannot be
  EXPECT_EQ(runMap({"build", query(), "-o", path, "--every", "3", "--overwrite"}).code, kFailed);
  EXPECT_EQ(contentOf(path), old);

  EXPECT_EQ(runMap({"build", input, "-o", folder_ / "new.flmap", "--every", "3"}).code, kFailed);
  EXPECT_FALSE(fs::exists(folder_ / "new.flmap"));
}

TEST_F(Tools, MapBuildResumesNothingOfOtherInputs) {
  const std::string input = folder_ / "input", path = folder_ / "m.flmap";
  fs::copy(query(), input, fs::copy_options::recursive);
  const auto resume = [&] { return runMap({"build", input, "-o", path, "--every", "3", "--resume"}); };
  ASSERT_EQ(resume().code, kOk);
  EXPECT_EQ(resume().code, kOk);
  std::vector<StampedPose> poses = readTumTrajectory(query() + "/groundtruth.txt").poses();
  for (StampedPose& pose : poses) pose.T_w_c.translation().x() += 0.01;
  writeTumTrajectory(input + "/groundtruth.txt", poses);
  EXPECT_EQ(resume().code, kFailed);
  fs::copy(query(), input, kReplace);
  EXPECT_EQ(resume().code, kOk);
  giveOtherImages(input);
  const ToolRun run = resume();
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("was built of other images, with other poses or other parameters"));
  EXPECT_THAT(runMap({"info", path}).out, Not(HasSubstr("images:")));
}

TEST_F(Tools, MapBuildReportsABadImage) {
  const std::string input = withOneCorruptImage(), path = folder_ / "m.flmap";
  const ToolRun run = runMap({"build", input, "-o", path, "--every", "1"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("1 of 12 items failed"));
  EXPECT_EQ(readMap(path).models.size(), 11u);
  fs::copy(query() + "/depth", input + "/depth", kReplace);
  EXPECT_EQ(runMap({"build", input, "-o", path, "--every", "1", "--resume"}).code, kOk);
  EXPECT_EQ(readMap(path).models.size(), 12u);
}

TEST_F(Tools, MapBuildNeedsPosesOrEvery) {
  const std::string input = folder_ / "input";
  fs::copy(map_run(), input, fs::copy_options::recursive);
  fs::remove(input + "/groundtruth.txt");
  const ToolRun run = runMap({"build", input, "-o", folder_ / "m.flmap"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("has no poses"));
  EXPECT_FALSE(fs::exists(folder_ / "m.flmap"));
  EXPECT_EQ(runMap({"build", input, "-o", folder_ / "m.flmap", "--every", "6"}).code, kOk);
  EXPECT_FALSE(readMap(folder_ / "m.flmap").models[0].T_w_m);
  EXPECT_EQ(
      runMap({"build", input, "-o", folder_ / "n.flmap", "--poses", map_run() + "/groundtruth.txt"}).code,
      kOk);
}

TEST_F(Tools, MapBuildMatchesNoPosesByIndex) {
  const std::string input = folder_ / "input", truth = query() + "/groundtruth.txt";
  fs::copy(query(), input, fs::copy_options::recursive);
  int number = 0;
  for (const fs::path& image : filesOf(input + "/depth"))
    fs::rename(image, input + "/depth/frame_" + std::to_string(10 + number++) + ".png");
  for (const std::vector<std::string>& poses : {std::vector<std::string>(), {"--poses", truth}}) {
    std::vector<std::string> arguments = {"build", input, "-o", folder_ / "m.flmap"};
    arguments.insert(arguments.end(), poses.begin(), poses.end());
    EXPECT_THAT(runMap(arguments).err, HasSubstr("no time stamps: poses cannot be matched"));
  }
  ASSERT_EQ(runMap({"build", input, "-o", folder_ / "m.flmap", "--every", "6"}).code, kOk);
  ASSERT_EQ(runTool<LocalizeApp>({map(), input, "-o", folder_ / "results"}).code, kOk);
  const ToolRun run = runTool<EvaluateApp>({folder_ / "results", truth});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("is no time stamp"));
}

TEST_F(Tools, AMountingOfAnotherHeightIsNotThatOfTheMap) {
  const std::string lower = folder_ / "lower", unknown = folder_ / "unknown";
  for (const std::string& input : {lower, unknown}) {
    fs::copy(query(), input, fs::copy_options::recursive);
    CameraFile camera = readCameraFile(input + "/camera.ini");
    camera.mounting =
        input == lower ? std::optional(CameraMounting{camera.mounting->height - 0.4, 10}) : std::nullopt;
    writeCameraFile(input + "/camera.ini", camera);
    const ToolRun run = runTool<LocalizeApp>({map(), input, "-o", input + "/results"});
    ASSERT_EQ(run.code, kOk) << run.err;
    EXPECT_THAT(run.err, HasSubstr(input == lower ? "mounted differently, 0.600 m"
                                                  : "mounting of the images' camera is unknown"));
    EXPECT_THAT(run.err, HasSubstr("the prior is isotropic"));
  }
  EXPECT_EQ(contentOf(lower + "/results/hypotheses.csv"), contentOf(unknown + "/results/hypotheses.csv"));
  const ToolRun pair = runTool<RegisterApp>({filesOf(lower + "/depth")[0].string(), firstImage()});
  EXPECT_THAT(pair.err, HasSubstr("mounted differently"));
}

TEST_F(Tools, WhatIsNoMapIsNotReplacedByOne) {
  const std::string truth = folder_ / "truth.txt";
  fs::copy_file(query() + "/groundtruth.txt", truth);
  const std::string before = contentOf(truth);
  EXPECT_EQ(runMap({"build", query(), "-o", truth, "--overwrite"}).code, kFailed);
  EXPECT_EQ(contentOf(truth), before);
}

TEST_F(Tools, ALinkToAMapStaysOne) {
  const std::string map_file = folder_ / "kept/m.flmap", link = folder_ / "link.flmap";
  fs::create_directories(folder_ / "kept");
  ASSERT_EQ(runMap({"build", query(), "-o", map_file, "--every", "6"}).code, kOk);
  fs::create_symlink(map_file, link);
  ASSERT_EQ(runMap({"build", query(), "-o", link, "--every", "3", "--overwrite"}).code, kOk);
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(readMap(map_file).models.size(), 4u);
}

TEST_F(Tools, TrueLabelsAreNotReplacedByFoundOnes) {
  const std::string input = folder_ / "input";
  fs::copy(query(), input, fs::copy_options::recursive);
  const ToolRun run = runTool<SegmentApp>({input, "-o", input + "/labels", "--labels"});
  EXPECT_EQ(run.code, kUsage);
  EXPECT_THAT(run.err, HasSubstr("use another output folder"));
}

TEST_F(Tools, AListOfImagesIsNotTakenForAJournal) {
  const std::string folder = folder_ / "out", list = folder + "/partial.txt";
  fs::create_directories(folder);
  fs::copy_file(query() + "/camera.ini", folder + "/camera.ini");
  std::ofstream(list) << firstImage() << "\n";
  EXPECT_EQ(runTool<LocalizeApp>({map(), list, "-o", folder}).code, kUsage);
  EXPECT_TRUE(fs::exists(list));
}

TEST_F(Tools, ParametersMayContainANumberSign) {
  const std::string out = folder_ / "run#3", file = folder_ / "p.ini";
  std::ofstream(file) << "output = " << out << " # where the results go\n#a comment\n";
  ASSERT_EQ(runTool<SegmentApp>({firstImage(), "--params", file}).code, kOk);
  EXPECT_TRUE(fs::exists(out));
}

TEST_F(Tools, MapMergeAndExport) {
  const std::string twin = folder_ / "twin.flmap", merged = folder_ / "merged.flmap";
  fs::copy_file(map(), twin);
  ASSERT_EQ(runMap({"merge", map(), twin, "-o", merged}).code, kOk);
  const Map one = readMap(map()), both = readMap(merged);
  ASSERT_EQ(both.models.size(), 2 * one.models.size());
  EXPECT_EQ(both.links.size(), 2 * one.links.size());
  EXPECT_EQ(both.models[0].name, "map_" + one.models[0].name);
  EXPECT_EQ(both.models[one.models.size()].name, "twin_" + one.models[0].name);
  EXPECT_TRUE(both.mounting);
  EXPECT_EQ(runMap({"merge", map(), "-o", merged}).code, kFailed);  // exists
  EXPECT_EQ(runMap({"merge", map(), map(), "-o", folder_ / "x.flmap"}).code, kFailed);

  const std::string alike = folder_ / "other/map.flmap";
  fs::create_directories(folder_ / "other");
  ASSERT_EQ(runMap({"build", query(), "-o", alike, "--every", "6"}).code, kOk);
  ASSERT_EQ(runMap({"merge", map(), alike, "-o", folder_ / "both.flmap"}).code, kOk);
  const Map of_both = readMap(folder_ / "both.flmap");
  EXPECT_NE(of_both.meta.at("map.source"), of_both.meta.at("map_2.source"));

  ASSERT_EQ(runMap({"export", map(), "-o", folder_ / "export"}).code, kOk);
  const auto exported = [this] { return filesOf(folder_ / "export/models").size(); };
  const std::size_t models = exported();
  ASSERT_EQ(runMap({"export", alike, "-o", folder_ / "export"}).code, kOk);
  EXPECT_EQ(exported(), 2u);
  EXPECT_GT(models, 2u);
  EXPECT_TRUE(fs::exists(folder_ / "export/graph.g2o"));
}

TEST_F(Tools, MapCommandsAreKnown) {
  EXPECT_EQ(runMap({}).code, kUsage);
  EXPECT_EQ(runMap({"biuld"}).code, kUsage);
  for (const char* option : {"--help", "-help", "-h", "--version", "-version"}) {
    EXPECT_EQ(runMap({option}).code, kOk) << option;
    std::ostringstream full, err;
    full.setstate(std::ios::badbit);
    EXPECT_EQ(runMapTool({option}, Console{full, err, false, false, {}}), kFailed) << option;
    EXPECT_THAT(err.str(), HasSubstr("cannot be written"));
  }
  test::writeContent(folder_ / "broken.flmap", "not a map");
  EXPECT_EQ(runMap({"check", folder_ / "broken.flmap"}).code, kFailed);
  EXPECT_EQ(runMap({"info", folder_ / "broken.flmap"}).code, kFailed);
}

TEST_F(Tools, SegmentWritesSegmentsLabelsAndOverlays) {
  const ToolRun run = runTool<SegmentApp>({firstImage(), "-o", folder_ / "out", "--labels", "--overlay"});
  ASSERT_EQ(run.code, kOk) << run.err;
  const std::string base = folder_ / "out/" + fs::path(firstImage()).stem().string();
  pcl::PointCloud<SegmentFrame> cloud;
  ASSERT_EQ(pcl::PCDReader().read(base + ".segments.pcd", cloud), 0);
  const Raster<std::uint16_t> labels = readGreyPng(base + ".png", 16);
  EXPECT_EQ(labels.width, 320);
  EXPECT_EQ(*std::max_element(labels.data.begin(), labels.data.end()), cloud.size());
  EXPECT_TRUE(fs::exists(base + "_overlay.png"));
}

TEST_F(Tools, SegmentReportsABadImageAndDoesTheOthers) {
  const std::string input = withOneCorruptImage();
  const ToolRun run = runTool<SegmentApp>({input, "-o", folder_ / "out"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("1 of 12 items failed"));
  EXPECT_EQ(filesOf(folder_ / "out").size(), 13u);  // and params.ini and images.txt

  // What is there is not touched, what is missing is done.
  const fs::path first = filesOf(folder_ / "out").front();
  const auto old = fs::file_time_type::clock::now() - std::chrono::hours(24);
  fs::last_write_time(first, old);
  fs::copy(query() + "/depth", input + "/depth", kReplace);
  const ToolRun resumed = runTool<SegmentApp>({input, "-o", folder_ / "out", "--resume"});
  EXPECT_EQ(resumed.code, kOk) << resumed.err;
  EXPECT_THAT(resumed.out, AllOf(HasSubstr("1 image with"), HasSubstr("11 were done before")));
  EXPECT_EQ(filesOf(folder_ / "out").size(), 14u);
  EXPECT_EQ(fs::last_write_time(first), old);
}

TEST_F(Tools, SegmentResumesNothingOfOtherInputs) {
  const std::string input = folder_ / "input", out = folder_ / "out";
  fs::copy(query(), input, fs::copy_options::recursive);
  const auto resume = [&](const std::string& width) {
    return runTool<SegmentApp>({input, "-o", out, "--width", width, "--resume"});
  };
  ASSERT_EQ(resume("160").code, kOk);
  EXPECT_THAT(resume("160").out, HasSubstr("12 were done before"));
  EXPECT_THAT(resume("320").err, HasSubstr("other parameters"));
  giveOtherImages(input);
  EXPECT_THAT(resume("160").err, HasSubstr("other images"));
  const ToolRun anew = runTool<SegmentApp>({input, "-o", out});
  EXPECT_EQ(anew.code, kOk) << anew.err;
  EXPECT_THAT(resume("320").out, HasSubstr("12 were done before"));
}

TEST_F(Tools, SegmentLeavesNothingThatIsOfAnotherRun) {
  const std::string input = folder_ / "input", out = folder_ / "out";
  fs::copy(query(), input, fs::copy_options::recursive);
  const fs::path gone = filesOf(input + "/depth").front();
  const fs::path labels = fs::path(out) / gone.filename();  // as large as the image was taken to be
  ASSERT_EQ(runTool<SegmentApp>({input, "-o", out, "--labels", "--overlay", "--width", "160"}).code, kOk);
  EXPECT_EQ(filesOf(out).size(), 3u * kFrames + 2);
  EXPECT_EQ(readGreyPng(labels, 16).width, 160);

  ASSERT_EQ(runTool<SegmentApp>({input, "-o", out}).code, kOk);
  EXPECT_EQ(filesOf(out).size(), 1u * kFrames + 2) << "labels of width 160";
  const ToolRun resumed = runTool<SegmentApp>({input, "-o", out, "--labels", "--resume"});
  EXPECT_EQ(resumed.code, kOk) << resumed.err;
  EXPECT_THAT(resumed.out, Not(HasSubstr("done before")));
  EXPECT_EQ(readGreyPng(labels, 16).width, 320);

  fs::remove(gone);
  ASSERT_EQ(runTool<SegmentApp>({input, "-o", out, "--labels", "--resume"}).code, kOk);
  EXPECT_EQ(filesOf(out).size(), 2u * (kFrames - 1) + 2);
  EXPECT_FALSE(fs::exists(labels));
}

TEST_F(Tools, SegmentsOfAnEmptyImageAreAValidFile) {
  const std::string input = folder_ / "input";
  fs::create_directories(input);
  fs::copy_file(query() + "/camera.ini", input + "/camera.ini");
  const Intrinsics camera = scaledKinect(320);
  writePng(input + "/0.png",
           Raster<std::uint16_t>{320, camera.height, 1, std::vector<std::uint16_t>(320 * 240, 0)});
  const ToolRun run = runTool<SegmentApp>({input, "-o", folder_ / "out", "--labels", "--overlay"});
  ASSERT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.err, IsEmpty());
  pcl::PointCloud<SegmentFrame> cloud;
  cloud.resize(3);
  EXPECT_EQ(pcl::PCDReader().read(folder_ / "out/0.segments.pcd", cloud), 0);
  EXPECT_TRUE(cloud.empty());
}

TEST_F(Tools, SegmentTellsImagesOfTheSameNameApart) {
  for (const char* run : {"map", "query"}) {
    fs::create_directories(folder_ / run + "/depth");
    fs::copy_file(query() + "/camera.ini", folder_ / run + "/camera.ini");
    fs::copy_file(firstImage(), folder_ / run + "/depth/7.png");
  }
  ASSERT_EQ(runTool<SegmentApp>({folder_ / "map", folder_ / "query/depth/7.png", "-o", folder_ / "out"}).code,
            kOk);
  EXPECT_TRUE(fs::exists(folder_ / "out/map_7.segments.pcd"));
  EXPECT_TRUE(fs::exists(folder_ / "out/query_7.segments.pcd"));
  const ToolRun twice = runTool<SegmentApp>({folder_ / "map", folder_ / "map", "-o", folder_ / "out"});
  EXPECT_EQ(twice.code, kUsage);
  EXPECT_THAT(twice.err, HasSubstr("would both be named"));
}

TEST_F(Tools, RegisterFindsAnImageInItself) {
  const auto images = filesOf(map_run() + "/depth");
  const ToolRun run = runTool<RegisterApp>({images[0].string(), images[1].string(), "-o", folder_ / "out"});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr(folder_ / "out"));
  const auto rows = readHypotheses(folder_ / "out");
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows[0].frame, images[0].stem().string());
  EXPECT_EQ(rows[0].rank > 0 ? rows[0].model : images[1].stem().string(), images[1].stem().string());
  EXPECT_EQ(runTool<RegisterApp>({images[0].string(), map_run()}).code, kUsage);
  EXPECT_EQ(runTool<RegisterApp>({images[0].string(), folder_ / "nowhere.png"}).code, kFailed);
}

TEST_F(Tools, EvaluateTellsThePlacesOfBothRuns) {
  const std::string place = fs::path(map_run()).parent_path().string();
  for (const char* run : {"map", "query"})
    ASSERT_EQ(
        runTool<LocalizeApp>({map(), place + "/" + run, "-o", folder_ / (std::string("results/") + run)})
            .code,
        kOk);
  const std::vector<std::string> arguments = {folder_ / "results", place, "--map", map()};
  const ToolRun run = runTool<EvaluateApp>(arguments);
  ASSERT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("all images"), HasSubstr("new"), HasSubstr("covered"), HasSubstr("Solvable:"),
                    HasSubstr("ERRORS BY THE NUMBER OF VISIBLE PLANES"), HasSubstr("TIME PER IMAGE")));
  EXPECT_THAT(contentOf(folder_ / "results/evaluation/report.html"), HasSubstr("TABLE II."));
  auto again = arguments;
  again.insert(again.end(), {"-o", folder_ / "again"});
  ASSERT_EQ(runTool<EvaluateApp>(again).code, kOk);
  for (const char* file : {"tables.csv", "frames.csv", "fig6.csv", "errors.csv", "timing_summary.csv"})
    EXPECT_EQ(contentOf(folder_ / "results/evaluation/" + file), contentOf(folder_ / "again/" + file))
        << file;
}

TEST_F(Tools, EvaluateLeavesNothingOfAnEarlierOne) {
  const std::string results = folder_ / "results", evaluation = results + "/evaluation";
  ASSERT_EQ(runTool<LocalizeApp>({map(), query(), "-o", results}).code, kOk);
  fs::create_directories(evaluation + "/failures");
  for (const char* stale : {"/failures/miss_1.5.png", "/failures/1.5.png", "/failures/miss_1.5.txt",
                            "/floor_map.png", "/timing_summary.csv"})
    test::writeContent(evaluation + stale, "stale");
  fs::remove(results + "/timing.csv");
  ASSERT_EQ(runTool<EvaluateApp>({results, query()}).code, kOk);
  for (const char* stale : {"/failures/miss_1.5.png", "/floor_map.png", "/timing_summary.csv"})
    EXPECT_FALSE(fs::exists(evaluation + stale)) << stale;
  for (const char* others : {"/failures/1.5.png", "/failures/miss_1.5.txt"})
    EXPECT_TRUE(fs::exists(evaluation + others)) << others;
  EXPECT_TRUE(fs::exists(evaluation + "/report.html"));
}

TEST_F(Tools, EvaluateSaysWhatIsWrongWithItsInput) {
  const std::string results = folder_ / "results";
  ASSERT_EQ(runTool<LocalizeApp>({map(), query(), "-o", results}).code, kOk);
  ASSERT_EQ(runMap({"build", query(), "-o", folder_ / "other.flmap"}).code, kOk);
  ToolRun run = runTool<EvaluateApp>({results, query(), "--map", folder_ / "other.flmap"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("of another map"));
  EXPECT_FALSE(fs::exists(results + "/evaluation"));

  const std::string hypotheses = contentOf(results + "/hypotheses.csv");
  test::writeContent(results + "/hypotheses.csv", hypotheses.substr(0, hypotheses.find('\n') + 1));
  run = runTool<EvaluateApp>({results, query()});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("has results of no image"));
  EXPECT_EQ(runTool<EvaluateApp>({folder_ / "nowhere", query()}).code, kFailed);
}

TEST_F(Tools, RenderDrawsWhatItIsGiven) {
  if (const OffscreenDisplay display; !display.available()) GTEST_SKIP() << display.problem();
  const auto draws = [&](std::vector<std::string> arguments, const std::string& output) {
    arguments.insert(arguments.end(), {"-o", output});
    const ToolRun run = runTool<RenderApp>(arguments);
    EXPECT_EQ(run.code, kOk) << run.err;
    EXPECT_THAT(lastLine(run.out), HasSubstr(output));
    return fs::exists(output);
  };
  EXPECT_TRUE(draws({firstImage()}, folder_ / "image.png"));
  EXPECT_TRUE(draws({firstImage(), "--map", map(), "--max-hypotheses", "2"}, folder_ / "answers.png"));
  EXPECT_TRUE(draws({map(), "--trajectory", query()}, folder_ / "map.png"));
  const std::string name = fs::path(firstImage()).stem().string();
  EXPECT_TRUE(draws({query(), "--frame", name}, folder_ / "again.png"));
  EXPECT_EQ(contentOf(folder_ / "image.png"), contentOf(folder_ / "again.png"));
  EXPECT_TRUE(draws({firstImage()}, folder_ / "alone"));
  EXPECT_EQ(filesOf(folder_ / "alone"), std::vector<fs::path>{folder_ / ("alone/" + name + ".png")});
  EXPECT_TRUE(draws({query()}, folder_ / "all"));
  EXPECT_EQ(filesOf(folder_ / "all").size(), static_cast<std::size_t>(kFrames));

  ASSERT_EQ(runTool<LocalizeApp>({map(), query(), "-o", folder_ / "results"}).code, kOk);
  const std::vector<std::string> failures = {folder_ / "results", "--map", map(),    "--sequence", query(),
                                             "--max_translation", "0",     "--most", "2"};
  EXPECT_TRUE(draws(failures, folder_ / "failures"));
  EXPECT_EQ(filesOf(folder_ / "failures").size(), 3u);  // and failures.png
}

TEST_F(Tools, RenderSaysWhatIsMissing) {
  if (const OffscreenDisplay display; !display.available()) GTEST_SKIP() << display.problem();
  EXPECT_EQ(runTool<RenderApp>({firstImage()}).code, kUsage);
  EXPECT_EQ(runTool<RenderApp>({firstImage(), "-o", firstImage()}).code, kUsage);
  EXPECT_EQ(runTool<RenderApp>({map(), "-o", map()}).code, kUsage);
  EXPECT_EQ(runTool<RenderApp>({query(), "-o", query() + "/depth"}).code, kUsage);
  EXPECT_EQ(runTool<RenderApp>({query(), "-o", folder_ / "several.png"}).code, kUsage);
  EXPECT_EQ(runTool<RenderApp>({firstImage(), "-o", folder_ / "image.jpg"}).code, kUsage);
  EXPECT_EQ(runTool<RenderApp>({query(), "--frame", "nowhere", "-o", folder_ / "x.png"}).code, kUsage);
  const ToolRun run = runTool<RenderApp>({folder_ / "nowhere.png", "-o", folder_ / "x.png"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("nowhere.png: does not exist"));
  ASSERT_EQ(runTool<LocalizeApp>({map(), firstImage(), "-o", folder_ / "results"}).code, kOk);
  EXPECT_EQ(runTool<RenderApp>({folder_ / "results", "-o", folder_ / "x"}).code, kUsage);
}

TEST_F(Tools, RenderOverwritesNothingButPictures) {
  if (const OffscreenDisplay display; !display.available()) GTEST_SKIP() << display.problem();
  const std::string input = folder_ / "input", results = folder_ / "results";
  fs::copy(query(), input, fs::copy_options::recursive);
  fs::copy_file(map(), folder_ / "m.flmap");
  ASSERT_EQ(runTool<LocalizeApp>({map(), query(), "-o", results}).code, kOk);
  const auto images = filesOf(input + "/depth");
  const auto refused = [](const std::vector<std::string>& arguments) {
    return runTool<RenderApp>(arguments).code == kUsage;
  };
  for (const std::string& output :
       {images[1].string(), folder_ / "m.flmap", filesOf(input + "/labels")[0].string()})
    EXPECT_TRUE(refused({images[0].string(), "-o", output})) << output;
  EXPECT_TRUE(refused({map(), "-o", folder_ / "m.flmap"}));
  EXPECT_TRUE(refused({input, "-o", input + "/labels"}));
  const std::vector<std::string> failures = {
      results, "--map", map(), "--sequence", input, "--max_translation", "0"};
  for (const char* folder : {"/depth", "/labels"}) {
    std::vector<std::string> arguments = failures;
    arguments.insert(arguments.end(), {"-o", input + folder});
    EXPECT_TRUE(refused(arguments)) << folder;
  }
  for (const fs::path& image : images)
    EXPECT_EQ(contentOf(image), contentOf(query() + "/depth/" + image.filename().string()));
  EXPECT_EQ(contentOf(folder_ / "m.flmap"), contentOf(map()));
  EXPECT_EQ(filesOf(input + "/depth").size(), images.size());
}

}  // namespace
}  // namespace facetloc
