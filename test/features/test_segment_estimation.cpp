// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/segment_estimation.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_depth.h>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace facetloc {
namespace {

using test::endlessPlane, test::IsPositiveSemidefinite, test::IsRotation, test::MatrixNear, test::noisy,
    test::render, test::Rng, test::Scene, test::smallCamera, test::uniform, testing::ElementsAre;

constexpr double kDisparityUnit = 1 / kKinectGain;

void paint(LabelImage& labels, std::uint16_t label, int u0, int v0, int u1, int v1) {
  for (int v = v0; v <= v1; ++v)
    for (int u = u0; u <= u1; ++u) labels.label[static_cast<std::size_t>(v) * labels.width + u] = label;
}

LabelImage noLabels(const Intrinsics& c) {
  return {c.width, c.height, std::vector<std::uint16_t>(static_cast<std::size_t>(c.width) * c.height, 0)};
}

// A labelled rectangle of pixels [u0, u1] x [v0, v1] on a plane through a point.
struct Patch {
  DepthImage image;
  LabelImage labels;
};
Patch patch(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, int u0, int v0, int u1, int v1,
            const Intrinsics& camera = smallCamera()) {
  Patch p{render({endlessPlane(point, normal)}, camera).image, noLabels(camera)};
  paint(p.labels, 1, u0, v0, u1, v1);
  return p;
}

std::vector<Segment> estimate(const Patch& p, const SegmentEstimationParams& params = {}) {
  return estimateSegments(p.image, p.labels, {}, params);
}

void expectSameNumbers(const std::vector<Segment>& segments, const std::vector<Segment>& want) {
  ASSERT_EQ(segments.size(), want.size());
  for (std::size_t i = 0; i < want.size(); ++i) EXPECT_TRUE(test::sameNumbers(segments[i], want[i])) << i;
}

TEST(SegmentEstimation, AWallInFrontHasTheMomentsOfItsRectangle) {
  const Patch p = patch({0, 0, 2}, {0, 0, 1}, 100, 80, 219, 139);
  const std::vector<Segment> segments = estimate(p);
  ASSERT_EQ(segments.size(), 1u);
  const Segment& s = segments[0];
  const double width = 120 * 2 / p.image.camera.fx, height = 60 * 2 / p.image.camera.fy;
  const Eigen::Vector3d centre = 2 * p.image.camera.ray(159.5, 109.5);
  EXPECT_THAT(s.t, MatrixNear(centre, 1e-6));
  EXPECT_THAT(s.R, IsRotation());
  EXPECT_NEAR(s.lambda[0], width * width / 12, 1e-3 * width * width / 12);
  EXPECT_NEAR(s.lambda[1], height * height / 12, 1e-3 * height * height / 12);
  EXPECT_NEAR(std::abs(s.R(0, 0)), 1, 1e-9);  // the longer side is x
  EXPECT_THAT(s.normal(), MatrixNear(Eigen::Vector3d::UnitZ(), 1e-6));
  EXPECT_EQ(s.num_points, 120 * 60);
  EXPECT_EQ(s.hull.size, 4);
  EXPECT_NEAR(s.area(), (width * 119 / 120) * (height * 59 / 60), 1e-5);
}

TEST(SegmentEstimation, EverySegmentIsAProperFrameOnItsPlane) {
  Rng rng(1);
  int found = 0;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d point = uniform(rng, 1, 4) * smallCamera().ray(160, 120);
    Eigen::Vector3d n = test::randomDirection(rng);
    if (std::abs(n.dot(point.normalized())) < 0.4) continue;
    if (n.dot(point) < 0) n = -n;
    const int u0 = 90 + i % 50, v0 = 60 + i % 30;
    const Patch p = patch(point, n, u0, v0, u0 + 70, v0 + 50);
    const std::vector<Segment> segments = estimate(p);
    if (segments.empty()) continue;
    ++found;
    const Segment& s = segments[0];
    EXPECT_THAT(s.R, IsRotation());
    EXPECT_GT(s.offset(), 0);  // the normal points away from the camera
    EXPECT_THAT(s.normal(), MatrixNear(n, 1e-5));
    EXPECT_NEAR(s.offset(), n.dot(point), 1e-5);
    EXPECT_GE(s.lambda[0], s.lambda[1]);
    EXPECT_THAT(s.Sigma_q, IsPositiveSemidefinite(1e-15));
    EXPECT_GT(s.Sigma_q.determinant(), 0);
    // The centroid is the mean of the pixels' points; the outline contains them all and has no room to spare.
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
    int count = 0;
    for (int v = v0; v <= v0 + 50; ++v)
      for (int u = u0; u <= u0 + 70; ++u) {
        if (!(p.image.at(u, v) > 0)) continue;
        const Eigen::Vector3d x = p.image.at(u, v) * p.image.camera.ray(u, v);
        const Eigen::Vector2d in_plane = (s.R.transpose() * (x - s.t)).head<2>();
        mean += x;
        second += in_plane * in_plane.transpose();
        ++count;
        EXPECT_TRUE(s.hull.contains(in_plane.cast<float>(), 1e-4f));
      }
    EXPECT_THAT(s.t, MatrixNear(mean / count, 1e-5));
    EXPECT_THAT((second / count).eval(), MatrixNear(Eigen::Matrix2d(s.lambda.asDiagonal()), 1e-5));
    EXPECT_GT(s.area(), 0);  // counter-clockwise
  }
  EXPECT_GT(found, 30);
}

