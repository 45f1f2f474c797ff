// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/simulation/simulated_place.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

/** \file
 * Intersections of a camera's rays with a world. */

namespace facetloc {

inline constexpr double kNearPlane = 0.05;      // [m]
inline constexpr double kEdgeTolerance = 1e-9;  // [m] closes the cracks between rectangles that share an edge
inline constexpr double kMiss = std::numeric_limits<double>::infinity();

/** A rectangle in the camera frame, ready for rays: the plane n . p = d and the two coordinates in it. */
struct Facet {
  Eigen::Vector3d normal, axis_u, axis_v;
  double distance, centre_u, centre_v, half_u, half_v;
  std::uint16_t label;
  Material material;

  Facet(const Rectangle& r, const Eigen::Isometry3d& T_c_w)
      : axis_u(T_c_w.linear() * r.axis_u),
        axis_v(T_c_w.linear() * r.axis_v),
        half_u(r.half_u),
        half_v(r.half_v),
        label(r.plane_id),
        material(r.material) {
    const Eigen::Vector3d centre = T_c_w * r.centre;
    normal = axis_u.cross(axis_v);
    distance = normal.dot(centre);
    centre_u = axis_u.dot(centre);
    centre_v = axis_v.dot(centre);
  }
  /** Depth at which a ray with b_z = 1 meets the whole plane; negative or infinite if it does not. */
  double depthAlong(const Eigen::Vector3d& ray) const { return distance / normal.dot(ray); }
  /** ... the rectangle itself. */
  double hitAlong(const Eigen::Vector3d& ray) const {
    const double z = depthAlong(ray);
    return z >= kNearPlane && contains(z * ray) ? z : kMiss;
  }
  bool contains(const Eigen::Vector3d& p) const {
    return std::abs(axis_u.dot(p) - centre_u) <= half_u + kEdgeTolerance &&
           std::abs(axis_v.dot(p) - centre_v) <= half_v + kEdgeTolerance;
  }
  Eigen::Vector3d normalAt(const Eigen::Vector3d&) const { return normal; }
  std::array<Eigen::Vector3d, 4> corners() const {
    const Eigen::Vector3d centre = distance * normal + centre_u * axis_u + centre_v * axis_v;
    const Eigen::Vector3d u = half_u * axis_u, v = half_v * axis_v;
    return {centre - u - v, centre + u - v, centre + u + v, centre - u + v};
  }
};

/** A round body in the camera frame: |S (p - c)| = 1, where S scales the axes that are round. */
struct Quadric {
  std::uint16_t label = 0;  // it is no plane
  Eigen::Isometry3d T_b_c;
  Eigen::Vector3d half_size, round;  // round: 1 / half size, 0 along a cylinder
  Material material;

  Quadric(const RoundBody& body, const Eigen::Isometry3d& T_c_w)
      : T_b_c((T_c_w * body.T_w_b).inverse()),
        half_size(body.half_size),
        round(half_size.cwiseInverse()),
        material(body.material) {
    if (body.shape == RoundBody::Shape::cylinder) round.z() = 0;
  }
  /** Depth at which a ray first enters, or leaves from inside an open end. */
  double depthAlong(const Eigen::Vector3d& ray) const {
    const Eigen::Vector3d direction = T_b_c.linear() * ray;
    const Eigen::Vector3d o = round.cwiseProduct(T_b_c.translation()), d = round.cwiseProduct(direction);
    const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - 1;
    const double discriminant = b * b - a * c;
    if (!(a > 0 && discriminant > 0)) return kMiss;
    for (const double root : {-std::sqrt(discriminant), std::sqrt(discriminant)}) {
      const double z = (root - b) / a;
      const double height = T_b_c.translation().z() + z * direction.z();
      if (z >= kNearPlane && std::abs(height) <= half_size.z()) return z;
    }
    return kMiss;
  }
  double hitAlong(const Eigen::Vector3d& ray) const { return depthAlong(ray); }
  Eigen::Vector3d normalAt(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d gradient = round.cwiseAbs2().cwiseProduct(T_b_c * p);
    return (T_b_c.linear().transpose() * gradient).normalized();
  }
  std::array<Eigen::Vector3d, 8> corners() const {
    const Eigen::Isometry3d T_c_b = T_b_c.inverse();
    std::array<Eigen::Vector3d, 8> corners;
    for (int i = 0; i < 8; ++i)
      corners[i] = T_c_b * Eigen::Vector3d(i & 1 ? half_size.x() : -half_size.x(),
                                           i & 2 ? half_size.y() : -half_size.y(),
                                           i & 4 ? half_size.z() : -half_size.z());
    return corners;
  }
};

/** Pixels [u0, u1) x [v0, v1). */
struct PixelBox {
  int u0 = 0, u1 = 0, v0 = 0, v1 = 0;
};

/** Grows around the projections of points. */
class ProjectedBox {
public:
  explicit ProjectedBox(const Intrinsics& camera) : camera_(camera) {}
  void include(const Eigen::Vector3d& p) {
    const Eigen::Vector2d pixel = camera_.project(p);
    lowest_ = lowest_.cwiseMin(pixel);
    highest_ = highest_.cwiseMax(pixel);
  }
  PixelBox pixels() const {
    if (!(lowest_.x() <= highest_.x())) return {};
    // One pixel more on each side makes up for rounding.
    const auto first = [](double x, int size) {
      return static_cast<int>(std::clamp(std::floor(x) - 1, 0.0, double(size)));
    };
    const auto end = [](double x, int size) {
      return static_cast<int>(std::clamp(std::ceil(x) + 2, 0.0, double(size)));
    };
    return {first(lowest_.x(), camera_.width), end(highest_.x(), camera_.width),
            first(lowest_.y(), camera_.height), end(highest_.y(), camera_.height)};
  }

private:
  const Intrinsics& camera_;
  Eigen::Vector2d lowest_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d highest_ = -lowest_;
};

/** The pixels that can see a facet: the bounding box of its projection, cut off at the near plane. */
inline PixelBox boundingBox(const Facet& facet, const Intrinsics& camera) {
  ProjectedBox box(camera);
  const auto corners = facet.corners();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    if (a.z() >= kNearPlane) box.include(a);
    if ((a.z() < kNearPlane) != (b.z() < kNearPlane)) {
      Eigen::Vector3d cut = a + (kNearPlane - a.z()) / (b.z() - a.z()) * (b - a);
      cut.z() = kNearPlane;
      box.include(cut);
    }
  }
  return box.pixels();
}

