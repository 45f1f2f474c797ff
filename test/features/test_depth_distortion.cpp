// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/depth_distortion.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace facetloc {
namespace {

using test::smallCamera;

/** A field that is linear along each axis, so that straight lines between the nodes are exact. */
double bilinear(const Eigen::Vector2d& ray) {
  return 1e-3 * (1 + ray.x() - 2 * ray.y() + 3 * ray.x() * ray.y());
}

DepthDistortion example(const Intrinsics& camera) {
  const DepthDistortion grid(DepthDistortion::extentOf(camera));
  DepthDistortion::Values values;
  for (int i = 0; i < DepthDistortion::kNodes; ++i) values[i] = bilinear(grid.rayOf(i));
  return DepthDistortion(grid.extent(), values);
}

/** A plane as a camera with that distortion measures it. */
DepthImage distorted(const DepthDistortion& distortion, const DepthImage& image) {
  return test::changedDepth(
      image, [&](float z, const Eigen::Vector3d& ray) { return 1 / (1 / z + distortion.at(ray.head<2>())); });
}

DepthImage wall(const Intrinsics& camera) {
  return test::render({test::endlessPlane({0, 0, 2.5}, {0.3, -0.4, 1})}, camera).image;
}

TEST(DepthDistortion, IsStraightBetweenItsNodes) {
  const DepthDistortion d = example(smallCamera());
  for (double x = -0.5; x <= 0.5; x += 0.07)
    for (double y = -0.4; y <= 0.4; y += 0.07) EXPECT_NEAR(d.at({x, y}), bilinear({x, y}), 1e-12);
}

TEST(DepthDistortion, OutsideIsLikeTheBorder) {
  const DepthDistortion d = example(smallCamera());
  EXPECT_EQ(d.at(d.extent().max() + Eigen::Vector2d(1, 1)), d.values().back());
  EXPECT_EQ(d.at(d.extent().min() - Eigen::Vector2d(1, 1)), d.values().front());
}

TEST(DepthDistortion, NodesSpanTheImage) {
  const Intrinsics camera = smallCamera();
  const DepthDistortion d(DepthDistortion::extentOf(camera));
  EXPECT_EQ(d.rayOf(0), camera.ray(0, 0).head<2>());
  EXPECT_EQ(d.rayOf(DepthDistortion::kNodes - 1), camera.ray(camera.width - 1, camera.height - 1).head<2>());
  EXPECT_EQ(d.rms(), 0);
}

TEST(DepthDistortion, NonsenseIsRefused) {
  const Eigen::AlignedBox2d extent = DepthDistortion::extentOf(smallCamera());
  DepthDistortion::Values values{};
  values[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(DepthDistortion(extent, values), std::invalid_argument);
  EXPECT_THROW(DepthDistortion{Eigen::AlignedBox2d()}, std::invalid_argument);
}

TEST(DepthDistortion, FitsTheCameraAtAnyResolution) {
  const DepthDistortion d(DepthDistortion::extentOf(smallCamera()));
  for (const int step : {1, 2, 4}) EXPECT_TRUE(d.fits(smallCamera().subsampled(step))) << step;
  Intrinsics other = smallCamera();
  other.fx *= 1.1;
  EXPECT_FALSE(d.fits(other));
  EXPECT_FALSE(d.fits({}));
}

TEST(DepthCorrection, GivesBackTheUndistortedImage) {
  const DepthDistortion d = example(smallCamera());
  DepthCorrection correct(d);
  for (const int step : {1, 2, 1}) {
    const DepthImage truth = wall(smallCamera().subsampled(step)), found = correct(distorted(d, truth));
    ASSERT_EQ(found.camera, truth.camera);
    for (std::size_t i = 0; i < truth.depth.size(); ++i)
      EXPECT_NEAR(found.depth[i], truth.depth[i], 2e-5) << i;
  }
}

TEST(DepthCorrection, UnknownStaysUnknown) {
  DepthDistortion::Values values;
  values.fill(0.01);
  DepthCorrection correct(DepthDistortion(DepthDistortion::extentOf(smallCamera()), values));
  DepthImage image{smallCamera(), std::vector<float>(320 * 240, 2.f)};
  image.depth[0] = 0;
  image.depth[1] = std::numeric_limits<float>::quiet_NaN();
  image.depth[2] = std::numeric_limits<float>::infinity();
  image.depth[3] = 100;  // all of its inverse depth is distortion
  image.depth[4] = 150;
  const DepthImage& found = correct(image);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(found.depth[i], 0) << i;
  EXPECT_NEAR(found.depth[5], 1 / 0.49, 1e-5);
}

TEST(DepthCorrection, ImagesOfOtherCamerasAreLeftAlone) {
  DepthCorrection correct(example(smallCamera()));
  Intrinsics other = smallCamera();
  other.cx += 20;
  for (const DepthImage& image : {wall(other), DepthImage(), DepthImage{smallCamera(), {1, 2, 3}}})
    EXPECT_EQ(&correct(image), &image);
}

}  // namespace
}  // namespace facetloc
