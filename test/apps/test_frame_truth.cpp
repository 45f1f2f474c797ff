// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation_report.h"
#include "evaluation/frame_truth.h"
#include "outputs/localization_report.h"
#include "tool_runner.h"

#include <facetloc/features/pose.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/segment_file.h>

namespace facetloc::test {
namespace {

constexpr double kPositionStd = 0.05, kRotationStd = 3 * kDegree;
constexpr double kPixels = 150;
const Intrinsics kCamera{320, 240, 280, 280, 159.5, 119.5};

// The world is the frame of a camera at its origin: x right, y down, z forward.
constexpr int kFloor = 1, kBack = 2, kLeft = 3, kRight = 4, kMovedBack = 12;
const std::map<int, WorldPlane> kPlanes = {{kFloor, {Eigen::Vector3d::UnitY(), 1.0}},
                                           {kBack, {Eigen::Vector3d::UnitZ(), 3.0}},
                                           {kLeft, {-Eigen::Vector3d::UnitX(), 1.0}},
                                           {kRight, {Eigen::Vector3d::UnitX(), 1.0}},
                                           {kMovedBack, {Eigen::Vector3d::UnitZ(), 3.5}}};

/** The planes with these ids as a camera sees them: the nearest one in front of it. */
LabelImage seen(const std::vector<int>& ids, const Eigen::Isometry3d& T_w_c,
                const Intrinsics& camera = kCamera) {
  LabelImage labels{camera.width, camera.height, {}};
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      double nearest = 20;
      int label = 0;
      for (const int id : ids) {
        const WorldPlane& p = kPlanes.at(id);
        const double z =
            (p.offset - p.normal.dot(T_w_c.translation())) / p.normal.dot(T_w_c.linear() * camera.ray(u, v));
        if (z > 0 && z < nearest) nearest = z, label = id;
      }
      labels.label.push_back(static_cast<std::uint16_t>(label));
    }
  return labels;
}

TrueSegments segmentsSeen(const std::vector<int>& ids,
                          const Eigen::Isometry3d& T_w_c = Eigen::Isometry3d::Identity()) {
  const LabelImage labels = seen(ids, T_w_c);
  return trueSegments(exactDepth(labels, kCamera, kPlanes, T_w_c), labels, kPixels);
}

Eigen::Isometry3d displaced() {
  Eigen::Isometry3d T(Eigen::Translation3d(0.2, -0.1, 0.3));
  T.rotate(expSO3({-0.06, -0.12, -0.04}));
  return T;
}

/** A sequence of one frame on disk, 640 px wide, so that the truth is of every second pixel. */
void writeSequence(const fs::path& folder, const std::string& frame, const std::vector<int>& ids,
                   const Eigen::Isometry3d& T_w_c) {
  const Intrinsics camera{640, 480, 560, 560, 319.0, 239.0};
  fs::create_directories(folder / "labels");
  writeCameraFile(folder / "camera.ini", {{camera, {}, {}, {}}, 5000});
  writeLabels(folder / "labels" / (frame + ".png"), seen(ids, T_w_c, camera));
  writeTumTrajectory(folder / "groundtruth.txt", {{std::stod(frame), T_w_c}});
  writePlanes(folder / "planes.csv", kPlanes);
}

TEST(FrameTruth, SegmentsLieInTheirPlanes) {
  for (const Eigen::Isometry3d& T : {Eigen::Isometry3d::Identity(), displaced()}) {
    const TrueSegments segments = segmentsSeen({kFloor, kBack, kLeft}, T);
    ASSERT_THAT(segments, UnorderedElementsAre(Key(kFloor), Key(kBack), Key(kLeft)));
    for (const auto& [id, s] : segments) {
      const WorldPlane& p = kPlanes.at(id);
      EXPECT_NEAR((T.linear() * s.normal()).dot(p.normal), 1, 1e-6) << id;  // away from the camera, as p here
      EXPECT_NEAR(p.normal.dot(T * s.t), p.offset, 1e-5) << id;
    }
  }
}

TEST(FrameTruth, PixelsWithoutALabelHaveNoDepth) {
  LabelImage labels = seen({kBack}, Eigen::Isometry3d::Identity());
  labels.label[7] = 0;
  const DepthImage image = exactDepth(labels, kCamera, kPlanes, Eigen::Isometry3d::Identity());
  EXPECT_EQ(image.depth[7], 0.f);
  EXPECT_FLOAT_EQ(image.depth[8], 3.f);
  labels.label[7] = 99;
  EXPECT_THROW(exactDepth(labels, kCamera, kPlanes, Eigen::Isometry3d::Identity()), std::invalid_argument);
}

TEST(FrameTruth, SmallPlanesDoNotCount) {
  LabelImage labels = seen({kBack}, Eigen::Isometry3d::Identity());
  for (int v = 50; v < 62; ++v)
    for (int u = 50; u < 62; ++u) labels.label[v * kCamera.width + u] = kMovedBack;  // 144 px
  const DepthImage image = exactDepth(labels, kCamera, kPlanes, Eigen::Isometry3d::Identity());
  EXPECT_THAT(trueSegments(image, labels, 150), ElementsAre(Key(kBack)));
  EXPECT_THAT(trueSegments(image, labels, 100), ElementsAre(Key(kBack), Key(kMovedBack)));
}

TEST(SharedPlanes, ACornerFixesThePose) {
  const TrueSegments corner = segmentsSeen({kFloor, kBack, kLeft});
  EXPECT_TRUE(sharedPlanesSuffice(corner, corner, kPositionStd, kRotationStd));
  EXPECT_TRUE(sharedPlanesSuffice(corner, segmentsSeen({kFloor, kBack, kLeft}, displaced()), kPositionStd,
                                  kRotationStd));
}

TEST(SharedPlanes, ACorridorDoesNot) {
  const TrueSegments corridor = segmentsSeen({kFloor, kLeft, kRight});
  ASSERT_EQ(corridor.size(), 3u);
  EXPECT_FALSE(sharedPlanesSuffice(corridor, corridor, kPositionStd, kRotationStd));
  EXPECT_FALSE(sharedPlanesSuffice({}, corridor, kPositionStd, kRotationStd));
}

TEST(SharedPlanes, MovedPlanesAreNotShared) {
  const TrueSegments now = segmentsSeen({kFloor, kLeft, kMovedBack});
  EXPECT_TRUE(sharedPlanesSuffice(now, now, kPositionStd, kRotationStd));
  EXPECT_FALSE(sharedPlanesSuffice(now, segmentsSeen({kFloor, kLeft, kBack}), kPositionStd, kRotationStd));
}

TEST(RenderedTruth, ReadsItsFolder) {
  const TemporaryFolder folder;
  const fs::path run = folder / "run";
  writeSequence(run, "7.500000", {kFloor, kBack, kLeft}, displaced());
  const auto truth = RenderedTruth::open(run);
  ASSERT_TRUE(truth);
  EXPECT_TRUE(truth->has("7.500000"));
  EXPECT_FALSE(truth->has("8.000000"));
  const TrueSegments read = truth->segments("7.500000", displaced(), kPixels);
  const TrueSegments expected = segmentsSeen({kFloor, kBack, kLeft}, displaced());
  ASSERT_EQ(read.size(), expected.size());
  for (const auto& [id, s] : expected) {
    EXPECT_NEAR(read.at(id).num_points, s.num_points, 0.03 * s.num_points) << id;
    EXPECT_NEAR((read.at(id).t - s.t).norm(), 0, 0.02) << id;
  }
  EXPECT_THROW(truth->segments("8.000000", displaced(), kPixels), IoError);
  const std::string whole = contentOf(run / "labels/7.500000.png");
  writeContent(run / "labels/8.000000.png", whole.substr(0, whole.size() / 2));
  EXPECT_THROW(truth->segments("8.000000", displaced(), kPixels), IoError);
  writeLabels(run / "labels/9.000000.png", seen({kFloor}, displaced()));  // half the size of camera.ini
  EXPECT_THROW(truth->segments("9.000000", displaced(), kPixels), IoError);
  writeLabels(run / "labels/10.000000.png", {640, 480, std::vector<std::uint16_t>(640 * 480, 99)});
  EXPECT_THROW(truth->segments("10.000000", displaced(), kPixels), IoError);  // there is no plane 99
  writeLabels(run / "labels/11.000000.png", {640, 480, std::vector<std::uint16_t>(640 * 480, 0)});
  EXPECT_TRUE(truth->segments("11.000000", displaced(), kPixels).empty());
  fs::remove(run / "planes.csv");
  EXPECT_FALSE(RenderedTruth::open(run));
}

TEST(RenderedTruth, NamesFaultsOfItsFiles) {
  const TemporaryFolder folder;
  const fs::path path = folder / "planes.csv";
  const auto complaint = [&](const std::string& content) {
    writeContent(path, content);
    return messageOf<IoError>([&] { readPlanes(path); });
  };
  EXPECT_EQ(complaint("plane,nx,ny,nz,d\n1,0,0,1,2\n\n65535,1,0,0,-3\r\n"), "");
  EXPECT_THAT(complaint(""), HasSubstr("does not begin with plane,nx,ny,nz,d"));
  EXPECT_THAT(complaint("plane,nx,ny,nz,d\n1,0,0,1\n"), HasSubstr("line 2: is not a plane"));
  EXPECT_THAT(complaint("plane,nx,ny,nz,d\n1,0,0,x,1\n"), HasSubstr("line 2: is not a plane"));
  EXPECT_THAT(complaint("plane,nx,ny,nz,d\n0,0,0,1,1\n"), HasSubstr("line 2: the id"));
  EXPECT_THAT(complaint("plane,nx,ny,nz,d\n1,0,0,1,1\n1,0,0,1,1\n"), HasSubstr("line 3: this id"));
  EXPECT_THAT(complaint("plane,nx,ny,nz,d\n1,0,1,1,1\n"), HasSubstr("line 2: the normal"));
  EXPECT_THROW(readPlanes(folder / "nowhere.csv"), IoError);
}

/** A place of which the map knows the corner, and the robot then also another view. */
class Place : public InAFolder {
protected:
  void SetUp() override {
    writeSequence(folder_ / "map", "1.000000", {kFloor, kBack, kLeft}, Eigen::Isometry3d::Identity());
    writeSequence(folder_ / "query", "1001.000000", {kFloor, kBack, kLeft}, displaced());
  }
  std::string place() const { return folder_ / ""; }
  FrameEvaluation query(const PlaceTruth& truth) const {
    const std::vector<RunResults> runs = {{"query", {noHypothesis("1001.000000", "")}, {}}};
    return evaluate(runs, truth, models_, {}).frames.at(0);
  }

