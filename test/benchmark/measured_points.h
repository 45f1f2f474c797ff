// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/io/depth_sequence.h>

#include <Eigen/Geometry>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace facetloc::benchmarks {

/** \brief An image where it truly is. */
struct Look {
  DepthImage depth;
  Eigen::Isometry3d T_c_w;
};

/** \brief The images of a run where they truly are. \param names of those wanted; all if empty
 * Throws IoError. */
inline std::vector<Look> looksOf(const std::filesystem::path& run, const std::set<std::string>& names) {
  std::vector<Look> looks;
  const DepthSequence images = DepthSequence::open(run);
  for (std::size_t i = 0; i < images.frames().size(); ++i)
    if (const auto T = images.groundTruth().at(images.frames()[i].stamp);
        T && (names.empty() || names.count(images.frames()[i].name)))
      looks.push_back({images.load(i, kWorkingWidth), T->inverse()});
  return looks;
}

/** \brief How images are compared with a point. */
struct PointComparison {
  double nearest, reach;  ///< distance of an image that counts [m]
  double behind;          ///< distance of a surface that is not the point's [m]
};

/** \brief The number of images that measure something at a point, and behind it. */
struct MeasuredPoint {
  int at_it = 0, through = 0;

  /** \brief Is it looked through, by two or more images, and by more of them than measure something at it? */
  bool isLookedThrough() const { return through >= 2 && through > at_it; }
};

inline MeasuredPoint measured(const Eigen::Vector3d& p_w, const std::vector<Look>& looks,
                              const PointComparison& comparison) {
  MeasuredPoint found;
  for (const Look& look : looks) {
    const Eigen::Vector3d p = look.T_c_w * p_w;
    if (p.z() < comparison.nearest || p.z() > comparison.reach) continue;
    const Intrinsics& camera = look.depth.camera;
    const Eigen::Vector2i at = camera.project(p).array().round().matrix().cast<int>();
    if (at.x() < 0 || at.y() < 0 || at.x() >= camera.width || at.y() >= camera.height) continue;
    const float z = look.depth.at(at.x(), at.y());
    if (!isMeasured(z) || z < p.z() - comparison.behind) continue;
    ++(z > p.z() + comparison.behind ? found.through : found.at_it);
  }
  return found;
}

}  // namespace facetloc::benchmarks
