// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/trajectory_graph.h"

#include <facetloc/mapping/trajectory_estimation.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace facetloc {

using namespace internal;

namespace {

using test::largeRoom, test::lookingAlong, test::MatrixNear, test::mounted, test::PoseNear, test::viewFrom;

/** A room that shows corners and edges wherever one looks. */
test::Scene furnishedRoom() {
  return largeRoom() + test::box({3.6, 0, 0}, {4.1, 0.5, 1.7}) + test::box({4.6, 0, 0}, {5.2, 0.3, 1.0}) +
         test::box({1.0, 4.6, 0}, {1.9, 5, 1.3}) + test::box({3.7, 4.7, 0}, {4.1, 5, 2.1}) +
         test::box({0, 2.1, 0}, {0.4, 2.8, 1.0}) + test::box({5.7, 2.6, 0}, {6, 3.0, 2.0}) +
         test::box({0.2, 0, 0}, {0.8, 0.5, 2.0}) + test::box({2.1, 4.8, 0}, {2.3, 5, 0.7});
}

/** Once around the middle of the room and a bit further, looking outwards. */
Eigen::Isometry3d onCircle(double turn_deg) { return test::onCircle(turn_deg, 0.75, 1.2, 0.25); }

/** Poses relative to the first one against the true ones. */
double largestError(const CameraTrajectory& found, const std::vector<Eigen::Isometry3d>& truth) {
  double largest = 0;
  const Eigen::Isometry3d T = truth[0] * found.images[0].T_w_c.inverse();
  for (std::size_t i = 0; i < truth.size(); ++i)
    largest = std::max(largest, (T * found.images[i].T_w_c.translation() - truth[i].translation()).norm());
  return largest;
}

/** Sparse images all around. */
class Around : public testing::Test {
protected:
  Around() {
    for (int i = 0; i < kImages; ++i) {
      truth_.push_back(onCircle(12 * i));
      views_.push_back(viewFrom(furnishedRoom(), truth_.back(), 50 + i));
    }
  }
  CameraTrajectory estimated(int threads = 1) const {
    TrajectoryEstimation estimation;
    estimation.setNumberOfThreads(threads);
    for (int i = 0; i < kImages; ++i) estimation.add(views_[i], i);
    estimation.improve();
    return estimation.trajectory();
  }
  static constexpr int kImages = 36;  // 420 deg
  std::vector<Eigen::Isometry3d> truth_;
  std::vector<View> views_;
};

TEST_F(Around, SparseImagesAreFollowedAndTheLoopIsClosed) {
  const CameraTrajectory found = estimated();
  ASSERT_EQ(found.images.size(), truth_.size());
  EXPECT_EQ(found.parts().size(), 1u);
  EXPECT_LT(largestError(found, truth_), 0.03);
  EXPECT_GT(found.loops(), 0);
  EXPECT_NEAR(found.length(), 35 * 2 * 0.75 * std::sin(6 * kDegree), 0.1);
  // as good as it says
  double squared = 0;
  for (std::size_t k = 1; k < found.keyframes.size(); ++k) {
    const Eigen::Isometry3d expected =
        found.keyframes[0].T_w_c.T * truth_[0].inverse() * truth_[found.keyframes[k].image];
    const Vector6d e = boxminus(found.keyframes[k].T_w_c.T, expected);
    squared += e.dot(found.keyframes[k].T_w_c.P.ldlt().solve(e)) / double(found.keyframes.size() - 1);
  }
  EXPECT_LT(squared, 3 * 6);
}

TEST_F(Around, IsTheSameForAnyNumberOfThreads) {
  const CameraTrajectory one = estimated(1), two = estimated(2);
  for (std::size_t i = 0; i < one.images.size(); ++i)
    EXPECT_EQ(one.images[i].T_w_c.matrix(), two.images[i].T_w_c.matrix()) << i;
}

TEST_F(Around, LinksJoinLocalModelsAlongTheWayAndAcrossTheLoop) {
  const CameraTrajectory found = estimated();
  const std::vector<std::size_t> images{0, 6, 12, 18, 24, 30, 35};
  const std::vector<Link> links = trajectoryLinks(found, images);
  int steps = 0;
  bool closed = false;
  for (const Link& link : links) {
    steps += link.to == link.from + 1;
    closed |= link.from <= 1 && link.to >= 5;
    EXPECT_EQ(Eigen::LLT<Matrix6d>(link.T_from_to.P).info(), Eigen::Success);
    EXPECT_THAT(link.T_from_to.T,
                PoseNear(truth_[images[link.from]].inverse() * truth_[images[link.to]], 0.04, 1.2));
  }
  EXPECT_EQ(steps, 6);
  EXPECT_TRUE(closed);
  EXPECT_THROW(trajectoryLinks(found, {0, 99}), std::invalid_argument);
  EXPECT_TRUE(trajectoryLinks({}, {}).empty());
}

TEST(TrajectoryEstimation, AVideoHasFewKeyframesAndAPoseForEachImage) {
  TrajectoryEstimation estimation;
  std::vector<Eigen::Isometry3d> truth;
  for (int i = 0; i < 60; ++i) {
    truth.push_back(onCircle(2 * i));
    estimation.add(viewFrom(furnishedRoom(), truth.back(), 50 + i), i / 15.0);
  }
  estimation.improve();
  const CameraTrajectory found = estimation.trajectory();
  EXPECT_EQ(found.images.size(), 60u);
  EXPECT_GE(found.keyframes.size(), 6u);
  EXPECT_LE(found.keyframes.size(), 15u);
  EXPECT_LT(largestError(found, truth), 0.03);
}

TEST(TrajectoryEstimation, ATurnedAwayCameraBeginsANewPieceThatIsTiedLater) {
  // Along one wall, then a view of the opposite one, and from there back to the first wall.
  TrajectoryEstimation estimation;
  std::vector<double> turns;
  for (int i = 0; i < 5; ++i) turns.push_back(10 * i);
  for (int i = 0; i < 23; ++i) turns.push_back(180 + 10 * i);
  std::vector<Eigen::Isometry3d> truth;
  for (std::size_t i = 0; i < turns.size(); ++i) {
    truth.push_back(onCircle(turns[i]));
    estimation.add(viewFrom(furnishedRoom(), truth.back(), 50 + static_cast<unsigned>(i)), double(i));
  }
  EXPECT_EQ(estimation.trajectory().parts().size(), 2u);
  estimation.improve();
  const CameraTrajectory found = estimation.trajectory();
  EXPECT_EQ(found.parts().size(), 1u);
  EXPECT_LT(largestError(found, truth), 0.15);
}

/** Images of a video around the room, at 15 Hz, with a gap of 3 s after which the camera is elsewhere. */
class WithGap : public testing::Test {
protected:
  /** The first piece looks from 0 to 48 deg. */
  CameraTrajectory estimated(const std::vector<double>& turns_after, TrajectoryEstimation& estimation) {
    for (double turn = 0; turn <= 48; turn += 3) add(estimation, turn);
    stamp_ += 3;
    for (const double turn : turns_after) add(estimation, turn);
    EXPECT_EQ(estimation.trajectory().parts().size(), 2u) << "before any tie";
    estimation.improve([this](double share) { progress_.push_back(share); });
    return estimation.trajectory();
  }
  static std::vector<double> turnsFrom(double first, double last) {
    std::vector<double> turns;
    for (double turn = first; turn <= last; turn += 3) turns.push_back(turn);
    return turns;
  }
  std::vector<Eigen::Isometry3d> truth_;
  std::vector<double> progress_;

private:
  void add(TrajectoryEstimation& estimation, double turn) {
    truth_.push_back(onCircle(turn));
    estimation.add(viewFrom(furnishedRoom(), truth_.back(), 50 + static_cast<unsigned>(truth_.size())),
                   stamp_ += 1 / 15.0);
  }
  double stamp_ = 0;
};

TEST_F(WithGap, TwoPiecesWithIndependentTiesBecomeOne) {
  TrajectoryEstimation estimation;
  const CameraTrajectory found = estimated(turnsFrom(10, 70), estimation);
  EXPECT_EQ(found.parts().size(), 1u);
  EXPECT_LT(largestError(found, truth_), 0.05);
  EXPECT_GT(found.overlaps.confirmed, 5);
  EXPECT_EQ(found.overlaps.contradicted, 0);
  EXPECT_EQ(found.cut_bonds, 0);
}

TEST_F(WithGap, TwoPiecesWithOneTieStayTwo) {
  TrajectoryEstimation estimation;
  // The second piece has one keyframe: whatever ties it has share that one.
  const CameraTrajectory found = estimated({20, 22, 24}, estimation);
  EXPECT_EQ(found.parts().size(), 2u);
}

TEST_F(WithGap, ProgressNeverGoesBackAndEndsWithAll) {
  TrajectoryEstimation estimation;
  estimated(turnsFrom(10, 70), estimation);
  ASSERT_GE(progress_.size(), 3u);
  EXPECT_TRUE(std::is_sorted(progress_.begin(), progress_.end()));
  EXPECT_EQ(progress_.back(), 1);
}

TEST(TrajectoryEstimation, PiecesThatFitInTwoWaysStayApart) {
  // Three of four equal walls, and a corner between two of them.
  const test::Scene square = test::box({0, 0, 0}, {5, 5, 2.5});
  TrajectoryEstimation estimation;
  double stamp = 0;
  unsigned seed = 7;
  const auto turn = [&](double first, double last) {
    for (double turn_deg = first; turn_deg <= last; turn_deg += 3) {
      const double a = turn_deg * kDegree;
      const Eigen::Isometry3d T_w_c = lookingAlong({2.5, 2.5, 1.2}, {std::cos(a), std::sin(a), -0.25});
      estimation.add(viewFrom(square, T_w_c, ++seed), stamp += 1 / 15.0);
    }
  };
  turn(0, 200);
  stamp += 3;
  turn(40, 100);
  estimation.improve();
  EXPECT_EQ(estimation.trajectory().parts().size(), 2u);
}

TEST(TrajectoryEstimation, PiecesWithNothingInCommonStayApart) {
  TrajectoryEstimation estimation;
  const View here = viewFrom(furnishedRoom(), onCircle(0), 1),
             there = viewFrom(furnishedRoom(), onCircle(180), 2);
  estimation.add(here, 0);
  estimation.add(there, 1);
  estimation.improve();
  const CameraTrajectory found = estimation.trajectory();
  EXPECT_EQ(found.parts(), (std::vector<int>{0, 1}));
  EXPECT_EQ(found.length(), 0);
}

TEST(TrajectoryEstimation, AStillCameraHasOneKeyframe) {
  TrajectoryEstimation estimation;
  for (int i = 0; i < 10; ++i) estimation.add(viewFrom(furnishedRoom(), onCircle(20), 7 + i), i);
  estimation.improve();
  const CameraTrajectory found = estimation.trajectory();
  EXPECT_EQ(found.keyframes.size(), 1u);
  for (const TrajectoryPose& pose : found.images)
    EXPECT_THAT(pose.T_w_c, PoseNear(Eigen::Isometry3d::Identity(), 0.02, 1));
}

TEST(TrajectoryEstimation, AnyStampsAndEmptyViewsHaveAnAnswer) {
  TrajectoryEstimation estimation;
  EXPECT_TRUE(estimation.trajectory().images.empty());
  estimation.improve();
  for (int i = 0; i < 6; ++i) {
    estimation.add(viewFrom(furnishedRoom(), onCircle(10 * i), 7 + i), 100 - i);  // backwards
    if (i == 3) estimation.add({}, 100 - i);
  }
  estimation.improve();
  const CameraTrajectory found = estimation.trajectory();
  EXPECT_EQ(found.images.size(), 7u);
  EXPECT_LE(found.parts().size(), 2u) << "an empty view may break the chain, once";
  EXPECT_THROW(TrajectoryEstimation([] {
                 MappingParams p;
                 p.odometry.key_distance = -1;
                 return p;
               }()),
               std::invalid_argument);
}

TEST(TrajectoryEstimation, AGivenOdometryCarriesACameraAlongACorridor) {
  constexpr int kImages = 30;
  const auto at = [](int i) { return lookingAlong({0, 0.3 * i, 1.2}, {0.05, 1, -0.2}); };
  const auto alongCorridor = [&](bool with_odometry) {
    TrajectoryEstimation estimation;
    for (int i = 0; i < kImages; ++i) {
      std::optional<Eigen::Isometry3d> motion;
      if (with_odometry && i > 0) motion = at(i - 1).inverse() * at(i);
      estimation.add(viewFrom(test::endlessCorridor(), at(i), 70 + i, 5), i, motion);
    }
    estimation.improve();
    return estimation.trajectory();
  };
  const CameraTrajectory with = alongCorridor(true), without = alongCorridor(false);
  const double distance = 0.3 * (kImages - 1);
  const auto gone = [](const CameraTrajectory& t) {
    return (t.images.back().T_w_c.translation() - t.images.front().T_w_c.translation()).norm();
  };
  EXPECT_NEAR(gone(with), distance, 0.05 * distance);
  // Without it, the pose is unknown, and the covariance says so.
  const Matrix6d P = without.keyframes.back().T_w_c.P;
  EXPECT_GT(largestTranslationStd(P), 0.2 * distance);
  EXPECT_LT(largestTranslationStd(with.keyframes.back().T_w_c.P), 0.3 * largestTranslationStd(P));
}

TEST(TrajectoryEstimation, TheWorldOfARobotIsItsFloor) {
  const CameraMounting mounting{1.2, std::atan(0.25) / kDegree};
  TrajectoryEstimation estimation;
  for (int i = 0; i < 8; ++i)
    estimation.add(mounted(viewFrom(furnishedRoom(), onCircle(10 * i), 30 + i), mounting), i);
  estimation.improve();
  for (const TrajectoryPose& pose : estimation.trajectory().images) {
    EXPECT_NEAR(pose.T_w_c.translation().z(), 1.2, 0.02);
    EXPECT_NEAR(pose.T_w_c.linear().col(0).z(), 0, 0.02);
  }
}

constexpr double kStep = 1.0 / 15;  // [s]

void drive(TrajectoryEstimation& estimation, int first, int last) {
  for (int i = first; i < last; ++i)
    estimation.add(viewFrom(largeRoom(), onCircle(4 * i), 100u + static_cast<unsigned>(i)), kStep * i);
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
                PoseNear(onCircle(0).inverse() * onCircle(4 * i), 0.05, 1.0))
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
    estimation.add(viewFrom(largeRoom(), onCircle(4 * at(i)), 300u + static_cast<unsigned>(i)), kStep * i);
    EXPECT_THAT(estimation.latest().T, PoseNear(onCircle(0).inverse() * onCircle(4 * at(i)), 0.06, 1.5)) << i;
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
    estimation.add(viewFrom(largeRoom(), onCircle(4 * (i % kWay)), 500u + static_cast<unsigned>(i)),
                   kStep * i);
    EXPECT_THAT(estimation.latest().T, PoseNear(onCircle(0).inverse() * onCircle(4 * (i % kWay)), 0.06, 1.5))
        << i;
  }
  EXPECT_LE(estimation.keyframes(), first_time + 1);
  EXPECT_EQ(estimation.trajectory().parts().size(), 1u);
}

}  // namespace
}  // namespace facetloc
