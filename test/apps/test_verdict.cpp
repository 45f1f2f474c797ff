// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/verdict.h"

#include <facetloc/testing/matchers.h>

#include <tuple>

namespace facetloc::test {
namespace {

FrameEvaluation image(AnswerState state, double error_m) {
  FrameEvaluation f;
  f.frame_class = FrameClass::new_image;
  f.covered = true;
  f.solvable = true;
  f.state = state;
  f.hypotheses = state == AnswerState::unknown ? 0 : 2;
  f.probability = state == AnswerState::sure ? 0.95 : 0.6;
  if (f.hypotheses > 0) {
    f.best_error = PoseError{error_m, 0.5, 0};
    f.first_correct = error_m < 0.2 ? 1 : 0;
  }
  return f;
}

EvaluationReport reportOf(const std::vector<FrameEvaluation>& frames) {
  EvaluationReport report{"results", "truth", {}, {}, {}, {}};
  report.evaluation.frames = frames;
  report.summaries = summarizeSets(report.evaluation);
  return report;
}

/** As many of an image as that, along a drive. */
void add(std::size_t n, FrameEvaluation f, std::vector<FrameEvaluation>& frames) {
  for (std::size_t i = 0; i < n; ++i) {
    f.T_w_c.translation().x() = 0.2 * static_cast<double>(frames.size());
    frames.push_back(f);
  }
}

EvaluationReport reportOf(std::size_t sure, std::size_t others, const FrameEvaluation& other) {
  std::vector<FrameEvaluation> frames;
  add(sure, image(AnswerState::sure, 0.01), frames);
  add(others, other, frames);
  return reportOf(frames);
}

Finding disagreement(double rotation_deg, double translation) {
  return {"poses.accuracy",
          Severity::note,
          "poses and images disagree",
          "",
          {{"rotation_deg", rotation_deg}, {"translation_m", translation}}};
}

TEST(Verdict, CountsSureRightAndWhyNot) {
  std::vector<FrameEvaluation> frames;
  add(150, image(AnswerState::sure, 0.01), frames);
  add(2, image(AnswerState::sure, 0.5), frames);
  add(30, image(AnswerState::doubtful, 0.01), frames);
  add(5, image(AnswerState::doubtful, 2), frames);
  FrameEvaluation far = image(AnswerState::doubtful, 2);
  far.covered = false;
  add(13, far, frames);
  const Verdict verdict = verdictOf(reportOf(frames));
  ASSERT_EQ(verdict.sentences.size(), 3u);
  EXPECT_EQ(verdict.sentences[0], "Of 200 images, 152 have a sure answer (76\u00a0%).");
  EXPECT_EQ(verdict.sentences[1], "150 of these are right (99\u00a0%), within 0.2 m and 2°; the other 2 are "
                                  "at the right place, off by 0.50 m and 0.5° (median).");
  EXPECT_EQ(verdict.sentences[2],
            "Of the other 48, 30 have the right pose first, but not probable enough: other places look "
            "the same, 13 were taken more "
            "than 1 m or 20° from every local model, and 5 fit another place better than the right one.");
  EXPECT_THAT(verdict.remarks, IsEmpty());
  EXPECT_EQ(verdict.next, "Look at the answers below that are sure and wrong.");
  ASSERT_EQ(verdict.figures.size(), 4u);
  EXPECT_EQ(verdict.figures[2].value, "10 mm, 0.50°");
  EXPECT_EQ(verdict.figures[3].value, "200");
}

TEST(Verdict, AdvisesByTheLargestObstacle) {
  const auto next = [](const FrameEvaluation& miss) { return verdictOf(reportOf(10, 10, miss)).next; };
  EXPECT_THAT(next(image(AnswerState::doubtful, 0.01)), HasSubstr("--sequence"));
  EXPECT_THAT(next(image(AnswerState::sure, 0.02)), HasSubstr("ready to be used"));
  FrameEvaluation f = image(AnswerState::doubtful, 3);
  EXPECT_THAT(next(f), HasSubstr("Look at the failures below"));
  f.solvable = false;
  EXPECT_THAT(next(f), HasSubstr("three directions"));
  f.covered = false;
  EXPECT_THAT(next(f), HasSubstr("facetloc_map extend"));
  f = image(AnswerState::unknown, 0);
  f.reason = "the camera is covered";
  EXPECT_THAT(next(f), HasSubstr("Look at the failures below"));
  EXPECT_THAT(verdictOf(reportOf({f})).sentences[2],
              HasSubstr("fits no place (mostly: the camera is covered)"));
}

TEST(Verdict, OfExtremesIsPlain) {
  EXPECT_EQ(verdictOf(reportOf({image(AnswerState::sure, 0.1)})).sentences,
            (std::vector<std::string>{"Of 1 image, 1 has a sure answer (100\u00a0%).",
                                      "All of these are right, within 0.2 m and 2°.",
                                      "No image is left without a sure answer."}));
  EXPECT_EQ(verdictOf(reportOf({image(AnswerState::doubtful, 0.1)})).sentences[1],
            "No answer is sure, so none can be acted on.");
  std::vector<FrameEvaluation> nearly;
  add(9999, image(AnswerState::sure, 0.1), nearly);
  add(1, image(AnswerState::sure, 1), nearly);
  EXPECT_THAT(verdictOf(reportOf(nearly)).sentences[1], HasSubstr("(99.9\u00a0%)")) << "100 % means all";
}

TEST(Verdict, WithoutTruthCountsTheAnswers) {
  RunResults run;
  for (const auto& [frame, rank, state] : {std::tuple("1", 1, AnswerState::sure),
                                           {"1", 2, AnswerState::sure},
                                           {"2", 1, AnswerState::doubtful},
                                           {"3", 0, AnswerState::unknown}}) {
    ResultRow row;
    row.frame = frame;
    row.rank = rank;
    row.state = state;
    row.probability = rank == 1 ? 0.8 : 0.1;
    if (rank == 0) row.reason = "the view shows no planar segment";
    run.rows.push_back(row);
  }
  EvaluationReport report{"results", "", {}, withoutTruth({run}), {}, {}};
  ASSERT_EQ(report.evaluation.frames.size(), 3u);
  EXPECT_EQ(report.evaluation.frames[0].hypotheses, 2);
  EXPECT_DOUBLE_EQ(report.evaluation.frames[0].probability, 0.8);
  EXPECT_FALSE(report.isJudged());
  const Verdict verdict = verdictOf(report);
  EXPECT_EQ(verdict.sentences[0], "Of 3 images, 1 has a sure answer (33\u00a0%).");
  EXPECT_THAT(verdict.sentences[1], HasSubstr("not known"));
  EXPECT_EQ(verdict.sentences[2], "Of the other 2, 1 fits no place (mostly: the view shows no planar "
                                  "segment), and 1 fits several places, or one that "
                                  "is not probable enough.");
  EXPECT_EQ(verdict.figures[2].words, "of the images have a place in the map");
}

TEST(Verdict, IsRelativeToLocalModelsInAMapOfItsOwn) {
  std::vector<FrameEvaluation> frames;
  FrameEvaluation bent =
      image(AnswerState::sure, 0.6);  // right in its local model, which the map has 0.6 m off
  bent.local_error = PoseError{0.02, 0.1, 0};
  bent.locally_correct = true;
  add(20, bent, frames);
  EvaluationReport report = reportOf(frames);
  EXPECT_THAT(verdictOf(report).sentences[1], StartsWith("0 of these are right"));
  report.own_frame = true;
  Alignment map;
  map.used = 12;
  map.residual = 0.032;
  map.rotation_residual_deg = 1.7;
  report.map_alignment = map;
  const Verdict verdict = verdictOf(report);
  EXPECT_EQ(verdict.sentences[1], "All of these are right, within 0.2 m and 2° of the truth in their local "
                                  "models, since the map lies in a frame of its own.");
  EXPECT_THAT(
      verdict.remarks,
      testing::ElementsAre("The map lies in a frame of its own and is bent by 1.7° and 32 mm (RMS, its "
                           "12 local models against their true poses)."));
}

TEST(Verdict, AllowsWhatTheTruthItselfIsOff) {
  EvaluationParams limits = withinTruth({}, {disagreement(1, 0.008)});
  EXPECT_DOUBLE_EQ(limits.max_rotation_deg, 3);
  EXPECT_DOUBLE_EQ(limits.max_translation, 0.2);
  limits = withinTruth({}, {disagreement(60, 9)});
  EXPECT_DOUBLE_EQ(limits.max_rotation_deg, 20) << "another place is never right";
  EXPECT_DOUBLE_EQ(limits.max_translation, 0.5);
  Finding refused = disagreement(60, 9);
  refused.severity = Severity::refusal;
  EXPECT_DOUBLE_EQ(withinTruth({}, {refused}).max_rotation_deg, 2);

  EvaluationReport report = reportOf(20, 0, {});
  report.findings = {disagreement(0.1, 0.008)};
  EXPECT_THAT(verdictOf(report).remarks, IsEmpty());
  report.findings = {disagreement(1, 0.008)};
  report.params = withinTruth(report.params, report.findings);
  const Verdict verdict = verdictOf(report);
  EXPECT_EQ(verdict.sentences[1], "All of these are right, within 0.2 m and 3°.");
  EXPECT_THAT(verdict.remarks,
              testing::ElementsAre("The true poses disagree with the images by 1.00° and 8 mm, so that "
                                   "answers within 3 times that count as right."));
}

TEST(Verdict, NamesAnotherPlaceOnlyFarFromTheTruth) {
  FrameEvaluation off = image(AnswerState::doubtful, 0.021);
  off.first_correct = 0;
  off.best_error->rotation_deg = 3.4;
  EXPECT_EQ(verdictOf(reportOf(19, 11, off)).sentences[2],
            "The other 11 are at the right place, off by 21 mm and 3.4° (median).");
  off.best_error->rotation_deg = 20.1;
  EXPECT_EQ(verdictOf(reportOf(19, 11, off)).sentences[2],
            "The other 11 fit another place better than the right one.");
}

TEST(Verdict, AdvisesNothingThatADoubtMayOverturn) {
  EvaluationReport report = reportOf(3, 17, image(AnswerState::doubtful, 3));
  EXPECT_THAT(verdictOf(report).next, HasSubstr("furniture"));
  report.findings = {{"camera.difference", Severity::note, "another camera", ""},
                     {"localize.scale", Severity::doubt, "depth_scale may not fit", "look at depth_scale"},
                     {"values.scale", Severity::refusal, "no room is 90 m deep", "set depth_scale"}};
  const Verdict verdict = verdictOf(report);
  EXPECT_EQ(verdict.next, "Settle first what is in doubt: set depth_scale.");
  EXPECT_THAT(verdict.remarks, testing::ElementsAre("In doubt: depth_scale may not fit; look at depth_scale.",
                                                    "In doubt: no room is 90 m deep; set depth_scale."));
}

TEST(Verdict, CallsNoMapReadyByItsOwnImagesOrAStillCamera) {
  EvaluationReport report = reportOf(12, 0, {});
  EXPECT_THAT(verdictOf(report).next, HasSubstr("ready to be used"));
  report.of_map = true;
  EXPECT_THAT(verdictOf(report).next, HasSubstr("Localize a later recording"));
  report.of_map = false;
  for (FrameEvaluation& f : report.evaluation.frames) f.T_w_c.translation().x() = 1;
  EXPECT_THAT(verdictOf(report).next, HasSubstr("these images show one view"));
}

TEST(Verdict, AgreesWithTheMissesBelow) {
  FrameEvaluation nowhere = image(AnswerState::sure, 1);
  nowhere.best_error.reset();  // as in a local model without a pose
  EvaluationReport report = reportOf(8, 2, nowhere);
  EXPECT_THAT(verdictOf(report).sentences[1],
              StartsWith("All of the 8 of these that can be judged are right"));
  EXPECT_TRUE(misses(report.evaluation).empty() ||
              misses(report.evaluation).front().kind != MissKind::confident_wrong);
  FrameEvaluation bent = image(AnswerState::sure, 0.6);
  bent.local_error = PoseError{0.02, 0.1, 0};
  bent.locally_correct = true;
  report = reportOf({bent, bent});
  report.own_frame = true;
  EXPECT_THAT(verdictOf(report).sentences[1], StartsWith("All of these are right"));
  EXPECT_THAT(misses(report.evaluation, judgesRelatively(report)), IsEmpty());
}

TEST(Verdict, AdvisesACalibrationThatHasImagesEnough) {
  FrameEvaluation wrong = image(AnswerState::sure, 2);
  EXPECT_THAT(verdictOf(reportOf(55, 2, wrong)).next, StartsWith("Look at the answers below"));
  wrong.probability = 0.91;
  EXPECT_THAT(verdictOf(reportOf(55, 2, wrong)).next, HasSubstr("--min-probability 0.95"));
  EvaluationReport report = reportOf(700, 6, wrong);
  EXPECT_THAT(verdictOf(report).next, HasSubstr("facetloc_map calibrate"));
  report.own_frame = true;
  EXPECT_THAT(verdictOf(report).next, HasSubstr("--min-probability 0.95"))
      << "poses in the coordinates of the map are missing";
}

TEST(Verdict, AdvisesNoDriveToADrive) {
  EvaluationReport report = reportOf(10, 10, image(AnswerState::doubtful, 0.01));
  EXPECT_THAT(verdictOf(report).next, HasSubstr("whole drive"));
  report.as_drive = true;
  EXPECT_THAT(verdictOf(report).next, HasSubstr("--odometry"));
}

}  // namespace
}  // namespace facetloc::test
