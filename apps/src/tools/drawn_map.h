// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief The floor map of a file, drawn by facetloc_render, as only that tool needs VTK. */
class DrawnMap {
public:
  /** \brief Throws UsageError for a file that is no picture, IoError if facetloc_render is not installed. */
  explicit DrawnMap(std::filesystem::path picture);

  /** \brief A way through the map. */
  void setTrajectory(std::vector<Eigen::Isometry3d> T_w_c) { trajectory_ = std::move(T_w_c); }
  /** \brief Marks of one kind, named in the legend. None are left out. */
  void addMarks(const std::string& name, std::vector<Eigen::Isometry3d> T_w_c);
  /** \brief Throws IoError if it cannot be drawn. */
  void draw(const std::filesystem::path& map) const;

private:
  std::filesystem::path picture_, renderer_;
  std::vector<Eigen::Isometry3d> trajectory_;
  std::vector<std::pair<std::string, std::vector<Eigen::Isometry3d>>> marks_;
};

}  // namespace facetloc
