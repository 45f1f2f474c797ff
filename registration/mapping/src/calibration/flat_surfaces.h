// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/depth_image.h>
#include <facetloc/mapping/map_findings.h>

#include <vector>

namespace facetloc::internal {

/** \brief A large surface that is flat as an image is read. */
struct FlatSurface {
  std::size_t image = 0;
  double share = 0;                      ///< share of the pixels of the image
  Eigen::Vector3d plane;                 ///< m of the plane m . p = 1 [1/m]
  std::vector<Eigen::Vector3d> samples;  ///< normalised ray x, y, and inverse depth [1/m]
  double weight = 0;                     ///< weight of a squared residual: by the noise at its depth [m^2]
};

/** \brief The largest surfaces of some images. */
struct FlatSurfaces {
  std::vector<FlatSurface> surfaces;  ///< sorted as the images
  double flat_share = 0;              ///< as of SurfaceBend
};

/** \brief Possible meanings of the numbers of depth images. */
enum class DepthIs {
  z,         ///< as they are read
  distance,  ///< along the ray, taken for z
  product,   ///< z, taken for a distance along the ray
  inverse,   ///< proportional to 1/z, taken for z
};

/** \brief Segments images under an assumed meaning of their numbers. */
FlatSurfaces flatSurfaces(const std::vector<DepthImage>& images, const Camera& camera, DepthIs meaning);

/** \brief How surfaces that look flat are bent nevertheless, beyond the reading that they were found with. */
SurfaceBend bendOf(const FlatSurfaces& flat);

/** \brief Nothing if fewer than 5 images show two surfaces that are not parallel. */
std::optional<SurfaceAngles> surfaceAngles(const FlatSurfaces& flat, const Intrinsics& camera);

}  // namespace facetloc::internal
