// SPDX-License-Identifier: BSD-3-Clause
#include "simulated_walls.h"

#include <facetloc/features/pose.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

namespace facetloc {
namespace {

using test::exact, test::kCamera, test::noErrors, test::rendered, test::sceneOf, test::wallAt;

int labelAt(const SimulatedFrame& frame, int u, int v) {
  return frame.labels.label[static_cast<std::size_t>(v) * frame.labels.width + u];
}

/** A camera upright in a room with z up: x right, y down, z forward. */
Eigen::Isometry3d standing(const Eigen::Vector3d& position, double yaw) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d forward(std::cos(yaw), std::sin(yaw), 0), down(0, 0, -1);
  T.linear() << down.cross(forward), down, forward;
  T.translation() = position;
  return T;
}

/** Errors in disparity units. */
std::vector<double> disparityErrors(const SimulatedFrame& frame, double true_depth) {
  std::vector<double> errors;
  for (const float z : frame.depth.depth)
    if (z > 0) errors.push_back(kKinectGain * (1 / static_cast<double>(z) - 1 / true_depth));
  return errors;
}

double meanOf(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x) sum += value;
  return sum / static_cast<double>(x.size());
}

double stdOf(const std::vector<double>& x) {
  const double mean = meanOf(x);
  double squares = 0;
  for (const double value : x) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(x.size()));
}

TEST(SimulatedCamera, AWallIsSeenAtItsDistance) {
  const SimulatedCamera camera(kCamera, SimulatedNoise(), 1);
  const auto frame = camera.renderExact(sceneOf({wallAt(2.5, 100, 7)}), Eigen::Isometry3d::Identity());
  ASSERT_EQ(frame.depth.depth.size(), 320u * 240u);
  for (const float z : frame.depth.depth) ASSERT_FLOAT_EQ(z, 2.5f);
  for (const auto label : frame.labels.label) ASSERT_EQ(label, 7);
}

TEST(SimulatedCamera, TheOutlineOfARectangleIsExact) {
  Rectangle sheet = wallAt(2);
  sheet.half_u = 0.5, sheet.half_v = 0.25;
  const auto frame = exact({sheet});
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 0; u < kCamera.width; ++u) {
      const Eigen::Vector3d p = 2 * kCamera.ray(u, v);
      const bool inside = std::abs(p.x()) <= 0.5 && std::abs(p.y()) <= 0.25;
      ASSERT_EQ(frame.depth.at(u, v) > 0, inside) << u << ", " << v;
    }
}

TEST(SimulatedCamera, TheNearerSurfaceHidesTheFarther) {
  const Rectangle near_sheet = wallAt(1, 0.1, 2);
  for (const SimulatedWorld& scene :
       {sceneOf({wallAt(3, 100, 1), near_sheet}), sceneOf({near_sheet, wallAt(3, 100, 1)})}) {
    const auto frame =
        SimulatedCamera(kCamera, noErrors(), 1).renderExact(scene, Eigen::Isometry3d::Identity());
    EXPECT_FLOAT_EQ(frame.depth.at(160, 120), 1.f);
    EXPECT_FLOAT_EQ(frame.depth.at(0, 0), 3.f);
  }
}

TEST(SimulatedCamera, SurfacesBehindTheCameraAreNotSeen) {
  const auto frame = exact({wallAt(-2)});
  EXPECT_EQ(*std::max_element(frame.depth.depth.begin(), frame.depth.depth.end()), 0.f);
  EXPECT_EQ(frame.labels.maxLabel(), 0);
}

TEST(SimulatedCamera, AFloorThatPassesUnderTheCameraIsSeenUpToTheImageBorder) {
  Rectangle floor;  // y = 1 below the camera, reaching behind it
  floor.centre = {0, 1, 0};
  floor.axis_u = Eigen::Vector3d::UnitX();
  floor.axis_v = Eigen::Vector3d::UnitZ();
  floor.half_u = floor.half_v = 50;
  const auto frame = exact({floor});
  for (const int v : {150, 200, 239})
    for (const int u : {0, 160, 319}) EXPECT_NEAR(frame.depth.at(u, v), 1 / kCamera.ray(u, v).y(), 1e-5);
  EXPECT_EQ(frame.depth.at(160, 100), 0.f);
}

