// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/region_frame.h>
#include <facetloc/testing/organized_clouds.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace facetloc {
namespace {

using test::MatrixNear, test::Rng;

const Eigen::Vector3d kHere = Eigen::Vector3d::Zero();

// Points of a rectangle about a centre, in rows; the plane's normal is z of R.
std::vector<Eigen::Vector3d> rectangle(const Eigen::Matrix3d& R, const Eigen::Vector3d& centre, double width,
                                       double height, int per_side) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < per_side; ++i)
    for (int j = 0; j < per_side; ++j)
      points.push_back(centre + R.col(0) * width * ((i + 0.5) / per_side - 0.5) +
                       R.col(1) * height * ((j + 0.5) / per_side - 0.5));
  return points;
}

Eigen::Vector3d diagonalOf(const Segment& s) { return s.Sigma_q.diagonal().cwiseSqrt(); }

// The true plane in the frame of a measured segment, METHOD 7.1.
Eigen::Vector3d disturbance(const Segment& s, const Eigen::Vector3d& n, double rho) {
  const Eigen::Vector3d in_frame = s.R.transpose() * n;
  return {in_frame.x() / in_frame.z(), in_frame.y() / in_frame.z(), rho - n.dot(s.t)};
}

TEST(RegionFrame, AgreesWithTheFrameThatTheImageGives) {
  const test::Rendering view = test::render(test::furnishedRoom(), test::smallCamera(),
                                            test::lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2}));
  const auto cloud = test::organizedCloud<pcl::PointXYZ>(view.image);
  std::vector<int> labels;
  const std::vector<Segment> of_image = estimateSegments(view.image, view.labels, {}, {}, &labels);
  ASSERT_GT(of_image.size(), 4u);
  for (std::size_t k = 0; k < labels.size(); ++k) {
    pcl::Indices inliers;
    for (std::size_t i = 0; i < view.labels.label.size(); ++i)
      if (view.labels.label[i] == labels[k]) inliers.push_back(static_cast<int>(i));
    const auto frame = regionFrame(*cloud, inliers, Eigen::Vector3f::Zero(), {});
    Segment s;
    ASSERT_TRUE(frame && toSegment(*frame, s));
    const Segment& want = of_image[k];
    EXPECT_LT((s.t - want.t).norm(), 0.001);
    EXPECT_GT(s.normal().dot(want.normal()), std::cos(0.01 * kDegree));
    EXPECT_NEAR(s.lambda[0], want.lambda[0], 0.01 * want.lambda[0]);
    EXPECT_NEAR(s.lambda[1], want.lambda[1], 0.01 * want.lambda[1]);
    EXPECT_LT(s.hull.area(), 1.05 * want.hull.area());
    EXPECT_GT(s.hull.area(), 0.95 * want.hull.area());
    // Axes may be turned where lambda_1 is about lambda_2; offset and overall slope stay.
    const Eigen::Vector3d std = diagonalOf(s), want_std = diagonalOf(want);
    EXPECT_NEAR(std.z(), want_std.z(), 0.3 * want_std.z());
    EXPECT_NEAR(std.head<2>().norm(), want_std.head<2>().norm(), 0.3 * want_std.head<2>().norm());
  }
}

// A camera sees a rectangle with one independent error for each of its 100 pixels; nothing else is uncertain.
TEST(RegionFrame, CovarianceIsThatOfManyMeasurements) {
  Rng rng(3);
  std::normal_distribution<double> gauss;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.5, Eigen::Vector3d(0.3, 1, 0.1).normalized()).matrix();
  const Eigen::Vector3d centre(0.2, -0.1, 2), n = R.col(2);
  SensorNoise noise;
  noise.distortion_slope = noise.distortion_offset = 0;
  SegmentEstimationParams exact;
  exact.errors = {0, 0, 0};
  const auto true_points = rectangle(R, centre, 1.0, 0.8, 13);
  const double std = noise.ofInverseDepth(centre.norm());
  double nees = 0;
  constexpr int kTrials = 2000;
  Segment s;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<Eigen::Vector3d> points = true_points;
    for (Eigen::Vector3d& p : points) p = p.normalized() / (1 / p.norm() + std * gauss(rng));
    const auto found = regionSegment(points, kHere, noise, exact);
    ASSERT_TRUE(found);
    s = *found;
    const Eigen::Vector3d q = disturbance(s, n, n.dot(centre));
    nees += q.dot(s.Sigma_q.ldlt().solve(q)) / kTrials;
  }
  // The rectangle has as many independent errors as its solid angle says, and not as it has points.
  const double independent = s.num_points / 100., given = static_cast<double>(true_points.size());
  EXPECT_NEAR(nees * given / independent, 3, 0.25);
  const double outline = 0.8 * 12 / 13 * 12 / 13;  // [m^2] between the outermost points
  const double pixels = 292.35 * 292.35 * outline * n.dot(centre) / std::pow(centre.norm(), 3);
  EXPECT_NEAR(s.num_points, pixels, 0.05 * pixels);
}

