// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/text.h"
#include "evaluation/evaluation_details.h"

#include <ostream>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Summaries of all frames and, as far as there are any, of the map images (of a single run), the new
 * images, and of the new images the covered ones, those solvable by planes, the rest that is not covered, and
 * those taken where the map has nothing. */
std::vector<Summary> summarizeSets(const Evaluation& evaluation);
/** \brief The summary of the new images; of all where it is not known which are new. */
const Summary& newImages(const std::vector<Summary>& summaries);

/** \brief A table for people, in text and in HTML. */
struct ReportTable {
  std::string title;
  TextTable table;
};
/** \brief Tables I and II beside the paper's figures, and further ones.
 * \param timing may be empty \param beside_paper else the paper's figures and the numbers of its tables are
 * left out */
std::vector<ReportTable> reportTables(const Evaluation& evaluation, const std::vector<Summary>& summaries,
                                      const std::vector<TimingRow>& timing, bool beside_paper);
/** \brief The frames that miss, and why as far as the data tell; the last column holds words. */
std::vector<ReportTable> missTables(const Evaluation& evaluation, bool relative);

/** \brief Tables I and II and further ones as CSV, one column per summary. */
void writeTables(std::ostream& out, const std::vector<Summary>& summaries);

}  // namespace facetloc
