// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/params.h>
#include <facetloc/segmentation/plane_segmenter.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_depth.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace facetloc {
namespace {

using test::box, test::endlessPlane, test::lookingAlong, test::noisy, test::render, test::Rendering,
    test::Rng, test::rounded, test::Scene, test::smallCamera, test::uniform;

constexpr double kDisparityUnit = 1 / kKinectGain;

// Whatever way an image is split, the same holds.
class EverySplit : public testing::TestWithParam<SplitMethod> {
protected:
  EverySplit() { params.split.method = GetParam(); }
  LabelledPlanes segmented(const DepthImage& image) const { return segmented(image, params); }
  static LabelledPlanes segmented(const DepthImage& image, const SegmentationParams& params) {
    LabelledPlanes out;
    PlaneSegmenter(params).segment(image, out);
    return out;
  }

  SegmentationParams params;
};
INSTANTIATE_TEST_SUITE_P(PlaneSegmenter, EverySplit,
                         testing::Values(SplitMethod::quadtree, SplitMethod::delaunay),
                         [](const auto& method) { return numberText(method.param); });

// Two walls and the floor, seen into the corner of a room.
Rendering corner() {
  return render(box({0, 0, 0}, {4, 4, 3}), smallCamera(), lookingAlong({1.8, 1.6, 1.3}, {1, 1.1, -0.65}));
}

// Share of the pixels on which two labellings agree, each label of a renamed to the one of b that it meets
// most.
double agreement(const LabelImage& a, const LabelImage& b) {
  std::vector<std::vector<int>> meets(a.maxLabel() + 1, std::vector<int>(b.maxLabel() + 1, 0));
  for (std::size_t i = 0; i < a.label.size(); ++i) ++meets[a.label[i]][b.label[i]];
  int same = 0;
  for (const auto& row : meets) same += *std::max_element(row.begin(), row.end());
  return same / static_cast<double>(a.label.size());
}

void expectConsistent(const LabelledPlanes& s, const DepthImage& image,
                      const SegmentationParams& params = {}) {
  ASSERT_EQ(s.labels.label.size(), image.depth.size());
  ASSERT_EQ(s.planes.size(), s.support.size());
  std::vector<int> count(s.planes.size() + 1, 0);
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    const int k = s.labels.label[i];
    ASSERT_LE(k, static_cast<int>(s.planes.size()));
    ++count[k];
    if (k == 0) continue;
    ASSERT_GT(image.depth[i], 0);
    const int u = static_cast<int>(i) % image.camera.width, v = static_cast<int>(i) / image.camera.width;
    EXPECT_LE(std::abs(1 / image.depth[i] - s.planes[k - 1].at(u, v)),
              params.labels.tolerance * s.noise * 1.001);
  }
  const double min_support =
      params.labels.min_support * static_cast<double>(image.depth.size()) / (320 * 240);
  for (std::size_t k = 0; k < s.planes.size(); ++k) {
    EXPECT_EQ(s.support[k], count[k + 1]);
    EXPECT_GE(s.support[k], min_support);
    if (k > 0) {
      EXPECT_LE(s.support[k], s.support[k - 1]);
    }
  }
}

TEST_P(EverySplit, AnExactCornerOfARoomIsThreePlanes) {
  const Rendering r = corner();
  const LabelledPlanes s = segmented(r.image);
  EXPECT_EQ(s.planes.size(), 3u);
  EXPECT_GT(agreement(s.labels, r.labels), 0.995);
  expectConsistent(s, r.image);
}

TEST_P(EverySplit, ANoisyRoundedCornerIsStillThreePlanes) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Rendering r = corner();
    const DepthImage image = rounded(noisy(r.image, 0.5 * kDisparityUnit, seed));
    const LabelledPlanes s = segmented(image);
    EXPECT_EQ(s.planes.size(), 3u) << seed;
    EXPECT_GT(agreement(s.labels, r.labels), 0.97) << seed;
    expectConsistent(s, image);
  }
}

TEST_P(EverySplit, PlanesAreThoseOfTheRoom) {
  const Scene room = box({0, 0, 0}, {4, 4, 3});
  const Eigen::Isometry3d T = lookingAlong({1.8, 1.6, 1.3}, {1, 1.1, -0.65});
  const Rendering r = render(room, smallCamera(), T);
  const LabelledPlanes s = segmented(r.image);
  for (std::size_t k = 0; k < s.planes.size(); ++k) {
    const auto first =
        std::find(s.labels.label.begin(), s.labels.label.end(), k + 1) - s.labels.label.begin();
    const test::Face& face = room.at(r.labels.label[first] - 1);
    Eigen::Vector3d n = T.linear().transpose() * face.x.cross(face.y);
    const double rho = n.dot(T.inverse() * face.centre);
    EXPECT_THAT(s.planes[k].toSpace(r.image.camera), test::MatrixNear(n / rho, 1e-4));
  }
}

