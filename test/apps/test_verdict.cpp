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

/** As many of an image as that. */
void add(std::size_t n, const FrameEvaluation& f, std::vector<FrameEvaluation>& frames) {
  frames.insert(frames.end(), n, f);
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
                                  "off by 0.50 m and 0.5° (median).");
  EXPECT_EQ(verdict.sentences[2],
            "Of the other 48, 30 have the right pose first, but not probable enough: other places look "
            "the same, 13 were taken more "
            "than 1 m or 20° from every local model, and 5 fit another place better than the right one.");
  EXPECT_THAT(verdict.map, IsEmpty());
  EXPECT_THAT(verdict.next, HasSubstr("facetloc_map calibrate"));
  ASSERT_EQ(verdict.figures.size(), 4u);
  EXPECT_EQ(verdict.figures[2].value, "10 mm, 0.50°");
  EXPECT_EQ(verdict.figures[3].value, "200");
}

TEST(Verdict, AdvisesByTheLargestObstacle) {
  const auto next = [](const FrameEvaluation& miss) {
    std::vector<FrameEvaluation> frames;
    add(10, image(AnswerState::sure, 0.01), frames);
    add(10, miss, frames);
    return verdictOf(reportOf(frames)).next;
  };
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
  EXPECT_EQ(verdict.map, "The map lies in a frame of its own and is bent by 1.7° and 32 mm (RMS, its 12 "
                         "local models against their true poses).");
}

}  // namespace
}  // namespace facetloc::test
