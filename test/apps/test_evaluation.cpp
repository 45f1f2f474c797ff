// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation.h"
#include "evaluation/evaluation_report.h"
#include "outputs/localization_report.h"
#include "tool_runner.h"

#include <facetloc/features/pose.h>
#include <facetloc/io/error.h>

namespace facetloc::test {
namespace {

Eigen::Isometry3d pose(double x, double yaw_deg = 0, double roll_deg = 0) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = expSO3({0, 0, yaw_deg * kDegree}) * expSO3({roll_deg * kDegree, 0, 0});
  T.translation().x() = x;
  return T;
}

ResultRow hypothesis(const std::string& frame, int rank, double probability, const Eigen::Isometry3d& T_w_c) {
  ResultRow row;
  row.frame = frame;
  row.rank = rank;
  row.model = "10.0";
  row.probability = probability;
  row.T_w_c = T_w_c;
  row.state = probability >= kMinProbability ? AnswerState::sure : AnswerState::doubtful;
  return row;
}

/** Five frames at the origin: right, right at rank 2, wrong, none, and right but unsure. A sixth has no
 * truth. */
std::vector<ResultRow> exampleRows() {
  return {hypothesis("1.0", 1, 0.95, pose(0.03, 0.4)),
          hypothesis("2.0", 1, 0.60, pose(5)),
          hypothesis("2.0", 2, 0.30, pose(0.05, 1.0)),
          hypothesis("2.0", 3, 0.05, pose(0.01, 0.1)),
          hypothesis("3.0", 1, 0.15, pose(0.1, 3)),
          noHypothesis("4.0", "the planes in view leave free: translation along (1, 0, 0)"),
          hypothesis("5.0", 1, 0.55, pose(0.01, 0, 0.5)),
          hypothesis("99.0", 1, 0.99, pose(0))};
}

Trajectory exampleTruth() {
  std::vector<StampedPose> poses;
  for (const double stamp : {1.0, 2.0, 3.0, 4.0, 5.001}) poses.push_back({stamp, pose(0)});
  return Trajectory(poses);
}

/** The first frame is a model itself; another model covers nothing. */
std::vector<ModelPose> exampleModels() { return {{"1.0", 1, pose(0)}, {"far", 50, pose(0, 60)}}; }

TEST(PoseError, KnownDifferences) {
  const PoseError e = poseError(pose(0.25, 0, 0), pose(0.05, 2, 0));
  EXPECT_NEAR(e.translation, 0.2, 1e-12);
  EXPECT_NEAR(e.rotation_deg, 2, 1e-9);
  EXPECT_NEAR(e.heading_deg, 2, 1e-9);
  EXPECT_NEAR(poseError(pose(0, 0, 1), pose(0)).heading_deg, 0, 1e-9);
  EXPECT_NEAR(poseError(pose(0, 0, 1), pose(0)).rotation_deg, 1, 1e-9);
  EXPECT_EQ(poseError(pose(0), pose(0)).rotation_deg, 0);
}

TEST(Evaluation, JudgesEachFrame) {
  const Evaluation evaluation = evaluate(exampleRows(), exampleTruth(), exampleModels(), {});
  EXPECT_THAT(evaluation.without_truth, ElementsAre("99.0"));
  ASSERT_EQ(evaluation.frames.size(), 5u);
  std::vector<int> ranks, counts;
  for (const FrameEvaluation& f : evaluation.frames) {
    ranks.push_back(f.first_correct);
    counts.push_back(f.hypotheses);
  }
  EXPECT_THAT(ranks, ElementsAre(1, 2, 0, 0, 1));
  EXPECT_THAT(counts, ElementsAre(1, 3, 1, 0, 1));
  const FrameEvaluation& second = evaluation.frames[1];
  EXPECT_NEAR(second.first_correct_error.translation, 0.05, 1e-12);
  EXPECT_NEAR(second.first_correct_error.rotation_deg, 1.0, 1e-9);
  EXPECT_NEAR(second.best_error->translation, 5, 1e-12);
  EXPECT_DOUBLE_EQ(second.probability, 0.6);
  EXPECT_THAT(evaluation.frames[3].reason, HasSubstr("leave free"));
  EXPECT_EQ(evaluation.frames[0].frame_class, FrameClass::map_image);
  EXPECT_EQ(evaluation.frames[1].frame_class, FrameClass::new_image);
  EXPECT_TRUE(evaluation.frames[1].covered);
  EXPECT_EQ(evaluation.frames[1].nearest->name, "1.0");
}

TEST(Evaluation, MissingWorldPosesComeFromTheMap) {
  ResultRow row = hypothesis("1.0", 1, 0.9, pose(0));
  row.T_w_c.reset();
  row.model = "m";
  row.T_m_c = pose(0.1);
  const Trajectory truth({{1.0, pose(2.1)}});
  EXPECT_EQ(evaluate({row}, truth, {{"m", 7, pose(2)}}, {}).frames[0].first_correct, 1);
  EXPECT_EQ(evaluate({row}, truth, {}, {}).frames[0].first_correct, 0);
  EXPECT_EQ(evaluate({row}, truth, {}, {}).frames[0].frame_class, FrameClass::unknown);
}

TEST(Evaluation, JudgesAnswersRelativeToTheirLocalModels) {
  ResultRow row = hypothesis("1.0", 1, 0.95, pose(7));  // result in a map that has drifted away
  row.model = "m";
  row.T_m_c = pose(0.13, 1);
  const RunResults run{"", {row}, {}};
  const PlaceTruth truth(Trajectory({{1.0, pose(2.1)}}));
  const FrameEvaluation f = evaluate({run}, truth, {}, {}, 0.02, {{"m", pose(2)}}).frames[0];
  EXPECT_EQ(f.first_correct, 0);
  ASSERT_TRUE(f.local_error);
  EXPECT_TRUE(f.locally_correct);
  EXPECT_NEAR(f.local_error->translation, 0.03, 1e-12);
  EXPECT_NEAR(f.local_error->rotation_deg, 1, 1e-9);
  const Summary s = summarize("", {f});
  EXPECT_EQ(s.local, 1u);
  EXPECT_EQ(s.local_correct, 1u);
  EXPECT_NEAR(s.local_translation_mm.bound(0.5), 30, 1e-9);
  EXPECT_FALSE(evaluate({run}, truth, {}, {}, 0.02, {{"other", pose(2)}}).frames[0].local_error);
}

TEST(Evaluation, ATrueModelPoseLocatesAnAnswer) {
  ResultRow row = hypothesis("1.0", 1, 0.95, pose(0));
  row.T_w_c.reset();
  row.model = "m";
  row.T_m_c = pose(0.1);
  const RunResults run{"", {row}, {}};
  EXPECT_EQ(evaluate({run}, PlaceTruth(Trajectory({{1.0, pose(2.1)}})), {}, {}, 0.02, {{"m", pose(2)}})
                .frames[0]
                .first_correct,
            1);
}

TEST(Evaluation, AlignsBySureAnswersOnly) {
  const std::vector<PosePair> pairs =
      sureAnswers({{"", exampleRows(), {}}}, PlaceTruth(exampleTruth()), exampleModels());
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].stamp, 1);
  EXPECT_TRUE(pairs[0].estimated.isApprox(pose(0.03, 0.4)));
  EXPECT_TRUE(pairs[0].truth.isApprox(pose(0)));
}

