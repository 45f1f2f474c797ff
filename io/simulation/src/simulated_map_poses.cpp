// SPDX-License-Identifier: BSD-3-Clause
#include "waves.h"

#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_map_poses.h>

namespace facetloc {
namespace {

constexpr double kRadian = 1;        // weight of rotation, as path length of the camera [m]
constexpr double kLongest = 3;       // wavelength, in terms of the shortest
constexpr std::uint64_t kDrift = 1;  // purpose of the seed

}  // namespace

std::vector<Eigen::Isometry3d> simulateMapPoses(const std::vector<Eigen::Isometry3d>& T_w_c,
                                                const MapPoseErrors& errors, std::uint64_t seed) {
  errors.validate();
  std::vector<Waves> of_axes;
  for (std::uint64_t axis = 0; axis < 6; ++axis)
    of_axes.emplace_back(errors.length, kLongest * errors.length, Random(derivedSeed(seed, kDrift, axis)));
  std::vector<Eigen::Isometry3d> poses;
  Eigen::Vector3d way = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < T_w_c.size(); ++i) {
    if (i > 0) {
      const Eigen::Isometry3d step = T_w_c[i - 1].inverse() * T_w_c[i];
      way.x() += step.translation().norm() + kRadian * rotationAngle(step.linear());
    }
    Vector6d d;
    for (int axis = 0; axis < 6; ++axis)
      d[axis] =
          (axis < 3 ? errors.rotation_std_deg * kDegree : errors.translation_std) * of_axes[axis].at(way);
    poses.push_back(perturbed(T_w_c[i], d));
  }
  return poses;
}

}  // namespace facetloc
