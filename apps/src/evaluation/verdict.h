// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/evaluation_report.h"

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
  std::vector<std::string> sentences;  ///< how many are sure; how many of these are right; why not the rest
  std::string map;                 ///< how a map in a frame of its own differs from the truth; may be empty
  std::string next;                ///< the next step
  std::vector<KeyFigure> figures;  ///< four
};
Verdict verdictOf(const EvaluationReport& report);
/** \brief Its sentences, one per line. */
void printVerdict(std::ostream& out, const Verdict& verdict);

/** \brief Whether an answer is judged by its error relative to its local model: the map lies in a frame of
 * its own, and the true poses of its images are known. */
bool judgesRelatively(const EvaluationReport& report);

/** \brief Whether images of the mapping run and later ones were judged together, as the paper did. */
bool isPapersExperiment(const EvaluationReport& report);

}  // namespace facetloc
