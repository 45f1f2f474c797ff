// SPDX-License-Identifier: BSD-3-Clause
#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

constexpr double kOnFloor = 1e-6;  // [m] a foot lower than this is not seen

Eigen::Vector3d up(double length) { return {0, 0, length}; }

Eigen::Vector3d at(const Eigen::Vector2d& place, double z) { return {place.x(), place.y(), z}; }

PlanOutline outlineOf(const Spot& spot, double along, double across) {
  const double x = along / 2, y = across / 2;
  return {spot.relative(-x, -y).place, spot.relative(x, -y).place, spot.relative(x, y).place,
          spot.relative(-x, y).place};
}

}  // namespace

Eigen::Isometry3d Spot::pose() const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = at(place, z);
  return T;
}

Spot Spot::relative(double x, double y, double turn, double up) const {
  return {place + Eigen::Rotation2Dd(yaw) * Eigen::Vector2d(x, y), yaw + turn, z + up};
}

void SceneBuilder::add(const Rectangle& rectangle, When when) {
  if (when != When::later) place_.mapped.rectangles.push_back(rectangle);
  if (when != When::mapped) place_.later.rectangles.push_back(rectangle);
}

void SceneBuilder::add(const RoundBody& body, When when) {
  if (when != When::later) place_.mapped.bodies.push_back(body);
  if (when != When::mapped) place_.later.bodies.push_back(body);
}

std::uint16_t SceneBuilder::rectangle(const Eigen::Vector3d& centre, const Eigen::Vector3d& half_u,
                                      const Eigen::Vector3d& half_v, When when, Material material,
                                      std::uint16_t id) {
  Rectangle r;
  r.centre = centre;
  r.half_u = half_u.norm();
  r.half_v = half_v.norm();
  r.axis_u = half_u / r.half_u;
  r.axis_v = half_v / r.half_v;
  r.plane_id = id ? id : next_id_++;
  r.material = material;
  add(r, when);
  return r.plane_id;
}

void SceneBuilder::box(const Spot& spot, const Eigen::Vector3d& size, When when, Material material) {
  addFaces(spot.pose() * Eigen::Translation3d(0, 0, size.z() / 2), size, when, material, spot.z >= kOnFloor);
}

void SceneBuilder::box(const Eigen::Isometry3d& T_w_box, const Eigen::Vector3d& size, When when,
                       Material material) {
  addFaces(T_w_box, size, when, material, true);
}

void SceneBuilder::addFaces(const Eigen::Isometry3d& T_w_box, const Eigen::Vector3d& size, When when,
                            Material material, bool with_foot) {
  const Eigen::Vector3d half = size / 2;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const int side : {-1, 1}) {
      if (axis == 2 && side < 0 && !with_foot) continue;
      rectangle(T_w_box.translation() + side * half[axis] * T_w_box.linear().col(axis),
                half[u] * T_w_box.linear().col(u), half[v] * T_w_box.linear().col(v), when, material);
    }
  }
}

void SceneBuilder::cylinder(const Spot& spot, double radius, double height, When when, Material material) {
  RoundBody body;
  body.shape = RoundBody::Shape::cylinder;
  body.T_w_b = spot.pose() * Eigen::Translation3d(0, 0, height / 2);
  body.half_size = {radius, radius, height / 2};
  body.material = material;
  add(body, when);
  // The largest square that fits stands for the round lid.
  const double side = radius / std::sqrt(2.0);
  rectangle(spot.pose() * up(height), spot.pose().linear().col(0) * side, spot.pose().linear().col(1) * side,
            when, material);
}

void SceneBuilder::ellipsoid(const Spot& spot, double centre_z, const Eigen::Vector3d& half_size, When when,
                             Material material) {
  RoundBody body;
  body.T_w_b = spot.pose() * Eigen::Translation3d(0, 0, centre_z);
  body.half_size = half_size;
  body.material = material;
  add(body, when);
}

