// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/evaluation_report.h"
#include "evaluation/trajectory_errors.h"

#include <filesystem>
#include <json/value.h>

namespace facetloc {

// The data of the charts of reports, which apps/pages/report.js draws. Rows are arrays of numbers. Each
// comment below lists the names of a row's numbers in their order.

/** \brief The charts of an evaluation; null without data.
 *
 * reliability: images, brier, enough (images of a bin that says something), bins (lowest, highest, images,
 * mean probability, share correct). position, orientation: limit, marks (99 % bounds by name), sets (name,
 * ascending errors of first correct hypotheses). planes, distance: mean, images, correct, correct at rank 1.
 * starts by images, metres: since the start, starts, sure, right. */
Json::Value chartData(const EvaluationReport& report, const std::vector<StartCurve>& starts);
/** \brief The charts of a trajectory. plan: true, estimated (to the right, to the top [m]). errors: true
 * distance [m], position [mm], orientation [deg]. */
Json::Value chartData(const TrajectoryErrors& errors);

/** \brief Draws a trajectory and the true one from above into a PNG, atomically. Needs an X display
 * (OffscreenDisplay). Throws IoError. */
void drawTrajectories(const std::filesystem::path& path, const TrajectoryErrors& errors);

}  // namespace facetloc
