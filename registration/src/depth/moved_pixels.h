// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/lanes.h"

#include <facetloc/features/depth_picture.h>

#include <Eigen/Core>

#include <algorithm>
#include <cstdint>

namespace facetloc::internal {

/** \brief The rays of a camera's pixels in other axes: across u + down v + origin for pixel (u, v). */
struct TurnedRays {
  float across[3], down[3], origin[3];

  /** \brief The common part of the rays of a row. */
  FACETLOC_ALWAYS_INLINE void startRow(int v, float (&start)[3]) const {
    for (int k = 0; k < 3; ++k) start[k] = down[k] * static_cast<float>(v) + origin[k];
  }
  FACETLOC_ALWAYS_INLINE void along(const float (&start)[3], const Floats& u, Floats (&ray)[3]) const {
    for (int k = 0; k < 3; ++k) ray[k] = across[k] * u + start[k];
  }
};

/** \param R turns the camera's axes into the others */
inline TurnedRays raysOf(const Intrinsics& c, const Eigen::Matrix3d& R) {
  TurnedRays rays;
  for (int k = 0; k < 3; ++k) {
    const double across = R(k, 0) / c.fx, down = R(k, 1) / c.fy;
    rays.across[k] = static_cast<float>(across), rays.down[k] = static_cast<float>(down);
    rays.origin[k] = static_cast<float>(R(k, 2) - c.cx * across - c.cy * down);
  }
  return rays;
}

/** \brief Columns and inverse depths [1/m] of some of the n pixels first, first + step, ... of a row, from
 * the i-th on. The last of the n stands in for those beyond it. */
FACETLOC_ALWAYS_INLINE void readPixels(const std::uint16_t* row, int first, int step, int n, int i, Floats& u,
                                       Floats& rho) {
  std::int32_t known[kLanes];
  for (int k = 0; k < kLanes; ++k) known[k] = row[first + std::min(i + k, n - 1) * step];
  Ints quanta;
  std::memcpy(&quanta, known, sizeof quanta);
  rho = static_cast<float>(DepthPicture::kQuantum) * __builtin_convertvector(quanta, Floats);
  u = static_cast<float>(first + i * step) + static_cast<float>(step) * kLaneOffset;
}

/** \brief The pixels that places in a picture lie in, where pixel i covers [i, i + 1). Places that are not
 * inside by a border of that width are no longer used; their pixel is (0, 0). */
FACETLOC_ALWAYS_INLINE void findPixels(const Floats& x, const Floats& y, int width, int height, int border,
                                       Ints& used, Ints& column, Ints& row) {
  const auto least = static_cast<float>(border), last_x = static_cast<float>(width - border),
             last_y = static_cast<float>(height - border);
  used &= (x >= least) & (y >= least) & (x < last_x) & (y < last_y);
  column = __builtin_convertvector((Floats)((Ints)x & used), Ints);
  row = __builtin_convertvector((Floats)((Ints)y & used), Ints);
}

}  // namespace facetloc::internal
