// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_trajectory.h"

#include <facetloc/testing/matchers.h>

namespace facetloc::test {
namespace {

TEST(LiveTrajectory, KeepsNoMorePointsThanNeeded) {
  LiveTrajectory trajectory;
  for (int i = 0; i < 100; ++i) trajectory.add({0.01 * i, 0, 0});
  ASSERT_THAT(trajectory.lines(), SizeIs(1));
  EXPECT_THAT(trajectory.lines()[0], SizeIs(testing::Le(21u)));
  EXPECT_THAT(trajectory.lines()[0], SizeIs(testing::Ge(16u)));
}

TEST(LiveTrajectory, BeginsANewLineAfterAnInterruptionAndAJump) {
  LiveTrajectory trajectory;
  trajectory.add({0, 0, 0});
  trajectory.add({0.1, 0, 0});
  trajectory.interrupt();
  trajectory.add({0.2, 0, 0});
  trajectory.add({5, 0, 0});
  ASSERT_THAT(trajectory.lines(), SizeIs(3));
  EXPECT_THAT(trajectory.lines()[0], SizeIs(2));
  EXPECT_EQ(trajectory.lines()[2].front().x(), 5);
}

TEST(LiveTrajectory, BeginsAnewInAnotherPartOfTheMap) {
  LiveTrajectory trajectory;
  trajectory.add({0, 0, 0}, 1);
  trajectory.interrupt();
  trajectory.add({0.2, 0, 0}, 2);
  ASSERT_THAT(trajectory.lines(), SizeIs(1));
  EXPECT_EQ(trajectory.lines()[0].front().x(), 0.2);
}

TEST(LiveTrajectory, LongOnesGetCoarser) {
  LiveTrajectory trajectory;
  for (int i = 0; i < 50000; ++i) trajectory.add({0.1 * i, 0, 0});
  std::size_t points = 0;
  for (const auto& line : trajectory.lines()) points += line.size();
  EXPECT_LE(points, 2001u);
  EXPECT_EQ(trajectory.lines().front().front().x(), 0);
  EXPECT_NEAR(trajectory.lines().back().back().x(), 5000, 10);
  EXPECT_THAT(trajectory.lines(), SizeIs(1));
}

}  // namespace
}  // namespace facetloc::test
