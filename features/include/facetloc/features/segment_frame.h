// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/segment.h>

#include <pcl/memory.h>
#include <pcl/pcl_macros.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/register_point_struct.h>

#include <cstdint>
#include <ostream>
#include <vector>

namespace facetloc {

// PCL clouds have another layout in memory where Eigen aligns to more, as under -mavx.
static_assert(EIGEN_MAX_ALIGN_BYTES == 16,
              "facetloc's libraries and Debian's PCL are compiled for EIGEN_MAX_ALIGN_BYTES = 16: link "
              "facetloc's CMake targets, or compile with -DEIGEN_MAX_ALIGN_BYTES=16");

/** \brief A planar surface segment as a PCL point: Segment in single precision, at home in PCD files and
 * viewers. */
struct EIGEN_ALIGN16 SegmentFrame {
  PCL_ADD_POINT4D;                                       ///< t_F: centroid of the supporting points [m]
  float normal_x = 0.f, normal_y = 0.f, normal_z = 1.f;  ///< z axis of R_F, for PCL's viewers and filters
  float orientation[4] = {0.f, 0.f, 0.f, 1.f};           ///< R_F as a unit quaternion (x, y, z, w)
  float sigma_q[6] = {0.f, 0.f, 0.f, 0.f,
                      0.f, 0.f};  ///< upper triangle of Sigma_q: (sx,sx) (sx,sy) (sx,r) (sy,sy) (sy,r) (r,r)
  float lambda[2] = {0.f, 0.f};   ///< eigenvalues of Sigma_p [m^2]
  std::int32_t num_points = 0;    ///< support [px]
  float noise = 0.f;  ///< noise of inverse depth at 2 m, in the image that showed it [1/m]; 0 = unknown
  std::int32_t hull_size = 0;                     ///< vertices of the contour
  float hull[2 * ConvexHull::kMaxVertices] = {};  ///< (x, y) pairs in S_F, counter-clockwise [m]

  SegmentFrame() {
    x = y = z = 0.f;
    data[3] = 1.f;
  }
  Eigen::Quaternionf rotation() const {
    return {orientation[3], orientation[0], orientation[1], orientation[2]};
  }
  Eigen::Vector3f normal() const { return rotation() * Eigen::Vector3f::UnitZ(); }
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

SegmentFrame toSegmentFrame(const Segment& segment);
/** \brief "(x,y,z - nx,ny,nz - n points)", as PCL writes its points. */
std::ostream& operator<<(std::ostream& out, const SegmentFrame& frame);
/** \brief False if a field is not finite, the quaternion is not a rotation, Sigma_q is not positive definite,
 * the hull is malformed, or the normal is another than the orientation's, as after
 * pcl::transformPointCloudWithNormals(); out is then unchanged. Never crashes, whatever the bytes. */
bool toSegment(const SegmentFrame& frame, Segment& out);

pcl::PointCloud<SegmentFrame> toCloud(const std::vector<Segment>& segments);

/** \brief The frame in other coordinates, T * F: orientation and origin move, q and hull live in S_F. */
SegmentFrame transformed(const SegmentFrame& frame, const Eigen::Isometry3d& T);
/** \brief The same of all; pcl::transformPointCloud() moves x, y and z only and leaves frames that lie. */
pcl::PointCloud<SegmentFrame> transformed(const pcl::PointCloud<SegmentFrame>& frames,
                                          const Eigen::Isometry3d& T);

}  // namespace facetloc

POINT_CLOUD_REGISTER_POINT_STRUCT(
    facetloc::SegmentFrame,
    (float, x, x)(float, y, y)(float, z, z)(float, normal_x, normal_x)(float, normal_y, normal_y)(
        float, normal_z, normal_z)(float[4], orientation, orientation)(float[6], sigma_q, sigma_q)(
        float[2], lambda, lambda)(std::int32_t, num_points,
                                  num_points)(float, noise, noise)(std::int32_t, hull_size,
                                                                   hull_size)(float[48], hull, hull))
