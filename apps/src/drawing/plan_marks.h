// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/page.h"

namespace facetloc {

/** \brief A segment from above, the darker the taller. \param from, to on the page. */
void drawWall(Page& page, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double height);
/** \brief A needle that points where a camera looks; none if that is straight up or down.
 * \param at on the page \param ahead its direction in the plan */
void drawHeading(Page& page, const Eigen::Vector2d& at, const Eigen::Vector2d& ahead, double length,
                 const Pen& pen);
void drawCross(Page& page, const Eigen::Vector2d& at, const Colour& colour);

}  // namespace facetloc
