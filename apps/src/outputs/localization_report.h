// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "batch/bytes.h"
#include "cli/command_line.h"

#include <facetloc/features/finding.h>
#include <facetloc/features/local_model.h>
#include <facetloc/io/results.h>
#include <facetloc/registration/hypothesis.h>

#include <string>
#include <vector>

namespace facetloc {

/** \brief The lines of hypotheses.csv for one frame: at most max_hypotheses, or one of rank 0 with the
 * reason. */
std::vector<ResultRow> resultRows(const std::string& frame, const Localization& answer, const Map& map,
                                  int max_hypotheses);
/** \brief The ranked poses as a table for people, each in the world, in the frame of its part of the map, or
 * else in its local model. \param world its name */
void printPoses(std::ostream& out, const std::vector<ResultRow>& rows, const std::string& world);
/** \brief "turn 60° to the left, then drive 1.5 m ahead". */
std::string toString(const NextLook& look);
/** \brief The line of a frame without an answer. */
ResultRow noHypothesis(const std::string& frame, const std::string& reason);

/** \brief The option of tools that tell sure answers from others. */
void addMinProbability(CommandLine& line, double& min_probability);

/** \brief How many frames have an answer of each state. */
struct StateCounts {
  int sure = 0, doubtful = 0, unknown = 0;

  void add(AnswerState state);
  int all() const { return sure + doubtful + unknown; }
};
/** \brief "235 images: 221 sure, 9 doubtful, 5 unknown". */
std::string toString(const StateCounts& counts);

/** \brief The median of values that are known; 0 without any. */
double medianOfKnown(std::vector<double> values);

/** \brief If hardly any answer is sure, things to check: sentences that begin with the likeliest cause. Else
 * empty. \param views of the images, as far as they are known */
Findings whatToLookAt(const StateCounts& counts, const std::vector<ViewTraits>& views, const Map& map);

}  // namespace facetloc
