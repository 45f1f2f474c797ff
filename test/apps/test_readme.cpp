// SPDX-License-Identifier: BSD-3-Clause
//
// README's library examples, as they stand there, beside the tool.
#include "example_room.h"
#include "tools/localize_app.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/registration/global_localization.h>
#include <facetloc/registration/map_localization.h>
#include <facetloc/segmentation/view_builder.h>

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <memory>
#include <sstream>

namespace facetloc::test {
namespace {

namespace fs = std::filesystem;

void exampleOfReadme() {
#include "readme_example.inc"
}

using Cloud = pcl::PointCloud<pcl::PointXYZRGBA>;
using Use = std::function<void(const Eigen::Isometry3d&, const Matrix6d&)>;

void cloudExampleOfReadme(const Cloud::ConstPtr& cloud, const Use& use){
#include "readme_cloud_example.inc"
}

/** What an example prints in a folder. */
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

/** What the results of the tool look like when they are printed so. */
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
    fs::copy(map(), folder_ / "office.flmap");
    fs::copy(query(), folder_ / "walk", fs::copy_options::recursive);
    CameraFile file = readCameraFile(folder_ / "walk/camera.ini");
    change(file.camera);
    writeCameraFile(folder_ / "walk/camera.ini", file);
    const ToolRun run =
        runTool<LocalizeApp>({folder_ / "office.flmap", folder_ / "walk", "-o", folder_ / "results"});
    ASSERT_EQ(run.code, kOk) << run.err;
    const std::string by_example = printedIn(folder_ / ".", exampleOfReadme),
                      by_tool = printed(readHypotheses(folder_ / "results"));
    EXPECT_EQ(by_example, by_tool);
    EXPECT_THAT(by_example, testing::HasSubstr(" at "));
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
  fs::copy(map(), folder_ / "office.flmap");
  const DepthSequence walk = DepthSequence::open(query());
  int sure = 0;
  for (std::size_t i = 0; i < walk.frames().size(); ++i) {
    const DepthImage image = walk.load(i);
    auto cloud = pcl::make_shared<Cloud>(image.camera.width, image.camera.height);
    for (int v = 0; v < image.camera.height; ++v)
      for (int u = 0; u < image.camera.width; ++u)
        (*cloud)(u, v).getVector3fMap() =
            (image.camera.ray(u, v) * (image.at(u, v) > 0 ? image.at(u, v) : NAN)).cast<float>();
    const Eigen::Isometry3d truth = *walk.groundTruth().at(walk.frames()[i].stamp);
    const auto use = [&](const Eigen::Isometry3d& T, const Matrix6d&) {
      ++sure;
      EXPECT_LT((T.translation() - truth.translation()).norm(), 0.1);
    };
    const int before = sure;
    const std::string printed_text = printedIn(folder_ / ".", [&] { cloudExampleOfReadme(cloud, use); });
    EXPECT_EQ(printed_text.empty(), sure > before) << printed_text;
  }
  EXPECT_GE(sure, 6);
}

}  // namespace
}  // namespace facetloc::test
