// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/image_list.h"
#include "recordings/recorded_poses.h"

#include <facetloc/io/depth_sequence.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/** \file
 * The layouts in which people have recordings, which the names of their files tell from each other. Private
 * to io.
 */

namespace facetloc::internal {

/** \brief The content of a recording by the names of its files. */
struct RecordingLayout {
  enum class Kind {
    plain,         ///< TUM's, where names are stamps, or images in the order of their names
    listed,        ///< a list gives the stamps
    seven_scenes,  ///< frame-000000.depth.png, frame-000000.pose.txt
    scannet,       ///< depth/0.png, pose/0.txt
    icl_nuim,      ///< depth/0.png, *.gt.freiburg
  };
  Kind kind = Kind::plain;
  std::vector<FrameFile> frames;  ///< sorted by stamp
  bool stamped = false;           ///< are the stamps times, rather than indices?
  std::vector<double> numbers;    ///< numbers in the names of the frames, or before these in a list; or empty
  TimeUnit unit;                  ///< unit of the numbers
  RecordedPoses poses;
  std::string remark;  ///< assumptions made, a sentence without full stop, or nothing

  /** \brief "7-Scenes", "images named by their times". */
  std::string toString() const;
  ImageTimes times() const;
};

/** \brief Where images have no stamps by their names, those are in a list beside them, or they are numbered,
 * or else only their order is known. Images without names of their own that are stamps
 * are named by their stamps, with 6 decimals. Images that are numbered take the stamps of poses beside them
 * that are the same numbers, or as many. Throws IoError for a name without a stamp among stamps.
 * \param beside folders to look for lists and poses in \param within those of them that are the
 * recording's own, where poses may have any name */
RecordingLayout layoutOf(const std::vector<ListedImage>& images,
                         const std::vector<std::filesystem::path>& beside,
                         const std::vector<std::filesystem::path>& within);

/** \brief A name that is a stamp. */
std::string nameOfStamp(double stamp);

}  // namespace facetloc::internal
