// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "models/patch_raster.h"

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

/** \brief The surface that the depth pictures of a map show together.
 *
 * A pixel of a picture counts unless more pictures look through it than agree with it: moved objects are left
 * out, surfaces hidden from the others stay. Where several pictures show a point of a rendered image, it has
 * their mean, each by its own error. A pixel is unknown where the nearest surface is seen from behind, where
 * nothing was seen, and where the way to the surface leads through space that no picture has looked into. */
class FusedSurface {
public:
  /** \param pictures of known poses; they must outlive it \param threads 0 = all cores */
  FusedSurface(const std::vector<PosedPicture>& pictures, int threads);

  /** \brief The depth image of an ideal camera, with its errors; 0 where the surface is unknown. \param step
   * every step-th pixel of the pictures is taken, in both directions: for a first look */
  RenderedDepth renderWithErrors(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c,
                                 int step = 1) const;
  const SeenSpace& space() const { return space_; }
  double contradictedShare() const { return contradicted_; }  ///< share of all pixels that are left out

private:
  std::vector<std::size_t> sourcesFor(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const;

  std::vector<SurfacePatches> pictures_;
  SeenSpace space_;
  double contradicted_ = 0;
};

}  // namespace facetloc::internal
