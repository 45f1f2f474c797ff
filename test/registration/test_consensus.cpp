// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/consensus.h"
#include "pairs/plane_measurement.h"

#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_depth.h>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>

namespace facetloc {
namespace {

using namespace internal;
using test::rectangle, test::Rng, test::smallCamera;

const double kPi = std::acos(-1.0);
const double kNewDirection =
    -std::log(1 - ScoreCalibration{}.parallel_weight);  // largest gain of a new direction

PoseWithCovariance accuratePose() {
  PoseWithCovariance pose;
  pose.P.diagonal() << 1e-5, 1e-5, 1e-5, 1e-4, 1e-4, 1e-4;
  return pose;
}

// Floor, a wall to the right and the end wall, all of them well inside the view.
std::vector<Segment> threeWalls() {
  return {rectangle({0, 1, 3}, {0, 1, 0}, 1, 0.8, 0, 0.02, 0.02),
          rectangle({1, 0, 3}, {1, 0, 0}, 1, 0.9, 0, 0.02, 0.02),
          rectangle({0, 0, 4}, {0, 0, 1}, 0.8, 0.8, 0, 0.02, 0.02)};
}

View viewOf(const std::vector<Segment>& segments) {
  View view;
  view.segments = segments;
  return view;
}

double llr(const View& scene, const View& model, const PoseWithCovariance& pose = accuratePose(),
           const ScoreCalibration& params = {}) {
  return logLikelihoodRatio(Query(scene), model, pose, DepthComparison({}), params);
}

double llr(const std::vector<Segment>& scene, const std::vector<Segment>& model,
           const PoseWithCovariance& pose = accuratePose(), const ScoreCalibration& params = {}) {
  return llr(viewOf(scene), viewOf(model), pose, params);
}

// ---- samples

TEST(SamplePoints, SpreadEvenlyOverTheOutline) {
  Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const Segment s = test::randomSegment(rng);
    const std::vector<Eigen::Vector3d> points = samplePoints(s);
    EXPECT_GE(points.size(), 12u);
    EXPECT_LE(points.size(), 48u);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : points) {
      const Eigen::Vector3d local = s.R.transpose() * (p - s.t);
      EXPECT_NEAR(local.z(), 0, 1e-9);
      EXPECT_TRUE(s.hull.contains(local.head<2>().cast<float>(), 1e-4f));
      mean += p / static_cast<double>(points.size());
    }
    EXPECT_LT((mean - s.t).norm(), 0.4 * std::sqrt(3 * s.lambda[0]));
  }
}

TEST(SamplePoints, OfATinyOutlineAreItsCentroidAndOfAnEmptyOneNothing) {
  Segment s = rectangle({0, 0, 2}, {0, 0, 1}, 1, 1);
  s.hull.size = 0;
  EXPECT_TRUE(samplePoints(s).empty());
  s = rectangle({0, 0, 2}, {0, 0, 1}, 1e-5, 1e-5);
  ASSERT_EQ(samplePoints(s).size(), 1u);
  EXPECT_EQ(samplePoints(s)[0], s.t);
}

// ---- log likelihood ratio

TEST(LogLikelihoodRatio, OfOneExactPairIsTheClosedForm) {
  const Segment s = threeWalls()[2];
  const PoseWithCovariance pose = accuratePose();
  PlaneMeasurement m;
  ASSERT_TRUE(measurePlane(s, s, pose.T, 0, m));
  Eigen::Matrix3d S = m.H * pose.P * m.H.transpose() + m.W;
  S.diagonal() += Eigen::Vector3d(std::pow(1 * kDegree, 2), std::pow(1 * kDegree, 2), 4e-4);
  const double chance = 1 / (2 * kPi * 6);
  const double pair = -0.5 * std::log(std::pow(2 * kPi, 3) * S.determinant()) - std::log(chance);
  EXPECT_NEAR(pair, 11, 2);  // METHOD 10.2: an exact match is worth about 11 nats
  EXPECT_NEAR(llr({s}, {s}), std::log(0.1 + 0.9 * std::exp(pair)), 1e-9);
}

TEST(LogLikelihoodRatio, IsTheSumOverIndependentDirections) {
  const std::vector<Segment> walls = threeWalls();
  double sum = 0;
  for (const Segment& s : walls) sum += llr({s}, walls);
  // Once others have been seen, chance is less likely to lie in a new direction: by ln 1 / (1 - mu) at most.
  EXPECT_NEAR(llr(walls, walls), sum, 2 * kNewDirection);
  EXPECT_GE(llr(walls, walls), sum);
}

TEST(LogLikelihoodRatio, LosesTheContributionOfARemovedSegment) {
  const std::vector<Segment> walls = threeWalls();
  const double all = llr(walls, walls);
  for (std::size_t j = 0; j < walls.size(); ++j) {
    std::vector<Segment> rest = walls;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(j));
    EXPECT_LT(llr(rest, walls), all);
    EXPECT_GT(llr(rest, walls), all - llr({walls[j]}, walls) - 2 * kNewDirection);
  }
}

