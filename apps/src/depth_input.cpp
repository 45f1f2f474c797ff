// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/depth_input.h>

namespace facetloc {

void DepthInput::addOptions(CommandLine& line) {
  line.addOption("width", width, "N",
                 "Working width: images are subsampled to at least so many columns; 0 = full size.");
  line.addParams(view);
}

ViewParams DepthInput::viewParams(const std::optional<CameraFile>& camera, const CommandLine& line) const {
  ViewParams params = view;
  if (camera && camera->inverse_depth_std && !line.given("inverse_depth_std"))
    params.noise.inverse_depth_std = *camera->inverse_depth_std;
  return params;
}

std::string toIni(const DepthInput& input, const ViewParams& view) {
  return "width = " + std::to_string(input.width) + "\n" + toIni(view);
}

}  // namespace facetloc
