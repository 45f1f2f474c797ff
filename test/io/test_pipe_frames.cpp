// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/error.h>
#include <facetloc/io/frame_grabber.h>
#include <facetloc/io/pipe_frames.h>
#include <facetloc/io/v4l2_frames.h>

#include <atomic>
#include <fcntl.h>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>

namespace facetloc::test {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kSoon(2000), kAtOnce(20);

/** A pipe into which a test writes. */
class Pipe {
public:
  Pipe() { EXPECT_EQ(::pipe(ends_), 0); }
  ~Pipe() {
    close();
    ::close(ends_[0]);
  }
  int out() const { return ends_[0]; }
  void write(const std::string& bytes) {
    EXPECT_EQ(::write(ends_[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void close() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }

private:
  int ends_[2] = {-1, -1};
};

const std::string kCamera = R"(,"fx":3.5,"fy":3.25,"cx":1.5,"cy":1)";

std::string header(double stamp, const std::string& more = kCamera) {
  return "{\"stamp\":" + std::to_string(stamp) + ",\"width\":4,\"height\":3" + more + "}\n";
}

std::string pixels(int first) {
  std::string bytes;
  for (int i = 0; i < 12; ++i) {
    const int value = first + 257 * i;
    bytes += static_cast<char>(value & 0xff);
    bytes += static_cast<char>(value >> 8);
  }
  return bytes;
}

std::string faultOf(const std::string& bytes, int frames = 1) {
  Pipe pipe;
  PipeFrames source(pipe.out(), "the pipe");
  std::thread writer([&] {  // more than a pipe holds
    pipe.write(bytes);
    pipe.close();
  });
  const std::string fault = ioErrorOf([&] {
    for (int i = 0; i < frames; ++i) source.next(kSoon);
  });
  EXPECT_TRUE(fault.empty() || source.hasFailed());
  writer.join();
  return fault;
}

TEST(PipeFrames, AreReadAsTheyAreWritten) {
  Pipe pipe;
  pipe.write(header(1.5, kCamera + R"(,"depth_scale":2000,"gravity":[0,9.81,0],"gravity_std_deg":2)") +
             pixels(1000));
  pipe.write(header(2.5, "") + pixels(7));
  pipe.close();
  PipeFrames source(pipe.out(), "the pipe");
  const auto camera = source.camera(kSoon);
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->camera.intrinsics, (Intrinsics{4, 3, 3.5, 3.25, 1.5, 1}));
  const auto first = source.next(kSoon), second = source.next(kSoon);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->number, 1u);
  EXPECT_EQ(first->stamp, 1.5);
  ASSERT_TRUE(first->gravity);
  EXPECT_TRUE(first->gravity->down.isApprox(Eigen::Vector3d::UnitY(), 1e-12));
  EXPECT_NEAR(first->gravity->std, 2 * kDegree, 1e-12);
  FrameConverter convert;
  const DepthImage image = convert(*first);
  ASSERT_TRUE(image.valid());
  for (int i = 0; i < 12; ++i) EXPECT_FLOAT_EQ(image.depth[i], static_cast<float>((1000 + 257 * i) / 2000.0));
  EXPECT_EQ(second->number, 2u);
  EXPECT_EQ(second->stamp, 2.5);
  EXPECT_FALSE(second->gravity);
  EXPECT_EQ(second->values[0], 7);
  EXPECT_FALSE(source.atEnd());
  EXPECT_FALSE(source.next(kSoon));
  EXPECT_TRUE(source.atEnd());
}

/** Bytes come when they come. */
TEST(PipeFrames, MayComeByteByByte) {
  Pipe pipe;
  PipeFrames source(pipe.out(), "the pipe");
  const std::string bytes = header(1) + pixels(500);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_FALSE(source.next(milliseconds(0))) << i;
    pipe.write(bytes.substr(i, 1));
  }
  const auto frame = source.next(kSoon);
  ASSERT_TRUE(frame);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(frame->values[i], 500 + 257 * i);
  EXPECT_FALSE(source.next(kAtOnce)) << "and there is no endless wait";
  EXPECT_FALSE(source.atEnd());
}

TEST(PipeFrames, HandOnLinesOfAnotherKindInTheirOrder) {
  Pipe pipe;
  pipe.write("{\"relocalize\":true}\n" + header(1) + pixels(1) + "{\"pose\":1}\n\n" + header(2, "") +
             pixels(2));
  pipe.close();
  PipeFrames source(pipe.out(), "the pipe");
  std::vector<std::string> seen;
  ASSERT_TRUE(source.camera(kSoon));  // before anybody wants lines
  source.setLines([&](const std::string& line) { seen.push_back(line); });
  EXPECT_THAT(seen, ElementsAre("{\"relocalize\":true}"));
  ASSERT_TRUE(source.next(kSoon));
  EXPECT_EQ(seen.size(), 1u);
  ASSERT_TRUE(source.next(kSoon));
  EXPECT_EQ(seen.back(), "{\"pose\":1}");
}

TEST(PipeFrames, OfAPresetHaveItsUsualIntrinsicsAndNoise) {
  const CameraPreset& preset = *findCameraPreset("realsense_d435");
  const Intrinsics usual = preset.intrinsics();
  Pipe pipe;
  pipe.write("{\"stamp\":0,\"width\":" + std::to_string(usual.width) +
             ",\"height\":" + std::to_string(usual.height) + ",\"camera\":\"realsense_d435\"}\n");
  PipeFrames source(pipe.out(), "the pipe");
  const auto camera = source.camera(kSoon);
  ASSERT_TRUE(camera);
  EXPECT_NEAR(camera->camera.intrinsics.fx, usual.fx, 1e-9);
  EXPECT_EQ(camera->camera.noise.inverse_depth_std, preset.camera().noise.inverse_depth_std);
}

TEST(PipeFrames, OfAKnownCameraAreOfItAndMayBeSmaller) {
  CameraFile known;
  known.camera.intrinsics = {8, 6, 7, 6.5, 3, 2};
  known.depth_scale = 5000;
  Pipe pipe;
  pipe.write(header(0) + pixels(5000));
  PipeFrames source(pipe.out(), "the pipe", known);
  const auto frame = source.next(kSoon);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->camera->camera.intrinsics, (known.camera.intrinsics.subsampled(2)));
  EXPECT_FLOAT_EQ(FrameConverter()(*frame).depth[0], 1.f);
  Pipe other;
  other.write("{\"stamp\":0,\"width\":5,\"height\":3}\n");
  PipeFrames wrong(other.out(), "the pipe", known);
  EXPECT_THROW(wrong.camera(kSoon), IoError);
}

