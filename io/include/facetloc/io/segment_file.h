// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/segment.h>

#include <filesystem>
#include <vector>

namespace facetloc {

/** \brief Writes segments as a binary_compressed PCD of SegmentFrame, atomically; no segments give a valid
 * file of no points. Throws IoError. */
void writeSegments(const std::filesystem::path& path, const std::vector<Segment>& segments);

/** \brief Writes labels as a 16-bit PNG, atomically. */
void writeLabels(const std::filesystem::path& path, const LabelImage& labels);

}  // namespace facetloc
