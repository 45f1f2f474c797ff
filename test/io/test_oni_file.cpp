// SPDX-License-Identifier: BSD-3-Clause
//
// Recordings as batch input: real ones where they are there, and the faults of bad ones.
#include "example_sequence.h"
#include "grabbed_frames.h"
#include "oni_writer.h"
#include "watchdog.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/oni_file.h>
#include <facetloc/testing/places.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <thread>

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;

std::string raw(std::initializer_list<std::uint16_t> depth) {
  std::string bytes;
  for (const std::uint16_t z : depth) bytes += OniWriter::packed(z);
  return bytes;
}

/** A recording of 4x2 pixels with colour beside it. */
OniWriter start(bool old = false) {
  OniWriter writer(old);
  writer.node(7, 3, "JPEG").mode(7, 640, 480).node(5, 2, "NONE").mode(5, 4, 2).view(5, 1.0, 0.5);
  return writer;
}
const std::string kImage = raw({0, 1000, 1001, 1002, 2000, 2001, 2002, 65535});

class OniFiles : public InAFolder {
protected:
  fs::path file(const std::string& bytes) { return putBytes(folder_ / "a.oni", bytes); }
  std::string errorOf(const std::string& bytes) {
    return ioErrorOf([&] { OniFile::open(file(bytes)).read(0); });
  }
};

/** As a recorder leaves it that is killed: cut anywhere, or with room behind it that was never filled. */
TEST_F(OniFiles, AreReadAsFarAsTheyGo) {
  const std::string one = start().frame(5, 0, kImage).bytes();
  const std::string two = start().frame(5, 0, kImage).frame(5, 33333, kImage).bytes();
  for (std::size_t size = one.size(); size < two.size(); ++size) {
    const OniFile oni = OniFile::open(file(two.substr(0, size)));
    EXPECT_EQ(oni.size(), 1u) << size;
    EXPECT_FALSE(oni.finished());
    EXPECT_EQ(oni.bytes(), one.size());
  }
  const OniFile with_room = OniFile::open(file(two + std::string(100000, '\0')));
  EXPECT_EQ(with_room.size(), 2u);
  EXPECT_FALSE(with_room.finished());
  EXPECT_THAT(DepthSequence::open(file(two)).remark(), HasSubstr("never finished"));
  EXPECT_TRUE(OniFile::open(file(start().frame(5, 0, kImage).end())).finished());
}

TEST_F(OniFiles, HaveDepthAndTimesAndTheCameraOfTheirFieldOfView) {
  for (const bool old : {false, true}) {
    const OniFile oni = OniFile::open(
        file(start(old).frame(7, 0, "colour").frame(5, 1500000, kImage).frame(5, 1600000, kImage).end()));
    ASSERT_EQ(oni.size(), 2u);
    EXPECT_DOUBLE_EQ(oni.stamp(0), 1.5);
    EXPECT_DOUBLE_EQ(oni.stamp(1), 1.6);
    EXPECT_EQ(oni.rate(), 30);
    EXPECT_FALSE(oni.mirrored());
    EXPECT_NEAR(oni.camera().fx, 2 / std::tan(0.5), 1e-12);
    EXPECT_NEAR(oni.camera().fy, 1 / std::tan(0.25), 1e-12);
    EXPECT_EQ(oni.camera().cx, 1.5);
    EXPECT_EQ(oni.camera().cy, 0.5);
    const DepthImage image = oni.read(1);
    EXPECT_THAT(image.depth, ElementsAre(0.f, 1.f, 1.001f, 1.002f, 2.f, 2.001f, 2.002f, 65.535f));
    EXPECT_THROW(oni.read(2), std::out_of_range);
  }
}

TEST_F(OniFiles, AreReadInTheirStatedUnit) {
  auto writer = start();
  const OniFile oni = OniFile::open(
      file(writer.property(5, "oniPixelFormat", 101).property(5, "xnMirror", 1).frame(5, 0, kImage).end()));
  EXPECT_FLOAT_EQ(oni.read(0).depth[1], 0.1f);
  EXPECT_EQ(oni.readRaw(0)[1], 1000);
  EXPECT_TRUE(oni.mirrored());
}

/** One of each kind: two small differences, a longer one, a number, more of the same, an odd end. */
TEST_F(OniFiles, OfDifferencesAreDecoded) {
  OniWriter writer;
  writer.node(1, 2, "16zP").mode(1, 3, 3).view(1, 1, 1);
  const std::string code = raw({1000}) + "\x57" + "\x6F" + "\x9D" + "\xE1" + "\xFF" + "\x12\x34" + "\x6D";
  const OniFile oni = OniFile::open(file(writer.frame(1, 0, code).end()));
  EXPECT_THAT(oni.readRaw(0), ElementsAre(1000, 1001, 1000, 1000, 1035, 1035, 1035, 0x1234, 0x1234));
}