TEST(LogLikelihoodRatio, AParallelSegmentIsDiscountedByHowLikelyItIsByChance) {
  // Along a direction already seen, a chance plane follows a normal distribution of 3 deg with probability
  // mu.
  const double uniform = 1 / (2 * kPi), parallel = uniform / std::pow(3 * kDegree, 2);
  const Segment s = threeWalls()[0], table = rectangle({0, 0.6, 3}, {0, 1, 0}, 1, 0.8, 0, 0.02, 0.02);
  for (const double mu : {0.0, 0.5, 0.8}) {
    ScoreCalibration params;
    params.parallel_weight = mu;
    const double share = mu * (1 - params.coplanar_weight);
    const double alone = llr({table}, {s, table}, accuratePose(), params);
    const double second =
        llr({s, table}, {s, table}, accuratePose(), params) - llr({s}, {s, table}, accuratePose(), params);
    EXPECT_NEAR(alone - second, std::log(((1 - mu) * uniform + share * parallel) / uniform), 1e-2) << mu;
  }
}

TEST(LogLikelihoodRatio, FurtherSegmentsOfAKnownPlaneAreDiscounted) {
  const Segment s = threeWalls()[0];
  const double uniform = 1 / (2 * kPi * 6), parallel = uniform / std::pow(3 * kDegree, 2);
  for (const double turn_deg : {0.0, 1.0, 3.0})
    for (const double offset : {0.0, 0.03, 0.08})
      for (const double w : {0.0, 0.5, 0.8}) {
        ScoreCalibration params;
        params.coplanar_weight = w;
        const double mu = params.parallel_weight, turn = turn_deg * kDegree;
        const Segment part =
            rectangle({0, 1 + offset, 3}, {0, std::cos(turn), std::sin(turn)}, 1, 0.8, 0, 0.02, 0.02);
        // The product of three normal distributions: two slopes of 1.5 deg, an offset of 3 cm.
        const double coplanar =
            std::exp(-0.5 * (std::pow(turn / (1.5 * kDegree), 2) + std::pow(offset / 0.03, 2))) /
            (std::pow(2 * kPi, 1.5) * std::pow(1.5 * kDegree, 2) * 0.03);
        const double chance = (1 - mu) * uniform +
                              mu * (1 - w) * parallel * std::exp(-0.5 * std::pow(turn_deg / 3, 2)) +
                              mu * w * coplanar;
        const double alone = llr({part}, {part}, accuratePose(), params);
        const double second =
            llr({s, part}, {part}, accuratePose(), params) - llr({s}, {part}, accuratePose(), params);
        const double pi_m = params.match_probability;
        const double explained = (std::exp(alone) - (1 - pi_m)) / pi_m * uniform / chance;
        EXPECT_NEAR(second, std::log(1 - pi_m + pi_m * explained), 1e-6)
            << turn_deg << ", " << offset << ", " << w;
      }
}

// A wall that is seen in nine pieces is no more evidence than a few walls.
TEST(LogLikelihoodRatio, AWallInPiecesIsNotAsMuchEvidenceAsThereArePieces) {
  const Segment wall = threeWalls()[2];
  std::vector<Segment> pieces;
  for (int i = 0; i < 9; ++i)
    pieces.push_back(
        rectangle({-0.5 + 0.5 * (i % 3), -0.5 + 0.5 * (i / 3), 4}, {0, 0, 1}, 0.25, 0.25, 0, 0.02, 0.02));
  ScoreCalibration each_by_itself;
  each_by_itself.coplanar_weight = 0;
  const double one = llr({wall}, {wall}), in_pieces = llr(pieces, {wall});
  EXPECT_GT(in_pieces, one - 1);
  EXPECT_LT(in_pieces, 2.5 * one);
  EXPECT_GT(llr(pieces, {wall}, accuratePose(), each_by_itself), 4.5 * one);
}

TEST(LogLikelihoodRatio, AnUnexplainedSegmentCannotVeto) {
  const std::vector<Segment> walls = threeWalls();
  std::vector<Segment> with_person = walls;
  with_person.push_back(rectangle({-0.3, 0, 2}, {1, 0.3, 1}, 0.3, 0.5));
  EXPECT_NEAR(llr(with_person, walls), llr(walls, walls) + std::log(0.1), 1e-9);
}

TEST(LogLikelihoodRatio, ASegmentThatTheModelCannotSeeSaysNothing) {
  // The model's camera sees the three walls and has a depth picture; the added segment lies beside its view
  // or behind its end wall.
  const test::Scene scene{test::endlessPlane({0, 1, 0}, {0, 1, 0}), test::endlessPlane({1, 0, 0}, {1, 0, 0}),
                          test::endlessPlane({0, 0, 4}, {0, 0, 1})};
  View model = viewOf(threeWalls());
  const DepthImage image = test::render(scene, smallCamera()).image;
  model.intrinsics = image.camera;
  model.depth = DepthPicture::fromDepth(image);
  const double before = llr(viewOf(threeWalls()), model);
  for (const Eigen::Vector3d& centre :
       {Eigen::Vector3d(-8, 0, 3), Eigen::Vector3d(0, 0, 7), Eigen::Vector3d(0, 0, -3)}) {
    View with_hidden = viewOf(threeWalls());
    with_hidden.segments.push_back(rectangle(centre, {0.2, 0.1, 1}, 0.4, 0.4));
    EXPECT_NEAR(llr(with_hidden, model), before, 1e-12) << centre.transpose();
  }
  View with_visible = viewOf(threeWalls());
  with_visible.segments.push_back(rectangle({0, 0, 2}, {0.2, 0.1, 1}, 0.4, 0.4));
  EXPECT_NEAR(llr(with_visible, model), before + std::log(0.1), 1e-9);  // this one it would have seen
}