TEST(SimulatedCamera, LabelsBelongToThePlanesOfTheirRectangles) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SimulatedWorld room = randomRoom(seed);
    std::map<int, Rectangle> by_id;
    for (const Rectangle& r : room.rectangles) by_id[r.plane_id] = r;
    for (const double yaw : {0.3, 2.0, 4.1}) {
      const Eigen::Isometry3d T_w_c = standing({0.1, -0.2, 1.3}, yaw);
      const auto frame = SimulatedCamera(kCamera, noErrors(), 1).renderExact(room, T_w_c);
      for (int v = 0; v < kCamera.height; ++v)
        for (int u = 0; u < kCamera.width; ++u) {
          const int label = frame.labels.label[static_cast<std::size_t>(v) * kCamera.width + u];
          ASSERT_TRUE(by_id.count(label)) << "a closed room has no holes";
          const Rectangle& r = by_id[label];
          const Eigen::Vector3d p = T_w_c * (frame.depth.at(u, v) * kCamera.ray(u, v)) - r.centre;
          ASSERT_LT(std::abs(r.axis_u.cross(r.axis_v).dot(p)), 1e-4);
          ASSERT_LT(std::abs(r.axis_u.dot(p)), r.half_u + 1e-4);
          ASSERT_LT(std::abs(r.axis_v.dot(p)), r.half_v + 1e-4);
        }
    }
  }
}

TEST(SimulatedCamera, ABoxIsClosedAndItsFacesHaveIdsOfTheirOwn) {
  SimulatedWorld scene;
  std::uint16_t next_id = 5;
  Eigen::Isometry3d T(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()));
  T.translation() << 1, 2, 3;
  addBox(scene, T, {0.5, 0.25, 1}, next_id);
  EXPECT_EQ(next_id, 11);
  ASSERT_EQ(scene.rectangles.size(), 6u);
  std::set<int> ids;
  double area = 0;
  for (const Rectangle& r : scene.rectangles) {
    ids.insert(r.plane_id);
    area += 4 * r.half_u * r.half_v;
    EXPECT_NEAR(r.axis_u.dot(r.axis_v), 0, 1e-12);
  }
  EXPECT_EQ(ids.size(), 6u);
  EXPECT_NEAR(area, 2 * (1 * 0.5 + 1 * 2 + 0.5 * 2), 1e-12);
}

TEST(SimulatedCamera, RoomsKeepTheirPromises) {
  std::set<double> widths;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const SimulatedWorld room = randomRoom(seed, 8);
    ASSERT_EQ(room.rectangles.size(), 6u * 9u);
    Eigen::AlignedBox3d bounds;
    for (const Rectangle& r : room.rectangles)
      for (const int su : {-1, 1})
        for (const int sv : {-1, 1})
          bounds.extend(r.centre + su * r.half_u * r.axis_u + sv * r.half_v * r.axis_v);
    EXPECT_NEAR(bounds.min().z(), 0, 1e-9);
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_GE(bounds.sizes()[axis], 3 - 1e-9);
      EXPECT_LE(bounds.sizes()[axis], 7 + 1e-9) << "boxes stay inside";
    }
    EXPECT_GE(bounds.sizes().z(), 2.4 - 1e-9);
    EXPECT_LE(bounds.sizes().z(), 3 + 1e-9);
    widths.insert(bounds.sizes().x());
    // The middle is free: looking up from near the floor one sees the ceiling.
    const Eigen::Isometry3d up(Eigen::Translation3d(0, 0, 0.01));
    const Intrinsics pixel{1, 1, 1, 1, 0, 0};
    EXPECT_NEAR(SimulatedCamera(pixel, noErrors(), 1).renderExact(room, up).depth.at(0, 0),
                bounds.max().z() - 0.01, 1e-6);
  }
  EXPECT_EQ(widths.size(), 200u);
}

