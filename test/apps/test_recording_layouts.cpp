// SPDX-License-Identifier: BSD-3-Clause
// A stranger's way: a recording in the layout it came in is mapped, localized, judged and drawn.
// Inputs after public reports, each with a check of the right outcome, where they lie beside the checkout.
#include "example_room.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/testing/example_bag.h>
#include <facetloc/testing/matchers.h>
#include <facetloc/testing/places.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

namespace facetloc::test {
namespace {

class Layouts : public Tools {
protected:
  static void copyCamera(const fs::path& from, const fs::path& to) {
    fs::create_directories(to);
    fs::copy_file(from / "camera.ini", to / "camera.ini");
  }

  /** Maps one folder, localizes the images of the other, and judges that. */
  void expectToWork(const std::string& mapped, const std::string& localized) {
    const std::string map = folder_ / "layout.flmap", results = folder_ / "results";
    EXPECT_THAT(ok(runMap({"build", mapped, "-o", map, "--map.distance", "0.1"})).err,
                Not(HasSubstr("no poses are given")));
    ok(runTool<localizeApp>({map, localized, "-o", results}));
    EXPECT_THAT(ok(runTool<evaluateApp>({results, localized, "--map", map})).out, HasSubstr("12 (100.00 %)"));
    const Trajectory truth = DepthSequence::readTruth(localized);
    const Trajectory found = readTrajectory(results + "/poses_tum.txt");
    EXPECT_GE(found.poses().size(), 10u);
    for (const StampedPose& pose : found.poses())
      EXPECT_LT((pose.T_w_c.translation() - truth.at(pose.stamp)->translation()).norm(), 0.1);
    const std::string first = DepthSequence::open(localized).frames().front().name;
    ok(runTool<renderApp>({localized, "-o", folder_ / "picture.png", "--map", map, "--frame", first}));
    EXPECT_TRUE(fs::exists(folder_ / "picture.png"));
  }

  /** As frame-000000.depth.png at 30 Hz. */
  std::string sevenScenes(const std::string& source, const std::string& name) {
    const fs::path folder = folder_ / name;
    copyCamera(source, folder);
    const DepthSequence sequence = DepthSequence::open(source);
    for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
      char base[32];
      std::snprintf(base, sizeof base, "frame-%06zu", i);
      fs::copy_file(sequence.frames()[i].path, folder / (std::string(base) + ".depth.png"));
      writeContent(folder / (std::string(base) + ".color.png"), "a picture that is not read");
      std::ostringstream matrix;
      matrix.precision(12);
      matrix << sequence.groundTruth().at(sequence.frames()[i].stamp)->matrix();
      writeContent(folder / (std::string(base) + ".pose.txt"), matrix.str());
    }
    return folder.string();
  }

  /** With poses beside it, and an odometry of the robot's base within. */
  std::string bag(const std::string& source, const std::string& name) {
    const fs::path folder = folder_ / name;
    fs::create_directories(folder);
    const DepthSequence sequence = DepthSequence::open(source);
    const Eigen::Isometry3d T_c_b = sequence.camera()->camera.mounting->T_b_c().inverse();
    std::vector<StampedPose> odometry;
    for (const StampedPose& pose : sequence.groundTruth().poses())
      odometry.push_back({pose.stamp, pose.T_w_c * T_c_b});
    fs::copy_file(fs::path(source) / "groundtruth.txt", folder / "groundtruth.txt");
    EXPECT_TRUE(writeBag(sequence, folder / "walk.bag", "uint16", Trajectory(odometry)));
    return (folder / "walk.bag").string();
  }

  /** As a recording of ROS 2 or RTAB-Map with camera and poses beside it. */
  std::string recorded(const std::string& source, const std::string& name, const std::string& words) {
    const fs::path folder = folder_ / name;
    copyCamera(source, folder);
    fs::copy_file(fs::path(source) / "groundtruth.txt", folder / "groundtruth.txt");
    const std::string container = words.substr(0, words.find(' '));
    const fs::path file = folder / ("walk." + (container == "rtabmap" ? "db" : container));
    const DepthSequence sequence = DepthSequence::open(source);
    EXPECT_TRUE(writeRecording(sequence, file, words, sequence.groundTruth())) << words;
    return file.string();
  }