TEST(Evaluation, ErrorsAndCovariancesAreTheSameInAnotherWorld) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = expSO3({0.5, -1, 2});
  motion.translation() << 3, 4, 5;
  std::vector<RunResults> runs = {{"", {hypothesis("1.0", 1, 0.95, pose(0.05, 1, 0.5))}, {}}};
  Vector6d std;
  std << 0.01, 0.02, 0.03, 0.1, 0.02, 0.05;
  runs[0].covariances["1.0"] = std.cwiseAbs2().asDiagonal();
  const FrameEvaluation before = evaluate(runs, PlaceTruth(Trajectory({{1.0, pose(0)}})), {}, {}).frames[0];
  moveWorld(motion, runs);
  const FrameEvaluation after =
      evaluate(runs, PlaceTruth(Trajectory({{1.0, motion * pose(0)}})), {}, {}).frames[0];
  ASSERT_TRUE(before.nees && after.nees);
  EXPECT_NEAR(*after.nees, *before.nees, 1e-9);
  EXPECT_NEAR(after.best_error->translation, before.best_error->translation, 1e-12);
  EXPECT_NEAR(after.best_error->rotation_deg, before.best_error->rotation_deg, 1e-9);
}

TEST(Evaluation, AnImageOfTheMapIsOneThoughItsPoseThereIsNotTheTrueOne) {
  const auto classOf = [](double off, const std::string& name, double stamp, std::uintmax_t size) {
    RunResults run{"", {hypothesis("1.0", 1, 0.9, pose(0))}, {}};
    run.images = {{"1.0", 4711}};
    const PlaceTruth truth(Trajectory({{1.0, pose(0)}}));
    return evaluate({run}, truth, {{name, stamp, pose(off), size}}, {}).frames[0].frame_class;
  };
  EXPECT_EQ(classOf(0, "1.0", 1, 0), FrameClass::map_image);
  EXPECT_EQ(classOf(0.3, "1.0", 1, 4711), FrameClass::map_image);
  EXPECT_EQ(classOf(0.3, "1.0", 1, 4712),
            FrameClass::new_image);  // an image of another run with the same stamps
  EXPECT_EQ(classOf(0.3, "x", 7, 4711), FrameClass::new_image);
}