TEST_F(OniFiles, WithFaultsNameThem) {
  EXPECT_THAT(errorOf("nothing"), HasAll("a.oni", "no .oni recording"));
  EXPECT_THAT(errorOf(std::string(1000, 'x')), HasSubstr("no .oni recording"));
  EXPECT_THAT(errorOf(""), HasSubstr("no .oni recording"));
  EXPECT_THAT(errorOf(start().bytes()), HasSubstr("is truncated, and has no depth frames"));
  EXPECT_THAT(errorOf(start().frame(7, 0, "colour").end()), HasSubstr("no depth frames"));
  EXPECT_THAT(errorOf(OniWriter().node(1, 3, "JPEG").frame(1, 0, "x").end()), HasSubstr("no depth stream"));
  EXPECT_THAT(errorOf(start().frame(5, 0, "short").end()), HasSubstr("frame 0 is corrupt"));
  EXPECT_THAT(errorOf(OniWriter().node(1, 2, "WHAT").end()), HasSubstr("unknown coding 'WHAT'"));
  EXPECT_THAT(errorOf(start().property(5, "oniPixelFormat", 102).end()), HasSubstr("unknown unit"));
  EXPECT_THAT(errorOf(start().property(5, "xnCropping", raw({1, 0, 0, 2, 2, 0})).end()),
              HasSubstr("cropped"));
  EXPECT_THAT(errorOf(start().frame(5, 0, kImage).mode(5, 2, 4).end()), HasSubstr("changes its size"));
  EXPECT_THAT(errorOf(OniWriter().node(1, 2, "NONE").mode(1, 0, 9).end()), HasSubstr("impossible size"));
  for (const std::uint32_t node : {5u, 7u})  // OpenNI2 crashes on a property of such a name
    EXPECT_THAT(errorOf(start().property(node, "M\xEDrror", 1).frame(5, 0, kImage).end()),
                HasSubstr("corrupt at byte"));
  EXPECT_THAT(ioErrorOf([&] { OniFile::open(folder_ / "none.oni"); }), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { OniFile::open(folder_.path()); }), HasSubstr("is a folder"));
}

/** Whatever a file is cut off or changed to, it is refused or read, and nothing else happens. */
TEST_F(OniFiles, ThatAreCutOrChangedAreRefusedOrRead) {
  OniWriter writer;
  writer.node(1, 2, "16zT").mode(1, 3, 2).view(1, 1, 1);
  const std::string code = raw({2, 500, 900, 0}) + "\x66" + "\xE1" + "\x5D";
  const std::string whole = OniWriter(writer).frame(1, 0, code).end();
  EXPECT_EQ(errorOf(whole), "");
  const std::size_t frame_ends = writer.frame(1, 0, code).bytes().size();
  for (std::size_t i = 0; i < whole.size(); ++i)
    EXPECT_EQ(errorOf(whole.substr(0, i)) == "", i >= frame_ends) << "cut at " << i;
  for (std::size_t i = 0; i < whole.size(); ++i)
    for (const int change : {1, 0x80, 0xFF}) {
      std::string changed = whole;
      changed[i] = static_cast<char>(changed[i] ^ change);
      errorOf(changed);  // throws nothing but IoError, and does not crash
    }
}

TEST_F(OniFiles, AreSequences) {
  auto writer = start();
  const auto path = file(writer.frame(5, 1500000, kImage).frame(5, 1600001, kImage).end());
  DepthSequence sequence = DepthSequence::open(path);
  ASSERT_EQ(sequence.frames().size(), 2u);
  EXPECT_EQ(sequence.frames()[1].name, "1.600001");
  EXPECT_DOUBLE_EQ(sequence.frames()[1].stamp, 1.600001);
  EXPECT_EQ(sequence.frames()[1].path, path);
  ASSERT_TRUE(sequence.camera());
  EXPECT_EQ(sequence.camera()->camera.intrinsics, OniFile::open(path).camera());
  EXPECT_EQ(sequence.load(0).depth[1], 1.f);
  EXPECT_EQ(sequence.load(0, 2).camera.width, 2);

  CameraFile file;
  file.camera.intrinsics = {4, 2, 3.5, 3.4, 1.6, 0.6};
  file.camera.noise.inverse_depth_std = 0.01;
  writeCameraFile(folder_ / "camera.ini", file);
  sequence = DepthSequence::open(path);
  EXPECT_EQ(sequence.load(0).camera, file.camera.intrinsics);  // the better known camera goes first
  EXPECT_EQ(sequence.camera()->camera.noise.inverse_depth_std, 0.01);
}

