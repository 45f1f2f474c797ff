// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "images/depth_file.h"
#include "recordings/ros_messages.h"

#include <facetloc/features/depth_image.h>

#include <string>

namespace facetloc::internal {

/** \brief Is it depth: 16UC1, mono16 or 32FC1? */
bool isDepth(const ImageMessage& image);
/** \brief Is it the format compressedDepth of image_transport? */
bool isDepth(const CompressedImageMessage& image);

/** \brief The image of such a message. Throws IoError for any other, and for corrupt ones. \param name in
 * errors */
StoredDepth readDepth(const ImageMessage& image, const std::string& name);

/** \brief The image of compressedDepth: behind 12 bytes, a number and the two parameters a and b of a
 * quantization, a PNG of 16 bits or an RVL code. Of 32FC1, a value v > 0 is the depth a / (v - b). Throws
 * IoError. \param name in errors */
StoredDepth readDepth(const CompressedImageMessage& image, const std::string& name);

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

}  // namespace facetloc::internal