TEST(SegmentEstimation, ARaggedRegionKeepsAtMostTheVerticesThatTheOutlineHolds) {
  const Intrinsics camera = smallCamera();
  Patch p{render({endlessPlane({0, 0, 2}, {0.2, 0.1, 1})}, camera).image, noLabels(camera)};
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u)
      if (std::hypot(u - 160, v - 120) < 100)
        p.labels.label[static_cast<std::size_t>(v) * camera.width + u] = 1;
  const std::vector<Segment> segments = estimate(p);
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].hull.size, ConvexHull::kMaxVertices);
  const double area =
      EIGEN_PI * 4 * std::sqrt(segments[0].lambda[0] * segments[0].lambda[1]);  // area of an ellipse
  EXPECT_NEAR(segments[0].area(), area, 0.03 * area);
}

TEST(SegmentEstimation, NoiseMovesThePlaneByNoMoreThanItsUncertainty) {
  double worst = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Patch p = patch({0.2, 0.1, 2.5}, {0.3, -0.2, 1}, 80, 60, 240, 180);
    const Segment truth = estimate(p).at(0);
    p.image = noisy(p.image, 0.5 * kDisparityUnit, seed);
    const Segment s = estimate(p).at(0);
    const Eigen::Vector3d n = truth.R.transpose() * s.normal();
    const Eigen::Vector3d q(n.x() / n.z(), n.y() / n.z(), s.offset() - s.normal().dot(truth.t));
    worst = std::max(worst, q.dot(truth.Sigma_q.llt().solve(q)));
  }
  EXPECT_LT(worst, 11.345);  // Sigma_q also covers distortion, so that white noise alone stays far below
}

TEST(SegmentEstimation, StrayPixelsLeaveTheFit) {
  Patch clean = patch({0, 0, 2}, {0.1, 0.2, 1}, 80, 60, 239, 179), dirty = clean;
  Rng rng(2);
  int stray = 0;
  for (int v = 60; v < 180; ++v)
    for (int u = 80; u < 240; ++u)
      if (uniform(rng, 0, 1) < 0.03) {
        float& z = dirty.image.depth[static_cast<std::size_t>(v) * 320 + u];
        z = static_cast<float>(1 / (1 / z - 30 * kDisparityUnit));
        ++stray;
      }
  const Segment want = estimate(clean).at(0), got = estimate(dirty).at(0);
  EXPECT_EQ(got.num_points, want.num_points - stray);
  EXPECT_THAT(got.normal(), MatrixNear(want.normal(), 1e-5));
  EXPECT_NEAR(got.offset(), want.offset(), 1e-5);
}

TEST(SegmentEstimation, HolesAndImpossibleDepthsAreNotMeasured) {
  Patch p = patch({0, 0, 2}, {0.1, 0.2, 1}, 80, 60, 239, 179);
  const Segment whole = estimate(p).at(0);
  Rng rng(3);
  const float holes[] = {0.f, -1.f, std::numeric_limits<float>::quiet_NaN()};
  for (std::size_t i = 0; i < p.image.depth.size(); ++i)
    if (uniform(rng, 0, 1) < 0.5) p.image.depth[i] = holes[i % 3];
  const Segment s = estimate(p).at(0);
  EXPECT_LT(s.num_points, 0.6 * whole.num_points);
  EXPECT_THAT(s.normal(), MatrixNear(whole.normal(), 1e-5));
  EXPECT_NEAR(s.offset(), whole.offset(), 1e-5);
}

