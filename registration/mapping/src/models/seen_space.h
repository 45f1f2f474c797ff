// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_picture.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace facetloc::internal {

/** \brief The space that depth pictures have looked into, as a grid of cells: the space between a camera and
 * the surfaces that it saw. Space that no picture shows is unknown, however empty it may be. */
class SeenSpace {
public:
  /// Depth beyond which cells of this size mean nothing, for all the noise [m]
  static constexpr double kFarthest = 10;

  /** \brief Thread-safe once it is made. \param pictures not empty ones, which need not outlive it */
  explicit SeenSpace(const std::vector<PosedPicture>& pictures);

  /** \brief Has a picture looked as far as there? Up to the surface and a cell's diagonal into it. */
  bool isKnown(const Eigen::Vector3d& point) const { return (at(point) & kKnown) != 0; }
  /** \brief Has a picture looked through there, a cell's diagonal in front of any surface? */
  bool isFree(const Eigen::Vector3d& point) const { return (at(point) & kFree) != 0; }
  /** \brief Is all of the way from a to b free? */
  bool isFreeBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;
  /** \brief Is all of the way from a to b known, but for a single cell? */
  bool isKnownBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

private:
  enum : std::uint8_t { kKnown = 1, kFree = 2 };
  std::uint8_t at(const Eigen::Vector3d& point) const;
  void look(const PosedPicture& picture);
  void stand(const Eigen::Vector3d& point);

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  double cell_ = 0.1;
  std::vector<std::uint8_t> cells_;
};

}  // namespace facetloc::internal
