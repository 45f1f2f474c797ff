// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/image_list.h"

#include <filesystem>
#include <string>
#include <vector>

/** \file
 * Times and poses of images in JSON, as scanner apps of phones and NeRF programs write them. Private to io.
 */

namespace facetloc::internal {

/** \brief Images with the times and poses of the JSON beside them, in the order of the images. */
struct ScannedImages {
  std::vector<ListedImage> images;  ///< stamps in the unit of the file; poses of the optical frame
  std::filesystem::path file;       ///< the first one; empty without any
  std::size_t unknown = 0;          ///< images without an entry
  std::string fault;                ///< the first file or entry that cannot be read; or nothing

  bool stamped() const;  ///< has each a time of its own?
  bool posed() const;    ///< has any a pose?
  /** \brief Their source and the fault, a sentence without full stop. */
  std::string remark(bool with_times) const;
};

/** \brief The entries of `transforms*.json` (`frames` of `file_path` or `depth_file_path`,
 * `transform_matrix`, `timestamp`), or of one JSON file per image with the numbers of its name
 * (`cameraPoseARFrame`, `time` or `timestamp`). Matrices are 4x4 by rows, of cameras whose y axis points up
 * and z axis backward. Empty unless more than half of the images have an entry. \param folders searched one
 * after the other */
ScannedImages scannedImages(const std::vector<ListedImage>& images,
                            const std::vector<std::filesystem::path>& folders);

}  // namespace facetloc::internal
