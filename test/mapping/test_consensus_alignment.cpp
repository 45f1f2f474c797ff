// SPDX-License-Identifier: BSD-3-Clause
#include "graph/consensus_alignment.h"

#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

namespace facetloc {

using namespace internal;
namespace {

constexpr PlaceTolerance kTolerance{0.3, 5 * kDegree};

Eigen::Isometry3d at(double x, double y, double heading_deg) {
  return Eigen::Translation3d(x, y, 1) * Eigen::Isometry3d(expSO3({0, 0, heading_deg * kDegree}));
}

/** A session of a few keyframes, and where it is in the map. */
class ConsensusAlignment : public testing::Test {
protected:
  ConsensusAlignment() {
    for (int k = 0; k < 8; ++k) session_.push_back(at(0.6 * k, 0.1 * k * k, 10 * k));
  }
  FoundKeyframe right(int k) const { return {k, {T_w_s_ * session_[k], Matrix6d::Zero()}}; }
  FoundKeyframe wrong(int k, const Eigen::Isometry3d& off) const {
    return {k, {off * T_w_s_ * session_[k], Matrix6d::Zero()}};
  }
  std::vector<int> agreeing(const std::vector<FoundKeyframe>& found, std::size_t least = 3) const {
    const RelativePose relative = [this](int a, int b) {
      PoseWithCovariance T{session_[a].inverse() * session_[b], Matrix6d::Zero()};
      T.P.diagonal().setConstant(std_ * std_ * std::abs(b - a));
      return std::optional(T);
    };
    std::vector<int> keyframes;
    for (const FoundKeyframe& f : consensusAlignment(found, relative, kTolerance, least))
      keyframes.push_back(f.keyframe);
    return keyframes;
  }

  std::vector<Eigen::Isometry3d> session_;
  Eigen::Isometry3d T_w_s_ = at(12, -3, 130);
  double std_ = 1e-3;  // standard deviation of a step [m, rad]
};

TEST_F(ConsensusAlignment, LeavesOutAnswersThatAgreeWithNoOther) {
  EXPECT_EQ(agreeing({right(0), wrong(1, at(4, 0, 0)), right(3), wrong(5, at(0, 0, 20)), right(6), right(7)}),
            (std::vector<int>{0, 3, 6, 7}));
}

TEST_F(ConsensusAlignment, IsNotBelievedFromTooFewAnswers) {
  EXPECT_TRUE(agreeing({}).empty());
  EXPECT_TRUE(agreeing({right(0), right(4)}).empty());
  EXPECT_EQ(agreeing({right(0), right(4)}, 2).size(), 2u);
}

TEST_F(ConsensusAlignment, IsUnclearWherePlacesLookTheSame) {
  const Eigen::Isometry3d next_corridor = at(5, 0, 0);
  EXPECT_TRUE(
      agreeing({right(0), right(1), right(2), wrong(4, next_corridor), wrong(5, next_corridor)}).empty());
  EXPECT_EQ(
      agreeing({right(0), right(1), right(2), right(3), wrong(4, next_corridor), wrong(5, next_corridor)}),
      (std::vector<int>{0, 1, 2, 3}));
}

TEST_F(ConsensusAlignment, AllowsForTheErrorsOfTheSession) {
  const Eigen::Isometry3d drift = at(0.5, 0, 0) * at(0, 0, 0).inverse();
  const std::vector<FoundKeyframe> found = {right(0), right(1), wrong(6, drift), wrong(7, drift)};
  EXPECT_TRUE(agreeing(found).empty());
  std_ = 0.05;
  EXPECT_EQ(agreeing(found), (std::vector<int>{0, 1, 6, 7}));
}

}  // namespace
}  // namespace facetloc
