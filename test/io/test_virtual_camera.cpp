// SPDX-License-Identifier: BSD-3-Clause
//
// Our driver of OpenNI2: sequences and simulated scenes as devices.
#include "example_sequence.h"
#include "grabbed_frames.h"
#include "watchdog.h"

#include <facetloc/io/oni_file.h>

#include <OpenNI.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sys/mount.h>

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;

class VirtualCamera : public InAFolder {
protected:
  std::string sequence(const ExampleSequence& sequence = {}) {
    return sequence.write(folder_ / "sequence").string();
  }
  std::string scene(const std::string& content, const std::string& name = "a.scene") {
    return putBytes(folder_ / name, content).string();
  }
  std::string cause(const std::string& device) {
    return ioErrorOf([&] { OpenNIGrabber grabber(device); });
  }
  /** All frames of a device, one by one. */
  std::vector<GrabbedFrame> triggered(OpenNIGrabber& grabber, std::size_t count) {
    const GrabbedFrames frames(grabber);
    grabber.trigger(0);
    grabber.start();
    for (std::size_t i = 1; i <= count; ++i) {
      grabber.trigger(1);
      if (!frames.waitFor(i)) ADD_FAILURE() << "frame " << i << " of " << count << " does not come";
      if (HasFailure()) break;
    }
    EXPECT_TRUE(count < 5 || waitUntil([&] { return grabber.isEndOfFile(); }));
    grabber.stop();
    return frames.frames();
  }
  /** All frames of a sequence as a recording. */
  fs::path recorded(const ExampleSequence& example) {
    const fs::path file = folder_ / "a.oni";
    const auto frames = static_cast<std::size_t>(example.frames);
    OpenNIGrabber grabber(sequence(example));
    grabber.trigger(0);  // which the recorder would start
    OniRecorder recorder(grabber.uri(), file);
    EXPECT_EQ(triggered(grabber, frames).size(), frames);
    EXPECT_FALSE(fs::exists(file));
    EXPECT_EQ(recorder.stop(), frames);
    EXPECT_EQ(recorder.stop(), frames);
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
    return file;
  }

  const Watchdog watchdog_;
};

TEST_F(VirtualCamera, DeliversEachImageOnceWhenTriggered) {
  ExampleSequence sequence;
  sequence.frames = 300;
  OpenNIGrabber grabber(this->sequence(sequence));
  const auto frames = triggered(grabber, 300);
  ASSERT_EQ(frames.size(), 300u);
  for (int i = 0; i < 300; ++i) {
    const GrabbedFrame& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.index, i + 1);
    EXPECT_NEAR(1e-6 * static_cast<double>(frame.stamp), sequence.stamp(i), 1e-6);
    for (int v = 0; v < 48; ++v)
      for (int u = 0; u < 64; ++u)
        ASSERT_EQ(frame.depth[static_cast<std::size_t>(64 * v + u)], sequence.millimetres(i, u, v));
  }
}

TEST_F(VirtualCamera, PlaysInRealTimeOnce) {
  ExampleSequence sequence;
  sequence.frames = 30;
  sequence.rate = 30;
  OpenNIGrabber grabber(this->sequence(sequence));
  EXPECT_EQ(grabber.getFramesPerSecond(), 30);
  const GrabbedFrames grabbed(grabber);
  const auto begin = std::chrono::steady_clock::now();
  grabber.start();
  EXPECT_FALSE(grabber.isEndOfFile());
  ASSERT_TRUE(grabbed.waitFor(1));
  ASSERT_TRUE(waitUntil([&] { return grabber.isEndOfFile(); }));
  const auto time = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(time, 29 * 33ms);
  const auto frames = grabbed.frames();  // all of them, unless the machine is busy
  for (std::size_t i = 1; i < frames.size(); ++i) EXPECT_GT(frames[i].index, frames[i - 1].index);
  EXPECT_EQ(frames.back().index, 30);
  EXPECT_FALSE(grabber.isRunning());
  grabber.start();  // does nothing
  EXPECT_FALSE(grabber.isRunning());
}

TEST_F(VirtualCamera, RepeatsAndSpeedsUpOnRequest) {
  ExampleSequence sequence;
  sequence.frames = 10;
  OpenNIGrabber grabber(this->sequence(sequence));
  EXPECT_TRUE(grabber.isFile());
  const GrabbedFrames grabbed(grabber);
  const auto timeOfImages = [&](double speed) {
    grabber.setPlayback(speed, true);
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_TRUE(grabbed.waitFor(grabbed.size() + 20));
    return std::chrono::steady_clock::now() - begin;
  };
  grabber.setPlayback(5, true);
  grabber.start();
  const auto fast = timeOfImages(5), slow = timeOfImages(0.5);
  EXPECT_LT(fast, slow);
  EXPECT_FALSE(grabber.isEndOfFile());
  grabber.stop();
  const auto frames = grabbed.frames();
  const auto back = std::adjacent_find(frames.begin(), frames.end(),
                                       [](const auto& a, const auto& b) { return b.stamp < a.stamp; });
  EXPECT_NE(back, frames.end());
  EXPECT_THAT(ioErrorOf([&] { grabber.setPlayback(-3, true); }), HasSubstr("cannot be played so"));
}