TEST_F(OniFiles, WithTimesThatDoNotGoOnHaveNumbers) {
  const auto path = file(start().frame(5, 100, kImage).frame(5, 100, kImage).frame(5, 50, kImage).end());
  const DepthSequence sequence = DepthSequence::open(path);
  ASSERT_EQ(sequence.frames().size(), 3u);
  EXPECT_EQ(sequence.frames()[2].name, "frame_2");
  EXPECT_EQ(sequence.frames()[2].stamp, 2);
}

TEST_F(OniFiles, WithoutAFieldOfViewNeedACameraFile) {
  OniWriter writer;
  const auto path = file(writer.node(1, 2, "NONE").mode(1, 4, 2).frame(1, 0, kImage).end());
  EXPECT_THAT(ioErrorOf([&] { DepthSequence::open(path); }), HasSubstr("camera.ini"));
}

struct Recording {
  const char* name;
  std::size_t frames;
  int width;
  double focal_length;

  friend void PrintTo(const Recording& of, std::ostream* out) { *out << of.name; }
};

class Recordings : public testing::TestWithParam<Recording> {
protected:
  void SetUp() override {
    path_ = dataFolder("oni") / GetParam().name;
    if (!fs::exists(path_)) GTEST_SKIP() << "no data at " << path_ << "; see FACETLOC_DATA";
  }
  fs::path path_;
};

TEST_P(Recordings, HaveAllFramesTheSameEachTimeInAnyOrder) {
  const DepthSequence sequence = DepthSequence::open(path_), again = DepthSequence::open(path_);
  const std::size_t n = sequence.frames().size();
  ASSERT_EQ(n, GetParam().frames);
  EXPECT_EQ(sequence.camera()->camera.intrinsics.width, GetParam().width);
  EXPECT_NEAR(sequence.camera()->camera.intrinsics.fx, GetParam().focal_length, 0.5);
  std::vector<DepthImage> images(n);
  std::vector<std::thread> readers;  // all at once
  for (int k = 0; k < 3; ++k)
    readers.emplace_back([&, k] {
      for (std::size_t i = static_cast<std::size_t>(k); i < n; i += 3) images[i] = sequence.load(i);
    });
  for (std::thread& reader : readers) reader.join();
  for (std::size_t i = n; i-- > 0;) {
    ASSERT_TRUE(images[i].valid());
    EXPECT_EQ(images[i].depth, again.load(i).depth) << i;
    const auto measured = std::count_if(images[i].depth.begin(), images[i].depth.end(), isMeasured);
    EXPECT_GT(measured, static_cast<std::ptrdiff_t>(images[i].depth.size() / 2)) << i;
    if (i > 0) {
      EXPECT_GT(sequence.frames()[i].stamp, sequence.frames()[i - 1].stamp);
    }
  }
}

/** OpenNI2's own player is the judge of the content of a recording. */
TEST_P(Recordings, ArePlayedByOpenNI2WithTheSameDepth) {
  const Watchdog watchdog;
  const OniFile oni = OniFile::open(path_);
  OpenNIGrabber grabber(path_.string());
  EXPECT_TRUE(grabber.isFile());
  EXPECT_NEAR(grabber.focalLength(), oni.camera().fx, 1e-3);
  EXPECT_EQ(grabber.getFramesPerSecond(), oni.rate());
  grabber.setPlayback(0.5, false);  // speed at which a busy machine loses few frames
  const GrabbedFrames grabbed(grabber);
  grabber.start();
  ASSERT_TRUE(waitUntil([&] { return grabber.isEndOfFile(); }));
  EXPECT_FALSE(grabber.isRunning());
  const auto frames = grabbed.frames();
  EXPECT_GE(frames.size(), GetParam().frames / 2);
  for (const GrabbedFrame& frame : frames)
    EXPECT_EQ(frame.depth, oni.readRaw(static_cast<std::size_t>(frame.index - 1))) << frame.index;
}

INSTANTIATE_TEST_SUITE_P(OfDevices, Recordings,
                         testing::Values(Recording{"kinect_12_frames.oni", 12, 640, 575.8},
                                         Recording{"primesense_24_frames.oni", 24, 640, 570.3},
                                         Recording{"redkitchen_60_frames_depth_only.oni", 60, 640, 585}),
                         [](const auto& of) {
                           return std::string(of.param.name, strcspn(of.param.name, "_"));
                         });

}  // namespace
}  // namespace facetloc::test
