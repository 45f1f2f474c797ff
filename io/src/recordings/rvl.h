// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "images/depth_file.h"
#include "recordings/message_reader.h"

#include <string>

/** \file
 * RVL, a code of depth images (Wilson, Fast Lossless Depth Image Compression, 2017). Private to io. */

namespace facetloc::internal {

/** \brief An image from its code, in front of which are its width and height, as compressedDepth of ROS and
 * RTAB-Map have it.
 *
 * Runs alternate: a number of zeros, a number of other values, each of these as its difference to the one
 * before. Numbers are coded in nibbles, three bits each from the lowest on, the fourth says that another one
 * follows; nibbles fill little-endian words of 32 bits from the top. Differences d are coded as 2d, or as -2d
 * - 1 if they are negative. Throws IoError for a code of another number of pixels. \param name in errors */
StoredDepth readRvl(ByteView bytes, const std::string& name);

}  // namespace facetloc::internal
