// SPDX-License-Identifier: BSD-3-Clause
#include "box_mesh.h"
#include "ranking/global_localization.h"

#include <facetloc/features/pose.h>
#include <facetloc/mapping/mesh_surface.h>
#include <facetloc/mapping/model_map.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

namespace facetloc {
namespace {

Camera robotCamera() {
  Camera camera;
  camera.intrinsics = kinectIntrinsics().subsampled(2);
  camera.mounting = CameraMounting{0.95, 8};
  return camera;
}

std::shared_ptr<const Surface> rooms() {
  static const auto surface = std::make_shared<const MeshSurface>(twoRooms().mesh());
  return surface;
}

const Map& mapOfRooms() {
  static const Map map = [] {
    ModelMap making(rooms(), robotCamera());
    making.setNumberOfThreads(2);
    return making.finish();
  }();
  return map;
}

/** As the camera of a robot in one of the rooms would measure it. */
DepthImage measured(const Eigen::Isometry3d& T_w_c, std::mt19937& random) {
  DepthImage image = rooms()->render(robotCamera().intrinsics, T_w_c);
  std::normal_distribution<double> noise(0, DepthNoise().inverse_depth_std);
  for (float& z : image.depth)
    if (z > 0) z = static_cast<float>(1 / (1 / z + noise(random)));
  return image;
}

TEST(ModelMap, FindsWhereItsCameraIs) {
  const auto map = std::make_shared<const Map>(mapOfRooms());
  ASSERT_FALSE(map->models.empty());
  EXPECT_TRUE(map->ambiguity);
  const internal::GlobalLocalization localization(map);
  ViewBuilder builder(robotCamera());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> x(0.6, 5.4), y(1.6, 3), heading(-M_PI, M_PI);
  int right = 0;
  for (int i = 0; i < 12; ++i) {
    const CameraMounting mounting = *robotCamera().mounting;
    Eigen::Isometry3d T_w_b(Eigen::AngleAxisd(heading(random), Eigen::Vector3d::UnitZ()));
    T_w_b.translation() << x(random), y(random), 0;
    const Eigen::Isometry3d T_w_c = T_w_b * mounting.T_b_c();
    const Localization answer = localization.localize(builder.build(measured(T_w_c, random)));
    ASSERT_FALSE(answer.hypotheses.empty()) << i;
    const bool is_right = isNear(*answer.hypotheses.front().T_w_c, T_w_c, 0.1, 2);
    right += is_right;
    EXPECT_TRUE(is_right || answer.state != AnswerState::sure) << i;
  }
  EXPECT_GE(right, 6);  // the others see a wall or two
}

TEST(ModelMap, LooksFromWhereItsCameraCanBe) {
  for (const LocalModel& model : mapOfRooms().models) {
    const Eigen::Vector3d p = model.T_w_m->translation();
    EXPECT_NEAR(0.95, p.z(), 1e-3);
    EXPECT_TRUE(p.x() > 0 && p.x() < 10.2 && p.y() > 0 && p.y() < 4) << p.transpose();
    const Eigen::Vector3d ahead = model.T_w_m->linear().col(2);
    EXPECT_NEAR(-std::sin(8 * kDegree), ahead.z(), 1e-9);
  }
}

TEST(ModelMap, IsTheSameForAnyNumberOfThreads) {
  ModelMapParams few;
  few.spacing = 2;
  const auto resultWith = [&](int threads) {
    ModelMap making(rooms(), robotCamera(), few);
    making.setNumberOfThreads(threads);
    std::vector<Eigen::Matrix4d> poses;
    std::vector<std::vector<std::uint16_t>> pictures;
    const Map map = making.finish();
    for (std::size_t i = 0; i < map.models.size(); ++i) {
      poses.push_back(map.models[i].T_w_m->matrix());
      pictures.push_back(map.view(static_cast<int>(i))->depth.inverse_depth);
    }
    return std::pair(poses, pictures);
  };
  EXPECT_EQ(resultWith(1), resultWith(3));
}

TEST(ModelMap, TakesTheViewpointsThatItIsGiven) {
  Eigen::Isometry3d T_w_c = Eigen::Isometry3d::Identity();
  T_w_c.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T_w_c.translation() << 2, 2, 1.3;
  Eigen::Isometry3d outside = T_w_c;
  outside.translation() << 500, 0, 0;
  ModelMap making(rooms(), Camera{});
  making.setViewpoints({outside, T_w_c});
  const Map map = making.finish();
  ASSERT_EQ(1u, map.models.size());
  EXPECT_TRUE(map.models[0].T_w_m->isApprox(T_w_c));
  EXPECT_EQ("view-00002", map.models[0].name);
  EXPECT_EQ(1u, making.findings().without_segments);
  EXPECT_GE(map.view(0)->segments.size(), 3u);
}

TEST(ModelMap, RefusesViewpointsThatAreNotFinite) {
  const Eigen::Isometry3d nowhere(Eigen::Translation3d(0, std::nan(""), 0));
  ModelMap making(rooms(), Camera{});
  EXPECT_THROW(making.setViewpoints({Eigen::Isometry3d::Identity(), nowhere}), std::invalid_argument);
  const DepthImage image = rooms()->render(robotCamera().intrinsics, nowhere);
  EXPECT_TRUE(std::all_of(image.depth.begin(), image.depth.end(), [](float z) { return z == 0; }));
}

TEST(ModelMap, SaysThatTheUnitMayBeWrong) {
  BoxMesh millimetres;  // a room of 6 x 4 m
  millimetres.add({0, 0, -200}, {6000, 4000, 0}).add({0, 0, 2500}, {6000, 4000, 2700});
  ModelMap making(std::make_shared<const MeshSurface>(millimetres.mesh()), robotCamera());
  EXPECT_TRUE(making.finish().models.empty());
  EXPECT_NE(std::string::npos, making.findings().problem.find("6000 x 4000 m")) << making.findings().problem;
}

TEST(ModelMap, EndsBeforeTheWorkWithTooManyPlaces) {
  ModelMap making(rooms(), robotCamera());
  making.setNumberOfThreads(2);
  making.setMostPlaces(50);
  EXPECT_TRUE(making.finish().models.empty());
  EXPECT_TRUE(making.findings().too_many);
  EXPECT_GT(making.findings().places, 50u);
  EXPECT_NE(std::string::npos, making.findings().problem.find("more than 50;")) << making.findings().problem;
}

TEST(ModelMap, SaysThatTheSurfaceIsUpsideDown) {
  ModelMapParams few;
  few.spacing = 3, few.turn_deg = 60;
  const auto open = std::make_shared<const MeshSurface>(twoRooms(false).mesh());
  for (const double up : {1.0, -1.0}) {
    ModelMap making(open, robotCamera(), few);
    making.setNumberOfThreads(2);
    making.setUp(up * Eigen::Vector3d::UnitZ());
    making.finish();
    EXPECT_EQ(up * Eigen::Vector3d::UnitZ(), making.findings().up);
    EXPECT_EQ(up < 0 ? SurfaceOrientation::Verdict::upside_down : SurfaceOrientation::Verdict::plausible,
              making.orientation().judge(making.findings().up).verdict);
  }
}

TEST(ModelMap, TakesTheUpwardDirectionFromTheSurface) {
  ModelMapParams few;
  few.spacing = 3, few.turn_deg = 60;
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(100 * kDegree, Eigen::Vector3d(1, 0.4, 0.2).normalized()).toRotationMatrix();
  const Eigen::Vector3d up = R * Eigen::Vector3d::UnitZ();
  const auto turned = std::make_shared<const MeshSurface>(twoRooms(false).turned(R).mesh());
  ModelMap making(turned, robotCamera(), few);
  making.setNumberOfThreads(2);
  making.setUpBySurface();
  const Map map = making.finish();
  EXPECT_LT(std::acos(making.findings().up.dot(up)), 0.2 * kDegree);
  ASSERT_FALSE(map.models.empty());
  for (const LocalModel& model : map.models) EXPECT_NEAR(0.95, model.T_w_m->translation().dot(up), 0.03);

  ModelMap unknown(std::make_shared<const MeshSurface>(BoxMesh().add({0, 0, 0}, {3, 3, 3}).mesh()), Camera{});
  unknown.setUpBySurface();
  EXPECT_TRUE(unknown.finish().models.empty());
  EXPECT_NE(std::string::npos, unknown.findings().problem.find("which direction is up"));
}

TEST(ModelMap, SaysWhyThereIsNoMap) {
  const auto wall = std::make_shared<const MeshSurface>(BoxMesh().add({0, 0, 0}, {5, 0.2f, 2.5f}).mesh());
  ModelMap outdoors(wall, robotCamera());
  EXPECT_TRUE(outdoors.finish().models.empty());
  EXPECT_NE(std::string::npos, outdoors.findings().problem.find("floor"));
  EXPECT_THROW(ModelMap(nullptr, Camera{}), std::invalid_argument);
  ModelMapParams params;
  params.overlap = 2;
  EXPECT_THROW(ModelMap(wall, Camera{}, params), std::invalid_argument);
}

TEST(ModelMap, KeepsToTheMaximumNumberOfModels) {
  ModelMapParams params;
  params.most_models = static_cast<int>(mapOfRooms().models.size() * 2 / 3);
  ModelMap making(rooms(), robotCamera(), params);
  making.setNumberOfThreads(2);
  const Map map = making.finish();
  EXPECT_LE(map.models.size(), static_cast<std::size_t>(params.most_models));
  EXPECT_FALSE(map.models.empty());
  EXPECT_LT(making.findings().overlap, params.overlap);
}

}  // namespace
}  // namespace facetloc
