// SPDX-License-Identifier: BSD-3-Clause
//
// With the real OpenNI2 library and our driver: nothing that is done to a grabber crashes, hangs or leaks.
#include "example_sequence.h"
#include "grabbed_frames.h"
#include "watchdog.h"

#include <facetloc/testing/places.h>

#include <atomic>
#include <cmath>
#include <random>
#include <stdexcept>

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using OnCloud = void(const Cloud::ConstPtr&);

/** The resources of the process. */
struct Holdings {
  long files = 0, threads = 0, memory_kb = 0;

  static Holdings now() {
    Holdings h;
    h.files = std::distance(fs::directory_iterator("/proc/self/fd"), {});
    h.threads = std::distance(fs::directory_iterator("/proc/self/task"), {});
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
      if (word == "VmRSS:") status >> h.memory_kb;
    return h;
  }
};

class Grabber : public InAFolder {
protected:
  std::string source(const ExampleSequence& sequence = {}) {
    return sequence.write(folder_ / "sequence").string();
  }
  std::string cause(const std::string& device,
                    OpenNIGrabber::Mode mode = OpenNIGrabber::OpenNI_Default_Mode) {
    return ioErrorOf([&] { OpenNIGrabber grabber(device, mode); });
  }

  const Watchdog watchdog_;
};

/** The plain grabber of PCL crashes or hangs within 60 such rounds. */
TEST_F(Grabber, IsOpenedStartedStoppedAndDestroyedHundredsOfTimes) {
  const std::string device = source();
  std::mt19937 random(1);
  std::uniform_int_distribution<int> while_running(0, 12);  // [ms]; an image comes every 10 ms
  constexpr int kRounds = 300, kWarmUp = 60;
  Holdings before;
  std::atomic<int> begun = 0;
  for (int round = 0; round < kRounds; ++round) {
    if (round == kWarmUp) before = Holdings::now();
    OpenNIGrabber grabber(device);
    grabber.setPlayback(1, true);
    const bool slow = round % 10 == 0;  // more than one image arrives meanwhile
    grabber.registerCallback<OnCloud>([&begun, slow](const Cloud::ConstPtr&) {
      ++begun;
      if (slow) std::this_thread::sleep_for(25ms);
    });
    const int before_start = begun;
    grabber.start();
    if (slow) {
      EXPECT_TRUE(waitUntil([&] { return begun > before_start; }));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(while_running(random)));
    if (round % 3 == 0) grabber.stop();
    if (round % 7 == 0) grabber.start();
  }
  const Holdings after = Holdings::now();
  EXPECT_LE(after.files, before.files);
  EXPECT_LE(after.threads, before.threads + 3);  // those that last are as many as were ever needed at once
  EXPECT_LE(after.memory_kb, before.memory_kb + 8 * 1024);
}

TEST_F(Grabber, ReopensRecordingsAsWell) {
  const auto recording = dataFolder("oni") / "kinect_12_frames.oni";
  if (!fs::exists(recording)) GTEST_SKIP() << "no data at " << recording << "; see FACETLOC_DATA";
  std::atomic<int> clouds = 0;
  for (int round = 0; round < 30; ++round) {
    OpenNIGrabber grabber(recording.string());
    grabber.setPlayback(round % 2 ? 1 : 4, round % 3 == 0);
    grabber.registerCallback<OnCloud>([&clouds](const Cloud::ConstPtr&) { ++clouds; });
    const int before = clouds;
    grabber.start();
    if (round % 10 == 9) {
      EXPECT_TRUE(waitUntil([&] { return clouds > before; }));
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(7 * (round % 10)));
    }
    if (round % 4 == 0) grabber.stop();
  }
}

/** The player decodes such a frame to whatever length comes out, or crashes. */
TEST_F(Grabber, RefusesRecordingsWithCorruptFrames) {
  const auto recording = dataFolder("oni") / "redkitchen_60_frames_depth_only.oni";
  if (!fs::exists(recording)) GTEST_SKIP() << "no data at " << recording << "; see FACETLOC_DATA";
  constexpr std::size_t kDifferences = 111914;  // differences in the first frame
  std::string bytes = bytesOf(recording);
  bytes[kDifferences] = '\xFE';  // thirty more pixels of the same depth
  const auto path = putBytes(folder_ / "corrupt.oni", bytes).string();
  EXPECT_THAT(ioErrorOf([&] { OpenNIGrabber grabber(path); }), HasAll("corrupt.oni", "frame 0 is corrupt"));
}

