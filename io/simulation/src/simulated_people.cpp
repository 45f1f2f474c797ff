// SPDX-License-Identifier: BSD-3-Clause
#include "random.h"

#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_people.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace facetloc {

namespace {

constexpr double kTurn = 360 * kDegree;
constexpr double kWalk = 1.2, kCadence = 1;       // speed and pace of a walk [m/s], [strides/s]
constexpr double kStride = 25 * kDegree;          // largest angle of the legs
constexpr double kStay = 8;                       // a person does one thing for this long [s]
constexpr double kNearest = 0.8, kToWall = 0.35;  // distances to the camera and to the wall behind [m]
constexpr double kBreast = 1.2;                   // height at which a person needs room [m]

Eigen::Isometry3d onFloor(const Eigen::Vector2d& place, double heading) {
  return Eigen::Translation3d(place.x(), place.y(), 0) *
         Eigen::Isometry3d(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()));
}

/** Distance along a level ray to the first surface [m]. */
double freeAlong(const SimulatedWorld& world, const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Rectangle& r : world.rectangles) {
    const double along = r.normal().dot(direction);
    if (std::abs(along) < 1e-9) continue;
    const double distance = r.normal().dot(r.centre - from) / along;
    const Eigen::Vector3d p = from + distance * direction - r.centre;
    if (distance > 0 && std::abs(p.dot(r.axis_u)) <= r.half_u && std::abs(p.dot(r.axis_v)) <= r.half_v)
      nearest = std::min(nearest, distance);
  }
  return nearest;
}

}  // namespace

std::vector<RoundBody> simulatedPerson(const Eigen::Isometry3d& T_w_p, double stride, std::uint64_t looks) {
  Random random(looks);
  const double height = random.uniform(1.55, 1.9), broad = height / 1.75 * random.uniform(0.9, 1.25);
  const bool coat = random.uniform() < 0.5;
  const Material cloth = random.uniform() < 0.25 ? Material::dark : Material::matt;
  std::vector<RoundBody> bodies;
  // Centres and half sizes for a person of 1 m, turned about the axis from left to right.
  const auto add = [&](RoundBody::Shape shape, const Eigen::Vector3d& centre,
                       const Eigen::Vector3d& half_size, double swing, Material material) {
    RoundBody body{shape, T_w_p, half_size, material};
    body.T_w_b.translate(height * centre).rotate(Eigen::AngleAxisd(swing, Eigen::Vector3d::UnitY()));
    body.half_size = {height * broad * half_size.x(), height * broad * half_size.y(), height * half_size.z()};
    bodies.push_back(body);
  };
  constexpr auto kRound = RoundBody::Shape::ellipsoid, kTube = RoundBody::Shape::cylinder;
  add(kRound, {0, 0, 0.93}, {0.055, 0.045, 0.07}, 0, Material::matt);
  add(kRound, {0, 0, 0.68}, {0.065, 0.13, 0.2}, 0, cloth);
  if (coat) add(kTube, {0, 0, 0.5}, {0.075, 0.12, 0.2}, 0, cloth);
  for (const double side : {-1.0, 1.0}) {
    const double swing = side * stride, reach = std::sin(swing);
    add(kTube, {-0.24 * reach, 0.055 * side, 0.24}, {0.045, 0.045, 0.24}, swing, cloth);
    add(kRound, {0.17 * reach, 0.15 * side, 0.63}, {0.03, 0.03, 0.2}, -swing, cloth);
  }
  return bodies;
}

SimulatedPeople::SimulatedPeople(int people, std::vector<Eigen::Isometry3d> T_w_c, std::vector<double> stamps,
                                 std::uint64_t seed)
    : people_(people), T_w_c_(std::move(T_w_c)), stamps_(std::move(stamps)), seed_(seed) {
  if (T_w_c_.size() != stamps_.size())
    throw std::invalid_argument("SimulatedPeople: each pose of the camera needs a stamp");
}

Eigen::Isometry3d SimulatedPeople::floorPose(double stamp) const {
  const auto next = std::lower_bound(stamps_.begin(), stamps_.end() - 1, stamp);
  const Eigen::Isometry3d& T = T_w_c_[next - stamps_.begin()];
  const Eigen::Vector3d ahead = T.linear().col(2);
  return onFloor(T.translation().head<2>(), std::atan2(ahead.y(), ahead.x()));
}

SimulatedWorld SimulatedPeople::in(const SimulatedWorld& world, std::size_t i) const {
  enum Way { kAhead, kPast, kAround };
  SimulatedWorld peopled = world;
  const double now = stamps_.at(i);
  const Eigen::Vector3d eye(T_w_c_[i].translation().x(), T_w_c_[i].translation().y(), kBreast);
  for (int k = 0; k < people_; ++k) {
    const double shift = Random(derivedSeed(seed_, k)).uniform(0, kStay);  // they do not change together
    const double part = std::floor((now + shift) / kStay), since = now + shift - part * kStay;
    Random random(derivedSeed(seed_, k, 1 + static_cast<std::uint64_t>(part)));
    const double distance = random.uniform(1, 3), aside = random.uniform(-0.6, 0.6),
                 phase = random.uniform(0, kTurn);
    const double turned = phase + 0.5 * kTurn * since / kStay;
    Eigen::Isometry3d T_w_p;
    double stride = kStride * std::sin(kTurn * kCadence * now + phase);
    if (k % 3 == kAhead) {
      T_w_p = floorPose(now) * onFloor({distance, aside * std::sin(turned)}, 0.3 * kTurn * std::sin(turned));
    } else if (k % 3 == kPast) {
      const double side = phase < 0.5 * kTurn ? 1 : -1;
      const double across = std::remainder(since - 0.25 * kStay, 0.5 * kStay);  // twice in each part
      T_w_p = floorPose(now - across) * onFloor({distance, side * kWalk * across}, 0.25 * kTurn * side);
    } else {
      T_w_p = floorPose(now - since + 0.5 * kStay) * onFloor({distance, aside}, turned);
      stride = 0;
    }
    // A wall between would hide the person: they stand before it.
    const Eigen::Vector3d there(T_w_p.translation().x(), T_w_p.translation().y(), kBreast);
    const Eigen::Vector3d direction = (there - eye).normalized();
    const double room = std::min((there - eye).norm(), freeAlong(world, eye, direction) - kToWall);
    if (!(room >= kNearest)) continue;
    T_w_p.translation().head<2>() = (eye + room * direction).head<2>();
    const std::vector<RoundBody> person = simulatedPerson(T_w_p, stride, derivedSeed(seed_, k));
    peopled.bodies.insert(peopled.bodies.end(), person.begin(), person.end());
  }
  return peopled;
}

}  // namespace facetloc