TEST(PipeFrames, ThatAreTornSayWhichOne) {
  const std::string sound = header(1) + pixels(1);
  EXPECT_EQ(faultOf(sound), "");
  EXPECT_THAT(faultOf(sound + sound.substr(0, 20), 2), HasSubstr("the pipe: frame 2: is torn"));
  EXPECT_THAT(faultOf(sound + sound.substr(0, sound.size() - 1), 2), HasSubstr("frame 2: is torn"));
  EXPECT_THAT(faultOf(header(1)), HasSubstr("frame 1: is torn: the pipe ends 24 bytes before"));
  EXPECT_THAT(faultOf(sound + pixels(10) + "\n", 2), HasSubstr("frame 2: its header cannot be used"));
  EXPECT_THAT(faultOf(sound + std::string(1 << 17, 'x'), 2), HasSubstr("frame 2: a line of more than"));
}

TEST(PipeFrames, ThatAreHostileSayWhy) {
  const auto of = [](const std::string& inner) { return faultOf("{" + inner + "}\n"); };
  const std::string size = R"("stamp":0,"width":4,"height":3)";
  EXPECT_THAT(of(R"("width":4,"height":3)"), HasSubstr("no stamp"));
  EXPECT_THAT(of(R"("stamp":"now","width":4,"height":3)"), HasSubstr("stamp is no number"));
  for (const char* stamp : {"1e300", "-1e300", "1732708800000000000"})  // the last one in nanoseconds
    EXPECT_THAT(of(std::string("\"stamp\":") + stamp + R"(,"width":4,"height":3)"),
                HasSubstr("impossible: it is a time in seconds"))
        << stamp;
  EXPECT_THAT(of(R"("stamp":0,"width":4)"), HasSubstr("no height"));
  EXPECT_THAT(of(R"("stamp":0,"width":-4,"height":3)"), HasSubstr("width of -4"));
  EXPECT_THAT(of(R"("stamp":0,"width":4.5,"height":3)"), HasSubstr("width of 4.5"));
  EXPECT_THAT(of(R"("stamp":0,"width":1e300,"height":3)"), HasSubstr("impossible"));
  EXPECT_THAT(of(R"("stamp":0,"width":16384,"height":16384)"), HasSubstr("more than any depth camera has"));
  EXPECT_THAT(of(size), HasSubstr("nothing is known of the camera"));
  EXPECT_THAT(of(size + R"(,"fx":3.5)"), HasSubstr("has no fy"));
  EXPECT_THAT(of(size + R"(,"fx":-1,"fy":1,"cx":1,"cy":1)"), HasSubstr("fx = -1 is impossible"));
  EXPECT_THAT(of(size + R"(,"camera":"no_such")"), HasSubstr("unknown camera 'no_such'"));
  EXPECT_THAT(of(size + R"(,"camera":[1])"), HasSubstr("neither number nor name"));
  EXPECT_THAT(of(size + kCamera + R"(,"depth_scale":0)"), HasSubstr("depth_scale"));
  EXPECT_THAT(of(size + kCamera + R"(,"gravity":[0,0])"), HasSubstr("three numbers"));
  EXPECT_THAT(of(size + kCamera + R"(,"gravity":[0,0,0])"), HasSubstr("frame 1"));
  EXPECT_THAT(faultOf(header(1) + pixels(1) + header(2, R"(,"fx":9)"), 2),
              HasSubstr("frame 2: its header cannot be used: its fx is 9"));
}

