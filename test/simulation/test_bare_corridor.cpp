// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_place.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace facetloc {
namespace {

constexpr double kLength = 40;   // [m]
constexpr double kMaxDepth = 8;  // range of the camera [m]
constexpr std::size_t kMany = 1000;

DriveParams mappingDrive() {
  DriveParams params;
  params.step = 0.25;
  return params;
}

class BareCorridor : public testing::TestWithParam<int> {
protected:
  const SimulatedPlace place_ = simulatedPlace("corridor", static_cast<std::uint64_t>(GetParam()));
  const std::vector<Eigen::Isometry3d> poses_ =
      simulateDrive(place_.mapping_route, kMany, mappingDrive(), 1, {}, RouteEnd::stop);
};

TEST_P(BareCorridor, IsFloorCeilingAndFourWalls) {
  EXPECT_EQ(place_.mapped.rectangles.size(), 6u);
  EXPECT_TRUE(place_.mapped.bodies.empty());
  Eigen::AlignedBox3d box;
  for (const Rectangle& r : place_.mapped.rectangles) {
    box.extend(r.centre - r.half_u * r.axis_u - r.half_v * r.axis_v);
    box.extend(r.centre + r.half_u * r.axis_u + r.half_v * r.axis_v);
  }
  EXPECT_NEAR(box.sizes().x(), kLength, 1e-9);
  EXPECT_NEAR(box.sizes().y(), 2, 0.2 + 1e-9);
  EXPECT_NEAR(box.sizes().z(), 2.7, 0.3 + 1e-9);
}

TEST_P(BareCorridor, IsDrivenAlongOnce) {
  ASSERT_TRUE(place_.one_way);
  ASSERT_LT(poses_.size(), kMany);
  EXPECT_GT((poses_.back().translation() - poses_.front().translation()).norm(), 0.9 * kLength);
  for (std::size_t i = 1; i < poses_.size(); ++i)
    EXPECT_GT(poses_[i].translation().x(), poses_[i - 1].translation().x()) << i;
}

TEST_P(BareCorridor, MidwayTheEndsAreOutOfRange) {
  const Intrinsics eighth = kinectIntrinsics().subsampled(8);
  SimulatedNoise noise;
  noise.max_depth = kMaxDepth;
  const SimulatedCamera camera(eighth, noise, 1);
  const auto isEnd = [&](int label) {
    const auto r = std::find_if(place_.mapped.rectangles.begin(), place_.mapped.rectangles.end(),
                                [&](const Rectangle& one) { return one.plane_id == label; });
    return std::abs(r->normal().x()) > 0.5;
  };
  int midway = 0;
  for (std::size_t i = 0; i < poses_.size(); i += 10) {
    const double x = poses_[i].translation().x();
    if (x < kMaxDepth || x > kLength - kMaxDepth - 0.5) continue;
    ++midway;
    const SimulatedFrame frame = camera.render(place_.mapped, poses_[i], i);
    std::set<int> seen;
    for (std::size_t k = 0; k < frame.labels.label.size(); ++k)
      if (isMeasured(frame.depth.depth[k])) seen.insert(frame.labels.label[k]);
    seen.erase(0);
    EXPECT_GE(seen.size(), 3u) << x;
    EXPECT_TRUE(std::none_of(seen.begin(), seen.end(), isEnd)) << x;
  }
  EXPECT_GE(midway, 8);
}

TEST_P(BareCorridor, DiffersFromSeedToSeed) {
  const SimulatedPlace other = simulatedPlace("corridor", static_cast<std::uint64_t>(GetParam()) + 1);
  for (const std::size_t i : {1, 2})  // height and width
    EXPECT_NE(other.mapped.rectangles[i].centre, place_.mapped.rectangles[i].centre);
  EXPECT_NE(other.mapping_route[0].place, place_.mapping_route[0].place);
  EXPECT_NE(place_.query_route[0].place, place_.mapping_route[0].place);
}

INSTANTIATE_TEST_SUITE_P(Seeds, BareCorridor, testing::Range(1, 5));

}  // namespace
}  // namespace facetloc