TEST(LogLikelihoodRatio, AWrongPoseScoresLess) {
  const std::vector<Segment> walls = threeWalls();
  const double right = llr(walls, walls);
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    PoseWithCovariance pose = accuratePose();
    pose.T.translation() = 0.3 * test::randomDirection(rng);
    EXPECT_LT(llr(walls, walls, pose), right);
    pose = accuratePose();
    pose.T.linear() = expSO3(8 * kDegree * test::randomDirection(rng));
    EXPECT_LT(llr(walls, walls, pose), right);
  }
}

TEST(LogLikelihoodRatio, MovesWithTheFrameOfTheModel) {
  Rng rng(3);
  for (int i = 0; i < 300; ++i) {
    std::vector<Segment> scene, model;
    PoseWithCovariance pose;
    pose.T = test::randomPose(rng, 0.3, 0.5);
    Vector6d std;
    std << 0.01, 0.02, 0.01, 0.02, 0.06, 0.1;
    pose.P = test::randomCovariance<6>(rng, std);
    for (int k = 0; k < 5; ++k) {
      model.push_back(test::randomSegment(rng));
      scene.push_back(transformed(test::anotherPart(rng, model.back(), 1), pose.T.inverse()));
    }
    const double here = llr(scene, model, pose);
    const Eigen::Isometry3d X = test::randomPose(rng, 3, 5);
    Matrix6d A = Matrix6d::Zero();
    A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = X.linear();
    for (Segment& s : model) s = transformed(s, X);
    EXPECT_NEAR(llr(scene, model, {X * pose.T, A * pose.P * A.transpose()}), here,
                1e-8 * (1 + std::abs(here)));
  }
}

TEST(LogLikelihoodRatio, OfAnEmptySceneIsZero) {
  EXPECT_EQ(llr(std::vector<Segment>{}, threeWalls()), 0);
  std::vector<Segment> without_outline = threeWalls();
  for (Segment& s : without_outline) s.hull.size = 0;
  EXPECT_EQ(llr(without_outline, threeWalls()), 0);
  EXPECT_NEAR(llr(threeWalls(), {}), 3 * std::log(0.1), 1e-9);
}

// ---- segment-overlap score

// Upper tail of chi-square with 3 degrees of freedom by numerical integration of its density.
double upperTail(double x) {
  double sum = 0;
  const double step = 1e-3;
  for (double t = x + step / 2; t < 60; t += step) sum += step * std::sqrt(t / (2 * kPi)) * std::exp(-t / 2);
  return sum;
}

TEST(SurfaceMatchingScore, OfExactPairsIsTheirSmallerSupportInPercent) {
  std::vector<Segment> scene = threeWalls(), model = threeWalls();
  scene[0].num_points = 700, model[0].num_points = 500;
  scene[1].num_points = 300, model[1].num_points = 900;
  scene[2].num_points = 0, model[2].num_points = 900;
  EXPECT_NEAR(surfaceMatchingScore(scene, model, accuratePose(), {}), 100 * (500 + 300), 1e-6);
}

TEST(SurfaceMatchingScore, WeighsByTheTailOfTheDistance) {
  std::vector<Segment> scene{threeWalls()[2]}, model = scene;
  for (const double shift : {0.01, 0.03, 0.05, 0.08}) {
    model[0].t.z() = 4 + shift;
    const double d2 = coplanarityDistance(scene[0], model[0], accuratePose());
    ASSERT_GT(d2, 0);
    ASSERT_LT(d2, 11.345);
    EXPECT_NEAR(surfaceMatchingScore(scene, model, accuratePose(), {}),
                100 * upperTail(d2) * scene[0].num_points, 1e-3 * scene[0].num_points);
  }
  model[0].t.z() = 4.5;  // beyond the gate
  EXPECT_EQ(surfaceMatchingScore(scene, model, accuratePose(), {}), 0);
}

TEST(SurfaceMatchingScore, TakesTheBestModelSegmentOfEachSceneSegment) {
  const std::vector<Segment> walls = threeWalls();
  std::vector<Segment> model = walls;
  model.insert(model.end(), walls.begin(), walls.end());
  EXPECT_EQ(surfaceMatchingScore(walls, model, accuratePose(), {}),
            surfaceMatchingScore(walls, walls, accuratePose(), {}));
  EXPECT_EQ(surfaceMatchingScore({}, walls, accuratePose(), {}), 0);
  EXPECT_EQ(surfaceMatchingScore(walls, {}, accuratePose(), {}), 0);
}

}  // namespace
}  // namespace facetloc
