// SPDX-License-Identifier: BSD-3-Clause
#include "box_mesh.h"
#include "ranking/global_localization.h"

#include <facetloc/features/pose.h>
#include <facetloc/mapping/mesh_surface.h>
#include <facetloc/mapping/model_map.h>
#include <facetloc/segmentation/view_builder.h>

#include <gtest/gtest.h>
#include <pcl/conversions.h>
#include <pcl/point_types.h>
#include <pcl/range_image/range_image_planar.h>

#include <limits>
#include <memory>
#include <random>
#include <stdexcept>

namespace facetloc {
namespace {

const Intrinsics kCamera{80, 60, 66, 66, 39.5, 29.5};

using Points = pcl::PointCloud<pcl::PointXYZ>;

pcl::PCLPointCloud2 fieldsOf(const Points& points) {
  pcl::PCLPointCloud2 fields;
  pcl::toPCLPointCloud2(points, fields);
  return fields;
}

/** A wall at a depth of 2 m, scanned at random places. */
Points wall(double spacing, double noise) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> across(-2, 2);
  std::normal_distribution<float> error(0, static_cast<float>(noise > 0 ? noise : 1));
  Points points;
  for (int i = 0; i < static_cast<int>(16 / (spacing * spacing)); ++i)
    points.emplace_back(across(random), across(random), 2 + (noise > 0 ? error(random) : 0.0f));
  return points;
}

TEST(CloudSurface, IsAsSmoothAsTheMeanOfItsNeighbours) {
  constexpr double kNoise = 0.004;
  const CloudSurface surface(fieldsOf(wall(0.02, kNoise)));
  EXPECT_NEAR(0.02, surface.spacing(), 0.004);
  EXPECT_NEAR(kNoise, surface.residual(), 0.2 * kNoise);
  const DepthImage image = surface.render(kCamera, Eigen::Isometry3d::Identity());
  double sum = 0, squares = 0, n = 0;
  for (const float z : image.depth)
    if (z > 0) sum += z - 2, squares += (z - 2) * (z - 2), ++n;
  EXPECT_GT(n, 0.995 * static_cast<double>(image.depth.size()));  // points that lie at random leave gaps
  EXPECT_LT(std::sqrt(squares / n), 0.75 * kNoise);
  EXPECT_NEAR(0, sum / n, kNoise / 2);  // the nearest of several discs is nearer than their mean
}

TEST(CloudSurface, LeavesHolesOpenAndInventsNothingNear) {
  Points points = wall(0.02, 0), with_hole;
  for (const pcl::PointXYZ& p : points)
    if (std::hypot(p.x, p.y) > 0.3) with_hole.push_back(p);
  const CloudSurface surface(fieldsOf(with_hole));
  const DepthImage image = surface.render(kCamera, Eigen::Isometry3d::Identity());
  int gaps = 0;
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 0; u < kCamera.width; ++u) {
      const double r = 2 * kCamera.ray(u, v).head<2>().norm();
      if (r < 0.25) {
        EXPECT_EQ(0, image.at(u, v)) << u << ", " << v;
      } else if (r > 0.35) {
        gaps += image.at(u, v) == 0;
        EXPECT_TRUE(image.at(u, v) == 0 || std::abs(2 - image.at(u, v)) < 1e-4) << u << ", " << v;
      }
    }
  EXPECT_LT(gaps, 0.005 * kCamera.width * kCamera.height);
  Eigen::Isometry3d near = Eigen::Isometry3d::Identity();
  near.translation() << 1, 0, 1.9;  // points are 0.2 rad apart
  const DepthImage unknown = surface.render(kCamera, near);
  EXPECT_EQ(0, *std::max_element(unknown.depth.begin(), unknown.depth.end()));
}

/** PCL's rendering, a pixel for each point, is the control: of a room with a column. */
TEST(CloudSurface, AgreesWithRangeImages) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> across(-1, 1), height(0, 2.5f);
  Points points;
  for (int i = 0; i < 15000; ++i) {
    points.emplace_back(3, 3 * across(random), height(random));
    points.emplace_back(3 * across(random), 3, height(random));
    points.emplace_back(3 * across(random), 3 * across(random), 0);
    if (i % 6 == 0) {
      const float angle = 3.14159f * across(random);
      points.emplace_back(1.5f + 0.3f * std::cos(angle), 1 + 0.3f * std::sin(angle), height(random));
    }
  }
  const CloudSurface surface(fieldsOf(points));
  const Eigen::Isometry3d T_w_c =
      Eigen::Translation3d(-1, 0, 1.2) *
      Eigen::Isometry3d((Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished() *
                        expSO3({0.2, 0.4, 0}));
  const DepthImage image = surface.render(kCamera, T_w_c);
  pcl::RangeImagePlanar control;
  control.createFromPointCloudWithFixedSize(
      points, kCamera.width, kCamera.height, static_cast<float>(kCamera.cx), static_cast<float>(kCamera.cy),
      static_cast<float>(kCamera.fx), static_cast<float>(kCamera.fy),
      T_w_c.cast<float>() * Eigen::Isometry3f::Identity(), pcl::RangeImage::CAMERA_FRAME, 0.0f, 0.0f);
  int both = 0, same = 0, only_control = 0;
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 0; u < kCamera.width; ++u) {
      if (!control.isValid(u, v)) continue;
      const double z = control.getPoint(u, v).range / kCamera.ray(u, v).norm();
      only_control += image.at(u, v) == 0;
      if (image.at(u, v) == 0) continue;
      ++both;
      same += std::abs(z - image.at(u, v)) < 0.03 * z;  // its pixels are as large as that
    }
  EXPECT_GT(both, 0.4 * kCamera.width * kCamera.height);  // half of the room is open
  EXPECT_GT(same, 0.97 * both);
  EXPECT_LT(only_control, 0.02 * both);
}

