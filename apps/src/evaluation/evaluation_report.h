// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/evaluation_tables.h"
#include "evaluation/trajectory_errors.h"

#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace facetloc {

/** \brief How results in a world of their own were brought to the true one. */
struct ResultsAlignment {
  Alignment motion;
  std::size_t answers = 0;  ///< sure ones with a true pose
  ErrorMoments errors;      ///< of the positions of all of them, after it [m]
};

/** \brief What facetloc_evaluate has found: one summary per set of frames; the first one is of all. */
struct EvaluationReport {
  std::string results;
  std::string truth;
  EvaluationParams params;
  Evaluation evaluation;
  std::vector<Summary> summaries;
  std::vector<TimingRow> timing;  ///< of all runs; may be empty
  std::optional<ResultsAlignment> alignment{};
};

/** \brief What was judged and by which rules, in sentences. */
std::vector<std::string> reportPreface(const EvaluationReport& report);

/** \brief The preface and the tables. */
void printReport(std::ostream& out, const EvaluationReport& report);

/** \brief Writes evaluation.txt, tables.csv, frames.csv, fig6.csv, errors.csv and, where times are known,
 * timing_summary.csv, atomically. Times are in the last one and in the text only: everything else depends on
 * nothing but the answers. */
void writeReport(const std::filesystem::path& folder, const EvaluationReport& report);

/** \brief A picture file and what it shows. */
struct ReportPicture {
  std::filesystem::path path;
  std::string caption;
};
/** \brief Writes report.html, atomically: everything in one file. Throws IoError. */
void writeHtmlReport(const std::filesystem::path& folder, const EvaluationReport& report,
                     const std::vector<ReportPicture>& pictures);

}  // namespace facetloc