  std::vector<ModelPose> models_ = {{"1.000000", 1, Eigen::Isometry3d::Identity()}};
};

TEST_F(Place, TheTruthsOfBothRunsAreOne) {
  const PlaceTruth truth = PlaceTruth::open(place());
  EXPECT_EQ(truth.poses().poses().size(), 2u);
  EXPECT_EQ(truth.sequences().size(), 2u);
  EXPECT_TRUE(truth.segments("1.000000", Eigen::Isometry3d::Identity(), kPixels));
  EXPECT_TRUE(truth.segments("1001.000000", displaced(), kPixels));
  EXPECT_FALSE(truth.segments("5", displaced(), kPixels));
  EXPECT_EQ(PlaceTruth::open(folder_ / "query").poses().poses().size(), 1u);
  EXPECT_EQ(PlaceTruth::open(folder_ / "query/groundtruth.txt").poses().poses().size(), 1u);
  EXPECT_TRUE(PlaceTruth::open(folder_ / "query/groundtruth.txt").sequences().empty());
  EXPECT_THROW(PlaceTruth::open(TemporaryFolder() / "."), IoError);
}

TEST_F(Place, RunsAtTheSameTimeAreDistinguishedByName) {
  std::filesystem::remove_all(folder_ / "query");
  writeSequence(folder_ / "query", "1.000000", {kFloor, kBack}, displaced());
  const PlaceTruth truth = PlaceTruth::open(place());
  const auto judged = [&](const std::string& run) {
    return evaluate({{run, {noHypothesis("1.000000", "")}, {}}}, truth, models_, {}).frames.at(0);
  };
  EXPECT_TRUE(judged("map").T_w_c.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(judged("query").T_w_c.isApprox(displaced(), 1e-6));
  EXPECT_EQ(judged("map").visible_planes, 3);
  EXPECT_EQ(judged("query").visible_planes, 2);
  EXPECT_THROW(judged(""), IoError);
}

TEST_F(Place, AQueryThatSharesTheCornerIsSolvable) {
  const FrameEvaluation f = query(PlaceTruth::open(place()));
  EXPECT_TRUE(f.covered);
  EXPECT_EQ(f.visible_planes, 3);
  EXPECT_EQ(f.solvable, true);
}

TEST_F(Place, AQueryWhoseCornerHasMovedIsNot) {
  writeSequence(folder_ / "query", "1001.000000", {kFloor, kMovedBack, kLeft}, displaced());
  const FrameEvaluation f = query(PlaceTruth::open(place()));
  EXPECT_TRUE(f.covered);
  EXPECT_EQ(f.solvable, false);
}

TEST_F(Place, AQueryThatIsNotCoveredIsNot) {
  models_[0].T_w_m.translation().z() = -2;
  const FrameEvaluation f = query(PlaceTruth::open(place()));
  EXPECT_FALSE(f.covered);
  EXPECT_EQ(f.solvable, false);
}

TEST_F(Place, SolvabilityIsUnknownWithoutTheMapsPlanes) {
  EXPECT_EQ(query(PlaceTruth::open(folder_ / "query")).solvable, std::nullopt);
  const FrameEvaluation f = query(PlaceTruth::open(folder_ / "query/groundtruth.txt"));
  EXPECT_TRUE(f.covered);
  EXPECT_EQ(f.solvable, std::nullopt);
  EXPECT_EQ(f.visible_planes, std::nullopt);
}

TEST_F(Place, WhereTheMapHasNothingNothingIsCovered) {
  writeContent(folder_ / "query/unmapped.txt", "# a room that was closed\n 1001.000000 # here\n\n");
  const PlaceTruth truth = PlaceTruth::open(place());
  EXPECT_TRUE(truth.unmapped("1001.000000"));
  EXPECT_FALSE(truth.unmapped("1.000000"));
  const FrameEvaluation f = query(truth);
  EXPECT_TRUE(f.unmapped);
  EXPECT_FALSE(f.covered);
  EXPECT_EQ(f.solvable, false);
}

}  // namespace
}  // namespace facetloc::test