TEST(CloudSurface, LeavesOutStrayPoints) {
  Points points = wall(0.02, 0);
  const std::size_t on_wall = points.size();
  points.emplace_back(0, 0, 1);
  points.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0, 1);
  const CloudSurface surface(fieldsOf(points));
  EXPECT_GE(surface.leftOut(), 2u);
  EXPECT_GT(surface.points(), 0.98 * static_cast<double>(on_wall));
  EXPECT_NEAR(2, surface.render(kCamera, Eigen::Isometry3d::Identity()).at(40, 30), 1e-4);
}

TEST(CloudSurface, IsTheSameForAnyNumberOfThreads) {
  const pcl::PCLPointCloud2 cloud = fieldsOf(wall(0.03, 0.005));
  const auto render = [&](int threads) {
    return CloudSurface(cloud, threads).render(kCamera, Eigen::Isometry3d::Identity()).depth;
  };
  EXPECT_EQ(render(1), render(4));
}

TEST(CloudSurface, RefusesInvalidClouds) {
  EXPECT_THROW(CloudSurface{pcl::PCLPointCloud2()}, std::invalid_argument);
  Points few;
  for (int i = 0; i < 11; ++i) few.emplace_back(static_cast<float>(i), 0, 1);
  EXPECT_THROW(CloudSurface{fieldsOf(few)}, std::invalid_argument);
}

constexpr double kStd = 0.03;  // error of the position of a wall in the scan [m]

Camera cameraInHand() {
  Camera camera;
  camera.intrinsics = kinectIntrinsics().subsampled(2);
  return camera;
}

/** A corner of a room with a cupboard; each surface is off by a sample of `error`. */
template <class Error>
std::shared_ptr<const MeshSurface> corner(Error error) {
  const float x = 3 + error(), y = 2 + error(), floor = error(), depth = 0.5f + error();
  BoxMesh mesh;
  mesh.add({-3, -3, floor - 0.2f}, {x, y, floor})
      .add({x, -3, -0.2f}, {x + 0.2f, y, 2.5f})
      .add({-3, y, -0.2f}, {x + 0.2f, y + 0.2f, 2.5f})
      .add({1, y - depth, floor}, {1.8f, y, 1.4f});
  return std::make_shared<const MeshSurface>(mesh.mesh());
}

/** Looking into the corner. */
Eigen::Isometry3d cameraAt(double x, double y) {
  return Eigen::Translation3d(x, y, 0) * Eigen::AngleAxisd(40 * kDegree, Eigen::Vector3d::UnitZ()) *
         CameraMounting{1.3, 15}.T_b_c();
}

/** Number of scans out of 30, each wrong in its own way, with the true pose within the 95 % ellipsoid. */
int inside(double surface_std) {
  std::mt19937 random(11);
  std::normal_distribution<float> of_wall(0, kStd);
  std::normal_distribution<double> noise(0, DepthNoise().inverse_depth_std);
  const auto truth = corner([] { return 0.f; });
  const Eigen::Isometry3d T_w_c = cameraAt(0.1, -0.1);
  ModelMapParams params;
  params.surface_std = surface_std;
  ViewBuilder builder(cameraInHand());
  int inside = 0;
  for (int i = 0; i < 30; ++i) {
    const auto scan = corner([&] { return of_wall(random); });
    ModelMap making(scan, cameraInHand(), params);
    making.setViewpoints({cameraAt(0, 0)});
    const auto map = std::make_shared<const Map>(making.finish());
    DepthImage image = truth->render(cameraInHand().intrinsics, T_w_c);
    for (float& z : image.depth)
      if (z > 0) z = static_cast<float>(1 / (1 / z + noise(random)));
    const Localization answer = internal::GlobalLocalization(map).localize(builder.build(image));
    if (answer.hypotheses.empty()) continue;
    const Hypothesis& best = answer.hypotheses.front();
    const PoseWithCovariance found = *map->models[0].T_w_m * best.T_m_c;
    const Vector6d error = boxminus(found.T, T_w_c);
    inside += error.dot(found.P.ldlt().solve(error)) < chiSquareQuantile(6, 0.95);
  }
  return inside;
}

// Walls that a scan has at the wrong place are there for all pixels of an image.
TEST(SurfaceError, CountsInTheCovarianceOfAPose) {
  EXPECT_GE(inside(kStd), 26);
  EXPECT_LE(inside(0), 15);
}

}  // namespace
}  // namespace facetloc
