// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "drawing/map_page.h"
#include "evaluation/evaluation_report.h"

#include <facetloc/features/local_model.h>

#include <filesystem>
#include <vector>

namespace facetloc {

// Pictures of an evaluation whose map and images are at hand, PNG. They need an X display (OffscreenDisplay)
// and throw IoError.

/** \brief The map with all runs through it, and where it failed. */
void drawMapOfRuns(const std::filesystem::path& path, const Map& map, const PlaceTruth& truth,
                   const Evaluation& evaluation, bool relative);

/** \brief The map from above, for apps/pages/report.js: the ends of upright segments, low and tall, x and y
 * of each, of which the longest 20 000 are there; the local models; and by the answers' states x, y and the
 * direction ahead of the images in question, where they were taken, or else where the answers say. Whole
 * millimetres. Throws IoError if no local model of the map has a pose. */
Json::Value planData(const Map& map, const Evaluation& evaluation, const MapPage& page);

/** \brief Results as they are shown in their map: the answers of all runs in their order, those of the part
 * of the map that is drawn with their places. Without runs in it, and without a title. Throws
 * std::runtime_error for an answer in a local model that the map has not. \param evaluation of these results;
 * null if nothing is known to be true \param relative whether errors relative to local models decide which
 * answers are right */
MapPage answerPage(const Map& map, const std::vector<RunResults>& runs,
                   const Evaluation* evaluation = nullptr, bool relative = false);

/** \brief The answers in their map as answerPage(), with the true poses and, where images are there, their
 * pictures and matches. Refers to the map. */
MapPage pageOfAnswers(const Map& map, const PlaceTruth& truth, const std::vector<RunResults>& runs,
                      const Evaluation& evaluation, bool relative);

/** \brief Misses to be shown, at most that many: equally many of each kind, as far as there are, spread
 * over the run. */
std::vector<Miss> chosenMisses(const Evaluation& evaluation, std::size_t most, bool relative = false);

/** \brief Removes the pictures that drawMisses() has drawn, and nothing else. */
void removeMisses(const std::filesystem::path& folder);

/** \brief Draws folder/miss_NAME.png, of several runs folder/miss_RUN_NAME.png, for misses whose depth images
 * are there: the answer of rank 1, and the local model that would have been right with the true pose. An
 * image that cannot be read or drawn is left out with a remark. */
std::vector<ReportPicture> drawMisses(const std::filesystem::path& folder, const std::vector<Miss>& misses,
                                      const Map& map, const PlaceTruth& truth,
                                      const std::vector<RunResults>& runs, bool relative,
                                      const Console& console);

/** \brief The paper's Fig. 5, and the places of its images: of each run four images spread over it whose rank
 * 1 is right, with their segments, the local model and both aligned. \return false without such an image */
bool drawExamples(const std::filesystem::path& path, const Evaluation& evaluation, const Map& map,
                  const PlaceTruth& truth, const std::vector<RunResults>& runs, bool relative);

/** \brief An image that was not localized, or not correctly. */
struct Failure {
  std::string run;  ///< may be empty
  std::string frame;
  std::string what;                 ///< such as "0.83 m and 12.10° off, probability 0.93"
  double probability = 0;           ///< probability of rank 1; 0 without an answer
  std::vector<DrawnMatch> answers;  ///< rank 1, then the true pose in the nearest local model
};

/** \brief The images whose rank 1 is not right (isRight()), the most confident of them first. Images taken
 * where the map has nothing fail only by an answer of probability kUnsure or more. \param runs that were
 * evaluated, with the poses of this map's local models. Throws std::runtime_error for an answer in a local
 * model that the map has not. */
std::vector<Failure> findFailures(const Evaluation& evaluation, const std::vector<RunResults>& runs,
                                  const Map& map, bool relative = false);

}  // namespace facetloc
