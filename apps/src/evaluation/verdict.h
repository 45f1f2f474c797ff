// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/evaluation_report.h"

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A number of the first screen, and its name. */
struct KeyFigure {
  std::string value;
  std::string words;
};

/** \brief An evaluation in words, of its new images; of all where it is not known which are new. */
struct Verdict {
  std::vector<std::string>
      sentences;  ///< how many are sure; how many of these are right; why the others are not
  std::vector<std::string> remarks;  ///< limits of the truth and of the map, then doubts about the input
  std::string next;                  ///< the next step
  std::vector<KeyFigure> figures;    ///< four
};
Verdict verdictOf(const EvaluationReport& report);
/** \brief Its sentences, one per line. */
void printVerdict(std::ostream& out, const Verdict& verdict);

/** \brief Findings in files about the recordings, then those that lie with results; each of them once. Throws
 * IoError. \param results folder of the runs */
Findings knownFindings(const std::vector<std::string>& files, const std::filesystem::path& results,
                       const std::vector<RunResults>& runs);
/** \brief Their list as a paragraph with a title; nothing without any. */
void printFindings(std::ostream& out, const Findings& findings);

/** \brief Whether an answer is judged by its error relative to its local model: the map lies in a frame of
 * its own, and the true poses of its images are known. */
bool judgesRelatively(const EvaluationReport& report);

/** \brief Limits that are at least three times the disagreement between poses and images that findings
 * state. No wider than a place, and not for poses that are refused. */
EvaluationParams withinTruth(const EvaluationParams& given, const Findings& findings);

}  // namespace facetloc
