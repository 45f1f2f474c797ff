// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/box.h"
#include "drawing/pictures.h"

#include <facetloc/features/local_model.h>

#include <array>
#include <filesystem>
#include <vector>

namespace facetloc {

/** \brief A part of a map seen from above. */
struct FloorPlan {
  PlanView view;
  std::vector<PlanLine> walls;            ///< upright segments
  std::vector<Eigen::Isometry3d> models;  ///< poses of the local models
  std::vector<std::array<Eigen::Vector3d, 2>> links;

  Eigen::AlignedBox2d extent() const;
};
/** \brief Models without a pose are left out. */
FloorPlan floorPlan(const Map& map, int part);
/** \brief The main part. Throws IoError, with the name of the picture that was to be, if no model of the map
 * has a pose. */
FloorPlan floorPlan(const Map& map, const std::filesystem::path& picture);

/** \brief Extends the extent of a plan to runs and marks. */
void extend(Eigen::AlignedBox2d& extent, const PlanView& view, const std::vector<DrawnRun>& runs,
            const std::vector<DrawnMarks>& marks);
/** \brief The largest of 1, 2, 5, 10, ... that does not exceed a length [m]. */
double roundLength(double length);

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

/** \brief Height from which on a segment is drawn darkest [m]. */
constexpr double kTallestWall = 1.5;

}  // namespace facetloc