TEST_F(VirtualCamera, GoesOnWhereItWasStopped) {
  OpenNIGrabber grabber(sequence());
  EXPECT_EQ(triggered(grabber, 3).size(), 3u);
  const auto next = triggered(grabber, 2);
  ASSERT_EQ(next.size(), 2u);
  EXPECT_NEAR(1e-6 * static_cast<double>(next[0].stamp), ExampleSequence().stamp(3), 1e-6);
}

TEST_F(VirtualCamera, LeavesOutImagesThatCannotBeReadAndSaysSo) {
  const ExampleSequence example;
  const std::string folder = sequence(example);
  const fs::path broken = example.image(folder, 2);
  putBytes(broken, bytesOf(broken).substr(0, 100));
  OpenNIGrabber grabber(folder);
  EXPECT_EQ(grabber.lastError(), "");
  const auto frames = triggered(grabber, 19);
  ASSERT_EQ(frames.size(), 19u);
  EXPECT_EQ(frames[2].stamp, static_cast<std::uint64_t>(std::llround(1e6 * example.stamp(3))));
  EXPECT_THAT(grabber.lastError(), HasSubstr(broken.string()));
  EXPECT_TRUE(grabber.isConnected());
}

TEST_F(VirtualCamera, SurvivesTheLossOfItsFolder) {
  const std::string folder = sequence();
  {
    OpenNIGrabber grabber(folder);
    const GrabbedFrames grabbed(grabber);
    grabber.start();
    ASSERT_TRUE(grabbed.waitFor(1));
    fs::remove_all(folder);
    EXPECT_TRUE(waitUntil([&] { return grabber.isEndOfFile(); }));
    EXPECT_THAT(grabber.lastError(), HasSubstr(folder));
  }
  EXPECT_THAT(cause(folder), HasAll(folder, "does not exist"));
}

TEST_F(VirtualCamera, ReportsItsFieldsOfViewToOpenNI2) {
  const ExampleSequence example;
  const std::string folder = sequence(example);
  ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
  openni::Device device;
  ASSERT_EQ(device.open(folder.c_str()), openni::STATUS_OK) << openni::OpenNI::getExtendedError();
  openni::VideoStream depth;
  ASSERT_EQ(depth.create(device, openni::SENSOR_DEPTH), openni::STATUS_OK);
  EXPECT_NEAR(64 / (2 * std::tan(depth.getHorizontalFieldOfView() / 2)), example.camera.fx, 1e-4);
  EXPECT_NEAR(48 / (2 * std::tan(depth.getVerticalFieldOfView() / 2)), example.camera.fy, 1e-4);
  EXPECT_EQ(depth.getVideoMode().getPixelFormat(), openni::PIXEL_FORMAT_DEPTH_1_MM);
  EXPECT_GT(depth.getMaxPixelValue(), 10000);
  EXPECT_FALSE(depth.getMirroringEnabled());
  EXPECT_NE(depth.setMirroringEnabled(true), openni::STATUS_OK);
  EXPECT_NE(depth.setCropping(0, 0, 8, 8), openni::STATUS_OK);
  EXPECT_EQ(device.getPlaybackControl()->getNumberOfFrames(depth), 20);
  depth.destroy();
  device.close();
  openni::OpenNI::shutdown();
}

TEST_F(VirtualCamera, DrivesThroughSimulatedPlaces) {
  const std::string content = "scene = office  # a comment\nrun=map\nseed = 3\nwidth = 80\nframes = 12\n";
  std::vector<std::vector<GrabbedFrame>> runs;
  for (const char* name : {"a.scene", "b.scene"}) {
    OpenNIGrabber grabber(scene(content, name));
    EXPECT_NEAR(grabber.focalLength(), 73.1, 0.1);
    EXPECT_EQ(grabber.getFramesPerSecond(), 30);
    runs.push_back(triggered(grabber, 12));
    ASSERT_EQ(runs.back().size(), 12u);
  }
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(runs[0][i].depth, runs[1][i].depth);  // the same seed, the same images
    if (i > 0) {
      EXPECT_NE(runs[0][i].depth, runs[0][i - 1].depth);
    }
    EXPECT_EQ(runs[0][i].stamp, static_cast<std::uint64_t>(std::llround(1e6 * static_cast<double>(i) / 30)));
    const auto& depth = runs[0][i].depth;
    const auto measured = std::count_if(depth.begin(), depth.end(), [](int z) { return z > 0; });
    EXPECT_GT(measured, static_cast<std::ptrdiff_t>(depth.size() / 4));
  }
}