TEST(SegmentEstimation, SmallRegionsAreDroppedInProportionToTheImage) {
  const auto found = [](const Intrinsics& camera, int width, int height) {
    SegmentEstimationParams params;
    params.min_support = 600;
    return estimate(patch({0, 0, 4}, {0, 0, 1}, 60, 50, 59 + width, 49 + height, camera), params).size();
  };
  EXPECT_EQ(found(smallCamera(), 30, 20), 1u);
  EXPECT_EQ(found(smallCamera(), 33, 18), 0u);       // 594 px
  EXPECT_EQ(found(test::tinyCamera(), 15, 10), 1u);  // a quarter of the pixels, a quarter of the limit
  EXPECT_EQ(found(test::tinyCamera(), 16, 9), 0u);   // 144 px
}

TEST(SegmentEstimation, FarRegionsAreDropped) {
  EXPECT_EQ(estimate(patch({0, 0, 7.4}, {0, 0, 1}, 80, 60, 239, 179)).size(), 1u);
  EXPECT_TRUE(estimate(patch({0, 0, 7.6}, {0, 0, 1}, 80, 60, 239, 179)).empty());
  SegmentEstimationParams params;
  params.max_depth = 10;
  EXPECT_EQ(estimate(patch({0, 0, 7.6}, {0, 0, 1}, 80, 60, 239, 179), params).size(), 1u);
}

TEST(SegmentEstimation, PlanesSeenEdgeOnAreDropped) {
  // A floor 4 cm below the camera centre, and a wall that the rays graze.
  EXPECT_TRUE(estimate(patch({0, 0.04, 0}, {0, 1, 0}, 40, 135, 279, 230)).empty());
  EXPECT_EQ(estimate(patch({0, 1, 0}, {0, 1, 0}, 40, 160, 279, 230)).size(), 1u);
  EXPECT_TRUE(estimate(patch({0, 0, 3}, {1, 0, 0.05}, 130, 60, 180, 180)).empty());
}

TEST(SegmentEstimation, StripsAreDropped) {
  EXPECT_TRUE(estimate(patch({0, 0, 2}, {0, 0, 1}, 20, 100, 299, 103)).empty());  // 280 x 4 px
  EXPECT_EQ(estimate(patch({0, 0, 2}, {0, 0, 1}, 20, 100, 299, 119)).size(), 1u);
  EXPECT_TRUE(estimate(patch({0, 0, 2}, {0, 0, 1}, 20, 100, 299, 100)).empty());  // a single row
}

TEST(SegmentEstimation, NothingGivesNothing) {
  std::vector<int> kept{1, 2, 3};
  EXPECT_TRUE(estimateSegments({}, {}, {}, {}, &kept).empty());
  EXPECT_TRUE(kept.empty());
  Patch p = patch({0, 0, 2}, {0, 0, 1}, 80, 60, 239, 179);
  for (float& z : p.image.depth) z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(estimate(p).empty());
  p = patch({0, 0, 2}, {0, 0, 1}, 80, 60, 239, 179);
  p.labels = noLabels(p.image.camera);
  EXPECT_TRUE(estimate(p).empty());
}

TEST(SegmentEstimation, LabelsOfAnotherSizeAreRefused) {
  Patch p = patch({0, 0, 2}, {0, 0, 1}, 80, 60, 239, 179);
  p.labels.label.pop_back();
  EXPECT_THROW(estimate(p), std::invalid_argument);
  p = patch({0, 0, 2}, {0, 0, 1}, 80, 60, 239, 179);
  std::swap(p.labels.width, p.labels.height);
  EXPECT_THROW(estimate(p), std::invalid_argument);
}

TEST(SegmentEstimation, KeptNamesTheLabelOfEachSegment) {
  const Intrinsics camera = smallCamera();
  Patch p{render({endlessPlane({0, 0, 2}, {0, 0, 1})}, camera).image, noLabels(camera)};
  paint(p.labels, 7, 10, 10, 200, 100);
  paint(p.labels, 3, 210, 10, 213, 13);  // too small
  paint(p.labels, 5, 10, 150, 100, 200);
  std::vector<int> kept;
  const std::vector<Segment> segments = estimateSegments(p.image, p.labels, {}, {}, &kept);
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_THAT(kept, ElementsAre(7, 5));
  EXPECT_EQ(segments[0].num_points, 191 * 91);
  EXPECT_EQ(segments[1].num_points, 91 * 51);
}

TEST(SegmentEstimation, TheValueOfALabelDoesNotMatter) {
  Patch p = patch({0, 0, 2}, {0.3, 0.1, 1}, 80, 60, 239, 179);
  const std::vector<Segment> want = estimate(p);
  ASSERT_EQ(want.size(), 1u);
  for (std::uint16_t& label : p.labels.label) label *= 65535;
  std::vector<int> kept;
  const std::vector<Segment> segments = estimateSegments(p.image, p.labels, {}, {}, &kept);
  EXPECT_THAT(kept, ElementsAre(65535));
  expectSameNumbers(segments, want);
}