TEST(Evaluation, AFirstAnswerThatIsNowhereInTheWorldIsNotJudged) {
  ResultRow nowhere = hypothesis("1.0", 1, 0.9, pose(0));
  nowhere.T_w_c.reset();
  const std::vector<ResultRow> rows = {nowhere, hypothesis("1.0", 2, 0.05, pose(0.01)),
                                       hypothesis("2.0", 1, 0.8, pose(0))};
  const Evaluation evaluation = evaluate(rows, Trajectory({{1, pose(0)}, {2, pose(0)}}), {}, {});
  EXPECT_FALSE(evaluation.frames[0].best_error);
  EXPECT_EQ(evaluation.frames[0].first_correct, 2);
  const Summary summary = summarize("all", evaluation.frames);
  EXPECT_EQ(summary.threshold, 0);
  EXPECT_EQ(summary.sure, 0u);
  EXPECT_NEAR(summary.brier, 0.04, 1e-12);
  TemporaryFolder folder;
  const EvaluationReport report{"r", "t", {}, evaluation, {summary}, {}};
  writeReport(folder / "", report);
  EXPECT_THAT(contentOf(folder / "frames.csv"), HasSubstr(",0.9,,,,,"));
  EXPECT_THAT(contentOf(folder / "evaluation.txt"), HasSubstr("in a local model without a pose: 1 image;"));
}

TEST(Evaluation, ErrorsWithoutAnswersAreNaN) {
  const Evaluation evaluation =
      evaluate({hypothesis("1.0", 1, 0.9, pose(5))}, Trajectory({{1, pose(0)}}), {}, {});
  TemporaryFolder folder;
  writeReport(folder / "", {"r", "t", {}, evaluation, {summarize("all", evaluation.frames)}, {}});
  EXPECT_THAT(contentOf(folder / "tables.csv"), HasSubstr("II,Translation error [mm],Avg.,36.83,\n"));
}

TEST(Evaluation, FramesWithoutNumbersAreStampedByIndexIfTheTruthIs) {
  const std::vector<ResultRow> rows = {hypothesis("b", 1, 0.9, pose(0)), hypothesis("a", 1, 0.9, pose(1))};
  const Evaluation evaluation = evaluate(rows, Trajectory({{0, pose(0)}, {1, pose(1)}}), {}, {});
  ASSERT_EQ(evaluation.frames.size(), 2u);
  for (const FrameEvaluation& f : evaluation.frames) EXPECT_EQ(f.first_correct, 1) << f.name;
  EXPECT_THROW(evaluate(rows, Trajectory({{0, pose(0)}, {0.5, pose(1)}}), {}, {}), IoError);
  EXPECT_THROW(evaluate(rows, Trajectory({{1, pose(0)}, {2, pose(1)}}), {}, {}), IoError);
}