TEST_F(VirtualCamera, ReportsAKnownMountingOfItsCamera) {
  const OpenNIGrabber driven(
      scene("scene = room\nframes = 3\ncamera_height = 1.2\ncamera_tilt_deg = 7\n", "a.scene"));
  ASSERT_TRUE(driven.mounting());
  EXPECT_EQ(driven.mounting()->height, 1.2);
  EXPECT_EQ(driven.mounting()->tilt_deg, 7);
  const fs::path folder = sequence(ExampleSequence());
  {
    const OpenNIGrabber unknown(folder);
    EXPECT_FALSE(unknown.mounting());
  }
  CameraFile file = readCameraFile(folder / "camera.ini");
  file.camera.mounting = CameraMounting{0.98, 10, -3.5, 90, 0.25, -0.125};
  writeCameraFile(folder / "camera.ini", file);
  EXPECT_EQ(OpenNIGrabber(folder).mounting()->T_b_c().matrix(), file.camera.mounting->T_b_c().matrix());
}

/** Where a jump leads is where the drive would have been. */
TEST_F(VirtualCamera, JumpsWhenTheSceneSaysSo) {
  const std::string drive =
      "scene = office\nwidth = 40\nnoise_factor = 0\nquantization = 0\nrandom_dropout = 0\n";
  OpenNIGrabber straight(scene(drive + "frames = 40\n", "a.scene"));
  OpenNIGrabber jumps(scene(drive + "frames = 10\njump_at = 5\njump = 30\n", "b.scene"));
  const auto all = triggered(straight, 40), some = triggered(jumps, 10);
  ASSERT_EQ(all.size(), 40u);
  ASSERT_EQ(some.size(), 10u);
  const auto difference = [](const GrabbedFrame& a, const GrabbedFrame& b) {
    std::size_t pixels = 0;
    for (std::size_t i = 0; i < a.depth.size(); ++i) pixels += std::abs(a.depth[i] - b.depth[i]) > 5;
    return pixels;
  };
  EXPECT_EQ(difference(some[4], all[4]), 0u);
  EXPECT_LT(difference(some[5], all[35]), some[5].depth.size() / 5);  // but for the patches that are lost
  EXPECT_GT(difference(some[5], all[5]), some[5].depth.size() / 4);
}

TEST_F(VirtualCamera, NamesFaultsOfAScene) {
  EXPECT_THAT(cause(scene("")), HasAll("a.scene", "has no scene"));
  EXPECT_THAT(cause(scene("# x\nscene = moon\n")), HasAll("line 2", "unknown scene 'moon'", "office"));
  EXPECT_THAT(cause(scene("scene = office\nwidht = 3\n")), HasSubstr("unknown key 'widht'"));
  EXPECT_THAT(cause(scene("scene = office\nwidth = wide\n")), HasSubstr("'wide' is not a number"));
  EXPECT_THAT(cause(scene("scene = office\nwidth = 3\n")), HasSubstr("width = 3 is impossible"));
  EXPECT_THAT(cause(scene("scene = office\nwidth = 80.5\n")), HasSubstr("whole number"));
  EXPECT_THAT(cause(scene("scene = office\nspeed = -1\n")), HasSubstr("speed = -1 is impossible"));
  EXPECT_THAT(cause(scene("scene = office\nscene = home\n")), HasSubstr("given twice"));
  EXPECT_THAT(cause(scene("office\n")), HasSubstr("expected key = value at 'office'"));
}

TEST_F(VirtualCamera, IsAnnouncedOnlyOnRequest) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // a process of its own, in which OpenNI2 starts anew
  const auto opens = [&](const char* announced) {
    if (announced) setenv("FACETLOC_ANNOUNCE_CAMERA", announced, 1);
    const std::string said = cause("");
    std::fprintf(stderr, "said: %s\n", said.c_str());
    std::_Exit(said.empty() ? 0 : 2);
  };
  const std::string folder = sequence();
  EXPECT_EXIT(opens(folder.c_str()), testing::ExitedWithCode(0), "said: ");
  EXPECT_EXIT(opens(nullptr), testing::ExitedWithCode(2), "no depth camera is connected");
}

