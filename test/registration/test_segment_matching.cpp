// SPDX-License-Identifier: BSD-3-Clause
#include "pcl/segment_frames.h"

#include <facetloc/registration/pose_prior.h>
#include <facetloc/registration/segment_matching.h>
#include <facetloc/testing/random_segments.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <tuple>

namespace facetloc {
namespace {

using namespace internal;
using test::gaussian, test::Rng;
using Cloud = pcl::PointCloud<SegmentFrame>;

class SegmentMatchingTest : public testing::Test {
protected:
  SegmentMatchingTest() {
    Rng rng(1);
    pose.P = posePrior(CameraMounting{0.98, 10});
    const Eigen::Isometry3d truth = boxplus(pose.T, 0.5 * gaussian<6>(rng, pose.P));
    for (int i = 0; i < 15; ++i) {
      const Segment s = test::randomSegment(rng);
      target->push_back(toSegmentFrame(s));
      source->push_back(toSegmentFrame(transformed(s, truth.inverse())));
    }
    auto m = pcl::make_shared<SegmentMatching>();
    m->setPose(pose);
    matching = m;
    matching->setInputSource(source);
    matching->setInputTarget(target);
  }
  using Pair = std::tuple<int, int, float>;
  static std::vector<Pair> listOf(const pcl::Correspondences& correspondences) {
    std::vector<Pair> list;
    for (const auto& c : correspondences) list.emplace_back(c.index_query, c.index_match, c.distance);
    return list;
  }
  std::vector<Pair> determine(double max_distance = std::numeric_limits<double>::max()) {
    pcl::Correspondences out(3);  // its former content does not matter
    matching->determineCorrespondences(out, max_distance);
    return listOf(out);
  }
  std::vector<Pair> determineReciprocal(double max_distance = std::numeric_limits<double>::max()) {
    pcl::Correspondences out(3);
    matching->determineReciprocalCorrespondences(out, max_distance);
    return listOf(out);
  }

  PoseWithCovariance pose;
  Cloud::Ptr source = pcl::make_shared<Cloud>(), target = pcl::make_shared<Cloud>();
  SegmentMatching::Base::Ptr matching;  // everything through PCL's base
};

TEST_F(SegmentMatchingTest, CorrespondencesAreTheCandidatePairs) {
  const RankedFrames s = rankedSegments(*source, nullptr), t = rankedSegments(*target, nullptr);
  std::vector<Pair> want;
  for (const SegmentPair& p : candidatePairs(s.segments, t.segments, pose))
    want.emplace_back(s.index[p.scene], t.index[p.model], static_cast<float>(p.distance));
  EXPECT_GE(want.size(), 15u);
  EXPECT_EQ(determine(), want);
}

TEST_F(SegmentMatchingTest, MaximumDistanceLowersTheGate) {
  const std::vector<Pair> all = determine(), near = determine(2);
  EXPECT_LT(near.size(), all.size());
  for (const Pair& p : near) EXPECT_LE(std::get<2>(p), 2);
  std::size_t within = 0;
  for (const Pair& p : all) within += std::get<2>(p) <= 2;
  EXPECT_EQ(near.size(), within);
}

TEST_F(SegmentMatchingTest, ReciprocalCorrespondencesAreTheBestOfBothSides) {
  const std::vector<Pair> all = determine(), reciprocal = determineReciprocal();
  ASSERT_FALSE(reciprocal.empty());
  EXPECT_LT(reciprocal.size(), all.size());
  std::map<int, float> best_source, best_target;
  for (const auto& [s, t, d] : all) {
    best_source.emplace(s, d).first->second = std::min(best_source.emplace(s, d).first->second, d);
    best_target.emplace(t, d).first->second = std::min(best_target.emplace(t, d).first->second, d);
  }
  const std::set<Pair> everything(all.begin(), all.end());
  for (const Pair& p : reciprocal) {
    EXPECT_TRUE(everything.count(p));
    EXPECT_EQ(std::get<2>(p), best_source[std::get<0>(p)]);
    EXPECT_EQ(std::get<2>(p), best_target[std::get<1>(p)]);
  }
}

TEST_F(SegmentMatchingTest, IndicesRestrictTheSource) {
  matching->setIndicesSource(pcl::make_shared<pcl::Indices>(pcl::Indices{2, 5, 7}));
  const std::vector<Pair> some = determine();
  ASSERT_FALSE(some.empty());
  for (const auto& [s, t, d] : some) EXPECT_TRUE(s == 2 || s == 5 || s == 7);
}

TEST_F(SegmentMatchingTest, InvalidFramesMatchNothing) {
  (*source)[4].x = std::numeric_limits<float>::quiet_NaN();
  (*target)[6] = SegmentFrame{};
  for (const auto& [s, t, d] : determine()) {
    EXPECT_NE(s, 4);
    EXPECT_NE(t, 6);
  }
}

TEST_F(SegmentMatchingTest, MissingCloudsHaveNone) {
  pcl::Correspondences out(3);
  SegmentMatching().determineCorrespondences(out);
  EXPECT_TRUE(out.empty());
  SegmentMatching only_source;
  only_source.setInputSource(source);
  out.resize(3);
  only_source.determineCorrespondences(out);
  EXPECT_TRUE(out.empty());
  only_source.determineReciprocalCorrespondences(out);
  EXPECT_TRUE(out.empty());
  SegmentMatching nothing;
  nothing.setInputSource(pcl::make_shared<Cloud>());
  nothing.setInputTarget(target);
  nothing.determineCorrespondences(out);
  EXPECT_TRUE(out.empty());
}

TEST_F(SegmentMatchingTest, ACloneMatchesLikeItsOriginal) {
  const std::vector<Pair> want = determine();
  matching = matching->clone();
  EXPECT_EQ(determine(), want);
}

TEST_F(SegmentMatchingTest, GettersReturnTheValuesSet) {
  MatchingParams params;
  params.max_segments = 3;
  auto& m = dynamic_cast<SegmentMatching&>(*matching);
  m.setParams(params);
  EXPECT_EQ(m.getParams().max_segments, 3);
  std::set<int> sources;
  for (const auto& [s, t, d] : determine()) sources.insert(s);
  EXPECT_LE(sources.size(), 3u);
}

}  // namespace
}  // namespace facetloc
