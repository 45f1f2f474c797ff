// SPDX-License-Identifier: BSD-3-Clause
// Organized clouds as viewers, robots and drivers write them.
#include "temporary_folder.h"

#include <facetloc/features/lens_distortion.h>
#include <facetloc/features/pose.h>
#include <facetloc/io/depth_sequence.h>

#include <pcl/io/pcd_io.h>

#include <clocale>
#include <cmath>
#include <functional>

namespace facetloc::test {
namespace {

const Intrinsics kCamera{64, 48, 52, 52, 31.5, 23.5};

/** A corner of a room with a box in front of it. */
double depthAlong(const Eigen::Vector2d& ray) {
  const double wall = 2.5 / (1 + 0.5 * ray.x()), floor = ray.y() > 0 ? 1.0 / ray.y() : 100;
  if (std::abs(ray.x()) < 0.15 && std::abs(ray.y()) < 0.2) return 1.2;
  return std::min(wall, floor);
}

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

Cloud cloudOf(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& change,
              const LensDistortion& lens = {}) {
  Cloud cloud(kCamera.width, kCamera.height);
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 0; u < kCamera.width; ++u) {
      const auto ray = lens.undistorted(kCamera.ray(u, v).head<2>());
      const Eigen::Vector3d p = depthAlong(*ray) * Eigen::Vector3d(ray->x(), ray->y(), 1);
      cloud(u, v).getVector3fMap() = change(p).cast<float>();
    }
  return cloud;
}

class OtherAxes : public testing::Test {
protected:
  DepthSequence open(const Cloud& cloud) const {
    pcl::io::savePCDFileBinary((folder_ / "1.5.pcd").string(), cloud);
    return DepthSequence::open(folder_.path());
  }
  static void expectScene(const DepthImage& image, double tolerance = 1e-3) {
    ASSERT_FALSE(image.empty());
    std::size_t wrong = 0;
    for (int v = 1; v + 1 < image.camera.height; ++v)
      for (int u = 1; u + 1 < image.camera.width; ++u)
        wrong += std::abs(image.at(u, v) - depthAlong(image.camera.ray(u, v).head<2>())) > tolerance;
    EXPECT_LT(double(wrong), 0.03 * double(image.depth.size()));
  }
  TemporaryFolder folder_;
};

TEST_F(OtherAxes, AreTurned) {
  const auto axes = [](int a, int b, int c) {
    Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
    int row = 0;
    for (const int axis : {a, b, c}) M(row++, std::abs(axis) - 1) = axis > 0 ? 1 : -1;
    return M;
  };
  for (const auto& [M, words] : {std::pair(axes(1, -2, -3), "x right, y up, z backward"),
                                 std::pair(axes(3, -1, -2), "x forward, y left, z up")}) {
    const DepthSequence sequence = open(cloudOf([M = M](const Eigen::Vector3d& p) { return M * p; }));
    EXPECT_THAT(sequence.remark(), HasSubstr(words));
    expectScene(sequence.load(0));
    EXPECT_NEAR(sequence.load(0).camera.fx, kCamera.fx, 0.1);
  }
}

TEST_F(OtherAxes, OfAKnownCameraAreAlsoTurned) {
  CameraFile file;
  file.camera.intrinsics = kCamera;
  writeCameraFile(folder_ / "camera.ini", file);
  expectScene(
      open(cloudOf([](const Eigen::Vector3d& p) { return Eigen::Vector3d(p.x(), -p.y(), -p.z()); })).load(0));
}

TEST_F(OtherAxes, RowsFromTheBottomUpAreTurnedOver) {
  Cloud cloud = cloudOf([](const Eigen::Vector3d& p) { return p; });
  Cloud over = cloud;
  for (std::uint32_t v = 0; v < cloud.height; ++v)
    for (std::uint32_t u = 0; u < cloud.width; ++u) over(u, v) = cloud(u, cloud.height - 1 - v);
  const DepthSequence sequence = open(over);
  EXPECT_THAT(sequence.remark(), HasSubstr("from the bottom up"));
  const DepthImage image = sequence.load(0);
  expectScene(image);
  const auto pixels = sequence.pixelsOfPoints(0);
  ASSERT_TRUE(pixels);
  ASSERT_EQ(pixels->size(), over.size());
  for (std::size_t i = 0; i < over.size(); ++i) EXPECT_EQ(image.depth[(*pixels)[i]], over[i].z) << i;
}

TEST_F(OtherAxes, MillimetresBecomeMetres) {
  const DepthSequence sequence =
      open(cloudOf([](const Eigen::Vector3d& p) { return Eigen::Vector3d(1000 * p); }));
  EXPECT_THAT(sequence.remark(), HasSubstr("millimetres"));
  expectScene(sequence.load(0));
}

TEST_F(OtherAxes, OnTheGridOfALensThePointsAreSortedIntoAPinholeGrid) {
  LensDistortion lens;
  lens.k1 = -0.25, lens.k2 = 0.08;
  const DepthSequence sequence = open(cloudOf([](const Eigen::Vector3d& p) { return p; }, lens));
  EXPECT_THAT(sequence.remark(), HasSubstr("lens"));
  const DepthImage image = sequence.load(0);
  expectScene(image, 0.1);  // half a pixel of the floor
  std::size_t others = 0;
  const auto pixels = sequence.pixelsOfPoints(0);
  ASSERT_TRUE(pixels);
  for (std::size_t i = 0; i < pixels->size(); ++i) others += (*pixels)[i] != i;
  EXPECT_GT(others, pixels->size() / 2);  // each is where a pinhole camera sees its point
}

TEST_F(OtherAxes, TheViewpointIsUndoneOrSaidToBeIgnored) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = expSO3(Eigen::Vector3d(0.3, -0.8, 0.2));
  T.translation() << 1, -2, 0.5;
  Cloud moved = cloudOf([&](const Eigen::Vector3d& p) { return T * p; });
  Cloud own = cloudOf([](const Eigen::Vector3d& p) { return p; });
  for (Cloud* cloud : {&moved, &own}) {
    cloud->sensor_origin_ << T.translation().cast<float>(), 0;
    cloud->sensor_orientation_ = Eigen::Quaternionf(T.linear().cast<float>());
    const DepthSequence sequence = open(*cloud);
    EXPECT_THAT(sequence.remark(), HasSubstr(cloud == &moved ? "moved back" : "ignored"));
    expectScene(sequence.load(0));
  }
}

TEST_F(OtherAxes, PointsThatNoCameraAtTheOriginSeesAreRefused) {
  EXPECT_THAT(ioErrorOf([&] {
                open(cloudOf([](const Eigen::Vector3d& p) {
                  return Eigen::Vector3d(p.x() + 1, p.y(), p.z());
                })).load(0);
              }),
              HasSubstr("pinhole camera at the origin"));
}

TEST_F(OtherAxes, AsciiNumbersAreReadInAnyLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  const char* found = nullptr;
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "nl_NL.UTF-8"})
    if (!found) found = std::setlocale(LC_ALL, name);
  if (!found) GTEST_SKIP() << "no locale with a decimal comma is installed";
  std::setlocale(LC_ALL, before.c_str());
  pcl::io::savePCDFileASCII((folder_ / "1.5.pcd").string(),
                            cloudOf([](const Eigen::Vector3d& p) { return p; }));
  std::setlocale(LC_ALL, found);
  const DepthImage image = readDepthPcd(folder_ / "1.5.pcd");
  std::setlocale(LC_ALL, before.c_str());
  expectScene(image);
}

}  // namespace
}  // namespace facetloc::test
