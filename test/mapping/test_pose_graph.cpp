// SPDX-License-Identifier: BSD-3-Clause
#include "graph/pose_graph.h"

#include <facetloc/testing/pose_matchers.h>

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <stdexcept>

namespace facetloc {

using namespace internal;
using test::MatrixNear, test::PoseNear;
namespace {

Vector6d smallNoise(std::mt19937& random, const Matrix6d& P) {
  std::normal_distribution<double> normal;
  Vector6d x;
  for (int i = 0; i < 6; ++i) x[i] = normal(random);
  return P.llt().matrixL() * x;
}

Matrix6d covariance(double rotation_deg, double translation) {
  Matrix6d P = Matrix6d::Zero();
  P.diagonal().head<3>().setConstant(rotation_deg * rotation_deg * kDegree * kDegree);
  P.diagonal().tail<3>().setConstant(translation * translation);
  P(0, 4) = P(4, 0) = 0.3 * rotation_deg * kDegree * translation;
  return P;
}

Eigen::Isometry3d at(double x, double y, double heading_deg) {
  return Eigen::Translation3d(x, y, 0.1 * x) * Eigen::Isometry3d(expSO3({0.1, -0.05, heading_deg * kDegree}));
}

// Round a square of 4 m in steps of 1 m; each motion is measured with errors of its covariance.
class Round : public testing::Test {
protected:
  static std::vector<Eigen::Isometry3d> truth() {
    std::vector<Eigen::Isometry3d> poses;
    for (int side = 0; side < 4; ++side)
      for (int i = 0; i < 4; ++i) {
        const double a = 90. * side * kDegree, x = i - 2, y = -2;
        poses.push_back(at(std::cos(a) * x - std::sin(a) * y, std::sin(a) * x + std::cos(a) * y, 90. * side));
      }
    return poses;
  }
  PoseEdge measured(int from, int to, std::mt19937& random) const {
    const Matrix6d P = covariance(0.5, 0.02);
    const Eigen::Isometry3d T = truth_[from].inverse() * truth_[to];
    return {from, to, {boxplus(T, smallNoise(random, P)), P}};
  }
  PoseGraph graph(unsigned seed, bool closed) const {
    std::mt19937 random(seed);
    PoseGraph g;
    g.T_w_n.push_back(truth_[0]);
    for (int i = 0; i + 1 < static_cast<int>(truth_.size()); ++i) {
      g.edges.push_back(measured(i, i + 1, random));
      g.T_w_n.push_back(g.T_w_n.back() * g.edges.back().T_from_to.T);
    }
    if (closed) g.edges.push_back(measured(static_cast<int>(truth_.size()) - 1, 0, random));
    return g;
  }
  const std::vector<Eigen::Isometry3d> truth_ = truth();
};

// Two doors look the same one image later; the rest of the graph decides.
TEST_F(Round, OtherMotionsChooseAmongAlternatives) {
  PoseGraph g = graph(3, true);
  PoseEdge& doubtful = g.edges[5];
  const PoseWithCovariance right = doubtful.T_from_to;
  const Vector6d next_door = (Vector6d() << 0, 0, 0, 0.6, 0, 0).finished();
  doubtful.T_from_to.T = boxplus(right.T, next_door);
  doubtful.others = {{right, -2}};
  const GraphPoses closed = optimized(g);
  EXPECT_TRUE(closed.converged);
  EXPECT_NEAR(closed.mismatch[5], mismatchOf({5, 6, right}, closed.nodes) + 4, 1e-6);
  for (std::size_t i = 0; i < truth_.size(); ++i)
    EXPECT_THAT(closed.nodes[i].T, PoseNear(truth_[i], 0.15, 3)) << i;

  g.edges.pop_back();  // a chain takes the likelier one
  EXPECT_NEAR(optimized(g).mismatch[5], 0, 1e-6);
}

TEST_F(Round, AChainIsTheProductOfItsMotionsAndOfTheirCovariances) {
  const PoseGraph g = graph(1, false);
  const GraphPoses found = optimized(g);
  EXPECT_TRUE(found.converged);
  PoseWithCovariance expected{truth_[0], Matrix6d::Zero()};
  for (std::size_t i = 0; i < truth_.size(); ++i) {
    EXPECT_THAT(found.nodes[i].T, PoseNear(expected.T, 1e-6, 1e-5)) << i;
    EXPECT_THAT(found.nodes[i].P, MatrixNear(expected.P, 1e-3 * expected.P.norm() + 1e-12)) << i;
    if (i < g.edges.size()) expected = expected * g.edges[i].T_from_to;
  }
  for (const double m : found.mismatch) EXPECT_NEAR(m, 0, 1e-9);
}

TEST_F(Round, ALoopThatIsClosedMakesPosesAsGoodAsTheirCovariances) {
  double squared = 0, open = 0, closed = 0;
  constexpr int kTrials = 60;
  for (unsigned seed = 0; seed < kTrials; ++seed) {
    const GraphPoses without = optimized(graph(seed, false), false), with = optimized(graph(seed, true));
    ASSERT_TRUE(with.converged);
    const std::size_t middle = truth_.size() / 2, last = truth_.size() - 1;
    const Vector6d e = boxminus(truth_[middle], with.nodes[middle].T);
    squared += e.dot(with.nodes[middle].P.ldlt().solve(e)) / kTrials;
    open += (without.nodes[last].T.translation() - truth_[last].translation()).norm();
    closed += (with.nodes[last].T.translation() - truth_[last].translation()).norm();
  }
  EXPECT_NEAR(squared, 6, 4 * std::sqrt(12. / kTrials));
  EXPECT_LT(closed, 0.4 * open);
}

TEST_F(Round, AWrongLoopThatMayBeWrongBendsLittle) {
  PoseGraph g = graph(3, true);
  PoseEdge wrong{2, 9, {at(0.3, 0.1, 5), covariance(0.5, 0.02)}, true};
  const GraphPoses right = optimized(g);
  g.edges.push_back(wrong);
  const GraphPoses robust = optimized(g);
  EXPECT_GT(robust.mismatch.back(), 1000);
  for (std::size_t i = 0; i < truth_.size(); ++i)
    EXPECT_THAT(robust.nodes[i].T, PoseNear(right.nodes[i].T, 0.1, 2)) << i;
}

TEST_F(Round, PartsWithoutAnEdgeBetweenThemStayWhereTheyBegin) {
  PoseGraph g = graph(4, false);
  g.edges.erase(g.edges.begin() + 5);  // edge between 5 and 6
  const GraphPoses found = optimized(g);
  for (int i = 0; i < 16; ++i) EXPECT_EQ(found.part[i], i < 6 ? 0 : 6);
  EXPECT_EQ(found.nodes[6].P, Matrix6d(Matrix6d::Zero()));
  EXPECT_THAT(found.nodes[6].T, PoseNear(g.T_w_n[6], 1e-12, 1e-6));
  EXPECT_GT(found.nodes[7].P(0, 0), 0);
}

TEST(PoseGraph, RefusesInvalidEdges) {
  PoseGraph g;
  EXPECT_TRUE(optimized(g).nodes.empty());
  g.T_w_n.assign(2, Eigen::Isometry3d::Identity());
  const PoseWithCovariance good{Eigen::Isometry3d::Identity(), covariance(1, 1)};
  for (const auto& [from, to] : {std::pair{0, 2}, {-1, 0}, {1, 1}}) {
    g.edges = {{from, to, good}};
    EXPECT_THROW(optimized(g), std::invalid_argument) << from << " " << to;
  }
  g.edges = {{0, 1, {}}};
  EXPECT_THROW(optimized(g), std::invalid_argument) << "zero";
  g.edges[0].T_from_to.P(3, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(optimized(g), std::invalid_argument) << "not finite";
}

}  // namespace
}  // namespace facetloc