TEST(SimulatedCamera, SameSeedSameImageOtherSeedOtherImage) {
  const SimulatedWorld room = randomRoom(3);
  const auto pose = standing({0, 0, 1.2}, 1);
  const SimulatedCamera a(kCamera, SimulatedNoise(), 9), b(kCamera, SimulatedNoise(), 9),
      c(kCamera, SimulatedNoise(), 10);
  EXPECT_EQ(a.render(room, pose, 4).depth.depth, b.render(randomRoom(3), pose, 4).depth.depth);
  EXPECT_EQ(a.render(room, pose, 4).labels.label, b.render(room, pose, 4).labels.label);
  EXPECT_NE(a.render(room, pose, 4).depth.depth, a.render(room, pose, 5).depth.depth);
  EXPECT_NE(a.render(room, pose, 4).depth.depth, c.render(room, pose, 4).depth.depth);
}

TEST(SimulatedCamera, WithoutErrorsTheImageIsExact) {
  const SimulatedWorld room = randomRoom(3);
  const auto pose = standing({0, 0, 1.2}, 1);
  const SimulatedCamera camera(kCamera, noErrors(), 1);
  const auto truth = camera.renderExact(room, pose), image = camera.render(room, pose, 0);
  EXPECT_EQ(truth.labels.label, image.labels.label);
  for (std::size_t i = 0; i < truth.depth.depth.size(); ++i)
    ASSERT_NEAR(truth.depth.depth[i], image.depth.depth[i], 1e-6 * truth.depth.depth[i]);
}

TEST(SimulatedCamera, TheNoiseHasTheStandardDeviationThatWasAskedFor) {
  for (const double correlation : {0.0, 1.0, 4.0}) {
    SimulatedNoise noise = noErrors();
    noise.disparity_std = 0.7, noise.correlation_px = correlation;
    const auto frame = rendered(noise, {wallAt(2)});
    const auto errors = disparityErrors(frame, 2);
    ASSERT_EQ(errors.size(), 320u * 240u);
    EXPECT_NEAR(stdOf(errors), 0.7, 0.035) << correlation;
    EXPECT_NEAR(meanOf(errors), 0, 0.05) << correlation;
  }
}

TEST(SimulatedCamera, TheNoiseIsCorrelatedOverTheAskedLength) {
  // Neighbours of noise smoothed by a Gaussian of sigma correlate with exp(-1 / (4 sigma^2)).
  const auto neighbourCorrelation = [](double correlation_px) {
    SimulatedNoise noise = noErrors();
    noise.disparity_std = 1, noise.correlation_px = correlation_px;
    const auto frame = rendered(noise, {wallAt(2)});
    const auto e = disparityErrors(frame, 2);
    double products = 0;
    for (std::size_t i = 0; i + 1 < e.size(); ++i) products += e[i] * e[i + 1];
    return products / static_cast<double>(e.size());
  };
  EXPECT_NEAR(neighbourCorrelation(0), 0, 0.02);
  EXPECT_NEAR(neighbourCorrelation(2), std::exp(-0.25), 0.05) << "2 px of 640 are 1 px of 320";
}

TEST(SimulatedCamera, TheDistortionIsFixedSmoothAndOfTheAskedSize) {
  SimulatedNoise noise = noErrors();
  noise.distortion = 0.5;
  const auto a = rendered(noise, {wallAt(2)});
  EXPECT_EQ(a.depth.depth, rendered(noise, {wallAt(2)}, 1).depth.depth);
  const auto errors = disparityErrors(a, 2);
  EXPECT_NEAR(stdOf(errors), 0.5, 0.01);
  EXPECT_NEAR(meanOf(errors), 0, 0.01);
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 1; u < kCamera.width; ++u) ASSERT_NEAR(errors[v * 320 + u], errors[v * 320 + u - 1], 0.06);
}

TEST(SimulatedCamera, DepthsAreQuantizedInDisparity) {
  SimulatedNoise noise = noErrors();
  noise.quantization = 1, noise.disparity_std = 2;
  const auto frame = rendered(noise, {wallAt(3)});
  for (const float z : frame.depth.depth) {
    const double disparity = kinectDisparity(z);
    ASSERT_NEAR(disparity, std::round(disparity), 1e-3);
  }
}