  /** The bytes of hypotheses.csv. */
  std::string localizedIn(const std::string& mapped, const std::string& localized) {
    const std::string map = folder_ / "layout.flmap", results = folder_ / "results";
    ok(runMap({"build", mapped, "-o", map, "--overwrite", "--map.distance", "0.1"}));
    ok(runTool<localizeApp>({map, localized, "-o", results}));
    return contentOf(results + "/hypotheses.csv");
  }

  /** As a camera with a lens stores it: distances along rays. */
  std::string throughALens(const std::string& source, const std::string& name) {
    const fs::path folder = folder_ / name;
    const DepthSequence sequence = DepthSequence::open(source);
    CameraFile camera = *sequence.camera();
    camera.lens.k1 = -0.25, camera.lens.k2 = 0.08, camera.lens.p1 = 1e-3;
    camera.depth_is = DepthKind::distance;
    fs::create_directories(folder / "depth");
    writeCameraFile(folder / "camera.ini", camera);
    fs::copy_file(fs::path(source) / "groundtruth.txt", folder / "groundtruth.txt");
    for (std::size_t i = 0; i < sequence.frames().size(); ++i)
      writeDepthPng(folder / "depth" / sequence.frames()[i].path.filename(), stored(sequence.load(i), camera),
                    camera.depth_scale);
    return folder.string();
  }

  /** Each pixel at twice its column and row. */
  std::string alignedToAFinerImage(const std::string& source, const std::string& name) {
    const fs::path folder = folder_ / name;
    const DepthSequence sequence = DepthSequence::open(source);
    fs::create_directories(folder / "depth");
    for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
      const DepthImage image = sequence.load(i);
      const Intrinsics& k = image.camera;
      DepthImage fine{{2 * k.width, 2 * k.height, 2 * k.fx, 2 * k.fy, 2 * k.cx + 1, 2 * k.cy + 1}, {}};
      for (int v = 0; v < fine.camera.height; ++v)
        for (int u = 0; u < fine.camera.width; ++u)
          fine.depth.push_back(u % 2 == 1 && v % 2 == 1 ? image.at(u / 2, v / 2) : 0.f);
      CameraFile camera = *sequence.camera();
      camera.camera.intrinsics = fine.camera;
      writeCameraFile(folder / "camera.ini", camera);
      writeDepthPng(folder / "depth" / sequence.frames()[i].path.filename(), fine, camera.depth_scale);
    }
    return folder.string();
  }

  /** 000000.png, 000001.png, ... */
  std::string numbered(const std::string& source, const std::string& name, std::size_t images) {
    const fs::path folder = folder_ / name;
    copyCamera(source, folder);
    fs::create_directories(folder / "depth");
    fs::copy_file(fs::path(source) / "groundtruth.txt", folder / "groundtruth.txt");
    const DepthSequence sequence = DepthSequence::open(source);
    for (std::size_t i = 0; i < std::min(images, sequence.frames().size()); ++i) {
      const std::string number = std::to_string(i);
      fs::copy_file(sequence.frames()[i].path,
                    folder / "depth" / (std::string(6 - number.size(), '0') + number + ".png"));
    }
    return folder.string();
  }

private:
  static DepthImage stored(const DepthImage& seen, const CameraFile& camera) {
    DepthImage image{seen.camera, {}};
    for (int v = 0; v < image.camera.height; ++v)
      for (int u = 0; u < image.camera.width; ++u) {
        const auto ray = camera.lens.undistorted(image.camera.ray(u, v).head<2>());
        const Eigen::Vector2d pixel =
            ray ? seen.camera.project({ray->x(), ray->y(), 1}) : Eigen::Vector2d(-1, -1);
        const int column = static_cast<int>(std::lround(pixel.x())),
                  row = static_cast<int>(std::lround(pixel.y()));
        const bool is_seen =
            column >= 0 && row >= 0 && column < seen.camera.width && row < seen.camera.height;
        image.depth.push_back(
            is_seen ? seen.at(column, row) * static_cast<float>(std::sqrt(1 + ray->squaredNorm())) : 0.f);
      }
    return image;
  }
};

