// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/io/trajectory.h>

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

namespace facetloc {

/** \brief The poses of a trajectory, to be drawn. */
std::vector<Eigen::Isometry3d> posesOf(const Trajectory& trajectory);

/** \brief The corners of a segment's hull in another frame. */
std::vector<Eigen::Vector3d> cornersOf(const Segment& segment, const Eigen::Isometry3d& T);

/** \brief Which way is up in a camera's frame, unit vector: by its mounting, or else by the planes that lie
 * about across the image's vertical. */
Eigen::Vector3d upInView(const View& view, const std::optional<CameraMounting>& mounting);

/** \brief The upward direction in the frame of a part of a map: z if that is about right, else the direction
 * that its views show. Models without a pose do not count. */
Eigen::Vector3d upInPart(const Map& map, int part);

/** \brief A segment seen from above. */
struct PlanLine {
  Eigen::Vector2d from, to;  ///< [m]
  double height = 0;         ///< vertical extent of the segment [m]
};

/** \brief The world from above. */
class PlanView {
public:
  /** \param up unit vector; with z up, x is to the right and y to the top. */
  explicit PlanView(const Eigen::Vector3d& up);
  Eigen::Vector2d point(const Eigen::Vector3d& p) const { return axes_ * p; }
  /** \brief The horizontal part of a direction; not normalised. */
  Eigen::Vector2d direction(const Eigen::Vector3d& d) const { return axes_ * d; }
  /** \brief An upright segment from above; nothing for one that leans by more than 15 degrees. */
  std::optional<PlanLine> line(const Segment& segment, const Eigen::Isometry3d& T_w_m) const;

private:
  Eigen::Vector3d up_;
  Eigen::Matrix<double, 2, 3> axes_;  // rows: to the right, to the top
};

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

/** \brief The largest of 1, 2, 5, 10, ... that does not exceed a length [m]. */
double roundLength(double length);
/** \brief Height from which on a segment is drawn darkest [m]. */
constexpr double kTallestWall = 1.5;

}  // namespace facetloc