TEST(SimulatedCamera, SilhouettesAreNoisyButSurfacesAreNot) {
  SimulatedNoise noise = noErrors();
  noise.edge_std_px = 2;
  const Rectangle sheet = wallAt(1, 0.2, 2);
  const auto without = exact({wallAt(3), sheet});
  const auto noisy = rendered(noise, {wallAt(3), sheet});
  int changed = 0;
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 0; u < kCamera.width; ++u) {
      const float z = noisy.depth.at(u, v);
      ASSERT_TRUE(std::abs(z - 1) < 1e-5 || std::abs(z - 3) < 1e-5) << "never a mixture";
      if (std::abs(z - without.depth.at(u, v)) < 1e-5) continue;
      ++changed;
      const Eigen::Vector3d p = kCamera.ray(u, v);
      const double off_edge = std::abs(std::max(std::abs(p.x()), std::abs(p.y())) - 0.2) * kCamera.fx;
      ASSERT_LT(off_edge, 6) << "px from the silhouette";
    }
  EXPECT_GT(changed, 100);
}

TEST(SimulatedCamera, DropoutsHaveNoDepthAndNoLabel) {
  SimulatedNoise noise = noErrors();
  noise.random_dropout = 0.1;
  const auto frame = rendered(noise, {wallAt(3)});
  int lost = 0;
  for (std::size_t i = 0; i < frame.depth.depth.size(); ++i) {
    lost += frame.depth.depth[i] == 0;
    ASSERT_EQ(frame.depth.depth[i] == 0, frame.labels.label[i] == 0);
  }
  EXPECT_NEAR(lost / (320.0 * 240.0), 0.1, 0.005);
}

TEST(SimulatedCamera, GrazingAndFarSurfacesAreLost) {
  SimulatedNoise noise = noErrors();
  Rectangle floor;
  floor.centre = {0, 1, 0};
  floor.axis_v = Eigen::Vector3d::UnitZ();
  floor.half_u = floor.half_v = 50;
  noise.grazing_dropout_deg = 80;
  auto frame = rendered(noise, {floor});
  for (int v = 121; v < kCamera.height; ++v) {
    const double angle = std::acos(kCamera.ray(159, v).normalized().y()) / kDegree;
    if (std::abs(angle - 80) > 0.1) {
      ASSERT_EQ(frame.depth.at(159, v) > 0, angle < 80) << v;
    }
  }
  noise = noErrors();
  noise.min_depth = 2, noise.max_depth = 4;
  frame = rendered(noise, {floor});
  for (const float z : frame.depth.depth) ASSERT_TRUE(z == 0 || (z >= 2 && z <= 4));
}

/** Depth of the first point inside a body along each ray, by small steps: slow and obvious. */
double marchedDepth(const RoundBody& body, const Eigen::Vector3d& ray) {
  constexpr double kStep = 2e-4;
  const Eigen::Isometry3d T_b_c = body.T_w_b.inverse();
  for (double z = 0.5; z < 4; z += kStep) {
    const Eigen::Vector3d p = (T_b_c * (z * ray)).cwiseQuotient(body.half_size);
    const bool cylinder = body.shape == RoundBody::Shape::cylinder;
    if (cylinder ? p.head<2>().norm() <= 1 && std::abs(p.z()) <= 1 : p.norm() <= 1) return z;
  }
  return 0;
}

TEST(SimulatedCamera, RoundBodiesHaveTheirShapeAndNoLabel) {
  const Intrinsics small{40, 30, 32.8, 32.8, 19.5, 14.5};
  for (const auto shape : {RoundBody::Shape::ellipsoid, RoundBody::Shape::cylinder}) {
    RoundBody body;
    body.shape = shape;
    body.T_w_b =
        Eigen::Translation3d(0.1, -0.1, 2) * Eigen::AngleAxisd(EIGEN_PI / 2, Eigen::Vector3d::UnitX());
    body.half_size = {0.3, 0.5, 0.7};
    const auto frame =
        SimulatedCamera(small, noErrors(), 1).renderExact({{}, {body}}, Eigen::Isometry3d::Identity());
    int seen = 0;
    for (int v = 0; v < small.height; ++v)
      for (int u = 0; u < small.width; ++u) {
        const double truth = marchedDepth(body, small.ray(u, v));
        ASSERT_NEAR(frame.depth.at(u, v), truth, 5e-4) << u << " " << v;
        ASSERT_EQ(labelAt(frame, u, v), 0);
        seen += truth > 0;
      }
    EXPECT_GT(seen, 100);
  }
}

