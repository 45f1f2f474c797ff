// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/loop_search.h"

#include <facetloc/features/pose.h>
#include <facetloc/testing/synthetic_views.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr CameraMounting kMounting{1.0, 10.0};

Eigen::Isometry3d robotCamera(double x, double y, double heading) {
  return Eigen::Translation3d(x, y, 0) * Eigen::Isometry3d(expSO3({0, 0, heading})) * kMounting.T_b_c();
}

TrajectoryNode keyframe(const View& view, int part, int run) {
  TrajectoryNode node;
  node.view = std::make_shared<const View>(view);
  node.part = part, node.run = run;
  return node;
}

/** Two rounds of a robot in a room, as two parts that nothing ties: view i of the second one is taken near
 * view i of the first one. */
class TwoRounds : public testing::Test {
protected:
  static constexpr int kViews = 48;

  static void SetUpTestSuite() {
    keyframes_ = new std::vector<TrajectoryNode>;
    for (int round = 0; round < 2; ++round)
      for (int i = 0; i < kViews; ++i) {
        const double heading = (i * 15 + 2 * round) * kDegree, x = i < kViews / 2 ? 2 : 3.8;
        const View view =
            test::viewFrom(test::largeRoom(), robotCamera(x + 0.05 * round, 2.4, heading), 100 * round + i);
        keyframes_->push_back(keyframe(test::mounted(view, kMounting), round, round));
      }
  }
  static void TearDownTestSuite() {
    delete keyframes_;
    keyframes_ = nullptr;
  }

  static std::vector<std::pair<int, int>> candidates(long long exhaustive_up_to, int first = 0,
                                                     const ChunkedWork& work = {2}) {
    return tieCandidates(*keyframes_, first, kMounting, work, exhaustive_up_to);
  }
  /** How many views of the second round are paired with their neighbours in the first one. */
  static int found(const std::vector<std::pair<int, int>>& pairs) {
    int n = 0;
    for (int i = 0; i < kViews; ++i) n += std::count(pairs.begin(), pairs.end(), std::pair(i, kViews + i));
    return n;
  }

  static std::vector<TrajectoryNode>* keyframes_;
};

std::vector<TrajectoryNode>* TwoRounds::keyframes_ = nullptr;

TEST_F(TwoRounds, ViewsOfOnePlaceArePaired) {
  const auto pairs = candidates(1'000'000);
  EXPECT_GE(found(pairs), 0.8 * kViews);
  for (const auto& [a, b] : pairs) EXPECT_NE((*keyframes_)[a].part, (*keyframes_)[b].part);
}

TEST_F(TwoRounds, AnIndexFindsThemAsWell) {
  const int all = found(candidates(1'000'000));
  EXPECT_GE(found(candidates(0)), all - 3);
}

TEST_F(TwoRounds, EachHasABoundedNumberOfPartners) {
  for (const long long exhaustive_up_to : {0, 1'000'000}) {
    std::vector<int> partners(2 * kViews);
    for (const auto& [a, b] : candidates(exhaustive_up_to)) ++partners[b];
    EXPECT_LE(*std::max_element(partners.begin(), partners.end()), 25);
  }
}

TEST_F(TwoRounds, OnlyTheLatestKeyframesAreSearchedForIfAsked) {
  for (const auto& [a, b] : candidates(0, 2 * kViews - 5)) EXPECT_GE(b, 2 * kViews - 5);
}

TEST_F(TwoRounds, ProgressIsReportedOnTheWay) {
  std::vector<double> reports;
  const auto pairs = candidates(1'000'000, 0, {2, [&](double share) { reports.push_back(share); }});
  ASSERT_GE(reports.size(), 3u);  // at the begin, and after each chunk of keyframes
  EXPECT_TRUE(std::is_sorted(reports.begin(), reports.end()));
  EXPECT_EQ(reports.front(), 0);
  EXPECT_GT(reports.back(), 0.5);
  EXPECT_LT(reports.back(), 1);
  EXPECT_EQ(pairs, candidates(1'000'000)) << "the same without reports";
}

TEST(TieCandidates, OnePartHasNoTies) {
  const std::vector<TrajectoryNode> one(3, keyframe({}, 7, 0));
  EXPECT_TRUE(tieCandidates(one, 0, {}, {}).empty());
  EXPECT_TRUE(tieCandidates({}, 0, {}, {}).empty());
}

constexpr int kLeast = 2;

TEST(PieceBonds, AConfirmedBondStays) {
  EXPECT_FALSE(weakestBond({{{0, 0}, {100, 2}}, {{0, 5}, {40, 1}}}, {{{0, 5}, 2}}, kLeast));
  EXPECT_FALSE(weakestBond({}, {}, kLeast));
}

TEST(PieceBonds, ABondOfOneTieIsCut) {
  EXPECT_EQ(weakestBond({{{0, 5}, {40, 0}}}, {{{0, 5}, 1}}, kLeast), PiecePair(0, 5));
}

TEST(PieceBonds, AContradictedBondIsCut) {
  EXPECT_EQ(weakestBond({{{0, 5}, {40, 0}}, {{0, 9}, {60, 20}}}, {{{0, 5}, 3}, {{0, 9}, 7}}, kLeast),
            PiecePair(0, 9));
}

TEST(PieceBonds, WhereTheEndsOfAChainContradictEachOtherItsWeakestBondIsCut) {
  const PieceBonds bonds{{{0, 3}, 4}, {{3, 5}, 2}, {{5, 9}, 6}};
  EXPECT_EQ(weakestBond({{{0, 9}, {1, 30}}}, bonds, kLeast), PiecePair(3, 5));
  EXPECT_EQ(weakestBond({{{0, 9}, {1, 30}}, {{5, 9}, {50, 2}}}, bonds, kLeast), PiecePair(5, 9));
}

TEST(PieceBonds, ContradictionsWithinAPieceCutNothing) {
  EXPECT_FALSE(weakestBond({{{0, 0}, {10, 10}}}, {{{0, 5}, 3}}, kLeast));
}

Eigen::Isometry3d along(double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); }

CameraSpeed after(int images, double interval) {
  CameraSpeed speed;
  for (int i = 0; i < images; ++i) speed.addInterval(interval);
  return speed;
}

TEST(CameraSpeed, AHoleInAVideoIsAGap) {
  const CameraSpeed speed = after(50, 0.033);
  EXPECT_TRUE(speed.isGap(3.5));
  EXPECT_FALSE(speed.isGap(0.1)) << "a few lost images";
}

TEST(CameraSpeed, AnImageNowAndThenIsARhythm) {
  EXPECT_FALSE(after(0, 0).isGap(5));
  EXPECT_FALSE(after(5, 5).isGap(6));
  EXPECT_TRUE(after(5, 5).isGap(20));
}

TEST(CameraSpeed, AFastCameraIsGoneSooner) {
  CameraSpeed speed = after(50, 0.033);
  EXPECT_FALSE(speed.isGap(0.8));
  speed.addMotion(along(0.75), 0.5);
  EXPECT_TRUE(speed.isGap(0.8));
  EXPECT_NEAR(speed.farthest(2), 6, 1e-9);
}

TEST(CameraSpeed, NoiseOfAnInstantIsNoSpeed) {
  CameraSpeed speed;
  speed.addMotion(along(0.1), 0.01);
  EXPECT_NEAR(speed.farthest(1), 1.5, 1e-9);
}

}  // namespace
}  // namespace facetloc::internal
