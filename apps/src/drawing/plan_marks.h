// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/page.h"

#include <Eigen/Geometry>

namespace facetloc {

/** \brief Scale from metres to a box of a page, in whose middle the extent lies. */
class PlanScale {
public:
  PlanScale(const Eigen::AlignedBox2d& extent, double pixels_per_metre, const Box& box)
      : low_(extent.center() - Eigen::Vector2d(box.width, box.height) / (2 * pixels_per_metre)),
        pixels_per_metre_(pixels_per_metre),
        box_(box) {}

  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d offset = pixels_per_metre_ * (p - low_);
    return {box_.left + offset.x(), box_.bottom() - offset.y()};
  }
  /** \brief The point that is drawn at a place of the page. */
  Eigen::Vector2d pointAt(const Eigen::Vector2d& place) const {
    return low_ + Eigen::Vector2d(place.x() - box_.left, box_.bottom() - place.y()) / pixels_per_metre_;
  }
  double pixelsPerMetre() const { return pixels_per_metre_; }
  const Box& box() const { return box_; }

private:
  Eigen::Vector2d low_;  // [m]
  double pixels_per_metre_;
  Box box_;
};

/** \brief Smaller plans are drawn as if they were this large [m]. */
constexpr double kLeastExtent = 0.5;
/** \brief Scale of a plan that is to fill a box. */
double pixelsPerMetreFor(const Eigen::AlignedBox2d& extent, double width, double height);

/** \brief A segment from above, the darker the taller. \param from, to on the page. */
void drawWall(Page& page, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double height);
/** \brief A needle that points where a camera looks; none if that is straight up or down.
 * \param at on the page \param ahead its direction in the plan */
void drawHeading(Page& page, const Eigen::Vector2d& at, const Eigen::Vector2d& ahead, double length,
                 const Pen& pen);
void drawCross(Page& page, const Eigen::Vector2d& at, const Colour& colour);

}  // namespace facetloc
