// SPDX-License-Identifier: BSD-3-Clause
#include "graph/loop_consistency.h"

#include <gtest/gtest.h>

namespace facetloc {

using namespace internal;
namespace {

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
}  // namespace facetloc
