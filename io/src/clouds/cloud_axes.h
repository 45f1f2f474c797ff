// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/** \file
 * Organized clouds that are not as a camera sees them: in other axes, in millimetres, moved by their
 * viewpoint, with rows from the bottom up, or on the grid of an image with lens distortion. Private to io. */

namespace facetloc::internal {

/** \brief The depth image of a cloud, and the changes made to its points: a sentence without full stop, or
 * nothing. */
struct CloudImage {
  DepthImage image;
  std::string remark{};
  std::vector<std::uint32_t> pixels{};  ///< pixel of each point, or one beyond the image. Empty: in order
};

/** \brief The image of an organized PCD file: of a camera at the origin of the points; where that does not
 * fit, of the points in other axes, which a signed permutation turns into x right, y down, z forward, or of
 * the points before their viewpoint moved them; on a grid that a lens has bent, the points are sorted into a
 * pinhole grid. Throws IoError, also if nothing fits. \param camera that the points have to be those of, if
 * it is known */
CloudImage imageOfPcd(const std::filesystem::path& path, const std::optional<Intrinsics>& camera);

/** \brief Throws IoError for an image of another size, which was not taken with this camera. */
void requireSizeOf(const Intrinsics& camera, int width, int height, const std::filesystem::path& path);

}  // namespace facetloc::internal
