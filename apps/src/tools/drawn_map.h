// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace facetloc {

/** \brief The floor map of a file, drawn by facetloc_render, as only that tool needs VTK. */
class DrawnMap {
public:
  /** \brief Throws UsageError for a file that is no picture, IoError if facetloc_render is not installed. */
  explicit DrawnMap(std::filesystem::path picture);

  /** \brief Throws IoError if it cannot be drawn. \param plan that the map was made of; may be empty */
  void draw(const std::filesystem::path& map, const std::filesystem::path& plan = {}) const;

private:
  std::filesystem::path picture_, renderer_;
};

}  // namespace facetloc