TEST(SegmentEstimation, BuffersOfAnotherImageDoNotShow) {
  const Intrinsics wide{317, 61, 280, 290, 158, 30}, narrow{50, 1, 45, 45, 25, 0}, none;
  SegmentEstimation reused;
  std::vector<Segment> segments;
  for (const Intrinsics& camera : {smallCamera(), wide, narrow, none, smallCamera()}) {
    const auto [image, labels] =
        render(test::furnishedRoom(), camera, test::lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2}));
    std::vector<int> kept, want_kept;
    reused.estimate(image, labels, {}, segments, kept);
    expectSameNumbers(segments, estimateSegments(image, labels, {}, {}, &want_kept));
    EXPECT_EQ(kept, want_kept);
  }
  EXPECT_GE(segments.size(), 4u);
}

// ---- uncertainty

TEST(SegmentCovariance, FaithfulModelIsTheClosedFormOfThePaper) {
  const Intrinsics camera = smallCamera();
  const SensorNoise noise;
  Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const Segment s = test::randomSegment(rng);
    const double kappa = uniform(rng, 0.1, 1), z = s.t.z(), rho = s.offset();
    const Eigen::Vector3d n = s.normal();
    // METHOD 2.3 with 1 px at 320x240 and 1 DU, then eqs. (4)-(5).
    const double var_r = kappa * kappa *
                         (z * z * (std::pow(n.x() / camera.fx, 2) + std::pow(n.y() / camera.fy, 2)) +
                          std::pow(z * rho * kDisparityUnit, 2));
    const Eigen::Vector3d want(var_r / (s.lambda[0] + var_r), var_r / (s.lambda[1] + var_r), var_r);
    const Eigen::Matrix3d got = paperCovariance(n, s.t, s.lambda, camera, kappa, noise);
    EXPECT_LT((got - Eigen::Matrix3d(want.asDiagonal())).norm(), 1e-9 * want.norm());
  }
}

TEST(SegmentCovariance, FaithfulModelDoesNotDependOnTheSizeOfTheImage) {
  Rng rng(5);
  const Segment s = test::randomSegment(rng);
  const Eigen::Matrix3d full = paperCovariance(s.normal(), s.t, s.lambda, kinectIntrinsics(), 1, {});
  const Eigen::Matrix3d half =
      paperCovariance(s.normal(), s.t, s.lambda, kinectIntrinsics().subsampled(2), 1, {});
  EXPECT_LT((full - half).norm(), 1e-12 * full.norm());
}

TEST(SegmentCovariance, FaithfulIsAParameter) {
  const Patch p = patch({0, 0, 2}, {0.1, 0.2, 1}, 80, 60, 239, 179);
  SegmentEstimationParams params;
  params.paper_uncertainty = true;
  const Segment s = estimate(p, params).at(0);
  EXPECT_THAT(s.Sigma_q,
              MatrixNear(paperCovariance(s.normal(), s.t, s.lambda, p.image.camera, 1, {}), 1e-15));
}

TEST(SegmentCovariance, SlopeAndOffsetSpreadAsFirstOrderPropagationSays) {
  // Pixels of a patch with white disparity noise: q of 20000 fits against J_q Sigma_m J_q^T (METHOD 7.3).
  const Intrinsics camera = smallCamera();
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, -0.2, 0.93).normalized();
  const double rho = 2, sigma = 0.5 * kDisparityUnit;
  std::vector<Eigen::Vector3d> rays;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  Eigen::Matrix3d bb = Eigen::Matrix3d::Zero();
  for (int u = 60; u < 200; u += 12)
    for (int v = 50; v < 170; v += 12) {
      const Eigen::Vector3d b = camera.ray(u, v);
      rays.push_back(b);
      bb += b * b.transpose();
      centroid += b * (rho / n.dot(b));
    }
  centroid /= static_cast<double>(rays.size());
  Eigen::Matrix3d R;
  const Eigen::Vector3d x = n.unitOrthogonal();
  R << x, n.cross(x), n;
  const Eigen::Matrix3d analytic = slopeOffsetCovariance(R, centroid, rho, sigma * sigma * bb.inverse());

  Rng rng(6);
  std::normal_distribution<double> noise(0, sigma);
  Eigen::Matrix3d sampled = Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d solve = bb.inverse();
  constexpr int kTrials = 20000;
  for (int i = 0; i < kTrials; ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& b : rays) sum += b * (n.dot(b) / rho + noise(rng));
    const Eigen::Vector3d m = solve * sum, in_frame = R.transpose() * m.normalized();
    const Eigen::Vector3d q(in_frame.x() / in_frame.z(), in_frame.y() / in_frame.z(),
                            1 / m.norm() - m.normalized().dot(centroid));
    sampled += q * q.transpose() / kTrials;
  }
  const Eigen::Vector3d scale = analytic.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix3d difference = scale.asDiagonal() * (sampled - analytic) * scale.asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.05);
}

