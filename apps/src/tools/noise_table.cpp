// SPDX-License-Identifier: BSD-3-Clause
#include "tools/noise_table.h"

#include "base/text.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/text.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

const CameraPreset& nearestPreset(const std::vector<NoiseBin>& bins) {
  const auto& presets = cameraPresets();
  return *std::min_element(presets.begin(), presets.end(), [&](const CameraPreset& a, const CameraPreset& b) {
    return misfit(a.noise, bins) < misfit(b.noise, bins);
  });
}

/** "16 %", of a root mean square of logarithms. */
std::string percent(double misfit) { return text::decimals(100 * std::expm1(misfit), 0) + " %"; }

}  // namespace

void printNoise(std::ostream& out, const std::vector<NoiseBin>& bins) {
  TextTable table(
      {"depth [m]", "flat tiles", "std of depth [mm]", "std of 1/z [1/m]", "correlated over [px]"});
  for (const NoiseBin& bin : bins)
    table.add({text::decimals(bin.nearest, 1) + " to " + text::decimals(bin.farthest, 1),
               std::to_string(bin.samples), text::significant(1e3 * bin.depthStd(), 3),
               text::significant(bin.typical.inverse_depth_std, 3),
               text::decimals(bin.typical.correlation_px, 1)});
  out << table;

  const DepthNoise noise = fittedNoise(bins);
  const CameraPreset& preset = nearestPreset(bins);
  out << "Correlated over " << text::decimals(correlationLength(bins), 1) << " px. For camera.ini:\n"
      << "  inverse_depth_std = " << text::significant(noise.inverse_depth_std, 3) << "\n";
  if (noise.depth_std > 0) out << "  depth_std = " << text::significant(noise.depth_std, 3) << "\n";
  if (noise.depth_std_slope > 0)
    out << "  depth_std_slope = " << text::significant(noise.depth_std_slope, 3) << "\n";
  out << "which is within " << percent(misfit(noise, bins))
      << " of the table; the nearest preset, camera = " << preset.name << ", is within "
      << percent(misfit(preset.noise, bins)) << ".\n";
}

}  // namespace facetloc
