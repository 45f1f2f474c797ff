// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace facetloc::internal {

/** \brief The view of a camera at a pose, in a few pixels. */
struct SmallView {
  Eigen::Isometry3d T_w_c;
  std::vector<float> depth;  ///< [m]; 0 = unknown
};

/** \brief Share of the known pixels of a view that another one of the same intrinsics also shows. */
double sharedPart(const SmallView& of, const SmallView& in, const Intrinsics& camera);

/** \brief Which views another one may stand for. */
struct Substitutes {
  struct Entry {
    std::uint32_t view;
    float shared;  ///< part of that view that the other one shows
  };
  std::vector<std::vector<Entry>> of;  ///< grouped by the representative view
};

/** \brief Few views, such that for each view there is one that shows at least that part of it: the greedy set
 * cover, in ascending order. */
std::vector<std::size_t> coveringViews(const Substitutes& substitutes, double shared);

}  // namespace facetloc::internal
