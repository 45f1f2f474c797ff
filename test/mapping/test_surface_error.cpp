// SPDX-License-Identifier: BSD-3-Clause
#include "box_mesh.h"
#include "ranking/global_localization.h"

#include <facetloc/features/pose.h>
#include <facetloc/mapping/mesh_surface.h>
#include <facetloc/mapping/model_map.h>
#include <facetloc/segmentation/view_builder.h>

#include <gtest/gtest.h>

#include <memory>
#include <random>

namespace facetloc {
namespace {

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