TEST(Evaluation, ModelsCoverWithinBothLimits) {
  const std::vector<ResultRow> rows = {hypothesis("1.0", 1, 0.9, pose(0))};
  const Trajectory truth({{1.0, pose(0)}});
  const auto covered = [&](const Eigen::Isometry3d& T_w_m) {
    return evaluate(rows, truth, {{"m", 7, T_w_m}}, {}).frames[0].covered;
  };
  EXPECT_TRUE(covered(pose(0.99, 19)));
  EXPECT_FALSE(covered(pose(1.01, 19)));
  EXPECT_FALSE(covered(pose(0.99, 21)));
}

TEST(Summary, CountsAndStatistics) {
  const Summary s = summarize("all", evaluate(exampleRows(), exampleTruth(), {}, {}).frames);
  EXPECT_EQ(s.total, 5u);
  EXPECT_EQ(s.none, 1u);
  EXPECT_EQ(s.wrong, 1u);
  EXPECT_EQ(s.correct, 3u);
  EXPECT_EQ(s.best_correct, 2u);
  EXPECT_NEAR(s.translation_mm.mean, 30, 1e-9);  // mean of 30, 50, 10 mm
  EXPECT_NEAR(s.translation_mm.std, 20, 1e-9);
  EXPECT_NEAR(s.translation_mm.max, 50, 1e-9);
  EXPECT_NEAR(s.rotation_deg.max, 1.0, 1e-9);
  EXPECT_NEAR(s.index.mean, 4.0 / 3, 1e-12);
}

TEST(Summary, RecallAtFullPrecision) {
  // The largest probability of a wrong rank 1 is 0.6, which one of five frames exceeds rightly.
  const Summary s = summarize("all", evaluate(exampleRows(), exampleTruth(), {}, {}).frames);
  EXPECT_DOUBLE_EQ(s.threshold, 0.6);
  EXPECT_DOUBLE_EQ(s.recall, 0.2);
}

TEST(Summary, Reliability) {
  const Summary s = summarize("all", evaluate(exampleRows(), exampleTruth(), {}, {}).frames);
  ASSERT_EQ(s.reliability.size(), 10u);
  EXPECT_EQ(s.reliability[9].n, 1u);
  EXPECT_DOUBLE_EQ(s.reliability[9].correct, 1);
  EXPECT_EQ(s.reliability[6].n, 1u);
  EXPECT_DOUBLE_EQ(s.reliability[6].correct, 0);
  EXPECT_DOUBLE_EQ(s.reliability[6].mean_probability, 0.6);
  const double squares = 0.05 * 0.05 + 0.6 * 0.6 + 0.15 * 0.15 + 0.45 * 0.45;
  EXPECT_NEAR(s.brier, squares / 4, 1e-12);
}

TEST(Summary, OfEmptyInputIsZero) {
  const Summary s = summarize("none", {});
  EXPECT_EQ(s.total, 0u);
  EXPECT_EQ(s.recall, 0);
  EXPECT_EQ(s.translation_mm.bound(0.99), 0);
}

TEST(Sample, IsSortedAndHasShares) {
  const Sample s({3, 1, 2, 2});
  EXPECT_THAT(s.values, ElementsAre(1, 2, 2, 3));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(s.share(i), 0.25 * static_cast<double>(i + 1));
  EXPECT_EQ(s.bound(0.5), 2);
  EXPECT_EQ(s.bound(0.76), 3);
  EXPECT_EQ(s.bound(0.99), 3);
  EXPECT_EQ(s.bound(0.1), 1);
}

std::vector<std::string> setsOf(const Evaluation& evaluation) {
  std::vector<std::string> found;
  for (const Summary& s : summarizeSets(evaluation)) found.push_back(s.name + " " + std::to_string(s.total));
  return found;
}

TEST(EvaluationReport, SetsOfFrames) {
  const auto names = [](const std::vector<ModelPose>& models) {
    return setsOf(evaluate(exampleRows(), exampleTruth(), models, {}));
  };
  EXPECT_THAT(names({}), ElementsAre("all 5"));
  EXPECT_THAT(names(exampleModels()), ElementsAre("all images 5", "map images 1", "new 4", "covered 4"));
  EXPECT_THAT(names({{"far", 50, pose(0, 60)}}), ElementsAre("all (new) 5", "rest 5"));
}

