// SPDX-License-Identifier: BSD-3-Clause
// The processing of a live run, fed without a camera.
#include "live/live_findings.h"
#include "live/live_session.h"
#include "process.h"

#include <facetloc/testing/synthetic_views.h>

#include <pcl/io/grabber.h>
#include <pcl/io/image_depth.h>

#include <condition_variable>

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;

/** A grabber without depth images. */
class FakeGrabber : public pcl::Grabber {
public:
  void start() override {}
  void stop() override {}
  bool isRunning() const override { return true; }
  std::string getName() const override { return "FakeGrabber"; }
  float getFramesPerSecond() const override { return 30; }
};

/** A camera whose frames need not have as many pixels as they say. */
class FakeCamera : public FakeGrabber {
public:
  using Picture = pcl::io::DepthImage;

  FakeCamera() : pictures_(createSignal<void(const Picture::Ptr&)>()) {}
  void deliver(std::vector<std::uint16_t> pixels) {
    (*pictures_)(pcl::make_shared<Picture>(pcl::make_shared<Frame>(std::move(pixels)), 0.f, 2.f, 0, 0));
  }

private:
  struct Frame : pcl::io::FrameWrapper {
    explicit Frame(std::vector<std::uint16_t> pixels) : pixels_(std::move(pixels)) {}
    const void* getData() const override { return pixels_.data(); }
    unsigned getDataSize() const override { return static_cast<unsigned>(2 * pixels_.size()); }
    unsigned getWidth() const override { return 4; }
    unsigned getHeight() const override { return 3; }
    unsigned getFrameID() const override { return 1; }
    std::uint64_t getTimestamp() const override { return 0; }
    std::vector<std::uint16_t> pixels_;
  };

  boost::signals2::signal<void(const Picture::Ptr&)>* pictures_;
};

/** The answers of a session, in their order. */
class Answers {
public:
  LiveSession::OnResult sink() {
    return [this](const LiveResultPtr& result) {
      const std::lock_guard<std::mutex> lock(mutex_);
      results_.push_back(result);
      changed_.notify_all();
    };
  }
  std::vector<LiveResultPtr> wait(std::size_t n) {
    std::unique_lock<std::mutex> lock(mutex_);
    EXPECT_TRUE(changed_.wait_for(lock, 60s, [&] { return results_.size() >= n; }))
        << results_.size() << " of " << n;
    return results_;
  }
  std::size_t count() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return results_.size();
  }

private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<LiveResultPtr> results_;
};

const Eigen::Isometry3d kFirstPose = lookingAlong({1, 1.5, 1.2}, {1, 0.7, -0.2});

/** The camera goes slowly to the right. */
Eigen::Isometry3d poseAt(int frame) { return kFirstPose * Eigen::Translation3d(0.01 * frame, 0, 0); }

DepthImage imageAt(int frame) {
  const DepthImage image = render(largeRoom(), smallCamera(), poseAt(frame)).image;
  return noisy(image, SensorNoise{}.inverse_depth_std, static_cast<unsigned>(frame));
}

std::shared_ptr<const Map> mapOfTheRoom() {
  auto map = std::make_shared<Map>();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Isometry3d T_w_m = kFirstPose * Eigen::Translation3d(0.15 * i, 0, 0) *
                                    Eigen::AngleAxisd(0.05 * i, Eigen::Vector3d::UnitY());
    map->models.emplace_back("model " + std::to_string(i), 0, T_w_m,
                             viewFrom(largeRoom(), T_w_m, 1000u + static_cast<unsigned>(i)));
  }
  return map;
}

LiveFrame frameOf(DepthImage image, double stamp) {
  return {stamp, [image = std::move(image)] { return image; }};
}

class LiveSessionTest : public testing::Test {
protected:
  LiveSessionTest() { options_.oldest_frame_ms = 60000; }  // however busy the machine is
  /** Frame after frame, each when the one before is done. */
  std::vector<LiveResultPtr> feed(LiveSession& session, int frames) {
    for (int i = 0; i < frames; ++i) {
      session.mailbox().put(frameOf(imageAt(i), 100 + i / 30.0));
      answers_.wait(static_cast<std::size_t>(i) + 1);
    }
    session.finish();
    return answers_.wait(static_cast<std::size_t>(frames));
  }

  Answers answers_;
  LiveSessionOptions options_;
};

TEST(LiveFindings, AreOfSomeOfTheFirstFrames) {
  const Intrinsics camera{40, 30, 40, 40, 19.5, 14.5};
  LiveFindings findings({});
  for (int number = 1; number <= 30; ++number) {
    DepthImage image;
    image.camera = camera;
    for (int i = 0; i < camera.width * camera.height; ++i)
      image.depth.push_back(0.04F + 0.0001F * static_cast<float>((i + number) % 100));
    findings.add(static_cast<std::uint64_t>(number), image);
  }
  EXPECT_THAT(findings.take(), IsEmpty()) << "not enough frames yet";
  findings.finish();
  const Findings found = findings.take();
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.front().id, "values.scale");
  EXPECT_EQ(found.front().severity, Severity::refusal);
  EXPECT_THAT(findings.take(), IsEmpty()) << "each once";
}

