// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/pictures.h"

#include <limits>
#include <string>
#include <vector>

namespace facetloc::test {

/** \brief A corner of a room, of rectangles, seen without noise: depth, labels and segments are true. The
 * world has z up. */
class ExampleScene {
public:
  ExampleScene() {
    add({2, 0, 0}, {0, 2, 0}, {-1.5, 0, 0});           // floor
    add({3.5, 0, 1.2}, {0, 2, 0}, {0, 0, 1.2});        // wall ahead
    add({2, 1.5, 1.2}, {1.5, 0, 0}, {0, 0, 1.2});      // wall on the left
    add({2.4, -0.6, 0.4}, {0, 0.4, 0}, {0, 0, 0.4});   // front of a box
    add({2.7, -0.6, 0.8}, {0, 0.4, 0}, {0.3, 0, 0});   // its top
    add({2.7, -0.2, 0.4}, {0.3, 0, 0}, {0, 0, 0.4});   // its left side
    add({3.45, 0.3, 1.5}, {0, 0.45, 0}, {0, 0, 0.3});  // notice board
  }

  static Eigen::Isometry3d pose(double x, double y, double heading_deg) {
    const Eigen::AngleAxisd turn(heading_deg * kDegree, Eigen::Vector3d::UnitZ());
    return Eigen::Translation3d(x, y, 0) * turn * CameraMounting{1.0, 8}.T_b_c();
  }

  SeenImage see(const std::string& name, const Eigen::Isometry3d& T_w_c) const {
    SeenImage image;
    image.name = name;
    image.depth.camera = {160, 120, 140, 140, 79.5, 59.5};
    image.labels.width = 160;
    image.labels.height = 120;
    image.view.intrinsics = image.depth.camera;
    for (const Segment& segment : world_) image.view.segments.push_back(inView(segment, T_w_c));
    for (int v = 0; v < 120; ++v)
      for (int u = 0; u < 160; ++u) addPixel(image, image.depth.camera.ray(u, v));
    image.view.depth = DepthPicture::fromDepth(image.depth);
    return image;
  }

  Map map() const {
    Map map;
    map.camera.mounting = CameraMounting{1.0, 8};
    addModel("start", pose(0, 0, 0), map);
    addModel("left", pose(0.4, 0.5, 8), map);
    addModel("right", pose(0.9, -0.3, -20), map);
    for (int i = 0; i + 1 < 3; ++i) {
      Link link;
      link.from = i;
      link.to = i + 1;
      map.links.push_back(link);
    }
    return map;
  }

private:
  /** A rectangle by its centre and half its sides [m]. */
  void add(const Eigen::Vector3d& centre, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    Segment s;
    s.t = centre;
    s.R.col(0) = a.normalized();
    s.R.col(1) = b.normalized();
    s.R.col(2) = a.cross(b).normalized();
    s.lambda = Eigen::Vector2d(a.squaredNorm(), b.squaredNorm()) / 3;
    s.Sigma_q = Eigen::Vector3d(1e-6, 1e-6, 1e-6).asDiagonal();
    s.num_points = 1000;
    const auto x = static_cast<float>(a.norm()), y = static_cast<float>(b.norm());
    s.hull.size = 4;
    s.hull.vertex[0] = {-x, -y}, s.hull.vertex[1] = {x, -y}, s.hull.vertex[2] = {x, y},
    s.hull.vertex[3] = {-x, y};
    world_.push_back(s);
  }

  /** Segment in the frame of a camera, its normal away from it. */
  static Segment inView(const Segment& segment, const Eigen::Isometry3d& T_w_c) {
    Segment s = transformed(segment, T_w_c.inverse());
    if (s.offset() > 0) return s;
    s.R.col(1) *= -1, s.R.col(2) *= -1;
    for (Eigen::Vector2f& v : s.hull.vertex) v.y() *= -1;
    std::swap(s.hull.vertex[1], s.hull.vertex[3]);  // counter-clockwise again
    return s;
  }

  static void addPixel(SeenImage& image, const Eigen::Vector3d& ray) {
    double nearest = std::numeric_limits<double>::infinity();
    std::uint16_t label = 0;
    for (std::size_t k = 0; k < image.view.segments.size(); ++k) {
      const Segment& s = image.view.segments[k];
      const double z = s.offset() / s.normal().dot(ray);
      const Eigen::Vector3d in_plane = s.R.transpose() * (z * ray - s.t);
      if (!(z > 0) || z >= nearest || !s.hull.contains(in_plane.head<2>().cast<float>())) continue;
      nearest = z;
      label = static_cast<std::uint16_t>(k + 1);
    }
    image.depth.depth.push_back(label ? static_cast<float>(nearest) : 0.f);
    image.labels.label.push_back(label);
  }

  void addModel(const std::string& name, const Eigen::Isometry3d& T_w_m, Map& map) const {
    map.models.emplace_back(name, static_cast<double>(map.models.size()), T_w_m, see(name, T_w_m).view);
  }

  std::vector<Segment> world_;
};

}  // namespace facetloc::test
