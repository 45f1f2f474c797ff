// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace facetloc {
namespace {

using test::lookingAlong, test::noisy, test::render, test::smallCamera;

DepthImage roomImage(unsigned seed = 1) {
  return noisy(
      render(test::furnishedRoom(), smallCamera(), lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2})).image,
      0.5 / kKinectGain, seed);
}

// The upper left corner of the image.
DepthImage cropped(const DepthImage& image, int width, int height) {
  DepthImage out;
  out.camera = image.camera;
  out.camera.width = width, out.camera.height = height;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) out.depth.push_back(image.at(u, v));
  return out;
}

TEST(ViewBuilder, LabelKIsSegmentKOfTheView) {
  ViewBuilder builder;
  const DepthImage image = roomImage();
  const View view = builder.build(image);
  EXPECT_EQ(view.intrinsics, image.camera);
  ASSERT_GE(view.segments.size(), 4u);
  const LabelledPlanes& s = builder.segmentation();
  ASSERT_EQ(s.planes.size(), view.segments.size());
  ASSERT_EQ(s.support.size(), view.segments.size());
  EXPECT_EQ(s.labels.maxLabel(), static_cast<int>(view.segments.size()));
  for (std::size_t k = 0; k < view.segments.size(); ++k) {
    const Segment& segment = view.segments[k];
    EXPECT_LE(segment.num_points, s.support[k]);
    EXPECT_GT(segment.num_points, 0.9 * s.support[k]);
    const Eigen::Vector3d m = s.planes[k].toSpace(image.camera);
    EXPECT_GT(m.normalized().dot(segment.normal()), std::cos(2 * kDegree));
    // The mean point of its labelled pixels is its centroid.
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    int count = 0;
    for (int v = 0; v < 240; ++v)
      for (int u = 0; u < 320; ++u)
        if (s.labels.label[static_cast<std::size_t>(v) * 320 + u] == k + 1)
          mean += image.at(u, v) * image.camera.ray(u, v), ++count;
    EXPECT_EQ(count, s.support[k]);
    EXPECT_LT((mean / count - segment.t).norm(), 0.02);
  }
}

TEST(ViewBuilder, LabelsAndSupportsAgreeInImagesOfAnySize) {
  const DepthImage image = roomImage();
  for (const int width : {317, 318, 319}) {
    ViewBuilder builder;
    const View view = builder.build(cropped(image, width, 239));
    const LabelledPlanes& s = builder.segmentation();
    ASSERT_GE(view.segments.size(), 4u);
    for (std::size_t k = 0; k < view.segments.size(); ++k)
      EXPECT_EQ(std::count(s.labels.label.begin(), s.labels.label.end(), k + 1), s.support[k]) << width;
    EXPECT_GT(s.labels.label.back(), 0) << "the last pixel is on the floor";
  }
}

TEST(ViewBuilder, SegmentsComeInTheOrderOfInformation) {
  const View view = ViewBuilder().build(roomImage());
  const std::vector<int> order = rankByInformation(view.segments);
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], static_cast<int>(i));
}

TEST(ViewBuilder, DepthPictureIsThatOfTheImage) {
  const DepthImage image = roomImage();
  EXPECT_EQ(ViewBuilder().build(image).depth.inverse_depth, DepthPicture::fromDepth(image).inverse_depth);
}

TEST(ViewBuilder, ANoisierImageGivesLessCertainSegments) {
  const View good = ViewBuilder().build(roomImage());
  const View bad = ViewBuilder().build(noisy(roomImage(), 3 / kKinectGain, 2));
  ASSERT_FALSE(bad.segments.empty());
  EXPECT_GT(bad.segments[0].Sigma_q.trace(), good.segments[0].Sigma_q.trace());
}

