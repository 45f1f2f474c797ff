// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "trajectory/overlap_verdict.h"

#include <map>
#include <optional>
#include <utility>

namespace facetloc::internal {

/** \brief Numbers of two pieces of a trajectory, the smaller first. */
using PiecePair = std::pair<int, int>;
/** \brief Independent ties between pieces. */
using PieceBonds = std::map<PiecePair, int>;

/** \brief The bond that is to be cut next, if any: one with too few independent ties, or else, where the
 * verdicts on two pieces contradict their relative pose, the one most contradicted among those that lead from
 * one to the other. Same input, same answer. */
std::optional<PiecePair> weakestBond(const PieceVerdicts& verdicts, const PieceBonds& bonds, int least_ties);

}  // namespace facetloc::internal
