// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/evaluation.h"

#include <facetloc/io/results.h>

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

namespace facetloc {

/** \brief The share of starts of a drive with a sure answer after N images or metres. */
struct StartCurve {
  struct Point {
    double x = 0;    ///< since the start: images, or the true distance [m]
    int starts = 0;  ///< that came so far
    int sure = 0;
    int right = 0;  ///< sure answers that are right

    double recall() const { return starts > 0 ? right / double(starts) : 0; }
    double precision() const { return sure > 0 ? right / double(sure) : 1; }
  };
  std::string name;  ///< images, metres
  std::vector<Point> points;
};

/** \brief The answers of starts over the number of images and over the true distance since each start. An
 * answer is right within the limits of a correct hypothesis. \param frames whose true poses are known; others
 * are left out \param T_true_estimated from the world of the answers to the world of the true poses */
std::vector<StartCurve> startCurves(const std::vector<StartAnswer>& answers,
                                    const std::vector<FrameEvaluation>& frames,
                                    const Eigen::Isometry3d& T_true_estimated,
                                    const EvaluationParams& params);

/** \brief Writes starts_by_NAME.csv of each curve, atomically. */
void writeStartCurves(const std::filesystem::path& folder, const std::vector<StartCurve>& curves);
/** \brief Some points of each. */
void printStartCurves(std::ostream& out, const std::vector<StartCurve>& curves);

}  // namespace facetloc
