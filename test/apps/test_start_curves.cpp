// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/start_curves.h"

#include <facetloc/io/error.h>

#include <gtest/gtest.h>

namespace facetloc {
namespace {

Eigen::Isometry3d at(double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); }

StartAnswer answer(const std::string& start, const std::string& frame, AnswerState state, double x) {
  return {start, frame, state, 0.95, at(x)};
}

TEST(StartCurves, CountEveryStartAsFarAsItGoes) {
  const Trajectory truth({{0, at(0)}, {1, at(0.5)}, {2, at(1)}, {3, at(1.5)}});
  const std::vector<StartAnswer> answers = {
      answer("0", "0", AnswerState::doubtful, 0), answer("0", "1", AnswerState::sure, 0.5),
      answer("0", "2", AnswerState::sure, 7),  // wrong
      answer("2", "2", AnswerState::sure, 1), answer("2", "3", AnswerState::sure, 1.5)};
  const std::vector<StartCurve> curves = startCurves(answers, truth, {}, 0.02);
  ASSERT_EQ(curves.size(), 2u);
  const auto& images = curves[0].points;
  ASSERT_EQ(images.size(), 3u);
  EXPECT_EQ(images[0].starts, 2);
  EXPECT_DOUBLE_EQ(images[0].recall(), 0.5);
  EXPECT_DOUBLE_EQ(images[1].recall(), 1);
  EXPECT_EQ(images[2].starts, 1);
  EXPECT_DOUBLE_EQ(images[2].recall(), 0);
  EXPECT_DOUBLE_EQ(images[2].precision(), 0);
  const auto& metres = curves[1].points;  // of the first image that is so far on
  ASSERT_EQ(metres.size(), 5u);
  EXPECT_DOUBLE_EQ(metres[4].x, 1);
  EXPECT_EQ(metres[2].starts, 2);
  EXPECT_DOUBLE_EQ(metres[2].recall(), 1);
  EXPECT_DOUBLE_EQ(metres[1].recall(), 1);
  EXPECT_EQ(metres[4].starts, 1);
  EXPECT_DOUBLE_EQ(metres[4].precision(), 0);
}

TEST(StartCurves, OfImagesWithoutStampsThereAreNone) {
  const Trajectory truth({{0, at(0)}});
  EXPECT_THROW(startCurves({answer("a", "a", AnswerState::sure, 0)}, truth, {}, 0.02), IoError);
  EXPECT_TRUE(startCurves({}, truth, {}, 0.02)[0].points.empty());
}

}  // namespace
}  // namespace facetloc
