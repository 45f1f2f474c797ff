// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_trail.h"

#include <gmock/gmock.h>

namespace facetloc {
namespace {

using testing::SizeIs;

TEST(LiveTrail, KeepsNoMorePointsThanNeeded) {
  LiveTrail trail;
  for (int i = 0; i < 100; ++i) trail.add({0.01 * i, 0, 0});
  ASSERT_THAT(trail.lines(), SizeIs(1));
  EXPECT_THAT(trail.lines()[0], SizeIs(testing::Le(21u)));
  EXPECT_THAT(trail.lines()[0], SizeIs(testing::Ge(16u)));
}

TEST(LiveTrail, BeginsANewLineAfterAnInterruptionAndAJump) {
  LiveTrail trail;
  trail.add({0, 0, 0});
  trail.add({0.1, 0, 0});
  trail.interrupt();
  trail.add({0.2, 0, 0});
  trail.add({5, 0, 0});
  ASSERT_THAT(trail.lines(), SizeIs(3));
  EXPECT_THAT(trail.lines()[0], SizeIs(2));
  EXPECT_EQ(trail.lines()[2].front().x(), 5);
}

TEST(LiveTrail, BeginsAnewInAnotherPartOfTheMap) {
  LiveTrail trail;
  trail.add({0, 0, 0}, 1);
  trail.interrupt();
  trail.add({0.2, 0, 0}, 2);
  ASSERT_THAT(trail.lines(), SizeIs(1));
  EXPECT_EQ(trail.lines()[0].front().x(), 0.2);
}

TEST(LiveTrail, LongOnesGetCoarser) {
  LiveTrail trail;
  for (int i = 0; i < 50000; ++i) trail.add({0.1 * i, 0, 0});
  std::size_t points = 0;
  for (const auto& line : trail.lines()) points += line.size();
  EXPECT_LE(points, 2001u);
  EXPECT_EQ(trail.lines().front().front().x(), 0);
  EXPECT_NEAR(trail.lines().back().back().x(), 5000, 10);
  EXPECT_THAT(trail.lines(), SizeIs(1));
}

}  // namespace
}  // namespace facetloc
