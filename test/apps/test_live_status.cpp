// SPDX-License-Identifier: BSD-3-Clause
#include "cli/progress.h"
#include "live/live_status.h"

#include <facetloc/testing/matchers.h>

#include <sstream>
#include <thread>

namespace facetloc::test {
namespace {

LiveResult trackedResult(TrackingState state, const std::string& reason) {
  LiveResult result;
  result.received = 12;
  result.dropped = 3;
  Localization& answer = result.answer.emplace();
  answer.tracking = state;
  if (state == TrackingState::tracking) answer.state = AnswerState::sure;
  answer.reason = reason;
  answer.hypotheses.emplace_back();
  answer.T_w_c.emplace();
  answer.T_w_c->T.translation() << 1.234, -2, 0.5;
  return result;
}

TEST(LiveStatus, ShowsStateAndPlaceOnATerminal) {
  std::ostringstream out, err;
  const Console console{out, err, true, false, {}};
  LiveStatus status(console);
  status.show(trackedResult(TrackingState::tracking, ""), 29.96);
  EXPECT_THAT(err.str(), HasAll("tracking", "1.23 -2.00 0.50 m", "30.0/s", "3 of 12 dropped"));
  err.str("");
  status.show(trackedResult(TrackingState::degenerate, "free: x"), 30);
  EXPECT_THAT(err.str(), HasAll("cannot tell: free: x", Not(HasSubstr("1.23"))));
  err.str("");
  status.clear();
  status.clear();
  EXPECT_EQ(err.str(), "\r\033[K") << "once";
  EXPECT_THAT(out.str(), IsEmpty());
}

TEST(LiveStatus, IsSilentWithoutATerminal) {
  std::ostringstream out, err;
  for (const Console& console : {Console{out, err, false, false, {}}, Console{out, err, true, true, {}}}) {
    LiveStatus status(console);
    status.show(trackedResult(TrackingState::lost, "why"), 30);
  }
  EXPECT_THAT(err.str(), IsEmpty());
}

TEST(LiveStatus, ShowsTimes) {
  LiveResult result = trackedResult(TrackingState::tracking, "");
  result.segment_ms = 5.14;
  result.localize_ms = 9.06;
  EXPECT_THAT(timesText(result, 30), HasAll("segmentation 5.1 ms", "localization 9.1 ms", "3 of 12 dropped"));
  result.answer.reset();
  EXPECT_THAT(timesText(result, 30), Not(HasSubstr("localization")));
  EXPECT_EQ(stateText(result), "segmenting");
}

TEST(FrameRate, CountsFramesPerSecond) {
  FrameRate rate;
  rate.update(10);
  EXPECT_EQ(rate.value(), 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(1050));
  rate.update(31);
  EXPECT_GT(rate.value(), 1);
  EXPECT_LE(rate.value(), 20.1);
}

TEST(StopSignal, TurnsTheFirstSignalIntoAFlag) {
  for (const int number : {SIGINT, SIGTERM}) {
    const StopSignal stop;
    EXPECT_FALSE(stop.raised());
    std::raise(number);
    EXPECT_TRUE(stop.raised());
  }
  const StopSignal again;
  EXPECT_FALSE(again.raised());
}

TEST(StopSignalDeathTest, TheSecondSignalKills) {
  EXPECT_EXIT(
      {
        const StopSignal stop;
        std::raise(SIGINT);
        std::raise(SIGTERM);
      },
      testing::KilledBySignal(SIGTERM), "");
}

TEST(StopSignal, LeavesHandlersAsTheyWere) {
  struct sigaction before = {}, after = {};
  sigaction(SIGINT, nullptr, &before);
  { const StopSignal stop; }
  sigaction(SIGINT, nullptr, &after);
  EXPECT_EQ(before.sa_handler, after.sa_handler);
}

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
