// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "images/depth_file.h"
#include "recordings/message_reader.h"

#include <facetloc/features/camera_model.h>

#include <Eigen/Geometry>

#include <map>
#include <optional>
#include <string>

/** \file
 * The cells of a database of RTAB-Map. Private to io. */

namespace facetloc::internal {

/** \brief A camera, and where it is on its robot. */
struct RtabmapCamera {
  Intrinsics intrinsics;  ///< intrinsics of the colour image
  Eigen::Isometry3d T_b_c = Eigen::Isometry3d::Identity();
};

/** \brief Throws IoError for stereo cameras, for several cameras, and for the form of version 0.11. \param
 * name in errors, of these and of the others */
RtabmapCamera readRtabmapCamera(ByteView bytes, const std::string& name);

/** \brief 12 floats, the upper rows of a matrix. Nothing for a lost pose. Throws IoError. */
std::optional<Eigen::Isometry3d> readRtabmapPose(ByteView bytes, const std::string& name);

/** \brief The poses of the graph, by node: matrices that are packed by zlib, with their sizes behind. */
std::map<int, Eigen::Isometry3d> readRtabmapGraph(ByteView ids, ByteView poses, const std::string& name);

/** \brief A PNG of 16 bits [mm], a PNG whose red, green, blue and alpha are the bytes of floats [m], or
 * "DEPTHRVL" and an RVL code [mm]. Throws IoError. */
StoredDepth readRtabmapDepth(ByteView bytes, const std::string& name);

}  // namespace facetloc::internal