TEST_F(Layouts, SevenScenes) {
  expectToWork(sevenScenes(map_run(), "seq-01"), sevenScenes(query(), "seq-02"));
}

TEST_F(Layouts, DistancesThroughALens) {
  expectToWork(throughALens(map_run(), "a"), throughALens(query(), "b"));
}

TEST_F(Layouts, DepthAlignedToAFinerImageShowsItsPlanesAtAnyWidth) {
  const auto segmentsOf = [&](const std::string& input, const std::string& width) {
    const ToolRun run = ok(runTool<segmentApp>({input, "-o", folder_ / ("s" + width), "--width", width}));
    const auto at = run.out.find(" with ");
    return std::stoi(run.out.substr(at + 6));
  };
  const std::string sparse = alignedToAFinerImage(query(), "a");
  const int dense = segmentsOf(query(), "320");
  for (const char* width : {"320", "0"}) EXPECT_GE(segmentsOf(sparse, width), 0.8 * dense) << width;
}

TEST_F(Layouts, NumberedImagesWithAsManyPoses) {
  expectToWork(numbered(map_run(), "a", 1000), numbered(query(), "b", 1000));
}

TEST_F(Layouts, NumberedImagesWithMorePosesMakeNoMap) {
  EXPECT_THAT(runMap({"build", numbered(map_run(), "a", 8), "-o", folder_ / "a.flmap"}),
              fails("they cannot be assigned to each other"));
  EXPECT_FALSE(fs::exists(folder_ / "a.flmap"));
}

TEST_F(Layouts, AMapIsNotMadeOfAFewPosesThatNothingChecks) {
  const std::string input = folder_.copyOf(map_run(), "input");
  std::vector<StampedPose> poses = readTrajectory(input + "/groundtruth.txt").poses();
  poses.resize(2);
  writeTumTrajectory(input + "/groundtruth.txt", poses);
  EXPECT_THAT(runMap({"build", input, "-o", folder_ / "a.flmap"}),
              fails("have no pose within the tolerance", "--force"));
  ok(runMap({"build", input, "-o", folder_ / "b.flmap", "--force"}));
}

TEST_F(Layouts, PosesInAnotherConventionAreReadAsTheirCheckSays) {
  const std::string input = folder_.copyOf(map_run(), "input");
  std::vector<StampedPose> poses = readTrajectory(input + "/groundtruth.txt").poses();
  for (StampedPose& pose : poses) pose.T_w_c = pose.T_w_c.inverse();
  writeTumTrajectory(input + "/groundtruth.txt", poses);
  EXPECT_THAT(runMap({"build", input, "-o", folder_ / "a.flmap"}), fails("--poses-are inverse"));
  ok(runMap({"build", input, "-o", folder_ / "b.flmap", "--poses-are", "inverse"}));
  EXPECT_EQ(runMap({"build", input, "-o", folder_ / "c.flmap", "--poses-are", "left"}).code, kUsage);
}

TEST_F(Layouts, ResultsSayWhichFileAFrameIsFrom) {
  const std::string input = numbered(query(), "a", 3), out = folder_ / "s";
  ok(runTool<segmentApp>({input, "-o", out}));
  EXPECT_THAT(contentOf(out + "/inputs.csv"), HasAll("frame,file\n", "a/depth/000001.png"));
}

TEST_F(Layouts, Bags) {
  if (!hasBags()) GTEST_SKIP() << "no python3-rosbag to write bags with";
  expectToWork(bag(map_run(), "a"), bag(query(), "b"));
}