// A wall with a step of this number of disparity units along a vertical line.
DepthImage steppedWall(double step, int at) {
  DepthImage image;
  image.camera = smallCamera();
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u)
      image.depth.push_back(static_cast<float>(kinectDepth(900 + (u < at ? 0 : step))));
  return image;
}

TEST_P(EverySplit, AStepOfSixDisparityUnitsSplitsAndOneOfOneDoesNot) {
  for (const auto& [step, planes] : {std::pair{6.0, 2u}, {1.0, 1u}})
    for (const int at : {60, 160, 280}) {
      const DepthImage wall = steppedWall(step, at);
      EXPECT_EQ(segmented(wall).planes.size(), planes) << at;
      for (unsigned seed = 0; seed < 3; ++seed)
        EXPECT_EQ(segmented(rounded(noisy(wall, 0.5 * kDisparityUnit, seed))).planes.size(), planes) << at;
    }
}

// Number of wrong labels among the pixels that are farther than this distance [px] from any other true face.
int errorsInside(const LabelImage& labels, const LabelImage& truth, int distance) {
  std::vector<std::vector<int>> meets(labels.maxLabel() + 1, std::vector<int>(truth.maxLabel() + 1, 0));
  for (std::size_t i = 0; i < labels.label.size(); ++i) ++meets[labels.label[i]][truth.label[i]];
  std::vector<int> face_of(meets.size(), -1);  // the face that a label meets most; no label is no face
  for (std::size_t k = 1; k < meets.size(); ++k)
    face_of[k] = static_cast<int>(std::max_element(meets[k].begin(), meets[k].end()) - meets[k].begin());
  const int w = truth.width, h = truth.height;
  int errors = 0;
  for (int v = 0; v < h; ++v)
    for (int u = 0; u < w; ++u) {
      const int face = truth.label[static_cast<std::size_t>(v) * w + u];
      if (face_of[labels.label[static_cast<std::size_t>(v) * w + u]] == face) continue;
      bool inside = true;
      for (int y = std::max(0, v - distance); y <= std::min(h - 1, v + distance); ++y)
        for (int x = std::max(0, u - distance); x <= std::min(w - 1, u + distance); ++x)
          inside = inside && truth.label[static_cast<std::size_t>(y) * w + x] == face;
      errors += inside;
    }
  return errors;
}

TEST_P(EverySplit, TheSilhouetteOfABoxIsRightWithinTwoPixels) {
  const Scene scene =
      test::operator+({endlessPlane({0, 0, 3}, {0.1, 0, 1})}, box({-0.4, -0.3, 1.5}, {0.5, 0.5, 2}));
  const Rendering r = render(scene, smallCamera());  // only the front of the box is seen
  EXPECT_EQ(errorsInside(segmented(r.image).labels, r.labels, 2), 0);
  for (unsigned seed = 0; seed < 5; ++seed)
    EXPECT_EQ(errorsInside(segmented(noisy(r.image, 0.5 * kDisparityUnit, seed)).labels, r.labels, 2), 0)
        << seed;
}

TEST_P(EverySplit, AnOffsetOfAllDisparitiesChangesNoLabel) {
  // A corner and boxes far from the limits of the plane-distance criterion, moved by 40 DU.
  const DepthImage image = noisy(corner().image, 0.5 * kDisparityUnit, 3);
  DepthImage shifted = image;
  for (float& z : shifted.depth) z = static_cast<float>(1 / (1 / double(z) + 40 * kDisparityUnit));
  const LabelledPlanes a = segmented(image), b = segmented(shifted);
  EXPECT_EQ(a.planes.size(), b.planes.size());
  EXPECT_GT(agreement(a.labels, b.labels), 0.9999);  // depth is stored in single precision
}

TEST_P(EverySplit, TolerancesFollowTheNoiseOfTheImage) {
  const Rendering r = corner();
  EXPECT_NEAR(segmented(r.image).noise, 0.5 * kDisparityUnit, 1e-12);  // never below the configured noise
  const DepthImage image = noisy(r.image, 2 * kDisparityUnit, 4);
  const LabelledPlanes s = segmented(image);
  EXPECT_NEAR(s.noise, 2 * kDisparityUnit, 0.2 * kDisparityUnit);
  EXPECT_EQ(s.planes.size(), 3u);
  SegmentationParams fixed = params;
  fixed.labels.estimate_noise = false;
  EXPECT_NEAR(segmented(image, fixed).noise, 0.5 * kDisparityUnit, 1e-12);
}

TEST_P(EverySplit, WithoutAnyNoiseAPlaneIsFound) {
  DepthImage image;
  image.camera = smallCamera();
  image.depth.assign(320 * 240, 2.f);
  SensorNoise noise;
  noise.inverse_depth_std = 0;
  for (const bool estimate_noise : {false, true}) {  // which is 0 as well
    params.labels.estimate_noise = estimate_noise;
    LabelledPlanes s;
    PlaneSegmenter(params, noise).segment(image, s);
    EXPECT_GT(s.noise, 0);
    ASSERT_EQ(s.planes.size(), 1u);
    EXPECT_EQ(s.support[0], 320 * 240);
    EXPECT_THAT(s.planes[0].toSpace(image.camera), test::MatrixNear(Eigen::Vector3d(0, 0, 0.5), 1e-6));
  }
}

