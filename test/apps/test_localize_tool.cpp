// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "evaluation/evaluation.h"
#include "example_room.h"

#include <facetloc/io/camera_file.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>
#include <facetloc/testing/full_disk.h>

#include <optional>
#include <set>

namespace facetloc::test {
namespace {

TEST_F(Tools, MapImagesAreFoundInTheirMap) {
  ok(runTool<localizeApp>({map(), map_run(), "-o", folder_ / "results"}));
  const auto rows = readHypotheses(folder_ / "results");
  const Trajectory truth = readTrajectory(map_run() + "/groundtruth.txt");
  const Evaluation evaluation = evaluate(rows, truth, {}, {});
  int localized = 0;
  for (const FrameEvaluation& f : evaluation.frames) localized += f.first_correct == 1;
  EXPECT_GE(localized, kFrames * 2 / 3);
}

TEST_F(Tools, AMapOfLinksAloneLocalizesAsWellAsOneWithPoses) {
  Map bare = readMap(map());
  for (LocalModel& model : bare.models) model.T_w_m.reset();
  writeMap(folder_ / "bare.flmap", bare);
  const auto sureIn = [&](const std::string& map, const std::string& results) {
    ok(runTool<localizeApp>({map, query(), "-o", folder_ / results}));
    return readTrajectory(folder_ / (results + "/poses_tum.txt")).poses().size();
  };
  const std::size_t with_poses = sureIn(map(), "posed");
  EXPECT_GT(with_poses, 0u);
  EXPECT_GE(static_cast<double>(sureIn(folder_ / "bare.flmap", "bare")),
            0.95 * static_cast<double>(with_poses));
  EXPECT_THAT(
      runTool<evaluateApp>({folder_ / "bare", query() + "/groundtruth.txt", "--map", folder_ / "bare.flmap"}),
      fails("no world poses"));

  bare.links.erase(bare.links.begin() + static_cast<std::ptrdiff_t>(bare.links.size() / 2));
  writeMap(folder_ / "parts.flmap", bare);
  EXPECT_EQ(sureIn(folder_ / "parts.flmap", "parts"), 0u) << "nothing is in the world";
  bool posed = false;
  for (const ResultRow& row : readHypotheses(folder_ / "parts")) {
    EXPECT_EQ(row.part.empty(), row.rank == 0);
    posed = posed || row.T_w_c;
  }
  EXPECT_TRUE(posed);
}

// The second camera stands where the first one does, and sees the same with the same noise.
TEST_F(Tools, FoldersOfARigAreOneViewWithThePoseOfTheFirst) {
  fs::create_directory(folder_ / "rig");
  for (const char* camera : {"rig/front", "rig/other"}) folder_.copyOf(query(), camera);
  writeContent(folder_ / "rig/rig.ini", "cameras = front other\n");
  ok(runTool<localizeApp>({map(), query(), "-o", folder_ / "one"}));
  ok(runTool<localizeApp>({map(), folder_ / "rig", "-o", folder_ / "both"}));
  EXPECT_THAT(contentOf(folder_ / "both/params.ini"), HasSubstr("# rig: front other, rotation_std_deg 0.5"));
  const auto answers = [&](const char* results) {
    return evaluate(readHypotheses(folder_ / results), readTrajectory(query() + "/groundtruth.txt"), {}, {});
  };
  const Summary one = summarize("", answers("one").frames), both = summarize("", answers("both").frames);
  EXPECT_EQ(both.total, one.total);
  EXPECT_GE(both.best_correct, one.best_correct);
  EXPECT_EQ(both.sure_correct, both.sure);

  writeContent(folder_ / "rig/other/camera.ini",
               "width=640 height=480 fx=525 fy=525 cx=320 cy=240 depth_scale=1000");
  EXPECT_THAT(runTool<localizeApp>({map(), folder_ / "rig", "-o", folder_ / "none"}),
              fails("has no mounting"));
}

TEST_F(Tools, ThePosesOfAnImageArePrinted) {
  const std::string image = firstImage();
  const ToolRun printed = ok(runTool<localizeApp>({map(), image}));
  const ToolRun kept = ok(runTool<localizeApp>({map(), image, "-o", folder_ / "results"}));
  EXPECT_EQ(linesIn(kept.out)[1], linesIn(printed.out)[1]);
  const ResultRow best = readHypotheses(folder_ / "results").front();
  ASSERT_EQ(best.rank, 1);
  std::string place = "world";
  for (const double metres : best.T_w_c->translation()) place += " +" + text::decimals(metres, 3);
  EXPECT_THAT(linesIn(printed.out)[1], ContainsRegex(place));
  EXPECT_THAT(lastLine(printed.out), AllOf(HasSubstr("1 image: "), Not(HasSubstr("results in"))));
  EXPECT_THAT(runTool<localizeApp>({map(), query()}), refuses("-o RESULTS"));
}

TEST_F(Tools, InputsAtTheWrongPlaceAreNamed) {
  const std::string both = map_run() + " is a recording and " + map() + " is a map; the order is ";
  EXPECT_THAT(runTool<localizeApp>({map_run(), map(), "-o", folder_ / "results"}),
              refuses(both + "MAP.flmap... RECORDING -o RESULTS"));
  EXPECT_THAT(runMap({"extend", map_run(), map()}), refuses(both + "MAP.flmap RECORDING"));
  EXPECT_THAT(runMap({"build", "out.flmap", "-o", map_run()}),
              refuses("out.flmap is a map and " + map_run() +
                      " is a recording; the order is RECORDING -o MAP.flmap"));
  EXPECT_THAT(runTool<checkApp>({map()}), refuses(map() + " is a map; expected RECORDING"));
  ok(runTool<localizeApp>({map(), firstImage(), "-o", folder_ / "results"}));
  EXPECT_THAT(runTool<evaluateApp>({map_run(), folder_ / "results"}),
              refuses((folder_ / "results") + " is a folder of results; expected RESULTS"));
  EXPECT_FALSE(fs::exists("out.flmap"));
}

TEST_F(Tools, ParametersOfResultsCanBeUsedAgain) {
  ok(runTool<localizeApp>({map(), firstImage(), "-o", folder_ / "a", "--probability.map_incomplete", "0.1",
                           "--calibration.probability.null_score", "-5", "--width=160"}));
  ok(runTool<localizeApp>({map(), firstImage(), "-o", folder_ / "b", "--params", folder_ / "a/params.ini"}));
  EXPECT_EQ(contentOf(folder_ / "a/params.ini"), contentOf(folder_ / "b/params.ini"));
  EXPECT_EQ(contentOf(folder_ / "a/hypotheses.csv"), contentOf(folder_ / "b/hypotheses.csv"));
}

TEST_F(Tools, AMapThatIsSaidToCoverAllNeedsLessEvidence) {
  const auto localized = [&](const std::string& name, const std::vector<std::string>& options) {
    return runTool<localizeApp>(Arguments{map(), firstImage(), "-o", folder_ / name} + options).code;
  };
  const auto not_in_map = [&](const std::string& name) {
    return readHypotheses(folder_ / name).front().not_in_map;
  };
  ASSERT_EQ(localized("usual", {}), kOk);
  ASSERT_EQ(localized("some", {"--map-covers", "some"}), kOk);
  ASSERT_EQ(localized("all", {"--map-covers", "all"}), kOk);
  ASSERT_EQ(localized("share", {"--map-covers", "0.99"}), kOk);
  EXPECT_EQ(contentOf(folder_ / "usual/hypotheses.csv"), contentOf(folder_ / "some/hypotheses.csv"));
  EXPECT_LT(not_in_map("all"), not_in_map("some"));
  EXPECT_LT(not_in_map("share"), not_in_map("all"));
  for (const std::string wrong : {"none", "0", "1", "1.5", "-0.5"})
    EXPECT_EQ(localized("wrong", {"--map-covers", wrong}), kUsage) << wrong;
  EXPECT_EQ(localized("wrong", {"--map-covers", "all", "--probability.map_incomplete", "0.1"}), kUsage);
}

TEST_F(Tools, ThePapersMethodFindsPlaces) {
  const std::string map = folder_ / "paper.flmap", results = folder_ / "paper";
  ok(runMap({"build", map_run(), "-o", map, "--preset", "paper"}));
  ok(runTool<localizeApp>({map, query(), "-o", results, "--preset", "paper"}));
  EXPECT_THAT(contentOf(fs::path(results) / "params.ini"),
              HasAll("max_expansions = 1000", "max_hypotheses = 20"));
  const Summary all = summarize(
      "", evaluate(readHypotheses(results), readTrajectory(query() + "/groundtruth.txt"), {}, {}).frames);
  EXPECT_EQ(all.none, 0u);
  EXPECT_GE(all.correct, all.total * 5 / 6);
}

TEST_F(Tools, ADriveIsLocalizedAsOne) {
  const auto run = [&](const std::string& threads) {
    const fs::path results = folder_ / ("drive" + threads);
    ok(runTool<localizeApp>({map(), map_run(), "-o", results, "--sequence", "--threads", threads}));
    return results;
  };
  const fs::path once = run("1"), again = run("2");
  EXPECT_EQ(contentOf(once / "hypotheses.csv"), contentOf(again / "hypotheses.csv"));
  EXPECT_THAT(contentOf(once / "params.ini"), HasSubstr("look_distance"));
  const Trajectory truth = readTrajectory(map_run() + "/groundtruth.txt");
  int sure = 0;
  const Trajectory found = readTrajectory(once / "poses_tum.txt");
  for (const StampedPose& p : found.poses()) {
    ++sure;
    EXPECT_TRUE(isNear(p.T_w_c, *truth.at(p.stamp, 0.02), 0.2, 2)) << p.stamp;
  }
  EXPECT_GE(sure, kFrames / 3);
  ok(runTool<localizeApp>({map(), map_run(), "-o", folder_ / "alone"}));
  EXPECT_EQ(readHypotheses(once).front().state, readHypotheses(folder_ / "alone").front().state)
      << "a drive begins as sure as its first image";
}

TEST_F(Tools, ADriveIsAlsoLocalizedByItsLaterImages) {
  const auto run = [&](const std::string& name, const std::vector<std::string>& more) {
    ok(runTool<localizeApp>(Arguments{map(), map_run(), "-o", folder_ / name, "--sequence"} + more));
    return folder_ / name;
  };
  const std::string filtered = run("filtered", {}), smoothed = run("smoothed", {"--smooth"});
  const Trajectory truth = readTrajectory(map_run() + "/groundtruth.txt");
  const auto sure = readTrajectory(smoothed + "/poses_tum.txt").poses();
  EXPECT_GE(sure.size(), readTrajectory(filtered + "/poses_tum.txt").poses().size());
  for (const StampedPose& p : sure) EXPECT_TRUE(isNear(p.T_w_c, *truth.at(p.stamp, 0.02), 0.2, 2)) << p.stamp;
  EXPECT_THAT(contentOf(smoothed + "/params.ini"), HasSubstr("smooth = 1"));
  EXPECT_EQ(runTool<localizeApp>({map(), map_run(), "-o", filtered, "--smooth"}).code, kUsage);
  EXPECT_EQ(runTool<localizeApp>({map(), map_run(), "-o", filtered, "--near", "0,0,1,0"}).code, kUsage);
  EXPECT_EQ(runTool<localizeApp>({map(), map_run(), "-o", filtered, "--sequence", "--near", "here"}).code,
            kUsage);
}

TEST_F(Tools, ADriveSaysWhenItIsFirstSureAndWhyNotBefore) {
  const ToolRun run = ok(runTool<localizeApp>(
      {map(), map_run(), "-o", folder_ / "drive", "--sequence", "--min-probability", "0.999"}));
  std::vector<std::string> frames;
  std::size_t first_sure = 0;
  for (const ResultRow& row : readHypotheses(folder_ / "drive")) {
    if (row.rank > 1) continue;
    frames.push_back(row.frame);
    if (row.state == AnswerState::sure && first_sure == 0) first_sure = frames.size();
    EXPECT_TRUE(row.state == AnswerState::sure || !row.reason.empty()) << row.frame;
  }
  ASSERT_GT(first_sure, 1u);
  EXPECT_THAT(run.out, HasSubstr(", first sure at image " + std::to_string(first_sure) + "; "));
}

TEST_F(Tools, ParametersOfADriveCanBeUsedAgain) {
  ok(runTool<localizeApp>({map(), map_run(), "-o", folder_ / "a", "--sequence", "--min-probability", "0.95",
                           "--localizer.look_distance", "0.2"}));
  ok(runTool<localizeApp>({map(), map_run(), "-o", folder_ / "b", "--params", folder_ / "a/params.ini"}));
  for (const char* file : {"params.ini", "hypotheses.csv", "poses_tum.txt", "covariances.csv"})
    EXPECT_EQ(contentOf(folder_ / ("a/" + std::string(file))),
              contentOf(folder_ / ("b/" + std::string(file))))
        << file;
}

TEST_F(Tools, ADriveIsJudgedFromAllItsStarts) {
  const fs::path results = folder_ / "starts";
  ok(runTool<localizeApp>({map(), map_run(), "-o", results, "--sequence", "--starts", "3"}));
  const std::vector<StartAnswer> answers = readStarts(results);
  std::set<std::string> starts;
  for (const StartAnswer& answer : answers) {
    EXPECT_EQ(starts.count(answer.start) > 0, answer.frame != answer.start) << "each begins with itself";
    starts.insert(answer.start);
  }
  EXPECT_EQ(starts.size(), static_cast<std::size_t>((kFrames + 2) / 3));

  EXPECT_THAT(ok(runTool<evaluateApp>({results, map_run() + "/groundtruth.txt"})).out,
              HasSubstr("FROM A START"));
  for (const char* name : {"starts_by_images.csv", "starts_by_metres.csv"})
    EXPECT_THAT(contentOf(results / "evaluation" / name), HasSubstr("recall,precision"));
  EXPECT_EQ(runTool<localizeApp>({map(), map_run(), "-o", results, "--starts", "3"}).code, kUsage);
  ok(runTool<localizeApp>({map(), map_run(), "-o", results}));
  EXPECT_TRUE(readStarts(results).empty()) << "of an earlier run";
}

TEST_F(Tools, ADriveHasAllItsImages) {
  EXPECT_THAT(runTool<localizeApp>({map(), map_run(), "-o", folder_ / "drive", "--sequence", "--resume"}),
              refuses("--resume"));
  const ToolRun by_overlap =
      runTool<localizeApp>({map(), map_run(), "-o", folder_ / "drive", "--sequence", "--score.by_overlap"});
  EXPECT_EQ(by_overlap.code, kUsage);
}

TEST_F(Tools, LocalizeResumes) {
  const std::string input = withOneCorruptImage();
  const std::string results = folder_ / "results";
  EXPECT_THAT(runTool<localizeApp>({map(), input, "-o", results}), fails(".png: ", "1 of 12 items failed"));
  EXPECT_EQ(readTiming(results).size(),
            static_cast<std::size_t>(kFrames));  // the corrupt one with its reason

  fs::copy(query() + "/depth", input + "/depth", kReplace);
  ok(runTool<localizeApp>({map(), input, "-o", results, "--resume"}));
  ok(runTool<localizeApp>({map(), input, "-o", folder_ / "at_once"}));
  EXPECT_EQ(contentOf(results + "/hypotheses.csv"), contentOf(folder_ / "at_once/hypotheses.csv"));

  const auto before = fs::last_write_time(results + "/hypotheses.csv");
  ok(runTool<localizeApp>({map(), input, "-o", results, "--resume"}));
  EXPECT_EQ(fs::last_write_time(results + "/hypotheses.csv"), before);

  EXPECT_THAT(runTool<localizeApp>({map(), input, "-o", results, "--resume", "--labels.min_support", "99"}),
              fails("other parameters"));
}

TEST_F(Tools, LocalizeResumesNothingOfOtherInputs) {
  const std::string input = folder_ / "input", copy = folder_ / "m.flmap", results = folder_ / "results";
  const auto restore = [&] {
    fs::copy(query(), input, kReplace);
    fs::copy_file(map(), copy, fs::copy_options::overwrite_existing);
  };
  const auto resume = [&] { return runTool<localizeApp>({copy, input, "-o", results, "--resume"}); };
  const auto expectRefused = [&] {
    EXPECT_THAT(resume(), fails("was begun with another map, other images or other parameters"));
  };
  restore();
  ok(resume());
  ok(resume());
  MapDatabase::open(copy).setMeta("changed", "yes");
  expectRefused();
  restore();
  giveOtherImages(input);
  expectRefused();
  restore();
  std::ofstream(input + "/camera.ini", std::ios::app) << "\ninverse_depth_std = 0.002\n";
  expectRefused();
  restore();
  ok(resume());
}

TEST_F(Tools, LocalizeResumesWithFewerImages) {
  const std::string input = folder_.copyOf(query(), "input"), results = folder_ / "results";
  ok(runTool<localizeApp>({map(), input, "-o", results}));
  const fs::path gone = filesOf(input + "/depth").front();
  fs::remove(gone);
  ok(runTool<localizeApp>({map(), input, "-o", results, "--resume"}));
  EXPECT_EQ(readTiming(results).size(), kFrames - 1u);
  for (const ResultRow& row : readHypotheses(results)) EXPECT_NE(row.frame, gone.stem());
  EXPECT_THAT(contentOf(results + "/images.txt"), Not(HasSubstr(gone.stem().string())));
}

TEST_F(Tools, LocalizeResumesWhereItsFilesDiffer) {
  const std::string results = folder_ / "results";
  ok(runTool<localizeApp>({map(), query(), "-o", results}));
  std::vector<std::string> frames;
  for (const TimingRow& row : readTiming(results)) frames.push_back(row.frame);
  const auto removeFrame = [&](const std::string& file, const std::string& frame) {
    std::string kept;
    for (const std::string& line : linesIn(contentOf(results + file)))
      if (line.rfind(frame + ",", 0) != 0) kept += line + "\n";
    writeContent(results + file, kept);
  };
  removeFrame("/hypotheses.csv", frames[2]);
  removeFrame("/timing.csv", frames[5]);
  ok(runTool<localizeApp>({map(), query(), "-o", results, "--resume"}));
  std::vector<std::string> timed;
  for (const TimingRow& row : readTiming(results)) timed.push_back(row.frame);
  EXPECT_EQ(timed, frames);
  std::set<std::string> answered;
  for (const ResultRow& row : readHypotheses(results)) answered.insert(row.frame);
  EXPECT_EQ(answered, std::set<std::string>(frames.begin(), frames.end()));
}

constexpr const char* kSameInEachRun[] = {"/hypotheses.csv", "/poses_tum.txt", "/covariances.csv",
                                          "/params.ini", "/images.txt"};

TEST_F(Tools, AFullDiskCostsTheImageAtHandOnly) {
  const std::string results = folder_ / "results", once = folder_ / "once";
  ok(runTool<localizeApp>({map(), query(), "-o", once}));
  {
    const auto room = fs::file_size(once + "/params.ini") + 100;
    ASSERT_LT(room, fs::file_size(once + "/hypotheses.csv"));
    const FullDisk full(room);
    const ToolRun run = runTool<localizeApp>({map(), query(), "-o", results});
    EXPECT_THAT(run, fails(".csv: " + std::string(FullDisk::kWords)));
    EXPECT_THAT(run.err, Not(HasSubstr("items failed"))) << "it stops at the first write that fails";
  }
  const std::size_t done = readResults(results).size();
  EXPECT_GT(done, 0u);
  EXPECT_THAT(runTool<evaluateApp>({results, query() + "/groundtruth.txt"}).err,
              HasSubstr("the run was not finished"));

  ok(runTool<localizeApp>({map(), query(), "-o", results, "--resume"}));
  for (const char* file : kSameInEachRun)
    EXPECT_EQ(contentOf(results + file), contentOf(once + file)) << file;
  EXPECT_THAT(runTool<evaluateApp>({results, query() + "/groundtruth.txt"}).err,
              Not(HasSubstr("not finished")));
}

TEST_F(Tools, ARunThatWasKilledGoesOnToTheSameBytes) {
  const std::string results = folder_ / "results", once = folder_ / "once";
  ok(runTool<localizeApp>({map(), query(), "-o", once}));
  const std::string timing = contentOf(once + "/timing.csv"), rows = contentOf(once + "/hypotheses.csv");
  std::size_t fifth = 0;  // ends, of the header and four images
  for (int line = 0; line < 5; ++line) fifth = timing.find('\n', fifth) + 1;
  const std::string next = timing.substr(fifth, timing.find(',', fifth) - fifth);
  const std::size_t of_next = rows.find("\n" + next + ",") + 1;
  for (const std::size_t written :
       {std::size_t{0}, std::size_t{30}, rows.find('\n', of_next) + 1 - of_next}) {
    fs::remove_all(results);
    fs::copy(once, results);
    writeContent(results + "/hypotheses.csv", rows.substr(0, of_next + written));
    writeContent(results + "/timing.csv", timing.substr(0, fifth) + (written ? "12" : ""));
    EXPECT_EQ(readResults(results).size(), 4u);
    ok(runTool<localizeApp>({map(), query(), "-o", results, "--resume"}));
    for (const char* file : kSameInEachRun)
      EXPECT_EQ(contentOf(results + file), contentOf(once + file)) << file << " of " << written;
  }
}

TEST_F(Tools, OtherParametersBeginAnew) {
  const std::string results = folder_ / "results";
  ok(runTool<localizeApp>({map(), query(), "-o", results}));
  ok(runTool<localizeApp>({map(), firstImage(), "-o", results, "--labels.min_support", "99"}));
  EXPECT_EQ(readTiming(results).size(), 1u);
  EXPECT_THAT(contentOf(results + "/params.ini"), HasSubstr("min_support = 99"));
}

TEST_F(Tools, LocalizeLeavesFilesOfOthersAloneUnlessToldOtherwise) {
  const std::string results = folder_ / "results", others = results + "/timing_of_mine.csv";
  fs::create_directories(results);
  writeContent(others, "mine");
  const auto localize = [&](const Arguments& more) {
    return runTool<localizeApp>(Arguments{map(), firstImage(), "-o", results} + more);
  };
  for (const Arguments& more : {Arguments{}, Arguments{"--resume"}})
    EXPECT_THAT(localize(more),
                fails("results: holds other files already", "timing_of_mine.csv", "--overwrite"));
  EXPECT_EQ(filesOf(results).size(), 1u);
  ok(localize({"--overwrite"}));
  ok(localize({}));
  EXPECT_EQ(readTiming(results).size(), 1u);
  EXPECT_EQ(contentOf(others), "mine");
}

TEST_F(Tools, LocalizeNamesMissingInputs) {
  EXPECT_EQ(runTool<localizeApp>({folder_ / "nowhere.flmap", query(), "-o", folder_ / "x"}).code, kFailed);
  const ToolRun run = runTool<localizeApp>({map(), folder_ / "nowhere", "-o", folder_ / "x"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_EQ(run.err, "facetloc_localize: " + (folder_ / "nowhere") + ": does not exist\n");
}

TEST_F(Tools, SmoothNoiseIsFoundAndReported) {
  const std::string room = folder_ / "room";
  ok(runTool<simulateApp>({"room", "-o", room, "--seed", "5", "--frames", std::to_string(kFrames), "--width",
                           "320", "--drive.turn_deg", "8", "--sensor.disparity_std", "2",
                           "--sensor.correlation_px", "3"}));
  const std::string images = room + "/query";
  const std::string noisy_map = folder_ / "noisy.flmap";
  const auto tells =
      HasSubstr("the images are noisier than their camera's specification: inverse_depth_std is about 0.00");
  EXPECT_THAT(ok(runMap({"build", room + "/map", "-o", noisy_map, "--map.distance", "0.1"})).err, tells);
  const ToolRun run = ok(runTool<localizeApp>({noisy_map, images, "-o", folder_ / "results"}));
  EXPECT_THAT(run.err, tells);
  EXPECT_THAT(run.out, HasSubstr("12 images: "));
  EXPECT_THAT(
      runTool<localizeApp>({noisy_map, images, "-o", folder_ / "told", "--noise.inverse_depth_std", "0.006"})
          .err,
      Not(HasSubstr("noisier")));
  EXPECT_THAT(runTool<localizeApp>({map(), query(), "-o", folder_ / "kinect"}).err,
              Not(HasSubstr("noisier")));
}

TEST_F(Tools, AMountingOfAnotherHeightIsNotThatOfTheMap) {
  const std::string lower = folder_.copyOf(query(), "lower"), unknown = folder_.copyOf(query(), "unknown");
  for (const std::string& input : {lower, unknown}) {
    CameraFile file = readCameraFile(input + "/camera.ini");
    std::optional<CameraMounting>& mounting = file.camera.mounting;
    mounting = input == lower ? std::optional(CameraMounting{mounting->height - 0.4, 10}) : std::nullopt;
    writeCameraFile(input + "/camera.ini", file);
    const ToolRun run = ok(runTool<localizeApp>({map(), input, "-o", input + "/results"}));
    EXPECT_THAT(run.err, HasAll(input == lower ? "mounted differently, 0.600 m"
                                               : "mounting of the images' camera is unknown",
                                "the prior is isotropic"));
  }
  EXPECT_THAT(runTool<registerApp>({filesOf(lower + "/depth")[0].string(), firstImage()}).err,
              HasSubstr("mounted differently"));
}

TEST_F(Tools, LocalizeDistinguishesSureAnswers) {
  const auto count = [&](const std::string& results, AnswerState state) {
    int n = 0;
    for (const ResultRow& row : readHypotheses(results)) n += row.rank <= 1 && row.state == state;
    return n;
  };
  const std::string usual = folder_ / "usual", strict = folder_ / "strict";
  const ToolRun run = ok(runTool<localizeApp>({map(), query(), "-o", usual}));
  const int sure = count(usual, AnswerState::sure);
  EXPECT_GT(sure, 0);
  EXPECT_THAT(run.out, HasSubstr("12 images: " + std::to_string(sure) + " sure, " +
                                 std::to_string(count(usual, AnswerState::doubtful)) + " doubtful, " +
                                 std::to_string(count(usual, AnswerState::unknown)) + " unknown; "));
  EXPECT_EQ(readTrajectory(usual + "/poses_tum.txt").poses().size(), static_cast<std::size_t>(sure));
  for (const auto& [frame, P] : readCovariances(usual)) EXPECT_EQ(P.llt().info(), Eigen::Success) << frame;

  ok(runTool<localizeApp>({map(), query(), "-o", strict, "--min-probability", "1"}));
  EXPECT_LT(count(strict, AnswerState::sure), sure);
  EXPECT_EQ(readCovariances(strict).size(), readCovariances(usual).size());
  EXPECT_EQ(runTool<localizeApp>({map(), query(), "-o", strict, "--min-probability", "0"}).code, kUsage);
}

/** Scores by overlap have no probabilities that one could act on. */
TEST_F(Tools, LocalizeIsNeverSureByOverlap) {
  EXPECT_THAT(ok(runTool<localizeApp>({map(), query(), "-o", folder_ / "results", "--score.by_overlap"})).out,
              HasSubstr("12 images: 0 sure"));
}

TEST_F(Tools, LocalizeAdvisesWhereNothingIsSure) {
  const std::string input = folder_.copyOf(query(), "input");
  CameraFile file = readCameraFile(input + "/camera.ini");
  const double fx = file.camera.intrinsics.fx;
  file.camera.intrinsics.fx = file.camera.intrinsics.fy = 0.6 * fx;
  writeCameraFile(input + "/camera.ini", file);
  EXPECT_THAT(runTool<localizeApp>({map(), input, "-o", folder_ / "focal"}).out,
              HasAll("Check the following:\nDo fx and fy fit", "12 images: 0 sure"));

  file.camera.intrinsics.fx = file.camera.intrinsics.fy = fx;
  file.depth_scale *= 5;
  writeCameraFile(input + "/camera.ini", file);
  EXPECT_THAT(runTool<localizeApp>({map(), input, "-o", folder_ / "scale"}).out,
              HasAll("Check the following:\nDoes depth_scale", "12 images: 0 sure"));
  EXPECT_THAT(runTool<localizeApp>({map(), query(), "-o", folder_ / "good"}).out,
              Not(HasSubstr("Check the following")));
}

}  // namespace
}  // namespace facetloc::test
