// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/pose.h>
#include <facetloc/registration/pose_prior.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace facetloc::internal {

/** \brief A vertical plane of a view, seen from above.
 *
 * Its frame is the upright camera frame: z up, the optical centre above its origin on the floor, x where the
 * camera looks. An end counts only if it is certain to be an end of the surface: one at the image border is
 * not. */
struct Wall {
  float heading = 0;           ///< heading of the normal, which points away from the camera [rad], (-pi, pi]
  float cosine = 1, sine = 0;  ///< direction of the heading
  float offset = 0;            ///< distance of the plane from the origin [m]
  float right = 0, left = 0;   ///< extent along z x normal, right <= left [m]
  float bottom = 0, top = 0;   ///< extent in height above the floor [m]
  float weight = 0;            ///< fourth root of its area [m^0.5]
  bool right_end = false, left_end = false, bottom_end = false, top_end = false;  ///< seen in the image

  // The extent, NaN where its end is not seen: that is near nothing.
  float seenRight() const { return right_end ? right : kNotSeen; }
  float seenLeft() const { return left_end ? left : kNotSeen; }
  float seenBottom() const { return bottom_end ? bottom : kNotSeen; }
  float seenTop() const { return top_end ? top : kNotSeen; }
  static constexpr float kNotSeen = std::numeric_limits<float>::quiet_NaN();
};

/** \brief The difference of two headings, not more than half a turn [rad]. */
inline float wrapped(float difference) {
  constexpr auto kPi = static_cast<float>(180 * kDegree);
  if (difference > kPi) return difference - 2 * kPi;
  return difference < -kPi ? difference + 2 * kPi : difference;
}

/** \brief A horizontal plane of a view that is not the floor, in the same frame. */
struct LevelSurface {
  float height = 0;         ///< above the floor [m]
  bool from_below = false;  ///< like a ceiling
  float x = 0, y = 0;       ///< centroid [m]
};

/** \brief A coarse depth image [mm], 0 = unknown. */
struct DepthThumbnail {
  Intrinsics camera;
  std::vector<std::uint16_t> depth;  ///< row-major
};

/** \brief The characteristic features of the place that a view shows, independent of the uninformative
 * effects of a camera's motion on a floor: roll, pitch and height.
 *
 * Heading and position on the floor remain unknown; the offsets of parallel walls differ by the same amount
 * from everywhere, and so do heights, angles between walls, and ends of walls from walls across.
 *
 * Most places are built along two directions at right angles. Walls facing a main heading come first, side
 * by side: those from facing[k] to facing[k + 1] face main_heading + k quarters of a turn. */
struct PlaceDescriptor {
  Eigen::Matrix3f R_u_c = Eigen::Matrix3f::Identity();  ///< camera axes in the upright frame
  float height = 0;                                     ///< height of the camera above the floor [m]
  float main_heading = 0;                               ///< [rad], within an eighth of a turn of 0
  std::array<std::int32_t, 5> facing{};
  std::vector<Wall> walls;
  std::vector<LevelSurface> surfaces;
  DepthThumbnail picture;  ///< empty if the view has no depth
};

/** \brief The signature of a view whose camera is mounted so.
 *
 * Roll and pitch are estimated from the planes that are nearly horizontal or vertical, with the floor's
 * unevenness as prior; the height from the floor where it is seen. Segments that are not finite are left
 * out; a view without any gives an empty signature. */
PlaceDescriptor placeDescriptor(const View& view, const CameraMounting& mounting,
                                const PosePriorParams& prior = {});

/** \brief Can it be the signature of a view? One that is read from elsewhere may hold any numbers. */
bool isSound(const PlaceDescriptor& place);

/** \brief Walls, property by property, for many of them at once are compared. Filled up beyond the last one
 * with NaN, which is like nothing. */
struct WallColumns {
  explicit WallColumns(const std::vector<Wall>& walls);
  /** \brief Filled up to whole vectors (lanes.h). From each element before size() on, a whole vector can be
   * read. */
  std::size_t size() const { return size_; }

  std::vector<float> heading, offset, right, left, bottom, top, weight;
  std::vector<float> seen_right, seen_left, seen_bottom, seen_top;  ///< NaN where the end is not seen

private:
  std::size_t size_;
};

/** \brief Points, coordinate by coordinate, for many of them at once are moved and looked up [m]. */
struct PointColumns {
  std::vector<float> x, y, z;

  std::size_t size() const { return x.size(); }
  void resize(std::size_t n) { x.resize(n), y.resize(n), z.resize(n); }
};

/** \brief Some pixels of the picture, without the floor, relative to the camera in upright axes. */
void pointsAboveFloor(const PlaceDescriptor& place, PointColumns& points);

}  // namespace facetloc::internal
