// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <string>
#include <utility>

namespace facetloc::test {

/** \brief A map of nothing but one view, whose camera frame is the world. */
inline Map mapOf(View view) {
  Map map;
  if (view.camera) map.camera = *view.camera;
  map.models.emplace_back(std::string(), 0.0, Eigen::Isometry3d::Identity(), std::move(view));
  return map;
}

}  // namespace facetloc::test