TEST_F(Grabber, StopsInAnyOrderAnyNumberOfTimes) {
  OpenNIGrabber grabber(source());
  grabber.setPlayback(1, true);
  const GrabbedFrames frames(grabber);
  grabber.stop();
  EXPECT_FALSE(grabber.isRunning());
  for (int i = 0; i < 5; ++i) {
    const std::size_t before = frames.size();
    grabber.start();
    grabber.start();
    EXPECT_TRUE(grabber.isRunning());
    EXPECT_TRUE(frames.waitFor(before + 3));
    grabber.stop();
    grabber.stop();
    const std::size_t stopped = frames.size();
    std::this_thread::sleep_for(30ms);
    EXPECT_EQ(frames.size(), stopped);
    EXPECT_FALSE(grabber.isRunning());
  }
  EXPECT_EQ(grabber.lastError(), "");
}

TEST_F(Grabber, StopWaitsForTheCallbackOfAnotherThread) {
  std::atomic<bool> inside = false;
  std::atomic<int> calls = 0;
  OpenNIGrabber grabber(source());
  grabber.setPlayback(1, true);
  grabber.registerCallback<OnCloud>([&](const Cloud::ConstPtr&) {
    inside = true;
    std::this_thread::sleep_for(40ms);
    ++calls;
    inside = false;
  });
  for (int i = 0; i < 10; ++i) {
    grabber.start();
    ASSERT_TRUE(waitUntil([&] { return inside.load(); }));
    std::thread other([&] { grabber.stop(); });
    grabber.stop();
    EXPECT_FALSE(inside);
    other.join();
    const int stopped = calls;
    std::this_thread::sleep_for(25ms);
    EXPECT_EQ(calls, stopped);
  }
}

/** OpenNI2 on its own reads the memory of threads that have called it and have ended; the C library gives it
 * back when some of them have. */
TEST_F(Grabber, IsUsedByThreadsThatComeAndGo) {
  OpenNIGrabber grabber(source());
  grabber.setPlayback(1, true);
  const GrabbedFrames frames(grabber);
  for (int i = 0; i < 10; ++i) {
    std::vector<std::thread> threads;
    for (int k = 0; k < 12; ++k)
      threads.emplace_back([&grabber, k] {
        k % 2 ? grabber.start() : grabber.stop();
        grabber.setPlayback(1 + k, true);
        EXPECT_EQ(grabber.lastError(), "");
      });
    for (std::thread& thread : threads) thread.join();
  }
  const std::size_t before = frames.size();
  grabber.start();
  EXPECT_TRUE(frames.waitFor(before + 3));
}

TEST_F(Grabber, IsStoppedByItsOwnCallback) {
  std::atomic<int> calls = 0;
  OpenNIGrabber grabber(source());
  grabber.setPlayback(1, true);
  grabber.registerCallback<OnCloud>([&](const Cloud::ConstPtr&) {
    ++calls;
    grabber.stop();
  });
  for (int i = 1; i <= 5; ++i) {
    grabber.start();
    EXPECT_TRUE(waitUntil([&] { return calls == i; }));
    std::this_thread::sleep_for(30ms);
    EXPECT_EQ(calls, i);
  }
}

TEST_F(Grabber, SurvivesExceptionsOfCallbacks) {
  std::atomic<int> calls = 0;
  OpenNIGrabber grabber(source());
  grabber.setPlayback(1, true);
  grabber.registerCallback<OnCloud>([&](const Cloud::ConstPtr&) {
    if (++calls % 2) throw std::runtime_error("out of cheese");
    throw 5;
  });
  testing::internal::CaptureStderr();  // PCL's console says it as well
  grabber.start();
  EXPECT_TRUE(waitUntil([&] { return calls >= 3; }));
  grabber.stop();
  testing::internal::GetCapturedStderr();
  EXPECT_THAT(grabber.lastError(), HasSubstr("a callback threw"));
  EXPECT_TRUE(grabber.isConnected());
}

