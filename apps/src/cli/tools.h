// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/commands.h"

#include <memory>

namespace facetloc {

/** \brief Makes a tool of the command line. Its options and its work are in the file of its name. */
using MakeApp = std::unique_ptr<App>();
MakeApp checkApp, convertApp, evaluateApp, liveApp, localizeApp, registerApp, renderApp, segmentApp,
    simulateApp, tryApp;
/** \brief Makes a command of facetloc_map. */
MakeApp mapBuildApp, mapCalibrateApp, mapChangesApp, mapCheckApp, mapDensifyApp, mapExportApp, mapExtendApp,
    mapImportApp, mapInfoApp, mapMergeApp, mapModelApp;

/** \brief facetloc_map. */
const CommandProgram& mapProgram();

}  // namespace facetloc
