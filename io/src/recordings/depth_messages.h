// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "images/depth_file.h"
#include "recordings/ros_messages.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/features/depth_image.h>

#include <Eigen/Geometry>

#include <map>
#include <optional>
#include <string>

namespace facetloc::internal {

/** \brief The encodings that are read, for messages. */
constexpr const char* kDepthEncodings =
    "depth is read from sensor_msgs/Image of 16UC1, mono16 or 32FC1, and from "
    "CompressedImage of compressedDepth or PNG of 16 bits";

/** \brief Is it depth: 16UC1, mono16 or 32FC1? */
bool isDepth(const ImageMessage& image);
/** \brief Is it the format compressedDepth of image_transport, or a grey PNG of 16 bits? */
bool isDepth(const CompressedImageMessage& image);

/** \brief The image of such a message. Throws IoError for any other, and for corrupt ones. \param name in
 * errors */
StoredDepth readDepth(const ImageMessage& image, const std::string& name);

/** \brief The PNG, or the image of compressedDepth: behind 12 bytes, a number and the two parameters a and b
 * of a quantization, a PNG of 16 bits or an RVL code. Of 32FC1, a value v > 0 is the depth a / (v - b).
 * Throws IoError. \param name in errors */
StoredDepth readDepth(const CompressedImageMessage& image, const std::string& name);

/** \brief A grey PNG of 16 bits. Throws IoError. \param name in errors */
StoredDepth readPngValues(ByteView bytes, const std::string& name);

/** \brief The image of values, with the size that it has and no intrinsics; numbers by the scale [1/m], 0 and
 * 65535 of which are not measured. */
DepthImage depthImageOf(StoredDepth values, double scale);

/** \brief An image from its RVL code (Wilson, Fast Lossless Depth Image Compression, 2017), in front of which
 * are its width and height, as compressedDepth of ROS and RTAB-Map have it.
 *
 * Runs alternate: a number of zeros, a number of other values, each of these as its difference to the one
 * before. Numbers are coded in nibbles, three bits each from the lowest on, the fourth says that another one
 * follows; nibbles fill little-endian words of 32 bits from the top. Differences d are coded as 2d, or as -2d
 * - 1 if they are negative. Throws IoError for a code of another number of pixels. \param name in errors */
StoredDepth readRvl(ByteView bytes, const std::string& name);

// The cells of a database of RTAB-Map.

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
