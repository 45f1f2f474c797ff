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

  /** \brief Marks of one kind, named in the legend. None are left out. */
  using Marks = std::pair<std::string, std::vector<Eigen::Isometry3d>>;
  /** \brief Throws IoError if it cannot be drawn. \param trajectory a way through the map */
  void draw(const std::filesystem::path& map, const std::vector<Eigen::Isometry3d>& trajectory = {},
            const std::vector<Marks>& marks = {}) const;

private:
  std::filesystem::path picture_, renderer_;
};

}  // namespace facetloc
