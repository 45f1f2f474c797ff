// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/evaluation.h"

#include <string>
#include <vector>

namespace facetloc {

/** \brief The frames that an evaluation is about: the new ones, or all where none is known to be new. */
std::vector<FrameEvaluation> framesInQuestion(const Evaluation& evaluation);

/** \brief The frames of results without truth: the answers' own numbers, at their poses. */
Evaluation withoutTruth(const std::vector<RunResults>& runs);

/** \brief Whether the first pose of an answer is right; empty without a pose or a known error.
 * \param relative by the error relative to its local model, else by the one in the world */
std::optional<bool> isRight(const FrameEvaluation& frame, bool relative);
/** \brief Error of the first pose of an answer, by which isRight() judges it. */
const std::optional<PoseError>& errorOf(const FrameEvaluation& frame, bool relative);

/** \brief The frames for which a quantity lies in [lowest, highest); summary.name is that range in words. */
struct ErrorGroup {
  double lowest = 0;
  double highest = 0;  ///< infinite in the last group
  double mean = 0;     ///< mean of the quantity
  Summary summary;
};
/** \brief Frames by the number of true planes in view, without empty groups. Left out: frames of which it is
 * not known, and those where the map has nothing. */
std::vector<ErrorGroup> errorsByVisiblePlanes(const std::vector<FrameEvaluation>& frames);
/** \brief The same by the distance to the most similar local model [m]. */
std::vector<ErrorGroup> errorsByDistance(const std::vector<FrameEvaluation>& frames);

/** \brief How long a stage took per image. */
struct StageTime {
  std::string stage;
  Sample ms;
};
/** \brief Nearly all images: tables say how long they took at most. */
constexpr double kMostShare = 0.95;
/** \brief Times of segmentation, features, localization and their sum; none without rows. Failed images are
 * left out. */
std::vector<StageTime> stageTimes(const std::vector<TimingRow>& rows);

/** \brief Kinds of unsatisfactory answers, the worst first. */
enum class MissKind {
  confident_wrong,  ///< sure, and rank 1 is wrong
  sure_of_nothing,  ///< the map has nothing there, yet rank 1 has a probability of at least kUnsure
  not_found,        ///< covered, or of unknown class, and no hypothesis is correct
  not_first         ///< correct, but not at rank 1
};
const char* toString(MissKind kind);

struct Miss {
  MissKind kind = MissKind::not_found;
  FrameEvaluation frame;
};
/** \brief The misses among the frames in question, by kind; a frame is in the first kind that fits. \param
 * relative as in isRight() */
std::vector<Miss> misses(const Evaluation& evaluation, bool relative = false);

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

}  // namespace facetloc
