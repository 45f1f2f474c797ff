// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_people.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace facetloc {
namespace {

double top(const RoundBody& body) { return body.T_w_b.translation().z() + body.half_size.z(); }

TEST(SimulatedPeople, AreAsTallAsPeople) {
  for (std::uint64_t looks = 0; looks < 20; ++looks) {
    const std::vector<RoundBody> person = simulatedPerson(Eigen::Isometry3d::Identity(), 0, looks);
    double height = 0;
    for (const RoundBody& body : person) height = std::max(height, top(body));
    EXPECT_GT(height, 1.5);
    EXPECT_LT(height, 2);
  }
}

TEST(SimulatedPeople, AreInViewAndMove) {
  const SimulatedRun run = simulatedRun("home", 3, kLaterRun, 40, DriveParams());
  const std::vector<double> stamps = drivingTimes(basePoses(run.poses, DriveParams().mounting()));
  const SimulatedPeople people(3, run.poses, stamps, 5);
  const SimulatedCamera camera(centredKinect(80), {}, 1);
  double hidden = 0, most = 0;
  for (std::size_t i = 0; i < run.poses.size(); ++i) {
    const SimulatedWorld world = people.in(run.world, i);
    EXPECT_EQ(world.rectangles.size(), run.world.rectangles.size());
    for (std::size_t k = run.world.bodies.size(); k < world.bodies.size(); ++k)
      EXPECT_GT((world.bodies[k].T_w_b.translation() - run.poses[i].translation()).head<2>().norm(), 0.5);
    const DepthImage empty = camera.renderExact(run.world, run.poses[i]).depth,
                     seen = camera.renderExact(world, run.poses[i]).depth;
    double nearer = 0;
    for (std::size_t k = 0; k < empty.depth.size(); ++k) nearer += seen.depth[k] < 0.99f * empty.depth[k];
    hidden += nearer / static_cast<double>(empty.depth.size()) / static_cast<double>(run.poses.size());
    most = std::max(most, nearer / static_cast<double>(empty.depth.size()));
  }
  EXPECT_GT(hidden, 0.1);
  EXPECT_GT(most, 0.3);
  EXPECT_EQ(people.in(run.world, 7).bodies.back().half_size, people.in(run.world, 7).bodies.back().half_size);
}

}  // namespace
}  // namespace facetloc
