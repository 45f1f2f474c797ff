// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <string>

namespace facetloc {

/** \brief The depth of a view as a small grey JPEG, darker = closer, black = not measured; empty for a view
 * without depth. \param width of the picture, at least; the depth picture is reduced by whole factors [px] */
std::string depthThumbnail(const View& view, int width);

}  // namespace facetloc
