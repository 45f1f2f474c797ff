// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/distortion_calibration.h"
#include "calibration/map_ambiguity.h"

#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

namespace facetloc::internal {
namespace {

using test::smallCamera;

const SensorNoise kNoise;
const PoseAccuracy kExact{0.02 * kDegree, 0.001}, kRough{0.5 * kDegree, 0.02};

/** About half a Kinect's disparity unit, tilted and bent. */
double trueDistortion(const Eigen::Vector2d& ray) {
  return 0.5 / kKinectGain * (std::sin(4 * ray.x() + 1) + 0.8 * std::cos(5 * ray.y() - 1) - 0.5);
}

/** Cameras all around the middle of a room, looking down a little. */
std::vector<Eigen::Isometry3d> cameras() {
  std::vector<Eigen::Isometry3d> out;
  for (int i = 0; i < 36; ++i) {
    const double angle = 20 * kDegree * i;
    out.push_back(test::lookingAlong({3 + 0.8 * std::cos(2 * angle), 2.4 + 0.6 * std::sin(3 * angle), 1.2},
                                     {std::cos(angle), std::sin(angle), i % 2 == 0 ? -0.2 : -0.35}));
  }
  return out;
}

Vector6d normal(std::mt19937& random) {
  std::normal_distribution<double> unit;
  Vector6d x;
  for (int k = 0; k < 6; ++k) x[k] = unit(random);
  return x;
}

Vector6d diagonal(double rotation, double translation) {
  Vector6d d;
  d << Eigen::Vector3d::Constant(rotation), Eigen::Vector3d::Constant(translation);
  return d;
}

class DistortionCalibration : public testing::Test {
protected:
  /** \param strength of the distortion */
  void see(double strength) {
    const std::vector<Eigen::Isometry3d> poses = cameras();
    depth_.clear();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const DepthImage image = test::noisy(test::render(test::largeRoom(), smallCamera(), poses[i]).image,
                                           kNoise.inverse_depth_std, static_cast<unsigned>(i));
      depth_.push_back(
          DepthPicture::fromDepth(test::changedDepth(image, [&](float z, const Eigen::Vector3d& ray) {
            return 1 / (1 / z + strength * trueDistortion(ray.head<2>()));
          })));
    }
    for (std::size_t i = 0; i < poses.size(); ++i) pictures_.push_back({&depth_[i], poses[i]});
  }
  void disturb(const PoseAccuracy& accuracy) {
    std::mt19937 rng(7);
    const Vector6d std = diagonal(accuracy.rotation_std, accuracy.translation_std);
    for (PosedPicture& p : pictures_) p.T_w_c = boxplus(p.T_w_c, std.cwiseProduct(normal(rng)));
  }
  /** Root mean square over the image [1/m]. */
  static double errorOf(const DepthDistortion& found, double strength) {
    double sum = 0;
    int n = 0;
    for (int v = 0; v < 240; v += 8)
      for (int u = 0; u < 320; u += 8, ++n) {
        const Eigen::Vector2d ray = smallCamera().ray(u, v).head<2>();
        sum += std::pow(found.at(ray) - strength * trueDistortion(ray), 2);
      }
    return std::sqrt(sum / n);
  }

  std::vector<DepthPicture> depth_;
  std::vector<PosedPicture> pictures_;
};

TEST_F(DistortionCalibration, FindsTheFieldOfACameraThatIsSaidToBeGoodInTheMiddle) {
  see(1);
  SensorNoise noise = kNoise;
  noise.distortion_offset = 0;
  const auto found = calibrateDistortion(pictures_, noise, kExact);
  ASSERT_TRUE(found);
  EXPECT_LT(errorOf(found->distortion, 1), 0.3 / kKinectGain);
}

TEST_F(DistortionCalibration, FindsTheField) {
  see(1);
  const auto found = calibrateDistortion(pictures_, kNoise, kExact);
  ASSERT_TRUE(found);
  EXPECT_GT(errorOf(DepthDistortion(found->distortion.extent()), 1), 0.4 / kKinectGain);
  EXPECT_LT(errorOf(found->distortion, 1), 0.1 / kKinectGain);
  EXPECT_TRUE(found->distortion.fits(smallCamera()));
}

TEST_F(DistortionCalibration, FindsItThoughThePosesAreRough) {
  see(1);
  disturb({0.15 * kDegree, 0.008});
  const auto found = calibrateDistortion(pictures_, kNoise, kRough);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->reliable());
  EXPECT_LT(errorOf(found->distortion, 1), 0.25 / kKinectGain);
}

TEST_F(DistortionCalibration, EstimatesTheAccuracyOfThePoses) {
  see(1);
  EXPECT_LT(calibrateDistortion(pictures_, kNoise, kRough)->poses.rotation_std, 0.1 * kDegree);
  const PoseAccuracy bad{1 * kDegree, 0.03};
  disturb(bad);
  const auto found = calibrateDistortion(pictures_, kNoise, kRough);
  EXPECT_NEAR(found->poses.rotation_std, bad.rotation_std, 0.35 * bad.rotation_std);
  EXPECT_NEAR(found->poses.translation_std, bad.translation_std, 0.35 * bad.translation_std);
  EXPECT_FALSE(found->reliable());
}

TEST_F(DistortionCalibration, FindsNoneForAPerfectCamera) {
  see(0);
  const auto found = calibrateDistortion(pictures_, kNoise, kRough);
  ASSERT_TRUE(found);
  EXPECT_LT(found->distortion.rms(), 0.15 / kKinectGain);
}

