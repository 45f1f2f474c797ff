// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/evaluation_report.h"
#include "evaluation/trajectory_errors.h"

#include <filesystem>
#include <ostream>
#include <string>

namespace facetloc {

/** \brief The comparison of a trajectory with the true one. */
struct TrajectoryReport {
  std::string estimate;
  std::string truth;
  TrajectoryErrors errors;
};

void printReport(std::ostream& out, const TrajectoryReport& report);

/** \brief Writes evaluation.txt, trajectory_errors.csv (by pose) and trajectory_summary.csv, atomically. */
void writeReport(const std::filesystem::path& folder, const TrajectoryReport& report);

/** \brief Writes report.html, atomically: everything in one file. Throws IoError. */
void writeHtmlReport(const std::filesystem::path& folder, const TrajectoryReport& report);

/** \brief "rotated by 12.30 deg, moved by (1.000, 2.000, 3.000) m". */
std::string motionText(const Eigen::Isometry3d& T);

}  // namespace facetloc