/** Frames of a query run in each class, and their mapping run. */
std::vector<RunResults> exampleRuns() {
  return {{"map", {hypothesis("1.0", 1, 0.99, pose(0)), hypothesis("1.5", 1, 0.8, pose(0.3))}, {}},
          {"query",
           {hypothesis("1001.0", 1, 0.95, pose(0.4)), hypothesis("1002.0", 1, 0.7, pose(9)),
            noHypothesis("1003.0", "too few planes")},
           {}}};
}

Trajectory exampleRunsTruth() {
  return Trajectory(
      {{1, pose(0)}, {1.5, pose(0.3)}, {1001, pose(0.4)}, {1002, pose(5)}, {1003, pose(0, 90)}});
}

TEST(Evaluation, RunsAreReadFromOneFolderOrSeveral) {
  const TemporaryFolder folder;
  for (const RunResults& run : exampleRuns()) {
    std::vector<FrameResult> results;
    for (const ResultRow& row : run.rows) results.push_back({0, {row}, {row.frame, 1, 2, 3, 4}});
    writeResults(folder / run.name, results, "");
  }
  std::filesystem::create_directory(folder / "evaluation");
  const std::vector<RunResults> runs = readRuns(folder / "");
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].name, "map");
  EXPECT_EQ(runs[1].name, "query");
  EXPECT_EQ(runs[1].rows.size(), 3u);
  EXPECT_EQ(runs[1].timing.size(), 3u);
  std::filesystem::remove(folder / "query/timing.csv");
  const std::vector<RunResults> alone = readRuns(folder / "query");
  ASSERT_EQ(alone.size(), 1u);
  EXPECT_EQ(alone[0].name, "");
  EXPECT_EQ(alone[0].folder, "query");  // whose truth is meant
  EXPECT_EQ(readRuns(folder / "query/")[0].folder, "query");
  EXPECT_TRUE(alone[0].timing.empty());
  EXPECT_THROW(readRuns(folder / "evaluation"), IoError);
}

TEST(Evaluation, TheMappingRunHasNoNewImages) {
  const Evaluation evaluation =
      evaluate(exampleRuns(), PlaceTruth(exampleRunsTruth()), {{"1.0", 1, pose(0)}}, {});
  std::vector<std::string> classes;
  for (const FrameEvaluation& f : evaluation.frames) classes.push_back(f.run + " " + toString(f.frame_class));
  EXPECT_THAT(classes, ElementsAre("map map", "map mapping run", "query new", "query new", "query new"));
  // Alone, the mapping run is judged as before: images that are no local model are new.
  const Evaluation alone =
      evaluate({exampleRuns().front()}, PlaceTruth(exampleRunsTruth()), {{"1.0", 1, pose(0)}}, {});
  EXPECT_EQ(alone.frames[1].frame_class, FrameClass::new_image);
}

FrameEvaluation newFrame(bool covered, std::optional<bool> solvable, bool unmapped) {
  FrameEvaluation f;
  f.frame_class = FrameClass::new_image;
  f.covered = covered;
  f.solvable = solvable;
  f.unmapped = unmapped;
  return f;
}

TEST(EvaluationReport, EachNewImageIsCoveredOrRestOrWhereNothingIs) {
  Evaluation evaluation;
  evaluation.frames = {newFrame(true, true, false), newFrame(true, false, false), newFrame(true, {}, false),
                       newFrame(false, false, false), newFrame(false, false, true)};
  EXPECT_THAT(setsOf(evaluation),
              ElementsAre("all (new) 5", "covered 3", "solvable 1", "rest 1", "nothing there 1"));
}

TEST(EvaluationReport, FramesOfSeveralPlacesArePooled) {
  Evaluation pooled = evaluate(exampleRuns(), PlaceTruth(exampleRunsTruth()), {{"1.0", 1, pose(0)}}, {});
  EXPECT_THAT(setsOf(pooled), ElementsAre("all images 5", "new 3", "covered 1", "rest 2"));
  const std::vector<FrameEvaluation> again = pooled.frames;
  pooled.frames.insert(pooled.frames.end(), again.begin(), again.end());
  EXPECT_THAT(setsOf(pooled), ElementsAre("all images 10", "new 6", "covered 2", "rest 4"));
  EXPECT_EQ(summarizeSets(pooled)[1].none, 2u);
  EXPECT_EQ(summarizeSets(pooled)[2].correct, 2u);
}

