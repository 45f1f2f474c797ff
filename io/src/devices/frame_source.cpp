// SPDX-License-Identifier: BSD-3-Clause
#include "images/depth_file.h"

#include <facetloc/features/hole_grid.h>
#include <facetloc/io/frame_source.h>

namespace facetloc {

DepthImage FrameConverter::operator()(const DepthFrame& frame) {
  DepthImage image;
  image.camera = frame.camera->camera.intrinsics;
  if (frame.values.size() != static_cast<std::size_t>(image.camera.width) * image.camera.height) return {};
  image.depth = metresOf(frame.values, frame.camera->depth_scale);
  return (*this)(std::move(image), frame.camera);
}

DepthImage FrameConverter::operator()(DepthImage stored, const std::shared_ptr<const CameraFile>& camera) {
  if (!camera->isPinhole()) {
    if (camera_ != camera) lens_.emplace(stored.camera, camera->lens, camera->depth_is);
    camera_ = camera;
    stored = (*lens_)(stored);
  }
  fillHoleGrid(stored);
  return stored;
}

}  // namespace facetloc
