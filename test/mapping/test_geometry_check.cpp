// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/mapping/map_findings.h>
#include <facetloc/mapping/map_making.h>
#include <facetloc/testing/synthetic_views.h>

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

namespace facetloc {
namespace {

using testing::HasSubstr, testing::IsEmpty;

constexpr int kImages = 16;

/** Images all around a room, with a Kinect's noise. */
std::vector<DepthImage> imagesOfARoom() {
  std::vector<DepthImage> images;
  for (int i = 0; i < kImages; ++i) {
    const double a = 2 * EIGEN_PI * i / kImages;
    const Eigen::Vector3d out(std::cos(a), std::sin(a), 0);
    const Eigen::Isometry3d T_w_c =
        test::lookingAlong(Eigen::Vector3d(3, 2.5, 1.3) - out, out - Eigen::Vector3d(0, 0, 0.3));
    images.push_back(test::noisy(test::render(test::largeRoom(), test::smallCamera(), T_w_c).image,
                                 SensorNoise{}.inverse_depth_std, static_cast<unsigned>(i)));
  }
  return images;
}

/** The same, with each depth changed by its place in the image. */
std::vector<DepthImage> changed(const std::function<double(double z, const Eigen::Vector3d& ray)>& change) {
  std::vector<DepthImage> images = imagesOfARoom();
  for (DepthImage& image : images) image = test::changedDepth(std::move(image), change);
  return images;
}

std::vector<DepthImage> withIntrinsics(const std::function<void(Intrinsics&)>& change) {
  std::vector<DepthImage> images = imagesOfARoom();
  for (DepthImage& image : images) change(image.camera);
  return images;
}

std::string findingOf(const std::vector<DepthImage>& images) {
  Camera camera;
  camera.intrinsics = images.front().camera;
  const GeometryCheck check = checkGeometry(images, camera);
  return check.findings.empty() ? std::string() : check.findings.front().text();
}

TEST(GeometryCheck, FindsNoFaultInCorrectImages) {
  const GeometryCheck check = checkGeometry(imagesOfARoom(), {});
  EXPECT_THAT(check.findings, IsEmpty());
  EXPECT_EQ(firstOf(check.findings, Severity::refusal), nullptr);
  EXPECT_EQ(check.images, std::size_t(kImages));
  EXPECT_GE(check.surfaces, 30u);
  EXPECT_NEAR(check.bend.ray_exponent, 0, 0.05);
  EXPECT_NEAR(check.bend.lens, 0, 0.02);
  EXPECT_THAT(checkGeometry({}, {}).findings, IsEmpty());
}

TEST(GeometryCheck, NamesDistancesAlongTheRays) {
  const auto distances = changed([](double z, const Eigen::Vector3d& ray) { return z * ray.norm(); });
  EXPECT_THAT(findingOf(distances), HasSubstr("depth_is = distance"));
  const GeometryCheck check = checkGeometry(distances, {});
  ASSERT_NE(firstOf(check.findings, Severity::refusal), nullptr);
  EXPECT_NEAR(check.bend.ray_exponent, 1, 0.15);
  const auto taken_for_such = changed([](double z, const Eigen::Vector3d& ray) { return z / ray.norm(); });
  EXPECT_THAT(findingOf(taken_for_such), HasSubstr("depth_is = z"));
}

TEST(GeometryCheck, NamesDisparities) {
  EXPECT_THAT(findingOf(changed([](double z, const Eigen::Vector3d&) { return 4 / z; })),
              HasSubstr("disparities"));
}

TEST(GeometryCheck, NamesALens) {
  constexpr double k1 = -0.2;
  std::vector<DepthImage> images = imagesOfARoom();
  for (DepthImage& image : images) {
    const DepthImage ideal = image;
    const Intrinsics& k = image.camera;
    for (int v = 0; v < k.height; ++v)
      for (int u = 0; u < k.width; ++u) {
        const Eigen::Vector2d distorted = k.ray(u, v).head<2>();
        Eigen::Vector2d ray = distorted;
        for (int i = 0; i < 20; ++i) ray = distorted / (1 + k1 * ray.squaredNorm());
        const int x = static_cast<int>(std::lround(k.fx * ray.x() + k.cx));
        const int y = static_cast<int>(std::lround(k.fy * ray.y() + k.cy));
        const bool inside = x >= 0 && y >= 0 && x < k.width && y < k.height;
        image.depth[static_cast<std::size_t>(v) * k.width + u] = inside ? ideal.at(x, y) : 0;
      }
  }
  const GeometryCheck check = checkGeometry(images, {});
  ASSERT_FALSE(check.findings.empty());
  EXPECT_THAT(check.findings.front().words, HasSubstr("as behind a lens"));
  EXPECT_EQ(firstOf(check.findings, Severity::refusal), nullptr)
      << "a map of such images is inaccurate, and no nonsense";
  EXPECT_NEAR(check.bend.lens, k1, 0.07);
}

TEST(GeometryCheck, DoubtsIntrinsicsByTheAnglesBetweenSurfaces) {
  for (const double factor : {0.7, 1.4}) {
    const auto images = withIntrinsics([factor](Intrinsics& k) { k.fx *= factor, k.fy *= factor; });
    EXPECT_THAT(findingOf(images), HasSubstr("angles between the same surfaces")) << factor;
    const GeometryCheck check = checkGeometry(images, {});
    ASSERT_TRUE(check.angles);
    EXPECT_NEAR(check.angles->fx * factor, 1, 0.05);
    EXPECT_EQ(firstOf(check.findings, Severity::refusal), nullptr) << "one witness alone";
  }
}

TEST(GeometryCheck, FewImagesAndOneViewSayNothingAboutAngles) {
  std::vector<DepthImage> images = withIntrinsics([](Intrinsics& k) { k.fx *= 1.4, k.fy *= 1.4; });
  images.resize(4);
  EXPECT_FALSE(checkGeometry(images, {}).angles);
}

/** The findings on images with 1.4 times the focal length, and on poses that turn by other angles. */
Findings withTurns(double ratio, double std) {
  MapFindings findings;
  findings.geometry = checkGeometry(withIntrinsics([](Intrinsics& k) { k.fx *= 1.4, k.fy *= 1.4; }), {});
  findings.poses.emplace();
  findings.poses->as_given.motions = 20;
  findings.poses->turns = {ratio, ratio, ratio, std, 0, 1, 20};
  return findings.list();
}

TEST(GeometryCheck, AsksTheTurnsOfThePosesAboutFocalLengths) {
  EXPECT_NE(firstOf(withTurns(1 / 1.4, 0.01), Severity::refusal), nullptr) << "both ask for it";
  EXPECT_EQ(firstOf(withTurns(1, 0.01), Severity::doubt), nullptr)
      << "the turns agree with the images as they are read";
  EXPECT_NE(firstOf(withTurns(1, 0.02), Severity::doubt), nullptr) << "which may be 8 % off";
  const Findings unknown = withTurns(0.8, 0.2);
  ASSERT_FALSE(unknown.empty());
  EXPECT_EQ(unknown.front().id, "geometry.angles");
  EXPECT_EQ(unknown.front().severity, Severity::doubt) << "turns that are not known well";
}

TEST(GeometryCheck, DoubtsPixelsThatAreNotSquare) {
  const GeometryCheck check = checkGeometry(withIntrinsics([](Intrinsics& k) { k.fx *= 1.15; }), {});
  ASSERT_FALSE(check.findings.empty());
  EXPECT_THAT(check.findings.back().words, HasSubstr("factor of 1.1"));
}

TEST(GeometryCheck, NothingIsMadeOfImagesThatCannotBeRight) {
  const auto makingOf = [](bool any_reading) {
    MapMakingParams params;
    params.any_reading = any_reading;
    MapMaking making({}, params);
    const auto images = changed([](double z, const Eigen::Vector3d& ray) { return z * ray.norm(); });
    for (int i = 0; i < kImages; ++i)
      making.add(
          {std::to_string(i), 0.1 * i, [image = images[static_cast<std::size_t>(i)]] { return image; }});
    return making;
  };
  MapMaking refused = makingOf(false);
  EXPECT_THAT(refused.finish().models, IsEmpty());
  EXPECT_THAT(refused.findings().problem, HasSubstr("along the rays"));
  MapMaking forced = makingOf(true);
  EXPECT_FALSE(forced.finish().models.empty());
}

}  // namespace
}  // namespace facetloc