TEST_F(Layouts, RecordingsOfTodayGiveTheBytesOfTheirImages) {
  if (!hasRecordings()) GTEST_SKIP() << "no Python to write recordings with";
  const auto inMillimetres = [this](const std::string& source, const char* name) {
    std::string folder = folder_ / name;
    ok(runTool<convertApp>({source, "-o", folder, "--scale", "1000"}));
    return folder;
  };
  const std::string mapped = inMillimetres(map_run(), "map"), later = inMillimetres(query(), "query");
  const std::string expected = localizedIn(mapped, later);
  int n = 0;
  for (const char* words : {"db3 zstd", "db3 png", "mcap lz4 32FC1", "mcap unchunked rvl", "rtabmap 32FC1"}) {
    const std::string name = std::to_string(n++);
    EXPECT_EQ(localizedIn(recorded(mapped, "a" + name, words), recorded(later, "b" + name, words)), expected)
        << words;
  }
}

TEST_F(Layouts, AnRtabmapDatabaseNeedsNoOtherFile) {
  if (!hasRecordings()) GTEST_SKIP() << "no Python to write recordings with";
  const std::string a = recorded(map_run(), "a", "rtabmap"), b = recorded(query(), "b", "rtabmap");
  for (const char* name : {"a", "b"})
    for (const char* file : {"camera.ini", "groundtruth.txt"}) fs::remove(fs::path(folder_ / name) / file);
  expectToWork(a, b);
}

TEST_F(Layouts, TheImuOfARecordingIsTakenForGravity) {
  if (!hasRecordings()) GTEST_SKIP() << "no Python to write recordings with";
  const std::string walk = recorded(query(), "a", "mcap imu=camera_imu_optical_frame"),
                    map = folder_ / "a.flmap";
  ok(runMap({"build", map_run(), "-o", map, "--map.distance", "0.1"}));
  EXPECT_THAT(ok(runTool<localizeApp>({map, walk, "-o", folder_ / "used"})).err,
              HasSubstr("gravity is by the accelerometer of /imu"));
  EXPECT_THAT(ok(runTool<localizeApp>({map, walk, "-o", folder_ / "ignored", "--gravity", "none"})).err,
              Not(HasSubstr("accelerometer")));
}

TEST_F(Layouts, TheOdometryOfABagIsTakenForAMap) {
  if (!hasBags()) GTEST_SKIP() << "no python3-rosbag to write bags with";
  const fs::path walk = bag(map_run(), "a");
  const Trajectory truth = DepthSequence::readTruth(walk);
  fs::remove(walk.parent_path() / "groundtruth.txt");
  copyCamera(map_run(), walk.parent_path());  // which tells the mounting
  const std::string found = folder_ / "found.txt";
  ok(runMap({"build", walk, "-o", folder_ / "a.flmap", "--odometry", walk, "--trajectory", found}));
  const Trajectory mapped = readTrajectory(found);
  ASSERT_EQ(mapped.poses().size(), static_cast<std::size_t>(kFrames));
  const Eigen::Isometry3d T = *truth.at(mapped.poses()[0].stamp) * mapped.poses()[0].T_w_c.inverse();
  for (const StampedPose& pose : mapped.poses())
    EXPECT_LT(((T * pose.T_w_c).translation() - truth.at(pose.stamp)->translation()).norm(), 0.05);
}

TEST_F(Layouts, AnOniRecordingWithoutPosesIsMappedAndFoundAgain) {
  const fs::path walk = dataFolder("oni/redkitchen_60_frames_depth_only.oni");
  if (!fs::exists(walk)) GTEST_SKIP() << "no recordings beside the checkout";
  const std::string map = folder_ / "kitchen.flmap", found = folder_ / "found.txt",
                    results = folder_ / "results";
  EXPECT_THAT(ok(runMap({"build", walk, "-o", map, "--trajectory", found})).err,
              HasSubstr("no poses are given"));
  ok(runTool<localizeApp>({map, walk, "-o", results}));
  EXPECT_THAT(ok(runTool<evaluateApp>({results, found, "--map", map})).out, HasSubstr("60 (100.00 %)"));
}

