// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/local_model.h>

#include <utility>

namespace facetloc {

std::string Map::partOf(int i) const {
  const auto part = static_cast<std::size_t>(models[static_cast<std::size_t>(i)].part);
  return part < parts.size() ? parts[part] : std::string();
}

Camera Map::calibrated(Camera of_images) const {
  const bool fits =
      !of_images.intrinsics.valid() || !camera.distortion || camera.distortion->fits(of_images.intrinsics);
  if (!of_images.distortion && fits) of_images.distortion = camera.distortion;
  return of_images;
}

Map mapOf(View view) {
  Map map;
  if (view.camera) map.camera = *view.camera;
  map.models.resize(1);
  map.models[0].T_w_m = Eigen::Isometry3d::Identity();
  map.models[0].view = std::move(view);
  return map;
}

}  // namespace facetloc
