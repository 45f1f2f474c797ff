// SPDX-License-Identifier: BSD-3-Clause
// Organized clouds as viewers, robots and drivers write them.
#include "temporary_folder.h"

#include <facetloc/features/lens_distortion.h>
#include <facetloc/features/pose.h>
#include <facetloc/io/cloud_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/testing/full_disk.h>

#include <pcl/common/io.h>
#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <clocale>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

namespace facetloc::test {
namespace {

DepthImage tilted() {
  DepthImage image{{5, 4, 6, 6, 2, 1.5}, {}};
  for (int v = 0; v < 4; ++v)
    for (int u = 0; u < 5; ++u) image.depth.push_back(u == 3 ? 0.f : 1.f + 0.1f * static_cast<float>(u + v));
  return image;
}

using CloudFile = InAFolder;

TEST_F(CloudFile, HasTheMovedPointsOfTheImage) {
  const DepthImage image = tilted();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()));
  T.translation() << 1, 2, 3;
  writeCloud(folder_ / "a.pcd", image, T);
  pcl::PointCloud<pcl::PointXYZ> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile(folder_ / "a.pcd", cloud), 0);
  ASSERT_EQ(cloud.width, 5u);
  ASSERT_EQ(cloud.height, 4u);
  for (int v = 0; v < 4; ++v)
    for (int u = 0; u < 5; ++u) {
      const pcl::PointXYZ& p = cloud(u, v);
      if (u == 3) {
        EXPECT_TRUE(std::isnan(p.x) && std::isnan(p.y) && std::isnan(p.z));
        continue;
      }
      const double z = image.at(u, v);
      const Eigen::Vector3d want = T * Eigen::Vector3d((u - 2) / 6. * z, (v - 1.5) / 6. * z, z);
      EXPECT_LT((p.getVector3fMap().cast<double>() - want).norm(), 1e-6);
    }
}

TEST_F(CloudFile, KeepsTheColoursOfAnotherOne) {
  const DepthImage image = tilted();
  std::vector<PointColour> colours(image.depth.size());
  for (std::size_t i = 0; i < colours.size(); ++i) colours[i] = {static_cast<std::uint8_t>(i), 100, 7};
  writeCloud(folder_ / "a.pcd", image, Eigen::Isometry3d::Identity(), colours);
  const std::vector<PointColour> found = readColours(folder_ / "a.pcd", image);
  ASSERT_EQ(found.size(), colours.size());
  EXPECT_EQ(found[9].red, 9);
  EXPECT_EQ(found[9].green, 100);
  EXPECT_EQ(found[9].blue, 7);
  writeCloud(folder_ / "moved.pcd", image, Eigen::Isometry3d(Eigen::Translation3d(0, 0, 1)), colours);
  EXPECT_TRUE(readColours(folder_ / "moved.pcd", image).empty());  // other points than the image's
  writeCloud(folder_ / "grey.pcd", image);
  EXPECT_TRUE(readColours(folder_ / "grey.pcd", image).empty());
  colours.pop_back();
  EXPECT_THROW(writeCloud(folder_ / "b.pcd", image, Eigen::Isometry3d::Identity(), colours),
               std::invalid_argument);
}

TEST_F(CloudFile, HasLabelsAndTheirColours) {
  LabelImage labels{5, 4, std::vector<std::uint16_t>(20, 0)};
  labels.label[0] = 1, labels.label[1] = 2, labels.label[2] = 3;
  writeLabelledCloud(folder_ / "a.pcd", tilted(), labels, {{255, 1, 2}, {3, 255, 4}});
  pcl::PointCloud<pcl::PointXYZRGBL> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile(folder_ / "a.pcd", cloud), 0);
  ASSERT_EQ(cloud.size(), 20u);
  const auto colour = [&cloud](int i) { return std::vector<int>{cloud[i].r, cloud[i].g, cloud[i].b}; };
  EXPECT_THAT(colour(0), ElementsAre(255, 1, 2));
  EXPECT_THAT(colour(1), ElementsAre(3, 255, 4));
  EXPECT_EQ(colour(2), colour(4));  // no colour was given for it
  EXPECT_EQ(cloud[2].label, 3u);
  EXPECT_EQ(cloud[4].label, 0u);
  labels.label.pop_back();
  EXPECT_THROW(writeLabelledCloud(folder_ / "b.pcd", tilted(), labels, {}), std::invalid_argument);
}

