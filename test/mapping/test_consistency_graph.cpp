// SPDX-License-Identifier: BSD-3-Clause
#include "graph/consistency_graph.h"

#include <gtest/gtest.h>

namespace facetloc::internal {
namespace {

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
    for (const FoundKeyframe& f : consensusAlignment(found, relative, least)) keyframes.push_back(f.keyframe);
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

Matrix6d covariance(double rotation_deg, double translation) {
  Matrix6d P = Matrix6d::Zero();
  P.diagonal().head<3>().setConstant(std::pow(rotation_deg * kDegree, 2));
  P.diagonal().tail<3>().setConstant(translation * translation);
  return P;
}

Eigen::Isometry3d along(double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); }

/** There and back again: nodes 0 .. 9 at x = 0 .. 9 m, nodes 10 .. 19 at the same places on the way back; the
 * way says little about where it has come back to. */
class ThereAndBack : public testing::Test {
protected:
  ThereAndBack() {
    for (int i = 0; i < 20; ++i) graph_.T_w_n.push_back(along(i < 10 ? i : 19 - i));
    for (int i = 0; i + 1 < 20; ++i)
      graph_.edges.push_back({i,
                              i + 1,
                              {graph_.T_w_n[i].inverse() * graph_.T_w_n[i + 1],
                               i == 9 ? covariance(5, 2) : covariance(0.1, 0.01)}});
  }
  /** A loop as it is, or one that is wrong by so much. */
  PoseEdge loop(int from, int to, double wrong_by = 0) const {
    const Eigen::Isometry3d T = graph_.T_w_n[from].inverse() * graph_.T_w_n[to];
    return {from, to, {along(wrong_by) * T, covariance(0.3, 0.02)}, true};
  }
  std::vector<bool> consistent(const std::vector<PoseEdge>& loops, int least, int apart = 1) const {
    return consistentLoops(loops, GraphCovariance(graph_), least,
                           [apart](int a, int b) { return std::abs(a - b) >= apart; });
  }
  PoseGraph graph_;
};

TEST_F(ThereAndBack, LoopsThatAgreeConfirmEachOther) {
  const std::vector<PoseEdge> loops{loop(2, 17), loop(1, 18, 3), loop(3, 16), loop(5, 14), loop(4, 15, -1)};
  EXPECT_EQ(consistent(loops, 3), (std::vector<bool>{true, false, true, true, false}));
  EXPECT_EQ(consistent(loops, 4), std::vector<bool>(5, false));
}

TEST_F(ThereAndBack, LoopsOfOneKeyframeAreOneWitness) {
  EXPECT_EQ(consistent({loop(2, 17), loop(3, 17), loop(4, 17)}, 3), std::vector<bool>(3, false));
}

TEST_F(ThereAndBack, LoopsOfNeighbouringKeyframesAreOneWitness) {
  const std::vector<PoseEdge> loops{loop(2, 17), loop(3, 16)};
  EXPECT_EQ(consistent(loops, 2), std::vector<bool>(2, true));
  EXPECT_EQ(consistent(loops, 2, 2), std::vector<bool>(2, false));
}

TEST_F(ThereAndBack, WhereEqualDoorsAgreeOnOtherPlacesNothingIsBelieved) {
  // The next door, 3 m on, is seen from as many keyframes as the right one.
  const std::vector<PoseEdge> loops{loop(2, 17),    loop(3, 16),    loop(5, 14),
                                    loop(1, 18, 3), loop(4, 15, 3), loop(6, 13, 3)};
  EXPECT_EQ(consistent(loops, 3), std::vector<bool>(6, false));
}

TEST_F(ThereAndBack, NothingToSay) { EXPECT_TRUE(consistent({}, 3).empty()); }

}  // namespace
}  // namespace facetloc::internal