/** No size in a header is believed before the bytes are there. */
TEST(PipeFrames, ThatAreAnnouncedTakeNoMemory) {
  Pipe pipe;
  const auto peak = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;  // [kB]
  };
  PipeFrames source(pipe.out(), "the pipe");
  EXPECT_FALSE(source.next(milliseconds(0)));
  const long before = peak();
  pipe.write(R"({"stamp":0,"width":4096,"height":4096)" + kCamera + "}\n");
  EXPECT_FALSE(source.next(kAtOnce));
  EXPECT_LT(peak() - before, 8192) << "of 32768 kB";
}

/** As after a program that was killed while it read. */
TEST(PipeFrames, BeginAfterTheRestOfAFrame) {
  Pipe pipe;
  std::string rest = pixels(0x0a0a).substr(5) + "{\"" + pixels(9) + "\n" + pixels(3);
  pipe.write(rest + header(4) + pixels(40) + header(5, "") + pixels(50));
  PipeFrames source(pipe.out(), "the pipe");
  for (const int i : {4, 5}) {
    const auto frame = source.next(kSoon);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->stamp, i);
    EXPECT_EQ(frame->values[0], 10 * i);
  }
}

TEST(PipeFrames, DoNotBeginInNoiseWithoutEnd) {
  TemporaryFolder folder;
  const std::string path = folder / "noise";
  std::ofstream(path, std::ios::binary) << std::string(std::size_t(40) << 20, '\x07');
  const int file = ::open(path.c_str(), O_RDONLY);
  PipeFrames source(file, path);
  EXPECT_THROW(while (!source.atEnd()) source.next(kSoon), IoError);
  ::close(file);
}

TEST(FrameGrabber, DeliversFramesAndClouds) {
  Pipe pipe;
  FrameGrabber grabber(std::make_shared<PipeFrames>(pipe.out(), "the pipe"));
  std::vector<DepthFrame::ConstPtr> frames;
  std::vector<pcl::PointCloud<pcl::PointXYZ>::ConstPtr> clouds;
  grabber.registerCallback<FrameGrabber::OnFrame>(
      [&](const DepthFrame::ConstPtr& f) { frames.push_back(f); });
  grabber.registerCallback<FrameGrabber::OnCloud>(
      [&](const pcl::PointCloud<pcl::PointXYZ>::ConstPtr& c) { clouds.push_back(c); });
  grabber.start();
  pipe.write(header(1) + pixels(0) + header(2, "") + pixels(1000));
  pipe.close();
  for (int i = 0; i < 200 && !grabber.atEnd(); ++i) std::this_thread::sleep_for(milliseconds(10));
  ASSERT_TRUE(grabber.atEnd());
  EXPECT_FALSE(grabber.isRunning());
  EXPECT_EQ(grabber.lastError(), "");
  ASSERT_EQ(frames.size(), 2u);
  ASSERT_EQ(clouds.size(), 2u);
  EXPECT_EQ(clouds[1]->header.stamp, 2000000u);
  EXPECT_TRUE(std::isnan((*clouds[0])(0, 0).z)) << "0 is not measured";
  const pcl::PointXYZ& p = (*clouds[1])(2, 1);  // depth 1 + 6 * 0.257
  EXPECT_FLOAT_EQ(p.z, 2.542f);
  EXPECT_FLOAT_EQ(p.x, 2.542f * 0.5f / 3.5f);
  EXPECT_FLOAT_EQ(p.y, 0.f);
}

