// SPDX-License-Identifier: BSD-3-Clause
#include "tools/depth_input.h"

#include "tools/provenance.h"
#include "tools/text.h"

#include <facetloc/io/map_database.h>
#include <facetloc/io/text.h>

#include <algorithm>

namespace facetloc {

void DepthInput::addOptions(CommandLine& line) {
  line.addOption("width", width, "N",
                 "Working width: images are subsampled to at least so many columns; 0 = full size.");
  line.addCheck([this] {
    constexpr int kLeastWidth = 40;  // [px] below, an image shows no segments
    if (width != 0 && width < kLeastWidth)
      throw UsageError("width = " + std::to_string(width) + " is neither 0 nor at least " +
                       std::to_string(kLeastWidth));
  });
  line.addParams(view);
}

ViewParams DepthInput::viewParams(const std::optional<CameraFile>& camera, const CommandLine& line) const {
  return line.given("inverse_depth_std") ? view : withNoiseOf(camera, view);
}

ViewParams withNoiseOf(const std::optional<CameraFile>& camera, ViewParams params) {
  if (camera && camera->inverse_depth_std) params.noise.inverse_depth_std = *camera->inverse_depth_std;
  return params;
}

ViewParams withDistortionOf(const Map& map, ViewParams params) {
  params.distortion = map.distortion;
  return params;
}

Map openMapFor(const std::optional<CameraFile>& camera, const std::string& path, const Console& console) {
  Map map = openMap(path);
  noteUnfinished(map, path, console);
  dropOtherMounting(camera, map, console);
  return map;
}

void dropOtherMounting(const std::optional<CameraFile>& camera, Map& map, const Console& console) {
  const std::optional<CameraMounting> mounting = camera ? camera->mounting : std::nullopt;
  if (!map.mounting || (mounting && mounting->agreesWith(*map.mounting))) return;
  if (mounting)
    console.note("the cameras are mounted differently, " + mountingText(*mounting) + ", and in the map " +
                 mountingText(*map.mounting) + ": the prior is isotropic");
  else
    console.note("the mounting of the images' camera is unknown: the prior is isotropic");
  map.mounting.reset();
}

void noteUnfinished(const Map& map, const std::string& path, const Console& console) {
  const auto state = map.meta.find(kStateKey);
  if (state != map.meta.end() && state->second == kUnderWay)
    console.note(path + ": its build has not ended, or was interrupted: it has " +
                 counted(map.models.size(), "local model") + " so far; facetloc_map build --resume goes on");
}

void noteNoise(std::vector<double> found, const SensorNoise& told, const Console& console) {
  constexpr double kMuch = 1.3;  // times what is told; a Kinect has up to 1.2 times
  found.erase(std::remove(found.begin(), found.end(), 0.0), found.end());
  if (found.empty()) return;
  const auto median = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
  std::nth_element(found.begin(), median, found.end());
  if (*median > kMuch * told.inverse_depth_std)
    console.note("the images are noisier than told: inverse_depth_std is about " +
                 text::significant(*median, 2) + ", not " + text::significant(told.inverse_depth_std, 2) +
                 "; told in camera.ini or by --inverse_depth_std, more answers are sure");
}

void requireTolerance(double seconds) {
  if (!(seconds >= 0)) throw UsageError("pose-tolerance must not be negative");
}

std::string toIni(const DepthInput& input, const ViewParams& view) {
  return "width = " + std::to_string(input.width) + "\n" + toIni(view);
}

}  // namespace facetloc
