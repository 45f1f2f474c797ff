// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation_details.h"

#include <gtest/gtest.h>

namespace facetloc::test {
namespace {

Eigen::Isometry3d at(double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); }

StartAnswer answer(const std::string& start, const std::string& frame, AnswerState state, double x) {
  return {start, frame, state, 0.95, at(x)};
}

FrameEvaluation frame(const std::string& name, double x) {
  FrameEvaluation out;
  out.name = name;
  out.T_w_c = at(x);
  return out;
}

TEST(StartCurves, CountEveryStartAsFarAsItGoes) {
  const std::vector<FrameEvaluation> truth = {frame("0", 0), frame("1", 0.5), frame("2", 1), frame("3", 1.5)};
  const std::vector<StartAnswer> answers = {
      answer("0", "0", AnswerState::doubtful, 0), answer("0", "1", AnswerState::sure, 0.5),
      answer("0", "2", AnswerState::sure, 7),  // wrong
      answer("2", "2", AnswerState::sure, 1), answer("2", "3", AnswerState::sure, 1.5)};
  const std::vector<StartCurve> curves = startCurves(answers, truth, Eigen::Isometry3d::Identity(), {});
  ASSERT_EQ(curves.size(), 2u);
  const auto& images = curves[0].points;
  ASSERT_EQ(images.size(), 3u);
  EXPECT_EQ(images[0].starts, 2);
  EXPECT_DOUBLE_EQ(images[0].recall(), 0.5);
  EXPECT_DOUBLE_EQ(images[1].recall(), 1);
  EXPECT_EQ(images[2].starts, 1);
  EXPECT_DOUBLE_EQ(images[2].recall(), 0);
  EXPECT_DOUBLE_EQ(images[2].precision(), 0);
  const auto& metres = curves[1].points;  // point of the first image that is so far on
  ASSERT_EQ(metres.size(), 5u);
  EXPECT_DOUBLE_EQ(metres[4].x, 1);
  EXPECT_EQ(metres[2].starts, 2);
  EXPECT_DOUBLE_EQ(metres[2].recall(), 1);
  EXPECT_DOUBLE_EQ(metres[1].recall(), 1);
  EXPECT_EQ(metres[4].starts, 1);
  EXPECT_DOUBLE_EQ(metres[4].precision(), 0);
}

TEST(StartCurves, AreOfImagesWhoseTruePosesAreKnown) {
  const std::vector<StartAnswer> answers = {answer("a", "a", AnswerState::sure, 9),
                                            answer("a", "b", AnswerState::sure, 0.5),
                                            answer("c", "c", AnswerState::sure, 9)};
  const auto curves = startCurves(answers, {frame("b", 0.5)}, Eigen::Isometry3d::Identity(), {});
  ASSERT_EQ(curves[0].points.size(), 1u);
  EXPECT_EQ(curves[0].points[0].starts, 1);
  EXPECT_EQ(curves[0].points[0].right, 1);
  EXPECT_TRUE(startCurves({}, {frame("b", 0.5)}, Eigen::Isometry3d::Identity(), {})[0].points.empty());
}

TEST(StartCurves, OfAnotherWorldAreAlignedWithTheTrueOne) {
  const auto curves = startCurves({answer("a", "a", AnswerState::sure, 5)}, {frame("a", 2)}, at(-3), {});
  EXPECT_EQ(curves[0].points.at(0).right, 1);
}

}  // namespace
}  // namespace facetloc::test