TEST(FrameGrabber, WaitsUntilFramesAreAskedForAndGoesOnAfterAStop) {
  Pipe pipe;
  FrameGrabber grabber(std::make_shared<PipeFrames>(pipe.out(), "the pipe"));
  std::atomic<int> frames{0};
  grabber.registerCallback<FrameGrabber::OnFrame>([&](const DepthFrame::ConstPtr&) { ++frames; });
  pipe.write(header(1) + pixels(1) + header(2, "") + pixels(2) + header(3, "") + pixels(3).substr(0, 9));
  const auto reaches = [&](int n) {
    for (int i = 0; i < 200 && frames < n; ++i) std::this_thread::sleep_for(milliseconds(10));
    std::this_thread::sleep_for(kAtOnce);
    return frames == n;
  };
  grabber.trigger(1);
  grabber.start();
  EXPECT_TRUE(reaches(1));
  grabber.trigger(2);
  EXPECT_TRUE(reaches(2));
  grabber.stop();
  pipe.write(pixels(3).substr(9));
  grabber.start();
  EXPECT_TRUE(reaches(3)) << "the part that had come before is not lost";
}

TEST(FrameGrabber, ReportsATornFrame) {
  Pipe pipe;
  FrameGrabber grabber(std::make_shared<PipeFrames>(pipe.out(), "the pipe"));
  grabber.start();
  pipe.write(header(1) + pixels(1) + header(2, "") + "x");
  pipe.close();
  for (int i = 0; i < 200 && grabber.isRunning(); ++i) std::this_thread::sleep_for(milliseconds(10));
  EXPECT_FALSE(grabber.isRunning());
  EXPECT_FALSE(grabber.atEnd());
  EXPECT_THAT(grabber.lastError(), HasSubstr("frame 2: is torn"));
}

/** Frames of a video device, from a file. */
class V4l2File : public InAFolder {
protected:
  std::string write(const std::string& bytes) {
    const std::string path = folder_ / "walk.z16";
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  static CameraFile camera() {
    CameraFile file;
    file.camera.intrinsics = {4, 3, 3.5, 3.25, 1.5, 1};
    return file;
  }
};

TEST_F(V4l2File, IsReadFrameByFrame) {
  const std::string path = write(pixels(100) + pixels(200));
  EXPECT_TRUE(V4l2Frames::reads(path));
  V4l2Frames source(path, camera());
  EXPECT_FALSE(source.isLive());
  for (int i = 0; i < 2; ++i) {
    const auto frame = source.next(kSoon);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->number, static_cast<std::uint64_t>(i + 1));
    EXPECT_DOUBLE_EQ(frame->stamp, i / 30.0);
    for (int k = 0; k < 12; ++k) EXPECT_EQ(frame->values[k], 100 * (i + 1) + 257 * k);
  }
  EXPECT_TRUE(source.atEnd());
  EXPECT_FALSE(source.next(kSoon));
}

TEST_F(V4l2File, ThatIsTornOrOfNoCameraSaysSo) {
  V4l2Frames torn(write(pixels(100) + pixels(200).substr(1)), camera());
  ASSERT_TRUE(torn.next(kSoon));
  EXPECT_THAT(ioErrorOf([&] { torn.next(kSoon); }), HasSubstr("frame 2: is torn: it has 23 bytes of 24"));
  EXPECT_THROW(V4l2Frames(write(pixels(1)), CameraFile()), IoError);
  EXPECT_THROW(V4l2Frames(write(""), camera()), IoError);
}

TEST(V4l2Device, AnotherFileIsRefused) {
  EXPECT_TRUE(V4l2Frames::reads("/dev/null"));
  EXPECT_THAT(ioErrorOf([] { V4l2Frames("/dev/null", CameraFile()); }),
              HasSubstr("/dev/null: is no video device"));
}

}  // namespace
}  // namespace facetloc::test
