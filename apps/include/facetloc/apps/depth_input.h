// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/apps/command_line.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/segmentation/view_builder.h>

#include <string>

namespace facetloc {

/** \brief How depth images become views: what the tools that read images have in common. */
struct DepthInput {
  int width = 320;  ///< working width [px]; 0 = full size
  ViewParams view;

  void addOptions(CommandLine& line);
  /** \brief The parameters for images of this camera: its own noise, unless the user gave another. */
  ViewParams viewParams(const std::optional<CameraFile>& camera, const CommandLine& line) const;
};

/** \brief The options as "name = value" lines, for what is recorded beside maps and results. */
std::string toIni(const DepthInput& input, const ViewParams& view);

}  // namespace facetloc
