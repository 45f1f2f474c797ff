// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <embree3/rtcore.h>
#include <functional>

namespace facetloc::internal {

/** \brief One geometry of Embree and the rays that are cast at it. */
class RayCaster {
public:
  RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;
  ~RayCaster();

  /** \brief Triangles, filled in by a function. Memory is Embree's. */
  struct Triangles {
    float* vertices;         ///< x, y, z of each
    std::uint32_t* corners;  ///< three indices of each
  };
  void setTriangles(std::size_t vertices, std::size_t triangles,
                    const std::function<void(const Triangles&)>& fill);

  /** \brief Discs, filled in by a function. */
  struct Discs {
    float* centres;  ///< x, y, z and the radius of each
    float* normals;  ///< x, y, z of each
  };
  void setDiscs(std::size_t discs, const std::function<void(const Discs&)>& fill);

  /** \brief Depth of the first hit of the ray through each pixel; 0 without one. Thread-safe.
   * \param fronts_only 0, too, where it is the back of a triangle, from which its vertices are clockwise */
  DepthImage depth(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c, bool fronts_only = false) const;

private:
  template <class Number>
  Number* buffer(RTCBufferType type, RTCFormat format, std::size_t numbers, std::size_t items);
  void commit();
  void requireNoError() const;

  RTCDevice device_;
  RTCScene scene_ = nullptr;
  RTCGeometry geometry_ = nullptr;
};

}  // namespace facetloc::internal
