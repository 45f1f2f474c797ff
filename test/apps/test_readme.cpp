// SPDX-License-Identifier: BSD-3-Clause
//
// The library examples of the documents, as they stand there, beside the tools.
#include "example_room.h"

#include <facetloc/features/segment_frame_estimation.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/localization/localizer.h>
#include <facetloc/localization/map_localization.h>
#include <facetloc/mapping/map_making.h>
#include <facetloc/registration/planar_registration.h>
#include <facetloc/segmentation/planar_segmentation.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/organized_clouds.h>

#include <cstdint>
#include <functional>
#include <iostream>
#include <memory>
#include <utility>

namespace facetloc::test {

using Cloud = pcl::PointCloud<pcl::PointXYZRGBA>;

// Those in files of their own, with no other includes than theirs.
void makeMapOfWalk();
void localizeWalk();
void localizeCloud(const Cloud::ConstPtr& cloud,
                   const std::function<void(const Eigen::Isometry3d&, const Matrix6d&)>& use);

namespace {

pcl::PointCloud<SegmentFrame> estimateFrames(const pcl::PointCloud<pcl::PointXYZ>::ConstPtr& cloud,
                                             const pcl::PointCloud<pcl::Label>::ConstPtr& labels) {
#include "example_estimate_frames.inc"
  return frames;
}

std::vector<pcl::PointIndices> segmentCloud(const Cloud::ConstPtr& cloud,
                                            std::vector<pcl::ModelCoefficients>& found) {
#include "example_segment_cloud.inc"
  found = planes;
  return segments;
}

void registerClouds(const pcl::PointCloud<pcl::PointXYZ>::ConstPtr& source,
                    const pcl::PointCloud<pcl::PointXYZ>::ConstPtr& target,
                    const std::function<void(const Eigen::Matrix4f&)>& use) {
#include "example_register_clouds.inc"
}

void localizeDrive(const std::shared_ptr<const Map>& map, ViewBuilder& builder,
                   const std::vector<std::pair<DepthImage, double>>& images,
                   const std::function<void(const Eigen::Isometry3d&)>& use) {
#include "example_localize_drive.inc"
}

void writeMapOfWalk(const std::function<View(const DepthImage&)>& myViewOf){
#include "example_write_map.inc"
}

/** The output of an example in a folder. */
std::string printedIn(const std::string& folder, const std::function<void()>& example) {
  const fs::path before = fs::current_path();
  std::ostringstream out;
  std::streambuf* const console = std::cout.rdbuf(out.rdbuf());
  fs::current_path(folder);
  example();
  fs::current_path(before);
  std::cout.rdbuf(console);
  return out.str();
}

/** The results of the tool in the format of the example. */
std::string printed(const std::vector<ResultRow>& rows) {
  std::ostringstream out;
  for (const ResultRow& row : rows) {
    if (row.rank == 0) out << row.reason << "\n";
    if (row.rank == 1) out << row.probability << " at " << row.T_w_c->translation().transpose() << "\n";
  }
  return out.str();
}

class Readme : public Tools {
protected:
  /** \param change of the images' camera */
  void expectSameAsTheTool(const std::function<void(Camera&)>& change) {
    fs::copy(map(), folder_ / "walk.flmap");
    fs::create_directory(folder_ / "walk");
    fs::copy(query(), folder_ / "walk/query", fs::copy_options::recursive);
    CameraFile file = readCameraFile(folder_ / "walk/query/camera.ini");
    change(file.camera);
    writeCameraFile(folder_ / "walk/query/camera.ini", file);
    ok(runTool<localizeApp>({folder_ / "walk.flmap", folder_ / "walk/query", "-o", folder_ / "results"}));
    const std::string by_example = printedIn(folder_ / ".", localizeWalk),
                      by_tool = printed(readHypotheses(folder_ / "results"));
    EXPECT_EQ(by_example, by_tool);
    EXPECT_THAT(by_example, HasSubstr(" at "));
  }
};

TEST_F(Readme, TheLibraryAnswersAsTheToolForARobotsCamera) {
  expectSameAsTheTool([](Camera&) {});
}
TEST_F(Readme, TheLibraryAnswersAsTheToolForACameraInTheHand) {
  expectSameAsTheTool([](Camera& camera) { camera.mounting.reset(); });
}
TEST_F(Readme, TheLibraryAnswersAsTheToolForANoisierCamera) {
  expectSameAsTheTool([](Camera& camera) { camera.noise.inverse_depth_std *= 4; });
}

TEST_F(Readme, ACloudIsFoundInAMap) {
  fs::copy(map(), folder_ / "walk.flmap");
  const DepthSequence walk = DepthSequence::open(query());
  int sure = 0;
  for (std::size_t i = 0; i < walk.frames().size(); ++i) {
    const auto cloud = organizedCloud<pcl::PointXYZRGBA>(walk.load(i));
    const Eigen::Isometry3d truth = *walk.groundTruth().at(walk.frames()[i].stamp);
    const auto use = [&](const Eigen::Isometry3d& T, const Matrix6d&) {
      ++sure;
      EXPECT_LT((T.translation() - truth.translation()).norm(), 0.1);
    };
    const int before = sure;
    const std::string printed_text = printedIn(folder_ / ".", [&] { localizeCloud(cloud, use); });
    EXPECT_EQ(printed_text.empty(), sure > before) << printed_text;
  }
  EXPECT_GE(sure, 6);
}

TEST_F(Readme, CloudsAreSegmentedAndRegistered) {
  const DepthSequence walk = DepthSequence::open(map_run());
  std::vector<pcl::ModelCoefficients> planes;
  const auto cloud = organizedCloud<pcl::PointXYZRGBA>(walk.load(0));
  const auto segments = segmentCloud(cloud, planes);
  ASSERT_FALSE(segments.empty());
  ASSERT_EQ(planes.size(), segments.size());
  auto labels = pcl::make_shared<pcl::PointCloud<pcl::Label>>(cloud->width, cloud->height);
  for (std::size_t k = 0; k < segments.size(); ++k)
    for (const int i : segments[k].indices) (*labels)[i].label = static_cast<std::uint32_t>(k + 1);
  const auto source = organizedCloud<pcl::PointXYZ>(walk.load(0)),
             target = organizedCloud<pcl::PointXYZ>(walk.load(1));
  EXPECT_GT(estimateFrames(source, labels).size(), segments.size() / 2);

  const auto& poses = walk.groundTruth().poses();
  const Eigen::Isometry3d truth = poses[1].T_w_c.inverse() * poses[0].T_w_c;
  int answers = 0;
  registerClouds(source, target, [&](const Eigen::Matrix4f& T) {
    ++answers;
    EXPECT_LT((T.topRightCorner<3, 1>().cast<double>() - truth.translation()).norm(), 0.05);
  });
  EXPECT_EQ(answers, 1);
}

TEST_F(Readme, ADriveIsFoundInAMap) {
  const DepthSequence walk = DepthSequence::open(query());
  const auto opened = std::make_shared<const Map>(openMap(map()));
  ViewBuilder builder(opened->calibrated(walk.camera()->camera));
  std::vector<std::pair<DepthImage, double>> images;
  for (std::size_t i = 0; i < walk.frames().size(); ++i)
    images.emplace_back(walk.load(i, 320), walk.frames()[i].stamp);
  int sure = 0;
  localizeDrive(opened, builder, images, [&](const Eigen::Isometry3d&) { ++sure; });
  EXPECT_GE(sure, 6);
}

TEST_F(Readme, AMapIsMadeOfARecording) {
  fs::copy(map_run(), folder_ / "walk", fs::copy_options::recursive);
  printedIn(folder_ / ".", makeMapOfWalk);
  ok(runMap({"build", map_run(), "-o", folder_ / "tool.flmap"}));
  const Map made = readMap(folder_ / "walk.flmap"), by_tool = readMap(folder_ / "tool.flmap");
  ASSERT_EQ(made.models.size(), by_tool.models.size());
  for (std::size_t i = 0; i < made.models.size(); ++i) EXPECT_EQ(made.models[i].name, by_tool.models[i].name);
  EXPECT_EQ(made.links.size(), by_tool.links.size());
}

TEST_F(Readme, AMapIsWrittenImageByImage) {
  fs::copy(query(), folder_ / "walk", fs::copy_options::recursive);
  ViewBuilder builder;
  const auto myViewOf = [&](const DepthImage& image) { return builder.build(image); };
  printedIn(folder_ / ".", [&] { writeMapOfWalk(myViewOf); });
  EXPECT_EQ(readMap(folder_ / "walk.flmap").models.size(), static_cast<std::size_t>(kFrames));
}

}  // namespace
}  // namespace facetloc::test