TEST_F(DistortionCalibration, PicturesWithoutOverlapGiveNoEstimate) {
  see(1);
  EXPECT_FALSE(calibrateDistortion({pictures_[0]}, kNoise, kExact));
  EXPECT_FALSE(calibrateDistortion({pictures_[0], pictures_[9]}, kNoise, kExact));  // turned by 180 deg
}

TEST_F(DistortionCalibration, NoPicturesOrDifferentCamerasGiveNothing) {
  EXPECT_FALSE(calibrateDistortion({}, kNoise, kExact));
  see(1);
  const DepthPicture empty;
  EXPECT_FALSE(calibrateDistortion({{&empty, Eigen::Isometry3d::Identity()}}, kNoise, kExact));
  const DepthPicture line = DepthPicture::fromStored({2, 1, 1, 1, 0, 0}, {9000, 9000});
  const PosedPicture of_line{&line, Eigen::Isometry3d::Identity()};
  EXPECT_FALSE(calibrateDistortion({of_line, of_line}, kNoise, kExact));
  const DepthPicture other =
      DepthPicture::fromDepth(test::render(test::largeRoom(), test::tinyCamera(), pictures_[0].T_w_c).image);
  pictures_.push_back({&other, pictures_[0].T_w_c});
  EXPECT_FALSE(calibrateDistortion(pictures_, kNoise, kExact));
}

constexpr double kPixelTranslation = 5e-4;  // error by independent pixels [m]

/** Views of a camera with these errors, as a realignment finds them. */
std::vector<RealignedView> viewsWith(const ConsideredErrors& errors, int n) {
  std::mt19937 random(7);
  std::vector<RealignedView> views(n);
  for (RealignedView& view : views) {
    const Vector6d std = diagonal(2e-4, kPixelTranslation);
    Matrix6d factor = std.asDiagonal();
    factor.col(0) += std.cwiseProduct(0.5 * normal(random));
    const Matrix6d of_pixels = factor * factor.transpose();
    view.information = of_pixels.inverse();
    view.error =
        std::sqrt(errors.pixels_as_one) * factor * normal(random) +
        std::sqrt(2) * diagonal(errors.rotation_std, errors.translation_std).cwiseProduct(normal(random));
  }
  return views;
}

// Student's distribution takes a normal one for a little wider than it is, never for narrower.
TEST(ConsideredErrors, AreFoundFromTheErrorsOfViews) {
  for (const ConsideredErrors truth :
       {ConsideredErrors{4, 0.5 * kDegree, 0.02}, ConsideredErrors{400, 0.3 * kDegree, 0.02}}) {
    const ConsideredErrors found = consideredErrors(viewsWith(truth, 200));
    EXPECT_EQ(found.views, 200);
    EXPECT_NEAR(found.rotation_std / truth.rotation_std, 1.2, 0.25);
    EXPECT_NEAR(found.translation_std / truth.translation_std, 1.2, 0.25);
  }
  const ConsideredErrors by_pixels = consideredErrors(viewsWith({400, 1e-6, 1e-6}, 200));
  EXPECT_NEAR(std::sqrt(by_pixels.pixels_as_one / 400), 1.2, 0.25);
  EXPECT_LT(by_pixels.rotation_std, 0.03 * kDegree);
  EXPECT_LT(by_pixels.translation_std, 0.3 * std::sqrt(400) * kPixelTranslation);
}

TEST(ConsideredErrors, OfFewViewsAreDrawnTowardsTheUsual) {
  EXPECT_EQ(consideredErrors({}).pixels_as_one, ConsideredErrors().pixels_as_one);
  const ConsideredErrors truth{1, 0.01 * kDegree, 1e-4};
  const double many = consideredErrors(viewsWith(truth, 100)).translation_std;
  const double few = consideredErrors(viewsWith(truth, 3)).translation_std;
  EXPECT_LT(many, few);
  EXPECT_LT(few, ConsideredErrors().translation_std);
}

/** Local models of a room, whose poses err by these standard deviations. */
std::shared_ptr<const Map> roomWithPoseErrors(double rotation, double translation) {
  std::mt19937 random(3);
  auto map = std::make_shared<Map>();
  for (int i = 0; i < 24; ++i) {
    const Eigen::Isometry3d T_w_c = test::onCircle(15 * i, 1);
    const Eigen::Isometry3d erring =
        boxplus(T_w_c, diagonal(rotation, translation).cwiseProduct(normal(random)));
    map->models.emplace_back("view" + std::to_string(i), i, erring,
                             test::viewFrom(test::largeRoom(), T_w_c, static_cast<unsigned>(i)));
  }
  return map;
}

TEST(ConsideredErrors, OfAMapAreThoseOfItsPoses) {
  const ConsideredErrors exact = consideredErrors(realignedViews(roomWithPoseErrors(0, 0), 2));
  EXPECT_EQ(exact.views, 24);
  EXPECT_LT(exact.rotation_std, 0.1 * kDegree);
  EXPECT_LT(exact.translation_std, 0.004);
  const ConsideredErrors erring =
      consideredErrors(realignedViews(roomWithPoseErrors(0.5 * kDegree, 0.02), 2));
  EXPECT_NEAR(erring.rotation_std, 0.5 * kDegree, 0.25 * kDegree);
  EXPECT_NEAR(erring.translation_std, 0.02, 0.01);
}

TEST(ConsideredErrors, AreTheSameForAnyNumberOfThreads) {
  const auto map = roomWithPoseErrors(0.2 * kDegree, 0.01);
  EXPECT_EQ(toText(consideredErrors(realignedViews(map, 1))),
            toText(consideredErrors(realignedViews(map, 3))));
}

}  // namespace
}  // namespace facetloc::internal