TEST(ViewBuilder, AKnownDistortionIsTakenOut) {
  DepthDistortion::Values values;
  for (int i = 0; i < DepthDistortion::kNodes; ++i)
    values[i] = (i % DepthDistortion::kColumns - 4) / kKinectGain;
  const DepthImage truth = roomImage();
  const DepthDistortion distortion(DepthDistortion::extentOf(truth.camera), values);
  const DepthImage measured = test::changedDepth(
      truth, [&](float z, const Eigen::Vector3d& ray) { return 1 / (1 / z + distortion.at(ray.head<2>())); });
  Camera camera;
  camera.distortion = distortion;
  const View expected = ViewBuilder().build(truth), found = ViewBuilder(camera).build(measured),
             raw = ViewBuilder().build(measured);
  const Eigen::Vector3d place = expected.segments.at(0).t;
  EXPECT_LT((found.segments.at(0).t - place).norm(), 0.002);
  EXPECT_GT((raw.segments.at(0).t - place).norm(), 0.004);
  EXPECT_EQ(found.segments.size(), expected.segments.size());
}

TEST(ViewBuilder, AViewKnowsItsCameraAndTheNoiseItWasSeenWith) {
  Camera camera;
  camera.mounting = CameraMounting{0.7, 5};
  camera.noise.inverse_depth_std = 2 / kKinectGain;
  ViewBuilder builder(camera);
  const View quiet = builder.build(roomImage());
  ASSERT_TRUE(quiet.camera);
  EXPECT_EQ(quiet.camera->mounting->height, 0.7);
  EXPECT_DOUBLE_EQ(quiet.noise(), 2 / kKinectGain);  // the specification, where the image shows less
  const View noisier = builder.build(noisy(roomImage(), 6 / kKinectGain, 2));
  EXPECT_NEAR(noisier.noise(), 6 / kKinectGain, 1 / kKinectGain);
  EXPECT_EQ(noisier.camera, quiet.camera);  // shared by all views of the builder
}

TEST(ViewBuilder, ALargeImageIsThinnedToTheWorkingWidth) {
  const DepthImage image = roomImage();
  const int half = image.camera.width / 2;
  const View thinned = ViewBuilder({}, {}, half).build(image),
             expected = ViewBuilder().build(workingImage(image, half));
  EXPECT_EQ(thinned.intrinsics, expected.intrinsics);
  EXPECT_EQ(thinned.segments.size(), expected.segments.size());
  EXPECT_EQ(thinned.depth.inverse_depth, expected.depth.inverse_depth);
  EXPECT_EQ(ViewBuilder({}, {}, image.camera.width).build(image).intrinsics, image.camera);
}

TEST(ViewBuilder, AViewHasTheGravityOfItsImage) {
  const Gravity gravity{Eigen::Vector3d::UnitY(), kDegree};
  ViewBuilder builder;
  ASSERT_TRUE(builder.build(roomImage(), gravity).gravity);
  EXPECT_EQ(builder.build(roomImage(), gravity).gravity->down, gravity.down);
  EXPECT_FALSE(builder.build(roomImage()).gravity) << "gravity of the last image is not kept";
}

TEST(ViewBuilder, NothingGivesAViewWithoutSegments) {
  ViewBuilder builder;
  builder.build(roomImage());
  EXPECT_TRUE(builder.build({}).segments.empty());
  EXPECT_TRUE(builder.build({}).depth.empty());
  DepthImage image = roomImage();
  std::fill(image.depth.begin(), image.depth.end(), std::numeric_limits<float>::quiet_NaN());
  const View view = builder.build(image);
  EXPECT_TRUE(view.segments.empty());
  EXPECT_EQ(builder.segmentation().labels.maxLabel(), 0);
}

TEST(ViewBuilder, BuffersOfAnotherImageDoNotShowInAnyNumber) {
  const DepthImage image = roomImage();
  ViewBuilder reused;
  View view;
  for (const DepthImage& next : {roomImage(9), cropped(image, 317, 239), cropped(image, 1, 50),
                                 cropped(image, 50, 1), DepthImage{}, image}) {
    ViewBuilder fresh;
    const View want = fresh.build(next);
    reused.build(next, view);
    EXPECT_EQ(reused.segmentation().labels.label, fresh.segmentation().labels.label);
    EXPECT_EQ(reused.segmentation().support, fresh.segmentation().support);
    EXPECT_EQ(view.depth.inverse_depth, want.depth.inverse_depth);
    ASSERT_EQ(view.segments.size(), want.segments.size());
    for (std::size_t i = 0; i < want.segments.size(); ++i)
      EXPECT_TRUE(test::sameNumbers(view.segments[i], want.segments[i])) << i;
  }
  EXPECT_GE(view.segments.size(), 4u);
}

}  // namespace
}  // namespace facetloc
