// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/charts.h"
#include "evaluation/evaluation_details.h"

#include <filesystem>
#include <vector>

namespace facetloc {

// Charts of an evaluation: as panels, for svgChart(), and as PNG files, written atomically, which need an X
// display (OffscreenDisplay) and throw IoError.

/** \brief The paper's Fig. 6: cumulative histograms of the errors and the rank of the first correct
 * hypothesis, with 99 % marks of the first summary and, beside the paper, of its own. */
std::vector<Panel> fig6Panels(const std::vector<Summary>& summaries, const EvaluationParams& params,
                              bool beside_paper = true);
void drawFig6(const std::filesystem::path& path, const std::vector<Summary>& summaries,
              const EvaluationParams& params);
/** \brief How often rank 1 is correct over its probability, and from how many images that is known. */
std::vector<Panel> reliabilityPanels(const Summary& summary);
void drawReliability(const std::filesystem::path& path, const Summary& summary);
/** \brief Shares and errors over the planes in view and over the distance to the map; none without groups. */
std::vector<Panel> errorPanels(const std::vector<ErrorGroup>& by_planes,
                               const std::vector<ErrorGroup>& by_distance);
/** \brief Draws them; false, and nothing drawn, without groups. */
bool drawErrors(const std::filesystem::path& path, const std::vector<ErrorGroup>& by_planes,
                const std::vector<ErrorGroup>& by_distance);

}  // namespace facetloc
