// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/command_line.h"

#include <facetloc/localization/localization_params.h>

#include <string>

namespace facetloc {

/** \brief The options of localization. Its calibration is known to the command line and to files of
 * parameters, too, but no help offers it. */
inline void addLocalizationOptions(CommandLine& line, GlobalLocalizationParams& params) {
  line.addParams(params);
  line.addParams(params.calibration, "calibration", CommandLine::Shown::nowhere);
}

/** \brief These parameters in the form that results record: a file of parameters. */
inline std::string localizationIni(const GlobalLocalizationParams& params) {
  return toIni(params) + toIni(params.calibration, "calibration");
}

}  // namespace facetloc
