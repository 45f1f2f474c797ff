// SPDX-License-Identifier: BSD-3-Clause
#include "object_score.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace facetloc::benchmarks {
namespace {

constexpr int kWidth = 100, kHeight = 40;  // images whose left half is the table, and right half an object

struct LabelledImage {
  DepthImage depth;
  Raster<std::uint16_t> truth;
  LabelImage found;

  LabelledImage() {
    depth.camera.width = found.width = truth.width = kWidth;
    depth.camera.height = found.height = truth.height = kHeight;
    depth.depth.assign(std::size_t(kWidth) * kHeight, 1);
    found.label.assign(depth.depth.size(), 0);
    truth.data.assign(depth.depth.size(), 3);
    fill(truth.data, kWidth / 2, kWidth, 20);
  }
  /** Columns from begin to end. */
  template <class Pixels, class Value>
  static void fill(Pixels& pixels, int begin, int end, Value value) {
    for (int v = 0; v < kHeight; ++v)
      for (int u = begin; u < end; ++u) pixels[std::size_t(v) * kWidth + u] = value;
  }
  ObjectScore score() const { return objectScore(found, truth, depth); }
};

TEST(ObjectScore, SegmentsAlongObjectsAreRight) {
  LabelledImage image;
  image.fill(image.found.label, 0, 50, 1);
  image.fill(image.found.label, 50, 90, 2);
  const ObjectScore score = image.score();
  EXPECT_EQ(score.segments, 2u);
  EXPECT_EQ(score.across, 0u);
  EXPECT_EQ(score.main_pixels, score.segment_pixels);
  EXPECT_EQ(score.object_pixels, 50u * kHeight);
  EXPECT_EQ(score.covered_pixels, 40u * kHeight);
}

TEST(ObjectScore, SegmentGoesAcrossFromATenthOnElsewhere) {
  LabelledImage image;
  image.fill(image.found.label, 0, 55, 1);  // 5 of 55 columns on the object
  EXPECT_EQ(image.score().across, 0u);
  image.fill(image.found.label, 0, 56, 1);  // 6 of 56
  const ObjectScore score = image.score();
  EXPECT_EQ(score.across, 1u);
  EXPECT_EQ(score.segment_pixels, 56u * kHeight);
  EXPECT_EQ(score.main_pixels, 50u * kHeight);
}

TEST(ObjectScore, FacesOfOneObjectAndPartsOfTheTableAreOneObject) {
  LabelledImage image;
  image.fill(image.truth.data, 0, 25, 9);
  image.fill(image.truth.data, 50, 75, 29);
  image.fill(image.found.label, 0, 50, 1);
  image.fill(image.found.label, 50, 100, 2);
  EXPECT_EQ(image.score().across, 0u);
  image.fill(image.truth.data, 50, 75, 30);
  EXPECT_EQ(image.score().across, 1u);
}

TEST(ObjectScore, PixelsWithoutLabelOrDepthDoNotCount) {
  LabelledImage image;
  image.fill(image.found.label, 0, 100, 1);
  image.fill(image.depth.depth, 50, 75, 0.f);
  image.fill(image.truth.data, 75, 100, 0);
  ObjectScore score = image.score();
  EXPECT_EQ(score.across, 0u);
  EXPECT_EQ(score.segment_pixels, 50u * kHeight);
  EXPECT_EQ(score.object_pixels, 0u);
  image.fill(image.truth.data, 2, 50, 0);  // 80 px are left
  EXPECT_EQ(image.score().segments, 0u);
}

TEST(ObjectScore, AddsUpOverImages) {
  LabelledImage image;
  image.fill(image.found.label, 0, 100, 1);
  ObjectScore sum;
  sum += image.score();
  sum += image.score();
  EXPECT_EQ(sum.images, 2u);
  EXPECT_EQ(sum.segments, 2u);
  EXPECT_EQ(sum.across, 2u);
  EXPECT_EQ(sum.object_pixels, 100u * kHeight);
}

TEST(ObjectScore, RefusesLabelsOfAnotherSize) {
  LabelledImage image;
  image.truth.data.pop_back();
  EXPECT_THROW(image.score(), std::invalid_argument);
}

}  // namespace
}  // namespace facetloc::benchmarks