void SceneBuilder::wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double thickness,
                        double height, const std::vector<Opening>& openings) {
  const double length = (to - from).norm();
  const Eigen::Vector2d along = (to - from) / length;
  const Eigen::Vector2d left(-along.y(), along.x());
  std::vector<Opening> holes = openings;
  std::sort(holes.begin(), holes.end(), [](const Opening& a, const Opening& b) { return a.at < b.at; });

  // The two faces: pillars of wall between the holes, and the wall above and below each hole.
  for (const int side : {-1, 1}) {
    std::uint16_t id = 0;
    const auto piece = [&](double start, double end, double bottom, double top) {
      if (end - start < kOnFloor || top - bottom < kOnFloor) return;
      const Eigen::Vector2d middle = from + (start + end) / 2 * along + side * thickness / 2 * left;
      id = rectangle(at(middle, (bottom + top) / 2), at(along, 0) * (end - start) / 2, up((top - bottom) / 2),
                     When::always, Material::matt, id);
    };
    double start = 0;
    for (const Opening& hole : holes) {
      piece(start, hole.at - hole.width / 2, 0, height);
      piece(hole.at - hole.width / 2, hole.at + hole.width / 2, 0, hole.bottom);
      piece(hole.at - hole.width / 2, hole.at + hole.width / 2, hole.top, height);
      start = hole.at + hole.width / 2;
    }
    piece(start, length, 0, height);
  }

  // On a floor plan, only openings that begin at the floor open a wall.
  double solid = 0;
  const Spot start{from, std::atan2(along.y(), along.x())};
  const auto solidUpTo = [&](double end) {
    if (end > solid)
      place_.walls.push_back(outlineOf(start.relative((solid + end) / 2, 0), end - solid, thickness));
  };
  for (const Opening& hole : holes) {
    if (hole.bottom > kOnFloor) continue;
    solidUpTo(hole.at - hole.width / 2);
    place_.doorways.push_back(outlineOf(start.relative(hole.at, 0), hole.width, thickness));
    solid = hole.at + hole.width / 2;
  }
  solidUpTo(length);

  const Eigen::Vector3d across = at(left, 0) * thickness / 2;
  for (const Opening& hole : holes) {
    const double middle_z = (hole.bottom + hole.top) / 2;
    const Eigen::Vector3d half_up = up((hole.top - hole.bottom) / 2);
    const Eigen::Vector3d half_along = at(along, 0) * hole.width / 2;
    const Eigen::Vector2d middle = from + hole.at * along;
    for (const int side : {-1, 1})
      rectangle(at(middle + side * hole.width / 2 * along, middle_z), across, half_up);
    if (hole.bottom > kOnFloor) rectangle(at(middle, hole.bottom), half_along, across);
    if (hole.top < height - kOnFloor) rectangle(at(middle, hole.top), half_along, across);
    if (hole.glazed) rectangle(at(middle, middle_z), half_along, half_up, When::always, Material::glass);
  }
  // The ends, which show where a wall stands free.
  for (const Eigen::Vector2d& end : {from, to}) rectangle(at(end, height / 2), across, up(height / 2));
}

void SceneBuilder::pillar(const Spot& spot, const Eigen::Vector3d& size) {
  box(spot, size);
  place_.walls.push_back(outlineOf(spot, size.x(), size.y()));
}

void SceneBuilder::roundPillar(const Spot& spot, double radius, double height) {
  constexpr int kSides = 16;  // sides of its outline
  cylinder(spot, radius, height);
  PlanOutline corners;
  for (int i = 0; i < kSides; ++i)
    corners.push_back(spot.relative(0, 0, 360 * kDegree * i / kSides).relative(radius, 0).place);
  place_.walls.push_back(std::move(corners));
}

void SceneBuilder::doorLeaf(const Eigen::Vector2d& hinge, double direction, double width, double height,
                            When when) {
  constexpr double kThickness = 0.04;
  const Spot spot{hinge, direction};
  box(spot.relative(width / 2, 0), {width, kThickness, height}, when);
}

void SceneBuilder::level(const Eigen::AlignedBox2d& area, double z) {
  const Eigen::Vector2d half = area.sizes() / 2;
  rectangle(at(area.center(), z), Eigen::Vector3d(half.x(), 0, 0), Eigen::Vector3d(0, half.y(), 0));
}

}  // namespace facetloc
