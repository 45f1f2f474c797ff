// SPDX-License-Identifier: BSD-3-Clause
//
// The whole pipeline on real depth images, where they are there.
#include "ranking/global_localization.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/overlap_score.h>
#include <facetloc/testing/places.h>
#include <facetloc/testing/segcomp.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

namespace facetloc {
namespace {

using test::dataFolder;

class RealImages : public testing::Test {};

#define SKIP_WITHOUT(path)                                                                                   \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no data at " << (path) << "; see FACETLOC_DATA"

std::shared_ptr<const Map> mapOf(const DepthSequence& sequence) {
  auto map = std::make_shared<Map>();
  MapBuilder rule;
  ViewBuilder builder;
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
    const auto T_w_c = sequence.groundTruth().at(sequence.frames()[i].stamp);
    if (!T_w_c || !rule.accept(*T_w_c)) continue;
    map->models.emplace_back("", 0, *T_w_c, builder.build(sequence.load(i, kWorkingWidth)));
  }
  return map;
}

struct Found {
  int images = 0, correct = 0;
};

/** Rank 1 within 0.3 m and 5 deg, every step-th image. */
Found localized(const internal::GlobalLocalization& localization, const DepthSequence& query,
                std::size_t step) {
  Found found;
  ViewBuilder builder;
  for (std::size_t i = 0; i < query.frames().size(); i += step) {
    const auto truth = query.groundTruth().at(query.frames()[i].stamp);
    if (!truth) continue;
    const Localization answer = localization.localize(builder.build(query.load(i, kWorkingWidth)));
    ++found.images;
    if (answer.hypotheses.empty()) continue;
    const Eigen::Isometry3d& T = *answer.hypotheses[0].T_w_c;
    found.correct += (T.translation() - truth->translation()).norm() <= 0.3 &&
                     rotationAngle(T.linear() * truth->linear().transpose()) <= 5 * kDegree;
  }
  return found;
}

TEST_F(RealImages, OfAKitchenAreFoundInAMapOfItsOtherHalf) {
  const auto data = dataFolder("redkitchen");
  SKIP_WITHOUT(data);
  const internal::GlobalLocalization localization(mapOf(DepthSequence::open(data / "map")));
  const Found found = localized(localization, DepthSequence::open(data / "query"), 10);
  EXPECT_GE(found.correct, 0.95 * found.images);  // observed: all
}

TEST_F(RealImages, OfAStereoCameraAreFoundAlthoughTheirNoiseIsSmooth) {
  const auto data = dataFolder("recordings/d435_desk");
  SKIP_WITHOUT(data);
  const internal::GlobalLocalization localization(mapOf(DepthSequence::open(data / "map")));
  const Found found = localized(localization, DepthSequence::open(data / "query"), 4);
  EXPECT_GE(found.correct, 0.6 * found.images);  // 0.26 if the noise counts as rough
}

TEST_F(RealImages, OfAnotherSensorAreSegmentedWithTheThresholdsOfAKinect) {
  const auto data = dataFolder("abw");
  SKIP_WITHOUT(data);
  test::OverlapScore sum;
  for (const test::SegCompImage& image : test::readSegComp(data)) {
    SegmentationParams params;
    params.labels.min_support = 100 / scaledPixels(1, image.depth.camera);
    LabelledPlanes found;
    PlaneSegmenter(params).segment(image.depth, found);
    sum += test::overlapScore(found.labels, image.truth);
  }
  EXPECT_GT(sum.rate(), 0.75);  // observed: 0.788
}

TEST_F(RealImages, FullOfHolesStillShowPlanes) {
  const auto data = dataFolder("cafe");
  SKIP_WITHOUT(data);
  const DepthSequence sequence = DepthSequence::open(data);
  ViewBuilder builder;
  for (std::size_t i = 0; i < sequence.frames().size(); i += 8)
    EXPECT_GE(builder.build(sequence.load(i, kWorkingWidth)).segments.size(), 3u)
        << sequence.frames()[i].name;
}

}  // namespace
}  // namespace facetloc