TEST(RegionFrame, OutlineAndPlaneGiveTheSameAsAllPoints) {
  Rng rng(4);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Isometry3d T = test::randomPose(rng, 0.3, 1);
    const Eigen::Matrix3d R = T.linear();
    const Eigen::Vector3d centre = Eigen::Vector3d(0, 0, 2.5) + T.translation(), n = R.col(2);
    const double width = 0.4, height = 0.25;
    pcl::ModelCoefficients plane;  // another length and sign
    for (const double v : {n.x(), n.y(), n.z(), -n.dot(centre)})
      plane.values.push_back(static_cast<float>(-3 * v));
    pcl::PointCloud<pcl::PointXYZ> corners;
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      const Eigen::Vector3f p = (centre + R.col(0) * x * width / 2 + R.col(1) * y * height / 2).cast<float>();
      corners.emplace_back(p.x(), p.y(), p.z());
    }
    const auto by_outline = regionFrame(plane, corners, Eigen::Vector3f::Zero(), {});
    const auto by_points = regionSegment(rectangle(R, centre, width, height, 60), kHere, {});
    Segment s;
    ASSERT_TRUE(by_points && by_outline && toSegment(*by_outline, s));
    EXPECT_LT((s.t - by_points->t).norm(), 0.02);  // the points are even in area, not in the image
    EXPECT_GT(s.normal().dot(by_points->normal()), 1 - 1e-6);
    EXPECT_NEAR(s.lambda[0], width * width / 12, 0.05 * s.lambda[0]);
    EXPECT_NEAR(s.lambda[1], height * height / 12, 0.05 * s.lambda[1]);
    EXPECT_NEAR(s.hull.area(), width * height, 1e-3);
    EXPECT_NEAR(s.num_points, by_points->num_points, 0.05 * s.num_points);
    EXPECT_LT((diagonalOf(s) - diagonalOf(*by_points)).norm(), 0.1 * diagonalOf(s).norm());
  }
}

TEST(RegionFrame, MovesWithCloudAndViewpoint) {
  Rng rng(5);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()).matrix();
  const auto points = rectangle(R, {0.1, 0.3, 1.8}, 0.9, 0.5, 40);
  const auto here = regionSegment(points, kHere, {});
  ASSERT_TRUE(here);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Isometry3d T = test::randomPose(rng, 3, 5);
    std::vector<Eigen::Vector3d> moved;
    for (const Eigen::Vector3d& p : points) moved.push_back(T * p);
    const auto there = regionSegment(moved, T.translation(), {});
    ASSERT_TRUE(there);
    const Segment want = transformed(*here, T);
    EXPECT_THAT(there->t, MatrixNear(want.t, 1e-9));
    EXPECT_THAT(there->normal(), MatrixNear(want.normal(), 1e-9));
    EXPECT_GT(there->normal().dot(there->t - T.translation()), 0);
    EXPECT_THAT(there->lambda, MatrixNear(want.lambda, 1e-9));
    EXPECT_EQ(there->num_points, want.num_points);
    EXPECT_NEAR(there->Sigma_q(2, 2), want.Sigma_q(2, 2), 1e-9);
  }
}

TEST(RegionFrame, ThinnedCloudsAreAsUncertain) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()).matrix();
  const auto dense = regionSegment(rectangle(R, {0, 0, 2}, 1, 1, 100), kHere, {}),
             thin = regionSegment(rectangle(R, {0, 0, 2}, 1, 1, 25), kHere, {});
  ASSERT_TRUE(dense && thin);
  EXPECT_NEAR(thin->num_points, dense->num_points, 0.07 * dense->num_points);
  EXPECT_LT((diagonalOf(*thin) - diagonalOf(*dense)).norm(), 0.05 * diagonalOf(*dense).norm());
}

TEST(RegionFrame, RejectsPointsOffAPlane) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(),
                   kInf = std::numeric_limits<double>::infinity();
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const Eigen::Vector3d nan = Eigen::Vector3d::Constant(kNan);
  const auto good = rectangle(I, {0, 0, 2}, 1, 1, 10);
  ASSERT_TRUE(regionSegment(good, kHere, {}));
  EXPECT_FALSE(regionSegment(std::vector<Eigen::Vector3d>{}, kHere, {}));
  EXPECT_FALSE(regionSegment({good[0], good[1]}, kHere, {}));
  EXPECT_FALSE(regionSegment(rectangle(I, {0, 0, 2}, 1, 0, 10), kHere, {})) << "a line";
  EXPECT_FALSE(regionSegment(good, {0, 0, 2}, {})) << "seen edge-on";
  EXPECT_FALSE(regionSegment(good, nan, {}));
  EXPECT_FALSE(regionSegment(std::vector<Eigen::Vector3d>(9, nan), kHere, {}));
  EXPECT_FALSE(regionSegment(std::vector<Eigen::Vector3d>(9, kHere), kHere, {}));
  EXPECT_FALSE(regionSegment(rectangle(I, {0, 0, 1e30}, 1e30, 1e30, 10), kHere, {}));
  EXPECT_FALSE(regionSegment(Eigen::Vector4d(0, 0, 0, 0), good, kHere, {}));
  EXPECT_FALSE(regionSegment(Eigen::Vector4d(0, 0, 1, 0), good, kHere, {})) << "through the viewpoint";
  EXPECT_FALSE(regionSegment(Eigen::Vector4d(0, kNan, 1, -2), good, kHere, {}));
  EXPECT_FALSE(regionSegment(Eigen::Vector4d(0, kInf, 1, -2), good, kHere, {}));
  EXPECT_FALSE(regionSegment(Eigen::Vector4d(0, 0, 1, -2), {good[0], good[1]}, kHere, {}));

  auto holes = good;
  holes.insert(holes.end(), {nan, kHere});
  const auto with_holes = regionSegment(holes, kHere, {});
  ASSERT_TRUE(with_holes);
  EXPECT_EQ(with_holes->t, regionSegment(good, kHere, {})->t);

  pcl::PointCloud<pcl::PointXYZ> cloud(10, 1);
  EXPECT_FALSE(regionFrame(cloud, {-1, 5, 100}, Eigen::Vector3f::Zero(), {}));
  pcl::ModelCoefficients sphere;
  sphere.values = {0, 0, 0};
  EXPECT_FALSE(regionFrame(sphere, cloud, Eigen::Vector3f::Zero(), {}));
}

}  // namespace
}  // namespace facetloc
