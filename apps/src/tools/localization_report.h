// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/io/results.h>
#include <facetloc/registration/hypothesis.h>

#include <ostream>
#include <string>
#include <vector>

namespace facetloc {

/** \brief The lines of hypotheses.csv for one frame: at most max_hypotheses, or one of rank 0 with the
 * reason. */
std::vector<ResultRow> resultRows(const std::string& frame, const Localization& answer, const Map& map,
                                  int max_hypotheses);
/** \brief The line of a frame without an answer. */
ResultRow noHypothesis(const std::string& frame, const std::string& reason);

/** \brief The ranked poses as a table for people. */
void printPoses(std::ostream& out, const std::vector<ResultRow>& rows);

}  // namespace facetloc
