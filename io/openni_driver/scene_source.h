// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "frame_source.h"
#include "scene_file.h"

#include <vector>

namespace facetloc {

/** \brief Images of a simulated place, rendered when they are asked for. */
class SceneSource : public FrameSource {
public:
  /** \brief Throws IoError if the place leaves no room to drive. */
  explicit SceneSource(const SceneFile& file);
  std::size_t size() const override { return poses_.size(); }
  std::uint64_t stamp(std::size_t index) const override;
  void read(std::size_t index, std::uint16_t* depth) const override;

private:
  SceneFile file_;
  Scene scene_;
  std::vector<Eigen::Isometry3d> poses_;
  SimulatedCamera simulated_camera_;
};

}  // namespace facetloc
