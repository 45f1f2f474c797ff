// SPDX-License-Identifier: BSD-3-Clause
#include "tools/noise_table.h"

#include "base/text.h"
#include "cli/text.h"

#include <cmath>
#include <fmt/core.h>

namespace facetloc {

void printNoise(std::ostream& out, const std::vector<NoiseBin>& bins) {
  TextTable table(
      {"depth [m]", "flat tiles", "std of depth [mm]", "std of 1/z [1/m]", "correlated over [px]"});
  for (const NoiseBin& bin : bins)
    table.add({fmt::format("{:.1f} to {:.1f}", bin.nearest, bin.farthest), std::to_string(bin.samples),
               text::significant(1e3 * bin.depthStd(), 3),
               text::significant(bin.typical.inverse_depth_std, 3),
               text::decimals(bin.typical.correlation_px, 1)});
  out << table;

  const DepthNoise noise = fittedNoise(bins);
  std::string fit = fmt::format("inverse_depth_std = {:.3g}", noise.inverse_depth_std);
  if (noise.depth_std > 0) fit += fmt::format(", depth_std = {:.3g}", noise.depth_std);
  if (noise.depth_std_slope > 0) fit += fmt::format(", depth_std_slope = {:.3g}", noise.depth_std_slope);
  const double percent = 100 * std::expm1(misfit(noise, bins));  // a root mean square of logarithms
  out << fmt::format("Correlated over {:.1f} px. {} is within {:.0f} % of the table.\n",
                     correlationLength(bins), fit, percent);
}

}  // namespace facetloc
