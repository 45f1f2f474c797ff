// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation_details.h"
#include "evaluation/evaluation_pictures.h"
#include "evaluation/evaluation_report.h"
#include "tool_runner.h"

namespace facetloc::test {
namespace {

FrameEvaluation frame(const std::string& name, int first_correct = 1, double probability = 0.7) {
  FrameEvaluation f;
  f.name = name;
  f.frame_class = FrameClass::new_image;
  f.covered = true;
  f.hypotheses = 3;
  f.first_correct = first_correct;
  f.probability = probability;
  f.state = probability >= kMinProbability ? AnswerState::sure : AnswerState::doubtful;
  f.first_correct_error.translation = 0.01;
  f.best_error = PoseError{first_correct == 1 ? 0.01 : 1.5, 0.5, 0};
  return f;
}

FrameEvaluation seeing(int planes, int first_correct = 1) {
  FrameEvaluation f = frame("f", first_correct);
  f.visible_planes = planes;
  return f;
}

FrameEvaluation away(double distance) {
  FrameEvaluation f = frame("f");
  f.nearest = NearestModel{"m", distance, 3};
  return f;
}

std::vector<std::string> namesOf(const std::vector<ErrorGroup>& groups) {
  std::vector<std::string> names;
  for (const ErrorGroup& g : groups) names.push_back(g.summary.name + ": " + std::to_string(g.summary.total));
  return names;
}

TEST(ErrorGroups, ByVisiblePlanes) {
  FrameEvaluation nowhere = seeing(4);
  nowhere.unmapped = true;
  const auto groups = errorsByVisiblePlanes({seeing(0), seeing(1), seeing(3), seeing(4), seeing(5, 0),
                                             seeing(5, 2), seeing(40), frame("unknown"), nowhere});
  EXPECT_THAT(namesOf(groups), ElementsAre("0 to 1: 2", "3: 1", "4 to 5: 3", "18 or more: 1"));
  EXPECT_EQ(groups[2].summary.correct, 2u);
  EXPECT_EQ(groups[2].summary.best_correct, 1u);
  EXPECT_NEAR(groups[2].mean, 14.0 / 3, 1e-12);
  EXPECT_NEAR(groups[2].summary.translation_mm.mean, 10, 1e-9);
}

TEST(ErrorGroups, ByDistance) {
  EXPECT_THAT(
      namesOf(errorsByDistance({away(0), away(0.2499), away(0.25), away(1.7), away(30), frame("no map")})),
      ElementsAre("0.00 to 0.25: 2", "0.25 to 0.50: 1", "1.50 to 2.00: 1", "2.00 or more: 1"));
  EXPECT_THAT(errorsByDistance({frame("no map")}), IsEmpty());
}

TEST(StageTimes, PercentilesOfFewImages) {
  std::vector<TimingRow> rows;
  for (int i = 1; i <= 100; ++i) rows.push_back({std::to_string(i), 1.0 * i, 2, 10, 5});
  const auto times = stageTimes(rows);
  ASSERT_EQ(times.size(), 4u);
  EXPECT_EQ(times[0].stage, "segmentation");
  EXPECT_EQ(times[0].ms.values.size(), 100u);
  EXPECT_DOUBLE_EQ(times[0].ms.mean, 50.5);
  EXPECT_DOUBLE_EQ(times[0].ms.bound(0.5), 50);
  EXPECT_DOUBLE_EQ(times[0].ms.bound(kMostShare), 95);
  EXPECT_DOUBLE_EQ(times[0].ms.max, 100);
  EXPECT_DOUBLE_EQ(times[2].ms.max, 10);
  EXPECT_DOUBLE_EQ(times[3].ms.mean, 62.5);
  EXPECT_THAT(stageTimes({}), IsEmpty());
}

TEST(StageTimes, ImagesThatFailedTookNoTime) {
  TimingRow failed;
  failed.frame = "failed";
  const auto times = stageTimes({failed, {"done", 4, 1, 5, 7}, failed});
  ASSERT_EQ(times.size(), 4u);
  EXPECT_EQ(times[3].ms.values.size(), 1u);
  EXPECT_DOUBLE_EQ(times[3].ms.mean, 10);
  EXPECT_DOUBLE_EQ(times[3].ms.bound(0.5), 10);
  EXPECT_THAT(stageTimes({failed}), IsEmpty());
}

TEST(Misses, TheWorstKindOfEach) {
  FrameEvaluation uncovered = frame("uncovered", 0), nowhere = frame("nowhere", 0), rightly_unsure = nowhere;
  uncovered.covered = false;
  nowhere.covered = rightly_unsure.covered = false;
  nowhere.unmapped = rightly_unsure.unmapped = true;
  rightly_unsure.name = "unsure";
  rightly_unsure.probability = 0.49;
  FrameEvaluation silent = frame("silent", 0, 0);
  silent.hypotheses = 0;
  FrameEvaluation mapped = frame("mapped", 0);
  mapped.frame_class = FrameClass::map_run;
  Evaluation evaluation;
  evaluation.frames = {frame("good"),
                       frame("second", 2),
                       frame("wrong", 0),
                       uncovered,
                       nowhere,
                       rightly_unsure,
                       silent,
                       frame("confident", 3, 0.9),
                       mapped};
  std::vector<std::string> found;
  for (const Miss& miss : misses(evaluation)) found.push_back(miss.frame.name + ": " + toString(miss.kind));
  EXPECT_THAT(found, ElementsAre("confident: Confident and wrong", "nowhere: Sure where the map has nothing",
                                 "wrong: No correct hypothesis", "silent: No correct hypothesis",
                                 "second: Correct, but not at rank 1"));
}

TEST(Misses, ThoseDrawnAreOfAllKindsAndFarApart) {
  Evaluation evaluation;
  for (int i = 0; i < 8; ++i) evaluation.frames.push_back(frame("wrong" + std::to_string(i), 0));
  evaluation.frames.push_back(frame("confident", 0, 0.95));
  evaluation.frames.push_back(frame("second", 2));
  const auto names = [&](std::size_t most) {
    std::vector<std::string> found;
    for (const Miss& miss : chosenMisses(evaluation, most)) found.push_back(miss.frame.name);
    return found;
  };
  EXPECT_THAT(names(4), ElementsAre("confident", "wrong0", "wrong4", "second"));
  EXPECT_THAT(names(2), ElementsAre("confident", "wrong0"));
  EXPECT_EQ(names(100).size(), 10u);
  EXPECT_THAT(names(0), IsEmpty());
}

TEST(Misses, WithoutAMapEveryImageCounts) {
  FrameEvaluation f = frame("f", 0);
  f.frame_class = FrameClass::unknown;
  f.covered = false;
  Evaluation evaluation;
  evaluation.frames = {f};
  EXPECT_EQ(misses(evaluation).size(), 1u);
}

TEST(EvaluationReport, OnlyTheTimesDependOnTheTimes) {
  EvaluationReport report{"results", "truth", {}, {}, {}, {}};
  report.evaluation.frames = {seeing(4), away(0.3), frame("a", 2)};
  report.summaries = summarizeSets(report.evaluation);
  report.timing = {{"f", 5, 1, 100, 40}};
  const TemporaryFolder a, b;
  writeReport(a / "", report);
  report.timing[0].localize_ms = 333;
  writeReport(b / "", report);
  for (const char* file : {"tables.csv", "frames.csv", "fig6.csv", "errors.csv"}) {
    EXPECT_FALSE(contentOf(a / file).empty());
    EXPECT_EQ(contentOf(a / file), contentOf(b / file)) << file;
  }
  EXPECT_EQ(contentOf(b / "timing_summary.csv"),
            "stage,images,mean_ms,median_ms,p95_ms,max_ms\n"
            "segmentation,1,5.000,5.000,5.000,5.000\nfeatures,1,1.000,1.000,1.000,1.000\n"
            "localization,1,333.000,333.000,333.000,333.000\nall,1,339.000,339.000,339.000,339.000\n");
  EXPECT_THAT(contentOf(a / "errors.csv"),
              HasAll("visible planes,4,6,1,1,1,10,0\n", "distance [m],0.25,0.5,1,1,1,10,0\n"));
}

}  // namespace
}  // namespace facetloc::test
