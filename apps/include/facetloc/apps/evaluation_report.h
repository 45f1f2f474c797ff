// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/apps/evaluation.h>

#include <filesystem>
#include <ostream>
#include <vector>

namespace facetloc {

/** \brief What facetloc_evaluate has found: one summary per set of frames; the first one is of all. */
struct EvaluationReport {
  std::string results;
  std::string truth;
  EvaluationParams params;
  Evaluation evaluation;
  std::vector<Summary> summaries;
};

/** \brief Summaries of all frames and, as far as there are any, of map images, new images and covered ones.
 */
std::vector<Summary> summarizeSets(const Evaluation& evaluation);

/** \brief Tables I and II beside the paper's figures, and what goes beyond them. */
void printReport(std::ostream& out, const EvaluationReport& report);

/** \brief Writes evaluation.txt, tables.csv, frames.csv and fig6.csv, atomically. */
void writeReport(const std::filesystem::path& folder, const EvaluationReport& report);

}  // namespace facetloc