TEST(Summary, ConfidentAndUnsureAnswers) {
  // Probabilities 0.95 (right), 0.6 and 0.15 (wrong), 0.55 (right), and no answer.
  Summary s = summarize("all", evaluate(exampleRows(), exampleTruth(), {}, {}).frames);
  EXPECT_EQ(s.sure, 1u);
  EXPECT_EQ(s.sure_correct, 1u);
  EXPECT_EQ(s.unsure, 2u);
  // The limits themselves count as confident, and not as unsure.
  s = summarize("limits", evaluate({hypothesis("1.0", 1, 0.9, pose(5)), hypothesis("2.0", 1, 0.5, pose(0))},
                                   exampleTruth(), {}, {})
                              .frames);
  EXPECT_EQ(s.sure, 1u);
  EXPECT_EQ(s.sure_correct, 0u);
  EXPECT_EQ(s.unsure, 0u);
}

TEST(Summary, OnlyFullBinsDeviate) {
  std::vector<FrameEvaluation> frames;
  const auto add = [&](int n, double probability, int first_correct) {
    FrameEvaluation f;
    f.hypotheses = 1;
    f.probability = probability;
    f.best_error = PoseError();
    f.first_correct = first_correct;
    frames.insert(frames.end(), n, f);
  };
  add(19, 0.35, 1);  // far from the truth, but too few
  EXPECT_EQ(summarize("few", frames).largest_deviation, 0);
  add(15, 0.85, 1);
  add(5, 0.85, 0);
  EXPECT_NEAR(summarize("enough", frames).largest_deviation, 0.1, 1e-12);  // 0.85 and 15 of 20
  add(1, 0.35, 1);
  EXPECT_NEAR(summarize("more", frames).largest_deviation, 0.65, 1e-12);
}

TEST(EvaluateApp, PrintsAndWritesTheTables) {
  const TemporaryFolder folder;
  std::vector<FrameResult> results;
  for (const ResultRow& row : exampleRows()) {
    if (results.empty() || results.back().rows.back().frame != row.frame) results.emplace_back();
    results.back().rows.push_back(row);
    results.back().timing.frame = row.frame;
  }
  writeResults(folder / "results", results, "");
  writeTumTrajectory(folder / "truth.txt", exampleTruth().poses());
  const ToolRun run = ok(runTool<evaluateApp>({folder / "results", folder / "truth.txt", "--table-paper"}));
  EXPECT_THAT(run.out, HasAll("718 (90.65 %)", "3 (60.00 %)"));
  EXPECT_EQ(lastLine(run.out), "evaluation in " + (folder / "results/evaluation"));
  EXPECT_THAT(contentOf(folder / "results/evaluation/tables.csv"),
              HasSubstr("II,Translation error [mm],Avg.,36.83,30\n"));
  EXPECT_THAT(contentOf(folder / "results/evaluation/frames.csv"),
              HasSubstr("\n,2.0,2,unknown,0,,,,3,2,50,1,1,doubtful,0.6,"));
  EXPECT_THAT(contentOf(folder / "results/evaluation/fig6.csv"),
              HasSubstr("set,share,translation_mm,orientation_deg,index\nall,0.333333333,10,"));
  EXPECT_EQ(runTool<evaluateApp>({folder / "nowhere", folder / "truth.txt"}).code, kFailed);
  EXPECT_EQ(runTool<evaluateApp>({}).code, kUsage);
  EXPECT_EQ(runTool<evaluateApp>({folder / "results"}).code, kOk) << "without truth";
}

TEST(EvaluateApp, MapPosesFollowThePapersRule) {
  std::vector<StampedPose> run;
  for (int i = 0; i < 20; ++i) run.push_back({0.1 * i, pose(0.1 * i)});
  EXPECT_EQ(modelPosesOf(Trajectory(run)).size(), 4u);  // at 0, 0.5, 1.0 and 1.5 m
}

}  // namespace
}  // namespace facetloc::test