TEST_P(EverySplit, ThresholdsScaleWithTheSensorNotWithTheKinect) {
  // The same image in a unit a hundred times finer, of a sensor a hundred times better: metres become
  // hectometres.
  const DepthImage image = noisy(corner().image, 0.5 * kDisparityUnit, 5);
  DepthImage far = image;
  for (float& z : far.depth) z *= 64;
  SensorNoise better;
  better.inverse_depth_std /= 64;
  LabelledPlanes a = segmented(image), b;
  params.merge.min_plane_distance *= 64;
  PlaneSegmenter(params, better).segment(far, b);
  EXPECT_GT(agreement(a.labels, b.labels), 0.9999);
}

TEST_P(EverySplit, AConstantPatchWithNothingAroundItIsFound) {
  for (const int side : {40, 60, 80, 100, 120})
    for (const auto& [left, top] : {std::pair{10, 15}, {101, 59}, {200, 120}}) {
      DepthImage image;
      image.camera = smallCamera();
      image.depth.assign(320 * 240, std::numeric_limits<float>::quiet_NaN());
      for (int v = top; v < top + side; ++v) std::fill_n(image.depth.begin() + 320 * v + left, side, 2.f);
      const LabelledPlanes s = segmented(image);
      ASSERT_FALSE(s.planes.empty()) << side;
      EXPECT_GT(s.support[0], 0.9 * side * side) << side << " at " << left << ", " << top;
      expectConsistent(s, image);
    }
}

TEST_P(EverySplit, LabelsAndSupportsAgreeOnFurnishedRooms) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Rendering r = render(test::furnishedRoom(), smallCamera(),
                               lookingAlong({1, 0.5, 1.2}, {0.4 + 0.2 * seed, 1, -0.2}));
    DepthImage image = rounded(noisy(r.image, 0.5 * kDisparityUnit, seed));
    Rng rng(seed);
    for (float& z : image.depth)
      if (uniform(rng, 0, 1) < 0.05) z = std::numeric_limits<float>::quiet_NaN();
    const LabelledPlanes s = segmented(image);
    EXPECT_GE(s.planes.size(), 4u);
    expectConsistent(s, image);
  }
}

TEST_P(EverySplit, NothingGivesNothing) {
  PlaneSegmenter segmenter(params);
  LabelledPlanes out;
  const auto expectNone = [&](const DepthImage& image) {
    segmenter.segment(corner().image, out);  // leave an answer that could go stale
    ASSERT_FALSE(out.planes.empty());
    segmenter.segment(image, out);
    EXPECT_TRUE(out.planes.empty());
    EXPECT_TRUE(out.support.empty());
    EXPECT_EQ(out.labels.label, std::vector<std::uint16_t>(image.depth.size(), 0));
  };
  expectNone({});
  for (const float z :
       {0.f, -1.f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    DepthImage image = corner().image;
    std::fill(image.depth.begin(), image.depth.end(), z);
    expectNone(image);
    image.depth[12345] = 2;  // a single pixel is no plane either
    expectNone(image);
  }
  for (const int size : {1, 2}) {
    DepthImage image;
    image.camera = {size, size, 100, 100, 0, 0};
    image.depth.assign(static_cast<std::size_t>(size) * size, 2.f);
    if (size == 1) expectNone(image);
    segmenter.segment(image, out);  // two by two pixels may be a plane; they must be no crash
  }
}

TEST_P(EverySplit, RandomDepthIsSlowWorkButEnds) {
  DepthImage image;
  image.camera = smallCamera();
  Rng rng(6);
  for (int i = 0; i < 320 * 240; ++i)
    image.depth.push_back(uniform(rng, 0, 1) < 0.8 ? static_cast<float>(uniform(rng, 0.5, 5)) : 0.f);
  SegmentationParams fixed = params;
  fixed.labels.estimate_noise = false;  // otherwise the noise explains the image
  expectConsistent(segmented(image, fixed), image, fixed);
  expectConsistent(segmented(image), image);
}

TEST_P(EverySplit, ReusedBuffersDoNotShow) {
  PlaneSegmenter segmenter(params);
  LabelledPlanes first, again;
  const DepthImage image = noisy(corner().image, 0.5 * kDisparityUnit, 7);
  segmenter.segment(image, first);
  segmenter.segment(noisy(image, kDisparityUnit, 8), again);
  segmenter.segment(image, again);
  EXPECT_EQ(again.labels.label, first.labels.label);
  EXPECT_EQ(again.support, first.support);
}

}  // namespace
}  // namespace facetloc