TEST(SimulatedCamera, TheProjectorCastsAShadowAsWideAsTheParallax) {
  SimulatedNoise noise = noErrors();
  noise.projector_baseline = 0.075;
  Rectangle sheet = wallAt(1, 100, 2);
  sheet.half_u = 0.15, sheet.half_v = 0.2;
  const auto frame = rendered(noise, {wallAt(3), sheet});
  int lost = 0, first = kCamera.width;
  for (int u = 0; u < kCamera.width; ++u)
    if (frame.depth.at(u, 120) == 0) ++lost, first = std::min(first, u);
  EXPECT_NEAR(lost, kCamera.fx * 0.075 * (1 / 1.0 - 1 / 3.0), 1.01);
  EXPECT_NEAR(first + lost, kCamera.cx - kCamera.fx * 0.15, 1.01) << "to the left of the sheet's left edge";
  for (int u = 0; u < kCamera.width; ++u)
    EXPECT_GT(frame.depth.at(u, 20), 0) << "nothing is in the way there";
}

TEST(SimulatedCamera, GlassIsSeenInPatchesAndTheRestShowsTheBackground) {
  Rectangle pane = wallAt(2, 100, 2);
  pane.material = Material::glass;
  const auto frame = rendered(noErrors(), {wallAt(3, 100, 1), pane});
  int glass = 0, borders = 0;
  for (int v = 0; v < kCamera.height; ++v)
    for (int u = 1; u < kCamera.width; ++u) {
      ASSERT_NEAR(frame.depth.at(u, v), labelAt(frame, u, v) == 2 ? 2 : 3, 1e-5);
      glass += labelAt(frame, u, v) == 2;
      borders += labelAt(frame, u, v) != labelAt(frame, u - 1, v);
    }
  EXPECT_NEAR(glass / (320.0 * 240.0), 0.097, 0.03);  // P(N(0, 1) > 1.3)
  EXPECT_LT(borders, glass / 2) << "patches, not single pixels";
}

TEST(SimulatedCamera, DarkSurfacesAreLostFarAwayAndAtASlant) {
  SimulatedNoise noise = noErrors();
  noise.dark_range = 3.5;
  const auto shareSeen = [&](double distance, Material material) {
    Rectangle wall = wallAt(distance);
    wall.material = material;
    const auto frame = rendered(noise, {wall});
    return 1 - std::count(frame.depth.depth.begin(), frame.depth.depth.end(), 0.f) / (320.0 * 240.0);
  };
  EXPECT_GT(shareSeen(1, Material::dark), 0.99);
  EXPECT_NEAR(shareSeen(3.3, Material::dark), 0.5, 0.15);
  EXPECT_LT(shareSeen(7.5, Material::dark), 0.05);
  EXPECT_EQ(shareSeen(7.5, Material::matt), 1);
}

TEST(SimulatedCamera, TheFactorRaisesTheNoise) {
  SimulatedNoise noise = noErrors();
  noise.disparity_std = 0.5, noise.noise_factor = 3;
  const auto frame = rendered(noise, {wallAt(2)});
  EXPECT_NEAR(stdOf(disparityErrors(frame, 2)), 1.5, 0.05);
}

TEST(SimulatedCamera, ImpossibleCamerasAreRefused) {
  EXPECT_THROW(SimulatedCamera(Intrinsics(), SimulatedNoise(), 1), std::invalid_argument);
  SimulatedNoise noise;
  noise.random_dropout = 2;
  EXPECT_THROW(SimulatedCamera(kCamera, noise, 1), std::invalid_argument);
}

}  // namespace
}  // namespace facetloc