TEST_F(LiveSessionTest, SegmentsWithoutAMap) {
  LiveSession session(options_, nullptr, answers_.sink());
  const auto results = feed(session, 3);
  ASSERT_EQ(results.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const LiveResult& r = *results[i];
    EXPECT_EQ(r.number, i + 1);
    EXPECT_EQ(r.state(), "segmenting");
    EXPECT_GE(r.image.view.segments.size(), 5u);
    EXPECT_EQ(r.image.labels.maxLabel(), static_cast<int>(r.image.view.segments.size()));
    EXPECT_NEAR(r.stamp, 100 + static_cast<double>(i) / 30, 1e-5);
    EXPECT_NEAR(r.image.depth.camera.fx, smallCamera().fx, 0.5);
    EXPECT_EQ(r.dropped, 0u);
  }
  EXPECT_EQ(results[0]->image.name, "100.000000");
  EXPECT_THAT(session.summary().states, ElementsAre(Key("segmenting")));
}

TEST_F(LiveSessionTest, FindsAndFollowsTheCamera) {
  LiveSession session(options_, mapOfTheRoom(), answers_.sink());
  const auto results = feed(session, 12);
  int localized = 0;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (!results[i]->isLocalized()) continue;
    ++localized;
    ASSERT_TRUE(results[i]->pose());
    const Eigen::Isometry3d error = poseAt(static_cast<int>(i)).inverse() * results[i]->pose()->T;
    EXPECT_LT(error.translation().norm(), 0.05) << i;
    EXPECT_LT(Eigen::AngleAxisd(error.linear()).angle(), 1.0 * kDegree) << i;
  }
  EXPECT_GE(localized, 10);
  EXPECT_EQ(results.back()->state(), "tracking");
  EXPECT_FALSE(results.back()->trajectory.lines().empty());
  EXPECT_THAT(session.summary().text(), HasSubstr("tracking"));
}

TEST_F(LiveSessionTest, RelocalizesWhenAsked) {
  LiveSession session(options_, mapOfTheRoom(), answers_.sink());
  const auto put = [&](int i) {
    session.mailbox().put(frameOf(imageAt(i), i / 30.0));
    return answers_.wait(static_cast<std::size_t>(i) + 1).back()->state();
  };
  std::string state;
  for (int i = 0; i < 6; ++i) state = put(i);
  EXPECT_EQ(state, "tracking");
  session.relocalize();
  EXPECT_NE(put(6), "tracking");
}

TEST_F(LiveSessionTest, AnOldFrameIsDropped) {
  options_.oldest_frame_ms = LiveSessionOptions().oldest_frame_ms;
  LiveSession session(options_, nullptr, answers_.sink());
  session.setPaused(true);
  session.mailbox().put(frameOf(imageAt(0), 1));
  std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(1.5 * options_.oldest_frame_ms));
  session.setPaused(false);
  // On a busy machine later frames may grow old as well.
  for (int i = 2; answers_.count() == 0 && i < 600; ++i) {
    session.mailbox().put(frameOf(imageAt(1), i));
    std::this_thread::sleep_for(100ms);
  }
  session.finish();
  const LiveResultPtr first = answers_.wait(1).front();
  EXPECT_GE(first->stamp, 2) << "not the one that had grown old";
  EXPECT_LE(first->age_ms, options_.oldest_frame_ms);
  EXPECT_GE(first->dropped, 1u);
  EXPECT_GE(first->received, first->dropped + 1);
}

TEST_F(LiveSessionTest, NoFrameOfARecordingIsTooOld) {
  options_.oldest_frame_ms = 1;
  options_.every_frame = true;
  LiveSession session(options_, nullptr, answers_.sink());
  session.setPaused(true);
  session.mailbox().put(frameOf(imageAt(0), 1));
  std::this_thread::sleep_for(50ms);
  session.setPaused(false);
  session.finish([] {});
  EXPECT_EQ(session.summary().processed, 1u);
}

/** Also of the frame that the thread was waiting for when the pause began. */
TEST_F(LiveSessionTest, WhilePausedNothingIsProcessed) {
  LiveSession session(options_, nullptr, answers_.sink());
  std::this_thread::sleep_for(30ms);  // it waits for a frame now
  session.setPaused(true);
  for (int i = 0; i < 3; ++i) {
    session.mailbox().put(frameOf(imageAt(i), i));
    std::this_thread::sleep_for(150ms);
  }
  EXPECT_EQ(answers_.count(), 0u);
  EXPECT_EQ(session.summary().received, 3u);
}