TEST_F(Grabber, DeliversCloudsWithTheCameraOfTheSequence) {
  const ExampleSequence sequence;
  std::mutex mutex;
  Cloud::ConstPtr first;
  OpenNIGrabber grabber(source(sequence));
  EXPECT_NEAR(grabber.focalLength(), sequence.camera.fx, 1e-6);
  EXPECT_EQ(grabber.getFramesPerSecond(), 100);
  EXPECT_EQ(grabber.getName(), "OpenNI2Grabber");
  grabber.registerCallback<OnCloud>([&](const Cloud::ConstPtr& cloud) {
    const std::lock_guard lock(mutex);
    if (!first) first = cloud;
  });
  grabber.start();
  grabber.trigger(1);
  ASSERT_TRUE(waitUntil([&] {
    const std::lock_guard lock(mutex);
    return first != nullptr;
  }));
  const int i = static_cast<int>(first->header.seq) - 1;
  EXPECT_NEAR(1e-6 * static_cast<double>(first->header.stamp), sequence.stamp(i), 1e-6);
  ASSERT_EQ(first->width, 64u);
  ASSERT_EQ(first->height, 48u);
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) {
      const pcl::PointXYZ& p = first->at(u, v);
      const int z = sequence.millimetres(i, u, v);
      if (z == 0) {
        EXPECT_TRUE(std::isnan(p.z));
        continue;
      }
      const Eigen::Vector3d expected = sequence.camera.ray(u, v) * (z / 1000.0);
      ASSERT_NEAR((p.getVector3fMap().cast<double>() - expected).norm(), 0, 1e-5) << u << " " << v;
    }
}

TEST_F(Grabber, IsOutlivedByItsFrames) {
  const ExampleSequence sequence;
  std::mutex mutex;
  std::vector<pcl::io::DepthImage::Ptr> kept;
  {
    OpenNIGrabber grabber(source(sequence));
    grabber.registerCallback<void(const pcl::io::DepthImage::Ptr&)>(
        [&](const pcl::io::DepthImage::Ptr& image) {
          const std::lock_guard lock(mutex);
          kept.push_back(image);
        });
    grabber.start();
    EXPECT_TRUE(waitUntil([&] { return grabber.isEndOfFile(); }));
  }
  ASSERT_GE(kept.size(), 3u);
  std::thread([&] {
    for (const auto& image : kept) {
      const int i = static_cast<int>(image->getFrameID()) - 1;
      for (int v = 0; v < 48; ++v)
        for (int u = 0; u < 64; ++u) ASSERT_EQ(image->getData()[64 * v + u], sequence.millimetres(i, u, v));
    }
    kept.clear();
  }).join();
}

TEST_F(Grabber, SaysWhyADeviceCannotBeOpened) {
  EXPECT_THAT(cause("/nowhere/a.oni"), HasSubstr("/nowhere/a.oni: does not exist"));
  EXPECT_THAT(cause("a.scene"), HasSubstr("does not exist"));
  const auto junk = putBytes(folder_ / "junk.oni", "no recording").string();
  EXPECT_THAT(cause(junk), HasAll(junk, "no .oni recording"));
  const auto text = putBytes(folder_ / "notes.txt", "no recording").string();
  EXPECT_THAT(cause(text), HasAll(text, "no driver of OpenNI2 can open it"));
  fs::create_directories(folder_ / "empty");
  EXPECT_THAT(cause((folder_ / "empty").string()), HasSubstr("has no depth images"));
  ExampleSequence().write(folder_ / "blind");
  fs::remove(folder_ / "blind" / "camera.ini");
  EXPECT_THAT(cause((folder_ / "blind").string()), HasSubstr("camera.ini"));
  EXPECT_THAT(cause(source(), OpenNIGrabber::OpenNI_SXGA_15Hz), HasSubstr("no such depth mode"));
  EXPECT_THAT(cause((folder_ / std::string(250, 'x')).string() + "/a.oni"), HasSubstr("does not exist"));
  const auto deep = folder_ / std::string(200, 'x') / std::string(100, 'y');
  EXPECT_THAT(cause(ExampleSequence().write(deep).string()), HasSubstr("longer than"));
  EXPECT_THAT(cause("#999"), HasSubstr("#999"));  // those opened before are known, sorted by path
}

/** Runs in a process of its own, as a device that has been opened by its path is known from then on. */
TEST_F(Grabber, SaysThatNoDeviceIsConnected) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const std::string said = cause("");
        std::fprintf(stderr, "%s\n", said.c_str());
        std::_Exit(said.empty() ? 1 : 0);
      },
      testing::ExitedWithCode(0), "depth camera: no depth camera is connected .drivers: .*OpenNI2/Drivers");
}

TEST_F(Grabber, TriggersOnlyOurCamera) {
  const auto recording = dataFolder("oni") / "kinect_12_frames.oni";
  if (!fs::exists(recording)) GTEST_SKIP() << "no data at " << recording << "; see FACETLOC_DATA";
  OpenNIGrabber grabber(recording.string());
  EXPECT_THAT(ioErrorOf([&] { grabber.trigger(1); }), HasSubstr("no virtual camera"));
}

}  // namespace
}  // namespace facetloc::test
