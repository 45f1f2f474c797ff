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

/** \brief What the names of a recording's files say of it. */
struct RecordingLayout {
  enum class Kind {
    plain,         ///< TUM's, where names are stamps, or images in the order of their names
    listed,        ///< a list gives the stamps
    seven_scenes,  ///< frame-000000.depth.png, frame-000000.pose.txt
    scannet,       ///< depth/0.png, pose/0.txt
    icl_nuim,      ///< depth/0.png, *.gt.freiburg
  };
  Kind kind = Kind::plain;
  std::vector<FrameFile> frames;  ///< in the order of their stamps
  bool stamped = false;           ///< are the stamps times, rather than indices?
  RecordedPoses poses;

  /** \brief "7-Scenes", "images named by their times". */
  std::string inWords() const;
};

/** \brief Recordings that number their images have so many per second. */
constexpr double kFrameRate = 30;

/** \brief Where images have no stamps by their names, those are in a list beside them, or they are numbered,
 * or else the order is all that is known of their times. Images without names of their own that are stamps
 * are named by their stamps, with 6 decimals. Throws IoError for a name that is none among stamps.
 * \param beside folders to look for lists and poses in */
RecordingLayout layoutOf(const std::vector<ListedImage>& images,
                         const std::vector<std::filesystem::path>& beside);

/** \brief The time that the name of an image is or has in it, as those of PCL's recorders do, [s]. */
std::optional<double> stampInName(const std::string& name);

/** \brief A name that is a stamp. */
std::string nameOfStamp(double stamp);

}  // namespace facetloc::internal