TEST(SegmentCovariance, DefaultModelHasTheTermsOfTheMeasuredMethod) {
  const Patch p = patch({0.1, 0, 2}, {0.1, 0.2, 1}, 80, 60, 239, 179);
  const SensorNoise noise;
  const Segment s = estimate(p).at(0);
  Eigen::Matrix3d bb = Eigen::Matrix3d::Zero();
  for (int v = 60; v <= 179; ++v)
    for (int u = 80; u <= 239; ++u) bb += p.image.camera.ray(u, v) * p.image.camera.ray(u, v).transpose();
  const double N = 160 * 120, independent = std::max(8.0, N / 100), du = kDisparityUnit;
  Eigen::Matrix3d Sigma_m = N / independent * std::pow(0.5 * du, 2) * bb.inverse();
  Sigma_m.diagonal() += Eigen::Vector3d(0.25, 0.25, 0.0625) * du * du;
  Eigen::Matrix3d want = slopeOffsetCovariance(s.R, s.t, s.offset(), Sigma_m) +
                         paperCovariance(s.normal(), s.t, s.lambda, p.image.camera, 0.15, noise);
  want.diagonal() += Eigen::Vector3d(std::pow(0.1 * kDegree, 2), std::pow(0.1 * kDegree, 2), 4e-6);
  EXPECT_LT((s.Sigma_q - want).norm(), 1e-6 * want.norm());
}

TEST(SegmentCovariance, AFartherOrSmallerSegmentIsLessCertain) {
  const auto spread = [](double z, int half) {
    const Segment s =
        estimate(patch({0, 0, z}, {0, 0.1, 1}, 160 - half, 120 - half, 160 + half, 120 + half)).at(0);
    return s.Sigma_q.diagonal().eval();
  };
  EXPECT_TRUE((spread(4, 40).array() > spread(2, 40).array()).all());
  EXPECT_TRUE((spread(2, 15).array() > spread(2, 40).array()).all());
}

// ---- ranking

Segment facing(const Eigen::Vector3d& normal, int num_points) {
  Segment s = test::rectangle(2 * normal, normal, 1, 1);
  s.num_points = num_points;
  return s;
}

TEST(SegmentRanking, ALoneSmallWallInItsOwnDirectionComesFirst) {
  std::vector<Segment> segments;
  for (int i = 0; i < 5; ++i) segments.push_back(facing({0, 0, 1}, 5000 + i));
  for (int i = 0; i < 3; ++i) segments.push_back(facing({0, 1, 0}, 8000));
  segments.push_back(facing({1, 0, 0}, 200));
  EXPECT_EQ(rankByInformation(segments).front(), 8);
}

TEST(SegmentRanking, IsByTheShareOfInformationAlongTheNormal) {
  Rng rng(7);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Segment> segments;
    for (int i = 0; i < 12; ++i)
      segments.push_back(facing(test::randomDirection(rng), static_cast<int>(uniform(rng, 150, 20000))));
    const auto share = [&](int j) {  // METHOD 9, term by term
      double all = 0;
      for (const Segment& s : segments)
        all += s.num_points * std::pow(s.normal().dot(segments[j].normal()), 2);
      return segments[j].num_points / all;
    };
    const std::vector<int> order = rankByInformation(segments);
    ASSERT_EQ(order.size(), segments.size());
    for (std::size_t i = 0; i + 1 < order.size(); ++i) EXPECT_GE(share(order[i]), share(order[i + 1]));
    for (std::size_t i = 0; i < order.size(); ++i) EXPECT_LE(share(order[i]), 1 + 1e-12);
  }
}

TEST(SegmentRanking, TiesKeepTheirOrder) {
  EXPECT_THAT(rankByInformation({facing({0, 0, 1}, 500), facing({0, 0, 1}, 500), facing({0, 0, 1}, 500)}),
              ElementsAre(0, 1, 2));
  EXPECT_TRUE(rankByInformation({}).empty());
  EXPECT_THAT(rankByInformation({facing({0, 0, 1}, 0)}), ElementsAre(0));  // no support at all is no crash
}

}  // namespace
}  // namespace facetloc
