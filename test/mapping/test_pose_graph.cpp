// SPDX-License-Identifier: BSD-3-Clause
#include "graph/pose_graph.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/pose_matchers.h>

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <stdexcept>

namespace facetloc::internal {

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
  EXPECT_NEAR(closed.mismatch[5], mismatchOf({5, 6, right}, closed.nodes) + 4, 1e-6);
  for (std::size_t i = 0; i < truth_.size(); ++i)
    EXPECT_THAT(closed.nodes[i].T, PoseNear(truth_[i], 0.15, 3)) << i;

  g.edges.pop_back();  // a chain takes the likelier one
  EXPECT_NEAR(optimized(g).mismatch[5], 0, 1e-6);
}

TEST_F(Round, AChainIsTheProductOfItsMotionsAndOfTheirCovariances) {
  const PoseGraph g = graph(1, false);
  const GraphPoses found = optimized(g);
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

PoseWithCovariance motion(double x, double y, double turn_deg, double std = 0.01) {
  PoseWithCovariance T;
  T.T.linear() = expSO3({0.1, -0.2, turn_deg * kDegree});
  T.T.translation() << x, y, 0.1;
  T.P = covariance(std / kDegree, 2 * std);
  return T;
}

PoseGraph chain() {
  PoseGraph graph;
  graph.T_w_n.push_back(motion(3, -2, 130).T);
  for (const PoseWithCovariance& T : {motion(1, 0, 20), motion(0.5, 0.5, -40, 0.02), motion(2, 0, 70)}) {
    const int from = static_cast<int>(graph.T_w_n.size()) - 1;
    graph.edges.push_back({from, from + 1, T});
    graph.T_w_n.push_back(graph.T_w_n.back() * T.T);
  }
  return graph;
}

TEST(GraphCovariance, AlongAChainItIsThatOfTheProductOfItsMotions) {
  const PoseGraph graph = chain();
  const GraphCovariance known(graph);
  const auto from_first = known.relativeTo(1);
  PoseWithCovariance expected = graph.edges[1].T_from_to * graph.edges[2].T_from_to;
  ASSERT_TRUE(from_first[3]);
  EXPECT_THAT(from_first[3]->T, PoseNear(expected.T, 1e-9, 1e-7));
  EXPECT_THAT(from_first[3]->P, MatrixNear(expected.P, 1e-5 * expected.P.norm()));
  EXPECT_THAT(from_first[1]->P, MatrixNear(Matrix6d::Zero(), 1e-15));
  // backwards, and back to the node that is held
  expected = inverse(graph.edges[0].T_from_to * graph.edges[1].T_from_to);
  EXPECT_THAT(known.relativeTo(2)[0]->P, MatrixNear(expected.P, 1e-5 * expected.P.norm()));
}

TEST(GraphCovariance, TwoMotionsHaveTwiceTheInformation) {
  PoseGraph graph = chain();
  graph.edges.push_back(graph.edges[1]);
  const GraphCovariance known(graph);
  const Matrix6d P = known.relativeTo(1)[2]->P, of_one = graph.edges[1].T_from_to.P;
  EXPECT_THAT(P, MatrixNear(0.5 * of_one, 1e-5 * of_one.norm()));
}

/** Second moment about 0 of a position with two modes and an optional Gaussian, summed over a grid. */
double summedMoment(double apart, double std, double log_odds, double other_std) {
  double sum = 0, moment = 0;
  for (double x = -3; x <= 3; x += 1e-3) {
    const auto gauss = [x](double at, double s) { return std::exp(-0.5 * (x - at) * (x - at) / (s * s)); };
    const double p = (gauss(0, std) + std::exp(log_odds) * gauss(apart, std)) * gauss(0, other_std);
    sum += p, moment += p * x * x;
  }
  return moment / sum;
}

TEST(GraphCovariance, AlternativesAreContainedByTheirOddsInTheGraph) {
  PoseWithCovariance here, next_door;
  here.P = next_door.P = 0.01 * Matrix6d::Identity();
  next_door.T.translation().x() = 0.6;
  PoseGraph graph;
  graph.T_w_n.assign(2, Eigen::Isometry3d::Identity());
  graph.edges.push_back({0, 1, here, false, {{next_door, -1}}});
  const double alone = GraphCovariance(graph).between(0, 1)->P(3, 3);
  EXPECT_NEAR(alone, summedMoment(0.6, 0.1, -1, 100), 0.01 * alone);
  for (const double std : {0.6, 0.3, 0.1}) {
    PoseWithCovariance other = here;
    other.P = std * std * Matrix6d::Identity();
    graph.edges.resize(1);
    graph.edges.push_back({0, 1, other});
    const double expected = summedMoment(0.6, 0.1, -1, std);
    EXPECT_NEAR(GraphCovariance(graph).between(0, 1)->P(3, 3), expected, 0.15 * expected) << std;
  }
}

TEST(GraphCovariance, OtherPartsAreNowhere) {
  PoseGraph graph = chain();
  graph.edges.erase(graph.edges.begin() + 1);
  const auto relative = GraphCovariance(graph).relativeTo(0);
  EXPECT_TRUE(relative[1]);
  EXPECT_FALSE(relative[2]);
  EXPECT_FALSE(relative[3]);
}

TEST(GraphCovariance, AFloorFixesRollPitchAndHeight) {
  const CameraMounting mounting{1.1, 15};
  PoseGraph graph;
  graph.T_w_n = {mounting.T_b_c(), mounting.T_b_c()};
  graph.T_w_n[1].translation().x() += 1;
  const PoseWithCovariance vague{graph.T_w_n[0].inverse() * graph.T_w_n[1], covariance(0.5 / kDegree, 1)};
  graph.edges.push_back({0, 1, vague});
  const Eigen::Matrix3d C = floorCovariance({});
  graph.floor = LevelFloor{mounting.T_b_c(), C};
  const Matrix6d P = GraphCovariance(graph).ofNodes()[1];
  // The camera is turned as much as its robot, and stands straight above it.
  EXPECT_NEAR(P(0, 0), C(0, 0), 0.02 * C(0, 0));
  EXPECT_NEAR(P(1, 1), C(1, 1), 0.02 * C(1, 1));
  EXPECT_NEAR(P(5, 5), C(2, 2), 0.02 * C(2, 2));
  EXPECT_GT(P(2, 2), 0.1);
  EXPECT_GT(P(3, 3), 0.5);
}

TEST(GraphCovariance, OfOnePairIsTheSameAsAmongAll) {
  const GraphCovariance known(chain());
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      const PoseWithCovariance alone = *known.between(a, b), among_all = *known.relativeTo(a)[b];
      EXPECT_THAT(alone.T, PoseNear(among_all.T, 1e-12, 1e-9));
      EXPECT_THAT(alone.P, MatrixNear(among_all.P, 1e-9 * among_all.P.norm() + 1e-10)) << a << " " << b;
    }
  PoseGraph apart = chain();
  apart.edges.erase(apart.edges.begin() + 1);
  EXPECT_FALSE(GraphCovariance(apart).between(0, 3));
}

TEST(GraphCovariance, NeighboursAreKnownHoweverFarFromTheFirst) {
  PoseGraph graph;
  graph.T_w_n.push_back(motion(0, 0, 0).T);
  for (int i = 0; i < 1000; ++i) {
    const PoseWithCovariance step = motion(0.3, 0, 0.1, i == 998 ? 0.001 : 3);
    graph.edges.push_back({i, i + 1, step});
    graph.T_w_n.push_back(graph.T_w_n.back() * step.T);
  }
  const Matrix6d P = GraphCovariance(graph).between(998, 999)->P, expected = graph.edges[998].T_from_to.P;
  EXPECT_THAT(P, MatrixNear(expected, 1e-5 * expected.norm()));
}

TEST(GraphCovariance, IsTheSameForAnyNumberOfThreads) {
  const GraphCovariance one(chain(), 1), two(chain(), 2);
  for (std::size_t i = 0; i < one.ofNodes().size(); ++i) EXPECT_EQ(one.ofNodes()[i], two.ofNodes()[i]);
}

}  // namespace

}  // namespace facetloc::internal