/** The pixels that can see a round body: all of them if it reaches behind the camera. */
inline PixelBox boundingBox(const Quadric& quadric, const Intrinsics& camera) {
  const auto corners = quadric.corners();
  const auto inFront = [](const Eigen::Vector3d& p) { return p.z() >= kNearPlane; };
  if (std::none_of(corners.begin(), corners.end(), inFront)) return {};
  if (!std::all_of(corners.begin(), corners.end(), inFront)) return {0, camera.width, 0, camera.height};
  ProjectedBox box(camera);
  for (const Eigen::Vector3d& corner : corners) box.include(corner);
  return box.pixels();
}

inline constexpr int kNothing = -1;

inline std::size_t pixelCount(const Intrinsics& camera) { return std::size_t(camera.width) * camera.height; }

/** The view of every pixel: the depth and the number of a surface, first the rectangles, then the bodies. */
class Hits {
public:
  /** \param opaque which pixels are reflected by glass; none if it is empty. */
  Hits(const SimulatedWorld& world, const Eigen::Isometry3d& T_w_c, const Intrinsics& camera,
       const std::vector<bool>& opaque = {})
      : depth(pixelCount(camera), kMiss), surface(pixelCount(camera), kNothing) {
    const Eigen::Isometry3d T_c_w = T_w_c.inverse();
    for (const Rectangle& r : world.rectangles) facets_.emplace_back(r, T_c_w);
    for (const RoundBody& b : world.bodies) quadrics_.emplace_back(b, T_c_w);
    int number = 0;
    for (const Facet& facet : facets_) cast(facet, number++, camera, opaque);
    for (const Quadric& quadric : quadrics_) cast(quadric, number++, camera, opaque);
  }

  /** Calls the function with the facet or the quadric of that number. */
  template <class What>
  auto with(int number, What&& what) const {
    const int facets = static_cast<int>(facets_.size());
    return number < facets ? what(facets_[number]) : what(quadrics_[number - facets]);
  }

  /** Depth that is seen where a pixel gets a share of its light from another surface. */
  double between(double z, int other, const Eigen::Vector3d& ray, double share) const {
    if (other == kNothing) return z;
    const double beyond = with(other, [&](const auto& seen) { return seen.depthAlong(ray); });
    return beyond >= kNearPlane && beyond < kMiss ? z + share * (beyond - z) : z;
  }

  std::vector<double> depth;
  std::vector<int> surface;

private:
  template <class Surface>
  void cast(const Surface& seen, int number, const Intrinsics& camera, const std::vector<bool>& opaque) {
    const PixelBox box = boundingBox(seen, camera);
    const bool glass = seen.material == Material::glass;
    for (int v = box.v0; v < box.v1; ++v) {
      for (int u = box.u0; u < box.u1; ++u) {
        const std::size_t i = std::size_t(v) * camera.width + u;
        if (glass && (opaque.empty() || !opaque[i])) continue;
        const double z = seen.hitAlong(camera.ray(u, v));
        if (!(z < depth[i])) continue;
        depth[i] = z;
        surface[i] = number;
      }
    }
  }

  std::vector<Facet> facets_;
  std::vector<Quadric> quadrics_;
};

}  // namespace facetloc
