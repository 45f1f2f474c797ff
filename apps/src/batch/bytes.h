// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_distortion.h>
#include <facetloc/io/results.h>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

struct View;

/** \brief Statistics of one image that reveal a wrong map, camera or scale; 0 if unknown. */
struct ViewTraits {
  double noise = 0;  ///< standard deviation of inverse depth, found in the image [1/m]
  double fov = 0;    ///< horizontal field of view [deg]
  double depth = 0;  ///< median [m]

  static ViewTraits of(const View& view);
};

/** \brief The result of an image, and the statistics of its view. */
using LocalizedImage = std::pair<FrameResult, ViewTraits>;
/** \brief The images of a recording that become local models, and the distortion of their camera. */
using ModelsOrder = std::pair<std::vector<std::size_t>, std::optional<DepthDistortion>>;

/** \brief A value as bytes, every number to the last bit, for another process of the same program on a
 * machine of the same kind: no format for files. For the types that bytes.cpp lists at its end. */
template <class T>
std::string toBytes(const T& value);
/** \brief The value again. Throws std::runtime_error if the bytes are not those of such a value. */
template <class T>
T fromBytes(const std::string& bytes);

}  // namespace facetloc