TEST_F(VirtualCamera, IsRecordedBitByBit) {
  ExampleSequence example;
  example.frames = 30;
  const fs::path file = recorded(example);
  const OniFile oni = OniFile::open(file);
  ASSERT_EQ(oni.size(), 30u);
  EXPECT_NEAR(oni.camera().fx, example.camera.fx, 1e-4);
  EXPECT_NEAR(oni.camera().fy, example.camera.fy, 1e-4);
  EXPECT_FALSE(oni.mirrored());
  EXPECT_EQ(oni.bytes(), fs::file_size(file));
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(oni.read(static_cast<std::size_t>(i)).depth, example.image(i).depth) << i;
    EXPECT_NEAR(oni.stamp(static_cast<std::size_t>(i)) - oni.stamp(0), i / example.rate, 2e-6);
  }
  OpenNIGrabber player(file.string());  // and OpenNI2 itself can play it
  const GrabbedFrames played(player);
  player.start();
  ASSERT_TRUE(waitUntil([&] { return player.isEndOfFile(); }));
  ASSERT_GE(played.size(), 15u);
  for (const GrabbedFrame& frame : played.frames())
    EXPECT_EQ(frame.depth, oni.readRaw(static_cast<std::size_t>(frame.index - 1))) << frame.index;
}

TEST_F(VirtualCamera, IsPlayedInMillimetresWhateverTheUnitOfItsRecording) {
  ExampleSequence example;
  example.frames = 10;
  std::string bytes = bytesOf(recorded(example));
  const std::string name("oniPixelFormat\0\x08\0\0\0", 19);
  const std::size_t unit = bytes.find(name);
  ASSERT_NE(unit, std::string::npos);
  ASSERT_EQ(bytes[unit + name.size()], 100);
  bytes[unit + name.size()] = 101;  // 100 um
  const OniFile oni = OniFile::open(putBytes(folder_ / "b.oni", bytes));
  OpenNIGrabber player(folder_ / "b.oni");
  const GrabbedFrames played(player);
  player.start();
  ASSERT_TRUE(waitUntil([&] { return player.isEndOfFile(); }));
  ASSERT_GE(played.size(), 5u);
  for (const GrabbedFrame& frame : played.frames()) {
    const std::vector<float> metres = oni.read(static_cast<std::size_t>(frame.index - 1)).depth;
    for (std::size_t i = 0; i < metres.size(); ++i) ASSERT_NEAR(1e-3 * frame.depth[i], metres[i], 0.51e-3);
  }
}

/** A disk of that size in memory, as long as it lives. */
class SmallDisk {
public:
  SmallDisk(const fs::path& folder, const std::string& size) : folder_(folder) {
    fs::create_directory(folder);
    mounted_ = mount("tmpfs", folder.c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool mounted() const { return mounted_; }

private:
  fs::path folder_;
  bool mounted_ = false;
};

TEST_F(VirtualCamera, KeepsTheFramesWrittenAndReportsAFullDisk) {
  const SmallDisk disk(folder_ / "disk", "32k");
  if (!disk.mounted()) GTEST_SKIP() << "no right to mount a disk";
  ExampleSequence example;
  example.frames = 60;
  OpenNIGrabber grabber(sequence(example));
  grabber.trigger(0);
  const fs::path file = folder_ / "disk" / "a.oni";
  OniRecorder recorder(grabber.uri(), file);
  EXPECT_TRUE(recorder.hasRoom());
  EXPECT_EQ(triggered(grabber, 60).size(), 60u);
  EXPECT_FALSE(recorder.hasRoom());
  EXPECT_THAT(ioErrorOf([&] { recorder.stop(); }), HasSubstr("the disk is full"));
  const OniFile oni = OniFile::open(file);
  EXPECT_LT(oni.size(), 60u);
  for (std::size_t i = 0; i < oni.size(); ++i)
    EXPECT_EQ(oni.read(i).depth, example.image(static_cast<int>(i)).depth) << i;
}

TEST_F(VirtualCamera, IsNotRecordedWhereThatIsImpossible) {
  OpenNIGrabber grabber(sequence());
  EXPECT_THAT(ioErrorOf([&] { OniRecorder recorder(grabber.uri(), folder_ / "none" / "a.oni"); }),
              HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { OniRecorder recorder("nothing", folder_ / "a.oni"); }), HasSubstr("nothing"));
  grabber.trigger(0);
  OniRecorder recorder(grabber.uri(), folder_ / "b.oni");
  EXPECT_EQ(recorder.stop(), 0u);
  EXPECT_FALSE(fs::exists(folder_ / "b.oni"));
}

}  // namespace
}  // namespace facetloc::test
