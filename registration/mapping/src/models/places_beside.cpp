// SPDX-License-Identifier: BSD-3-Clause
#include "models/places_beside.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>

namespace facetloc::internal {
namespace {

constexpr double kBody = 0.2;   // radius of the robot or person with the camera [m]
constexpr int kDirections = 8;  // to the sides of a driven pose

/** Is there room for a camera and what carries it? */
bool hasRoom(const SeenSpace& space, const Eigen::Vector3d& place, const Eigen::Matrix3d& level) {
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * EIGEN_PI * k / kDirections;
    if (!space.isFree(place + kBody * (std::cos(angle) * level.col(0) + std::sin(angle) * level.col(1))))
      return false;
  }
  return true;
}

/** Axes in the world whose z is upwards at a driven pose. */
Eigen::Matrix3d levelAt(const DrivenPose& pose) {
  const Eigen::Vector3d up = pose.T_w_c.linear() * pose.upwards;
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up).toRotationMatrix();
}

struct Standpoint {
  Eigen::Vector3d place;
  std::size_t beside;
};

/** On the drive itself first, then farther and farther from it. */
std::vector<Standpoint> standpoints(const std::vector<DrivenPose>& drive, const SeenSpace& space,
                                    const DensifyParams& params) {
  std::vector<Standpoint> found;
  const double apart = params.spacing / 2;
  const auto isNew = [&](const Eigen::Vector3d& place) {
    return std::none_of(found.begin(), found.end(),
                        [&](const Standpoint& s) { return (s.place - place).norm() < apart; });
  };
  for (double distance = 0; distance <= params.reach + 1e-9; distance += apart)
    for (std::size_t i = 0; i < drive.size(); ++i) {
      const Eigen::Matrix3d level = levelAt(drive[i]);
      const Eigen::Vector3d& from = drive[i].T_w_c.translation();
      for (int k = 0; k < (distance > 0 ? kDirections : 1); ++k) {
        const double angle = 2 * EIGEN_PI * k / kDirections;
        const Eigen::Vector3d place =
            from + distance * (std::cos(angle) * level.col(0) + std::sin(angle) * level.col(1));
        if (!isNew(place)) continue;
        if (distance > 0 && !(hasRoom(space, place, level) && space.isFreeBetween(from, place))) continue;
        found.push_back({place, i});
      }
    }
  return found;
}

}  // namespace

std::vector<PlaceBeside> placesBeside(const std::vector<DrivenPose>& drive, const SeenSpace& space,
                                      const DensifyParams& params) {
  std::vector<PlaceBeside> places;
  const int headings = static_cast<int>(std::ceil(720 / params.rotation_deg));
  for (const Standpoint& standpoint : standpoints(drive, space, params)) {
    const DrivenPose& beside = drive[standpoint.beside];
    const Eigen::Vector3d up = beside.T_w_c.linear() * beside.upwards;
    for (int k = 0; k < headings; ++k) {
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.linear() = Eigen::AngleAxisd(2 * EIGEN_PI * k / headings, up) * beside.T_w_c.linear();
      T.translation() = standpoint.place;
      const bool is_shown = std::any_of(drive.begin(), drive.end(), [&](const DrivenPose& pose) {
        return isNear(pose.T_w_c, T, params.spacing, params.rotation_deg);
      });
      if (!is_shown) places.push_back({T, standpoint.beside});
    }
  }
  return places;
}

std::vector<PlaceBeside> spreadOut(std::vector<PlaceBeside> places, const DensifyParams& params,
                                   std::size_t most) {
  std::stable_sort(places.begin(), places.end(),
                   [](const PlaceBeside& a, const PlaceBeside& b) { return a.known_share > b.known_share; });
  std::vector<PlaceBeside> chosen;
  for (const PlaceBeside& place : places) {
    if (chosen.size() >= most || place.known_share < params.known_share) break;
    const bool is_shown = std::any_of(chosen.begin(), chosen.end(), [&](const PlaceBeside& other) {
      return isNear(other.T_w_c, place.T_w_c, params.spacing, params.rotation_deg);
    });
    if (!is_shown) chosen.push_back(place);
  }
  return chosen;
}

}  // namespace facetloc::internal