TEST_F(Layouts, ACameraThatIsNamedStandsForItsFile) {
  const std::string input = folder_ / "input";
  fs::create_directories(input);
  fs::copy(fs::path(query()) / "depth", input + "/depth");
  EXPECT_THAT(runTool<segmentApp>({input, "-o", folder_ / "a"}), fails("camera=kinect"));
  EXPECT_THAT(
      ok(runTool<segmentApp>({input, "-o", folder_ / "b", "--camera", "kinect", "--depth-scale", "5000"}))
          .err,
      HasSubstr("typical kinect"));
  const std::string file = query() + "/camera.ini";
  ok(runTool<segmentApp>({input, "-o", folder_ / "c", "--camera", file}));
  EXPECT_EQ(runTool<segmentApp>({input, "-o", folder_ / "d", "--camera", "webcam"}).code, kFailed);
  EXPECT_EQ(runTool<segmentApp>({input, "-o", folder_ / "d", "--depth-scale", "-1"}).code, kUsage);
}

TEST_F(Layouts, ATimeOffsetBringsImagesAndPosesTogether) {
  const std::string input = folder_.copyOf(query(), "input");
  std::vector<StampedPose> poses = readTrajectory(input + "/groundtruth.txt").poses();
  for (StampedPose& pose : poses) pose.stamp += 100;
  writeTumTrajectory(input + "/groundtruth.txt", poses);
  EXPECT_EQ(runMap({"build", input, "-o", folder_ / "a.flmap"}).code, kFailed);
  ok(runMap({"build", input, "-o", folder_ / "b.flmap", "--time-offset", "100"}));
  ok(runMap({"build", input, "-o", folder_ / "c.flmap", "--poses", input + "/groundtruth.txt",
             "--time-offset", "100"}));
  EXPECT_EQ(contentOf(folder_ / "b.flmap").size(), contentOf(folder_ / "c.flmap").size());
}

class Cases : public testing::TestWithParam<const char*> {};

TEST_P(Cases, AreReadRightOrNamed) {
  constexpr int kNeedsInstallation = 77;
  const fs::path check = dataFolder("cases") / GetParam() / "check.sh";
  if (!fs::exists(check)) GTEST_SKIP() << "no cases beside the checkout";
  const std::string tools = fs::path(kMapTool).parent_path().string();
  const int status = std::system(("bash '" + check.string() + "' '" + tools + "' 1>&2").c_str());
  const int code = status >= 0 ? status >> 8 : -1;
  if (code == kNeedsInstallation) GTEST_SKIP() << "needs an installation";
  EXPECT_EQ(code, 0);
}

INSTANTIATE_TEST_SUITE_P(
    , Cases,
    testing::Values("01-rtabmap-export", "03-distance-along-rays", "04-rotated-bits",
                    "05-other-trajectory-files", "05-poses-that-were-lost", "06-turned-cloud",
                    "07-pclzf-folder", "08-tiff-depth", "09-lens-distortion", "10-decimated-then-aligned",
                    "10-sparse-after-alignment", "11-stamps-in-nanoseconds", "12-depth-at-the-end",
                    "13-folder-aligned_depth", "15-utf-16", "16-native-mode-848x480", "17-camera-upside-down",
                    "18-swapped-bytes", "20-lists", "20-lists-and-poses-that-are-read", "22-names-of-folders",
                    "27-pairwise-tutorial", "28-scale-of-800", "30-numbered-images", "32-rtabmap-sample"),
    [](const auto& test) {
      std::string name = test.param;
      for (char& c : name)
        if (c == '-') c = '_';
      return name;
    });

}  // namespace
}  // namespace facetloc::test
