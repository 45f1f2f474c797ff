// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/mapping/trajectory_estimation.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace facetloc {
namespace {

using test::largeRoom, test::PoseNear, test::viewFrom;

constexpr double kStep = 1.0 / 15;  // [s]

/** Around the middle of the room, looking outwards and down. */
Eigen::Isometry3d onCircle(int i) { return test::onCircle(4 * i, 0.75, 1.2, 0.25); }

void drive(TrajectoryEstimation& estimation, int first, int last) {
  for (int i = first; i < last; ++i)
    estimation.add(viewFrom(largeRoom(), onCircle(i), 100u + static_cast<unsigned>(i)), kStep * i);
}

void expectSame(const TrajectoryEstimation& a, const TrajectoryEstimation& b) {
  const CameraTrajectory of_a = a.trajectory(), of_b = b.trajectory();
  ASSERT_EQ(of_a.keyframes.size(), of_b.keyframes.size());
  for (std::size_t k = 0; k < of_a.keyframes.size(); ++k) {
    EXPECT_EQ(of_a.keyframes[k].T_w_c.T.matrix(), of_b.keyframes[k].T_w_c.T.matrix()) << k;
    EXPECT_EQ(of_a.keyframes[k].T_w_c.P, of_b.keyframes[k].T_w_c.P) << k;
    EXPECT_EQ(of_a.keyframes[k].part, of_b.keyframes[k].part) << k;
  }
  ASSERT_EQ(of_a.motions.size(), of_b.motions.size());
  for (std::size_t i = 0; i < of_a.motions.size(); ++i) {
    EXPECT_EQ(of_a.motions[i].from, of_b.motions[i].from) << i;
    EXPECT_EQ(of_a.motions[i].to, of_b.motions[i].to) << i;
    EXPECT_EQ(of_a.motions[i].T_from_to.T.matrix(), of_b.motions[i].T_from_to.T.matrix()) << i;
  }
}

TEST(TrajectoryImprovement, AnImprovedCloneIsAsGoodAsBeingImproved) {
  TrajectoryEstimation live, direct;
  drive(live, 0, 24);
  drive(direct, 0, 24);
  TrajectoryEstimation clone = live.clone();
  clone.improve();
  live.adopt(clone);
  direct.improve();
  expectSame(live, direct);
  drive(live, 24, 30);
  drive(direct, 24, 30);
  expectSame(live, direct);
}

TEST(TrajectoryImprovement, ImagesAddedWhileACloneIsImprovedMoveWithTheKeyframeBefore) {
  TrajectoryEstimation live;
  drive(live, 0, 20);
  TrajectoryEstimation clone = live.clone();
  const int n = live.keyframes();
  drive(live, 20, 40);
  const CameraTrajectory before = live.trajectory();
  ASSERT_GT(live.keyframes(), n);
  clone.improve();
  live.adopt(clone);
  const CameraTrajectory after = live.trajectory();
  ASSERT_EQ(after.keyframes.size(), before.keyframes.size());
  ASSERT_EQ(after.images.size(), before.images.size());
  for (int k = 0; k < n; ++k)
    EXPECT_THAT(after.keyframes[k].T_w_c.T, PoseNear(clone.pose(k).T, 1e-12, 1e-9)) << k;
  const auto fromLast = [n](const CameraTrajectory& t, std::size_t k) {
    return t.keyframes[static_cast<std::size_t>(n - 1)].T_w_c.T.inverse() * t.keyframes[k].T_w_c.T;
  };
  for (std::size_t k = static_cast<std::size_t>(n); k < after.keyframes.size(); ++k)
    EXPECT_THAT(fromLast(after, k), PoseNear(fromLast(before, k), 1e-9, 1e-6)) << k;

  TrajectoryEstimation next = live.clone();
  next.improve({}, n);
  live.adopt(next);
  for (int i = 0; i < 40; i += 5)
    EXPECT_THAT(live.trajectory().images[static_cast<std::size_t>(i)].T_w_c,
                PoseNear(onCircle(0).inverse() * onCircle(i), 0.05, 1.0))
        << i;
}

TEST(TrajectoryImprovement, RefusesToAdoptAnotherTrajectory) {
  TrajectoryEstimation longer, other;
  drive(longer, 0, 8);
  EXPECT_THROW(other.adopt(longer), std::invalid_argument);
}

TEST(TrajectoryImprovement, AnEndlessOneDoesNotGrowWhereTheCameraHasBeen) {
  TrajectoryEstimation estimation;
  estimation.setEndless(true);
  constexpr int kThere = 16;  // images to one side, and then back and forth
  const auto at = [](int i) { return kThere - std::abs(kThere - i % (2 * kThere)); };
  int first_time = 0;
  for (int i = 0; i < 8 * kThere; ++i) {
    if (i == 2 * kThere) first_time = estimation.keyframes();
    estimation.add(viewFrom(largeRoom(), onCircle(at(i)), 300u + static_cast<unsigned>(i)), kStep * i);
    EXPECT_THAT(estimation.latest().T, PoseNear(onCircle(0).inverse() * onCircle(at(i)), 0.06, 1.5)) << i;
  }
  EXPECT_LE(estimation.keyframes(), first_time + 1);
  EXPECT_LE(estimation.trajectory().images.size(), static_cast<std::size_t>(estimation.keyframes()) + 1);
  EXPECT_EQ(estimation.trajectory().parts().size(), 1u);
}

TEST(TrajectoryImprovement, RecognizesThePlaceThatACameraIsCarriedBackTo) {
  TrajectoryEstimation estimation;
  estimation.setEndless(true);
  constexpr int kWay = 11;  // images, after which the camera begins again: 44 deg away
  int first_time = 0;
  for (int i = 0; i < 4 * kWay; ++i) {
    if (i == kWay) first_time = estimation.keyframes();
    if (i % kWay == 0) estimation.interrupt();
    estimation.add(viewFrom(largeRoom(), onCircle(i % kWay), 500u + static_cast<unsigned>(i)), kStep * i);
    EXPECT_THAT(estimation.latest().T, PoseNear(onCircle(0).inverse() * onCircle(i % kWay), 0.06, 1.5)) << i;
  }
  EXPECT_LE(estimation.keyframes(), first_time + 1);
  EXPECT_EQ(estimation.trajectory().parts().size(), 1u);
}

}  // namespace
}  // namespace facetloc
