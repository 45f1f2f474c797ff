// SPDX-License-Identifier: BSD-3-Clause
#include "live/latest_frame.h"

#include <gmock/gmock.h>

#include <memory>
#include <thread>

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;

TEST(LatestFrame, GivesTheNewestAndCountsTheOthers) {
  LatestFrame<int> box;
  EXPECT_FALSE(box.take(0ms));
  EXPECT_FALSE(box.lastArrival());
  for (const int frame : {1, 2, 3}) box.put(frame);
  EXPECT_TRUE(box.counts().waiting);
  const auto arrived = box.take(0ms);
  ASSERT_TRUE(arrived);
  EXPECT_EQ(arrived->frame, 3);
  EXPECT_EQ(arrived->arrival, box.lastArrival());
  EXPECT_FALSE(box.take(0ms));
  const auto counts = box.counts();
  EXPECT_EQ(counts.received, 3u);
  EXPECT_EQ(counts.dropped, 2u);
  EXPECT_FALSE(counts.waiting);
}

TEST(LatestFrame, WaitsNoLongerThanAsked) {
  LatestFrame<int> box;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(box.take(30ms));
  EXPECT_GE(std::chrono::steady_clock::now() - start, 30ms);
}

TEST(LatestFrame, WakesWhoWaits) {
  LatestFrame<int> box;
  std::thread camera([&] {
    std::this_thread::sleep_for(20ms);
    box.put(7);
  });
  const auto arrived = box.take(60s);
  camera.join();
  ASSERT_TRUE(arrived);
  EXPECT_EQ(arrived->frame, 7);
}

TEST(LatestFrame, ClosedStillGivesItsFrameAndTakesNoMore) {
  LatestFrame<int> box;
  box.put(1);
  box.close();
  box.put(2);
  EXPECT_TRUE(box.closed());
  EXPECT_EQ(box.counts().received, 1u);
  const auto arrived = box.take(60s);
  ASSERT_TRUE(arrived);
  EXPECT_EQ(arrived->frame, 1);
  EXPECT_FALSE(box.take(60s)) << "a frame that will never come is not waited for";
}

TEST(LatestFrame, CloseWakesWhoWaits) {
  LatestFrame<int> box;
  std::thread end([&] {
    std::this_thread::sleep_for(20ms);
    box.close();
  });
  EXPECT_FALSE(box.take(60s));
  end.join();
}

TEST(LatestFrame, ClearedFramesAreDropped) {
  LatestFrame<std::shared_ptr<int>> box;
  auto frame = std::make_shared<int>(1);
  box.put(frame);
  box.clear();
  EXPECT_EQ(frame.use_count(), 1);
  EXPECT_EQ(box.counts().dropped, 1u);
  box.clear();
  EXPECT_EQ(box.counts().dropped, 1u);
}

/** A frame that asks its mailbox something when it goes, as a driver's buffer may call back. */
struct Curious {
  LatestFrame<std::shared_ptr<Curious>>* box;
  explicit Curious(LatestFrame<std::shared_ptr<Curious>>* b) : box(b) {}
  ~Curious() { box->counts(); }
};

TEST(LatestFrame, FramesGoWithoutTheLock) {
  LatestFrame<std::shared_ptr<Curious>> box;
  box.put(std::make_shared<Curious>(&box));
  box.put(std::make_shared<Curious>(&box));  // the first one goes here
  box.clear();
  EXPECT_EQ(box.counts().dropped, 2u);
}

TEST(LatestFrame, EveryFrameIsTakenOrDropped) {
  constexpr int kFrames = 20000;
  LatestFrame<int> box;
  std::thread camera([&] {
    for (int i = 1; i <= kFrames; ++i) box.put(i);
    box.close();
  });
  std::uint64_t taken = 0;
  int last = 0;
  for (;;) {
    const auto arrived = box.take(60s);
    if (!arrived) break;
    EXPECT_GT(arrived->frame, last);
    last = arrived->frame;
    ++taken;
  }
  camera.join();
  EXPECT_EQ(last, kFrames) << "the last one is never dropped";
  EXPECT_EQ(box.counts().received, static_cast<std::uint64_t>(kFrames));
  EXPECT_EQ(taken + box.counts().dropped, static_cast<std::uint64_t>(kFrames));
}

TEST(LatestFrame, NothingIsDroppedInTurn) {
  LatestFrame<int> mailbox;
  constexpr int kFrames = 200;
  std::thread writer([&] {
    for (int i = 0; i < kFrames; ++i) mailbox.putInTurn(i);
  });
  for (int i = 0; i < kFrames; ++i) {
    const auto taken = mailbox.take(10s);
    ASSERT_TRUE(taken);
    EXPECT_EQ(taken->frame, i);
  }
  writer.join();
  EXPECT_EQ(mailbox.counts().dropped, 0u);
}

TEST(LatestFrame, CloseEndsTheWaitForOnesTurn) {
  LatestFrame<int> mailbox;
  mailbox.put(1);
  std::thread writer([&] { mailbox.putInTurn(2); });
  std::this_thread::sleep_for(20ms);
  mailbox.close();
  writer.join();
  EXPECT_EQ(mailbox.counts().received, 1u);
}

}  // namespace
}  // namespace facetloc::test
