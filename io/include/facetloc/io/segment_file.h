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

/** \brief The end of the names of such files. */
constexpr const char* kSegmentEnding = ".segments.pcd";
bool isSegmentFile(const std::filesystem::path& path);

/** \brief The segments of such a file, in its order. Throws IoError, which names it, for a file that is no
 * PCD file, lacks the fields of SegmentFrame, or holds an invalid frame.
 */
std::vector<Segment> readSegments(const std::filesystem::path& path);

/** \brief Writes labels as a 16-bit PNG, atomically. */
void writeLabels(const std::filesystem::path& path, const LabelImage& labels);

}  // namespace facetloc