TEST_F(CloudFile, KeepsTheFieldsBesideTheLabels) {
  pcl::PointCloud<pcl::PointXYZINormal> in(3, 2);
  for (std::size_t i = 0; i < in.size(); ++i) {
    const auto x = static_cast<float>(i);
    in[i].x = x, in[i].y = 1, in[i].z = 2, in[i].intensity = 10 * x, in[i].normal_y = -x,
    in[i].curvature = 0.5f;
  }
  in[4].z = std::numeric_limits<float>::quiet_NaN();
  in.sensor_origin_ << 1, 2, 3, 0;
  pcl::io::savePCDFileBinary(folder_ / "in.pcd", in);
  const LabelImage labels{3, 2, {1, 2, 0, 1, 2, 3}};
  writeLabelledCloud(folder_ / "out.pcd", folder_ / "in.pcd", {5, 1, 2, 3, 4, 99}, labels, {{1, 2, 3}});
  pcl::PointCloud<pcl::PointXYZINormal> same;
  pcl::PointCloud<pcl::PointXYZRGBL> out;
  ASSERT_EQ(pcl::io::loadPCDFile(folder_ / "out.pcd", same), 0);
  ASSERT_EQ(pcl::io::loadPCDFile(folder_ / "out.pcd", out), 0);
  ASSERT_EQ(out.width, 3u);
  ASSERT_EQ(out.height, 2u);
  EXPECT_EQ(same.sensor_origin_, in.sensor_origin_);
  for (std::size_t i = 0; i < in.size(); ++i) {
    EXPECT_EQ(same[i].x, in[i].x);
    EXPECT_EQ(same[i].intensity, in[i].intensity);
    EXPECT_EQ(same[i].normal_y, in[i].normal_y);
    EXPECT_EQ(same[i].curvature, in[i].curvature);
  }
  std::vector<std::uint32_t> found;
  for (const pcl::PointXYZRGBL& p : out) found.push_back(p.label);
  EXPECT_THAT(found, ElementsAre(3, 2, 0, 1, 0, 0));  // the last two: not finite, and outside the image
  EXPECT_EQ(out[3].b, 3);
  EXPECT_EQ(out[1].r, out[2].r);  // grey: no colour was given for label 2
  writeLabelledCloud(folder_ / "again.pcd", folder_ / "out.pcd", {0, 0, 0, 0, 0, 0}, labels, {});
  pcl::PCLPointCloud2 again;
  ASSERT_EQ(pcl::io::loadPCDFile(folder_ / "again.pcd", again), 0);
  EXPECT_EQ(pcl::getFieldsList(again), "x y z intensity normal_x normal_y normal_z curvature rgb label");
  EXPECT_THROW(writeLabelledCloud(folder_ / "b.pcd", folder_ / "in.pcd", {0}, labels, {}),
               std::invalid_argument);
}

TEST_F(CloudFile, PolygonsAreAMesh) {
  Segment square;
  square.t << 1, 2, 3;
  square.R = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()).matrix();
  square.hull.size = 4;
  const Eigen::Vector2f corners[] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  std::copy(std::begin(corners), std::end(corners), square.hull.vertex.begin());
  const ColouredPolygon polygon = polygonOf(square, {10, 20, 30});
  ColouredPolygon line = polygon;
  line.vertices.resize(2);
  writePolygons(folder_ / "a.ply", {polygon, line, polygon});

  pcl::PolygonMesh mesh;
  ASSERT_EQ(pcl::io::loadPLYFile((folder_ / "a.ply").string(), mesh), 0);
  ASSERT_EQ(mesh.polygons.size(), 2u);
  EXPECT_THAT(mesh.polygons[1].vertices, ElementsAre(4, 5, 6, 7));
  pcl::PointCloud<pcl::PointXYZRGB> vertices;
  pcl::fromPCLPointCloud2(mesh.cloud, vertices);
  ASSERT_EQ(vertices.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    const Eigen::Vector3d in_plane =
        square.R.transpose() * (vertices[i].getVector3fMap().cast<double>() - square.t);
    EXPECT_LT((in_plane.head<2>() - corners[i % 4].cast<double>()).norm(), 1e-6);
    EXPECT_NEAR(in_plane.z(), 0, 1e-6);
    EXPECT_EQ(vertices[i].g, 20);
  }
  writePolygons(folder_ / "none.ply", {});
  pcl::PolygonMesh nothing;
  EXPECT_EQ(pcl::io::loadPLYFile((folder_ / "none.ply").string(), nothing), 0);
  EXPECT_TRUE(nothing.polygons.empty());
}

TEST_F(CloudFile, AFullDiskLeavesNothing) {
  const FullDisk full(100);
  EXPECT_THAT(ioErrorOf([&] { writeCloud(folder_ / "a.pcd", tilted()); }), HasSubstr(FullDisk::kWords));
  EXPECT_EQ(folder_.count(), 0);
}

TEST_F(CloudFile, FoldersThatAreNotThereAreErrors) {
  EXPECT_NE(ioErrorOf([&] { writeCloud(folder_ / "no/a.pcd", tilted()); }), "");
  EXPECT_NE(ioErrorOf([&] { writePolygons(folder_ / "no/a.ply", {}); }), "");
}

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

class OtherAxes : public InAFolder {
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
