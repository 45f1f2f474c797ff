// SPDX-License-Identifier: BSD-3-Clause
#include "pcl/segment_frames.h"

#include <facetloc/features/segment_estimation.h>
#include <facetloc/testing/random_segments.h>

#include <gmock/gmock.h>

#include <limits>

namespace facetloc {
namespace {

using namespace internal;
using test::Rng, testing::IsEmpty, testing::UnorderedElementsAre;

pcl::PointCloud<SegmentFrame> randomFrames(int n) {
  Rng rng(1);
  pcl::PointCloud<SegmentFrame> cloud;
  for (int i = 0; i < n; ++i) cloud.push_back(toSegmentFrame(test::randomSegment(rng)));
  return cloud;
}

TEST(SegmentFrames, ComeInTheOrderOfInformationWithTheirIndex) {
  const pcl::PointCloud<SegmentFrame> cloud = randomFrames(20);
  const RankedFrames ranked = rankedSegments(cloud, nullptr);
  ASSERT_EQ(ranked.segments.size(), 20u);
  ASSERT_EQ(ranked.index.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(ranked.segments[i].num_points, cloud[ranked.index[i]].num_points);
    EXPECT_EQ(rankByInformation(ranked.segments)[i], static_cast<int>(i));
  }
}

TEST(SegmentFrames, InvalidFramesAreLeftOut) {
  pcl::PointCloud<SegmentFrame> cloud = randomFrames(5);
  cloud[1].x = std::numeric_limits<float>::quiet_NaN();
  cloud[3] = SegmentFrame{};
  EXPECT_THAT(rankedSegments(cloud, nullptr).index, UnorderedElementsAre(0, 2, 4));
}

TEST(SegmentFrames, IndicesChooseAndThoseOutsideTheCloudAreIgnored) {
  const pcl::PointCloud<SegmentFrame> cloud = randomFrames(5);
  const pcl::Indices some{4, -1, 2, 5, 1000000};
  EXPECT_THAT(rankedSegments(cloud, &some).index, UnorderedElementsAre(2, 4));
  const pcl::Indices none;
  EXPECT_THAT(rankedSegments(cloud, &none).index, IsEmpty());
  EXPECT_THAT(rankedSegments({}, nullptr).segments, IsEmpty());
}

}  // namespace
}  // namespace facetloc
