// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/organized_cloud.h>
#include <facetloc/testing/organized_clouds.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace facetloc {
namespace {

using test::organizedCloud, test::render, test::Rng, test::uniform;

DepthImage roomImage(const Intrinsics& camera) {
  return render(test::furnishedRoom(), camera, test::lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2})).image;
}

void expectNear(const std::optional<Intrinsics>& got, const Intrinsics& want, double relative) {
  ASSERT_TRUE(got);
  EXPECT_EQ(got->width, want.width);
  EXPECT_EQ(got->height, want.height);
  EXPECT_NEAR(got->fx, want.fx, relative * want.fx);
  EXPECT_NEAR(got->fy, want.fy, relative * want.fy);
  EXPECT_NEAR(got->cx, want.cx, relative * want.fx);
  EXPECT_NEAR(got->cy, want.cy, relative * want.fy);
}

template <typename PointT>
class OrganizedCloud : public testing::Test {};
using PointTypes = testing::Types<pcl::PointXYZ, pcl::PointXYZI, pcl::PointXYZRGB, pcl::PointXYZRGBA>;
TYPED_TEST_SUITE(OrganizedCloud, PointTypes, );  // the comma for -Wpedantic of Clang

TYPED_TEST(OrganizedCloud, IntrinsicsAreRecoveredFromThePoints) {
  const Intrinsics camera{320, 240, 262.5, 301.25, 140.5, 131.75};  // fx, fy and the centre all differ
  expectNear(recoverIntrinsics(*organizedCloud<TypeParam>(roomImage(camera))), camera, 1e-7);
}

TYPED_TEST(OrganizedCloud, DepthIsZWhereThereIsAny) {
  const DepthImage image = roomImage(test::tinyCamera());
  auto cloud = organizedCloud<TypeParam>(image);
  (*cloud)[5].z = std::numeric_limits<float>::quiet_NaN();
  (*cloud)[6].z = std::numeric_limits<float>::infinity();
  (*cloud)[7].z = -1;
  const DepthImage again = depthImage(*cloud, image.camera);
  EXPECT_EQ(again.camera, image.camera);
  ASSERT_EQ(again.depth.size(), image.depth.size());
  for (std::size_t i = 0; i < image.depth.size(); ++i)
    EXPECT_EQ(again.depth[i], i >= 5 && i <= 7 ? 0.f : image.depth[i]);
}

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

TEST(RecoverIntrinsics, HolesDoNotMatter) {
  const Intrinsics camera{160, 120, 140, 150, 75, 64};
  DepthImage image = roomImage(camera);
  Rng rng(1);
  for (float& z : image.depth)
    if (uniform(rng, 0, 1) < 0.9) z = 0;
  expectNear(recoverIntrinsics(*organizedCloud<pcl::PointXYZ>(image)), camera, 1e-6);
}

TEST(RecoverIntrinsics, APointThatNoCameraMeasuresDoesNotMatter) {
  const Intrinsics camera{160, 120, 140, 150, 75, 64};
  Cloud cloud = *organizedCloud<pcl::PointXYZ>(roomImage(camera));
  cloud[1000] = {0.1f, -0.1f, 1e-9f};
  expectNear(recoverIntrinsics(cloud), camera, 1e-6);
}

// Its first column has no points; one pixel in a thousand would be just those.
TEST(RecoverIntrinsics, AllColumnsAreLookedAt) {
  const Intrinsics camera{1280, 1000, 1100, 1100, 640, 500};
  Cloud cloud(camera.width, camera.height);
  for (int v = 0, k = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u, ++k)
      cloud[k].getVector3fMap() = 2 * camera.ray(u, v).cast<float>() * (u > 0 ? 1.f : std::nanf(""));
  expectNear(recoverIntrinsics(cloud), camera, 1e-6);
  Rng rng(3);
  for (auto& p : cloud) p.x += static_cast<float>(uniform(rng, -0.1, 0.1));
  EXPECT_FALSE(recoverIntrinsics(cloud));  // organized, but by no camera
}

TEST(RecoverIntrinsics, CloudsThatAreNoImageHaveNone) {
  Cloud cloud = *organizedCloud<pcl::PointXYZ>(roomImage(test::tinyCamera()));
  cloud.width *= cloud.height, cloud.height = 1;
  EXPECT_FALSE(recoverIntrinsics(cloud));  // not organized
  EXPECT_FALSE(recoverIntrinsics(Cloud{}));
  Rng rng(2);
  Cloud random(160, 120);
  for (auto& p : random)
    p = pcl::PointXYZ(float(uniform(rng, -2, 2)), float(uniform(rng, -2, 2)), float(uniform(rng, 0.5, 4)));
  EXPECT_FALSE(recoverIntrinsics(random));  // organized, but by no camera
  random.points.pop_back();
  EXPECT_FALSE(recoverIntrinsics(random));  // width x height is not the size
}

TEST(RecoverIntrinsics, TooFewPointsHaveNone) {
  const Intrinsics camera = test::tinyCamera();
  DepthImage image = roomImage(camera);
  std::fill(image.depth.begin(), image.depth.end(), 0.f);
  EXPECT_FALSE(recoverIntrinsics(*organizedCloud<pcl::PointXYZ>(image)));
  for (int i = 0; i < 15; ++i) image.depth[static_cast<std::size_t>(i) * 7 * 161] = 2;
  EXPECT_FALSE(recoverIntrinsics(*organizedCloud<pcl::PointXYZ>(image)));
  std::fill(image.depth.begin(), image.depth.end(), 0.f);
  for (int u = 0; u < camera.width; ++u) image.depth[u] = 2;  // a single row
  EXPECT_FALSE(recoverIntrinsics(*organizedCloud<pcl::PointXYZ>(image)));
  std::fill(image.depth.begin(), image.depth.end(), 0.f);
  for (int v = 0; v < camera.height; ++v)
    image.depth[static_cast<std::size_t>(v) * camera.width] = 2;  // a column
  EXPECT_FALSE(recoverIntrinsics(*organizedCloud<pcl::PointXYZ>(image)));
}

TEST(RecoverIntrinsics, FailsForAMirroredImage) {
  Cloud cloud = *organizedCloud<pcl::PointXYZ>(roomImage(test::tinyCamera()));
  for (auto& p : cloud) p.x = -p.x;
  EXPECT_FALSE(recoverIntrinsics(cloud));
}

}  // namespace
}  // namespace facetloc