TEST_F(LiveSessionTest, EndsAfterEnoughFrames) {
  options_.max_frames = 2;
  LiveSession session(options_, nullptr, answers_.sink());
  for (int i = 0; i < 2; ++i) {
    session.mailbox().put(frameOf(imageAt(i), i));
    answers_.wait(static_cast<std::size_t>(i) + 1);
  }
  EXPECT_TRUE(eventually([&] { return session.done(); }));
  session.mailbox().put(frameOf(imageAt(2), 3));
  session.finish();
  EXPECT_EQ(session.summary().processed, 2u);
  EXPECT_EQ(session.summary().received, 2u);
}

TEST_F(LiveSessionTest, TheLastFrameOfAFileIsProcessed) {
  for (int round = 0; round < 20; ++round) {
    Answers answers;
    LiveSession session(options_, nullptr, answers.sink());
    session.mailbox().put(frameOf({}, 1));
    session.finish();
    EXPECT_EQ(session.summary().processed, 1u);
  }
}

TEST_F(LiveSessionTest, TimeGoesOnWhenARecordingIsRepeated) {
  LiveSession session(options_, nullptr, answers_.sink());
  const std::vector<double> stamps = {5.0, 5.1, 5.0, 5.1};
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    session.mailbox().put(frameOf(imageAt(0), stamps[i]));
    answers_.wait(i + 1);
  }
  const auto results = answers_.wait(4);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_GT(results[i]->stamp, results[i - 1]->stamp);
  EXPECT_NE(results[0]->image.name, results[2]->image.name);
}

TEST_F(LiveSessionTest, ExceptionsOfSinksAreRethrown) {
  LiveSession session(options_, nullptr, [](const LiveResultPtr&) { throw std::runtime_error("disk full"); });
  session.mailbox().put(frameOf(imageAt(0), 1));
  EXPECT_TRUE(eventually([&] { return session.done(); }));
  EXPECT_THROW(session.finish(), std::runtime_error);
}

TEST_F(LiveSessionTest, ExceptionsOfFramesAreRethrown) {
  LiveSession session(options_, nullptr, answers_.sink());
  session.mailbox().put({1, []() -> DepthImage { throw std::runtime_error("not organized"); }});
  EXPECT_THROW(session.finish(), std::runtime_error);
}

TEST_F(LiveSessionTest, LetsGoOfFrames) {
  LiveSession session(options_, nullptr, answers_.sink());
  const auto buffer = std::make_shared<DepthImage>(imageAt(0));
  const std::weak_ptr<DepthImage> watched = buffer;
  for (int i = 0; i < 50; ++i)
    session.mailbox().put({double(i), [copy = std::make_shared<DepthImage>(*buffer)] { return *copy; }});
  session.mailbox().put({50, [buffer] { return *buffer; }});
  session.letGo();
  EXPECT_EQ(watched.use_count(), 1) << "only the test itself";
}

TEST_F(LiveSessionTest, CanBeDestroyedAtAnyTime) {
  for (int i = 0; i < 20; ++i) {
    LiveSession session(options_, nullptr, answers_.sink());
    session.mailbox().put(frameOf(imageAt(0), i));
    std::this_thread::sleep_for(std::chrono::milliseconds(i));
  }
}

TEST(ConnectFrames, RefusesAGrabberWithoutDepth) {
  FakeGrabber grabber;
  EXPECT_THROW(connectFrames(grabber, {}, [](LiveFrame) {}), std::runtime_error);
}

TEST(ConnectFrames, TheGivenCameraGoesFirst) {
  FakeCamera camera;
  LiveFrame last;
  connectFrames(camera, Intrinsics{8, 6, 10, 12, 3.5, 2.5},
                [&](LiveFrame frame) { last = std::move(frame); });
  camera.deliver(std::vector<std::uint16_t>(12, 1500));
  EXPECT_EQ(last.image().camera, (Intrinsics{8, 6, 10, 12, 3.5, 2.5}.subsampled(2)));

  FakeCamera other;
  connectFrames(other, Intrinsics{100, 100, 50, 50, 50, 50},
                [&](LiveFrame frame) { last = std::move(frame); });
  other.deliver(std::vector<std::uint16_t>(12, 1500));
  EXPECT_THROW(last.image(), std::runtime_error) << "a calibration of another camera";
}

/** PCL would copy the wrong number of bytes. */
TEST(ConnectFrames, ImagesOfAWrongLengthAreRefused) {
  FakeCamera camera;
  LiveFrame last;
  connectFrames(camera, {}, [&](LiveFrame frame) { last = std::move(frame); });
  camera.deliver(std::vector<std::uint16_t>(12, 1500));
  EXPECT_THAT(last.image().depth, Each(1.5f));
  for (const std::size_t pixels : {0, 11, 13, 100000}) {
    camera.deliver(std::vector<std::uint16_t>(pixels, 1500));
    EXPECT_THROW(last.image(), std::runtime_error) << pixels;
  }
}

}  // namespace
}  // namespace facetloc::test
