// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_place.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

namespace facetloc {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr std::uint64_t kSeeds = 12;

class SimulatedPlaces : public testing::TestWithParam<std::string> {
protected:
  static SimulatedPlace place(std::uint64_t seed) { return simulatedPlace(GetParam(), seed); }
};

bool same(const Rectangle& a, const Rectangle& b) {
  return a.centre == b.centre && a.axis_u == b.axis_u && a.axis_v == b.axis_v && a.half_u == b.half_u &&
         a.half_v == b.half_v && a.plane_id == b.plane_id && a.material == b.material;
}

bool same(const RoundBody& a, const RoundBody& b) {
  return a.shape == b.shape && a.T_w_b.matrix() == b.T_w_b.matrix() && a.half_size == b.half_size &&
         a.material == b.material;
}

bool same(const Waypoint& a, const Waypoint& b) { return a.place == b.place && a.look_deg == b.look_deg; }

template <class Things>
bool allSame(const Things& a, const Things& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return same(x, y); });
}

bool same(const SimulatedWorld& a, const SimulatedWorld& b) {
  return allSame(a.rectangles, b.rectangles) && allSame(a.bodies, b.bodies);
}

bool same(const SimulatedPlace& a, const SimulatedPlace& b) {
  const auto same_room = [](const Eigen::AlignedBox2d& x, const Eigen::AlignedBox2d& y) {
    return x.min() == y.min() && x.max() == y.max();
  };
  return same(a.mapped, b.mapped) && same(a.later, b.later) && allSame(a.mapping_route, b.mapping_route) &&
         allSame(a.query_route, b.query_route) &&
         std::equal(a.unmapped_rooms.begin(), a.unmapped_rooms.end(), b.unmapped_rooms.begin(),
                    b.unmapped_rooms.end(), same_room);
}

// ---- Distances in the floor plan ----

struct Stretch {
  Vector2d from, to;
};

std::vector<Stretch> stretches(const Route& route) {
  std::vector<Stretch> all;
  for (std::size_t i = 0; i < route.size(); ++i)
    all.push_back({route[i].place, route[(i + 1) % route.size()].place});
  return all;
}

double distance(const Vector2d& p, const Stretch& s) {
  const Vector2d d = s.to - s.from;
  const double length2 = d.squaredNorm();
  const double share = length2 > 0 ? std::clamp((p - s.from).dot(d) / length2, 0.0, 1.0) : 0.0;
  return (s.from + share * d - p).norm();
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double distance(const Stretch& a, const Stretch& b) {
  const Vector2d da = a.to - a.from, db = b.to - b.from;
  const double denominator = cross(da, db);
  if (denominator != 0) {
    const double s = cross(b.from - a.from, db) / denominator, t = cross(b.from - a.from, da) / denominator;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) return 0;
  }
  return std::min({distance(a.from, b), distance(a.to, b), distance(b.from, a), distance(b.to, a)});
}

/** The part of a convex polygon at one side of a height. */
std::vector<Vector3d> clipped(const std::vector<Vector3d>& polygon, double z, double side) {
  std::vector<Vector3d> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double above_a = side * (a.z() - z), above_b = side * (b.z() - z);
    if (above_a >= 0) out.push_back(a);
    if ((above_a > 0 && above_b < 0) || (above_a < 0 && above_b > 0))
      out.push_back(a + above_a / (above_a - above_b) * (b - a));
  }
  return out;
}

/** The heights at which a robot would bump into something [m]. */
constexpr double kLowest = 0.05, kHighest = 1.2;

/** The outline of a rectangle in the floor plan, as far as it is in the robot's way. */
std::vector<Stretch> outline(const Rectangle& r) {
  const Vector3d u = r.half_u * r.axis_u, v = r.half_v * r.axis_v;
  std::vector<Vector3d> corners = {r.centre - u - v, r.centre + u - v, r.centre + u + v, r.centre - u + v};
  corners = clipped(clipped(corners, kLowest, 1), kHighest, -1);
  std::vector<Stretch> edges;
  for (std::size_t i = 0; i < corners.size(); ++i)
    edges.push_back({corners[i].head<2>(), corners[(i + 1) % corners.size()].head<2>()});
  return edges;
}

bool contains(const std::vector<Stretch>& polygon, const Vector2d& p) {
  bool inside = false;
  for (const Stretch& e : polygon) {
    if ((e.from.y() > p.y()) == (e.to.y() > p.y())) continue;
    const double x = e.from.x() + (p.y() - e.from.y()) / (e.to.y() - e.from.y()) * (e.to.x() - e.from.x());
    if (p.x() < x) inside = !inside;
  }
  return inside;
}

double clearance(const Rectangle& rectangle, const Stretch& way) {
  const std::vector<Stretch> edges = outline(rectangle);
  if (contains(edges, way.from)) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (const Stretch& edge : edges) least = std::min(least, distance(way, edge));
  return least;
}

double clearance(const RoundBody& body, const Stretch& way) {
  const Vector3d centre = body.T_w_b.translation();
  if (centre.z() - body.half_size.z() > kHighest || centre.z() + body.half_size.z() < kLowest)
    return std::numeric_limits<double>::infinity();
  const Vector2d middle = centre.head<2>();
  return distance(middle, way) - body.half_size.head<2>().maxCoeff();
}

void expectFreeLanes(const SimulatedWorld& scene, const Route& route) {
  constexpr double kClearance = 0.25;  // [m] half the width of a small robot, and some air
  for (const Stretch& way : stretches(route)) {
    double least = std::numeric_limits<double>::infinity();
    for (const Rectangle& rectangle : scene.rectangles) least = std::min(least, clearance(rectangle, way));
    for (const RoundBody& body : scene.bodies) least = std::min(least, clearance(body, way));
    EXPECT_GE(least, kClearance) << way.from.transpose() << " to " << way.to.transpose();
  }
}

TEST_P(SimulatedPlaces, TheRobotCanGoItsWays) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const SimulatedPlace p = place(seed);
    expectFreeLanes(p.mapped, p.mapping_route);
    expectFreeLanes(p.later, p.query_route);
  }
}

// ---- Planes ----

TEST_P(SimulatedPlaces, TheSameSeedGivesTheSamePlace) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    EXPECT_TRUE(same(place(seed), place(seed))) << seed;
    EXPECT_FALSE(same(place(seed), place(seed + 1))) << seed;
  }
}

TEST_P(SimulatedPlaces, RectanglesAreWellFormed) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const SimulatedPlace p = place(seed);
    for (const SimulatedWorld* scene : {&p.mapped, &p.later}) {
      for (const Rectangle& r : scene->rectangles) {
        ASSERT_NEAR(r.axis_u.norm(), 1, 1e-9);
        ASSERT_NEAR(r.axis_v.norm(), 1, 1e-9);
        ASSERT_NEAR(r.axis_u.dot(r.axis_v), 0, 1e-9);
        ASSERT_GT(std::min(r.half_u, r.half_v), 0);
        ASSERT_NE(r.plane_id, 0) << "label of a surface that is no plane";
      }
      for (const RoundBody& body : scene->bodies) {
        ASSERT_GT(body.half_size.minCoeff(), 0);
        ASSERT_NEAR(body.T_w_b.linear().determinant(), 1, 1e-9);
      }
    }
  }
}

TEST_P(SimulatedPlaces, RectanglesOfOneIdAreOnePlane) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const SimulatedPlace p = place(seed);
    std::map<int, Rectangle> first;
    for (const SimulatedWorld* scene : {&p.mapped, &p.later})
      for (const Rectangle& r : scene->rectangles) {
        const Rectangle& other = first.emplace(r.plane_id, r).first->second;
        ASSERT_NEAR(std::abs(r.normal().dot(other.normal())), 1, 1e-9) << r.plane_id;
        ASSERT_NEAR(other.normal().dot(r.centre - other.centre), 0, 1e-9) << r.plane_id;
      }
  }
}

std::map<int, std::vector<Rectangle>> byId(const SimulatedWorld& scene) {
  std::map<int, std::vector<Rectangle>> all;
  for (const Rectangle& r : scene.rectangles) all[r.plane_id].push_back(r);
  return all;
}

TEST_P(SimulatedPlaces, SomethingHasMovedAndHasNewIdsButMostIsTheSame) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const SimulatedPlace p = place(seed);
    const auto mapped = byId(p.mapped), later = byId(p.later);
    std::size_t common = 0;
    for (const auto& [id, rectangles] : mapped) {
      const auto found = later.find(id);
      if (found == later.end()) continue;
      ++common;
      EXPECT_TRUE(allSame(rectangles, found->second)) << id;
    }
    EXPECT_LT(common, mapped.size());
    EXPECT_LT(common, later.size());
    constexpr double kMost = 0.5;  // one bookcase that has moved takes a hundred planes with it
    EXPECT_GT(static_cast<double>(common), kMost * static_cast<double>(mapped.size()));
    EXPECT_GT(static_cast<double>(common), kMost * static_cast<double>(later.size()));
  }
}

TEST_P(SimulatedPlaces, ThereAreCurvedThingsAndSurfacesThatAreHardToSee) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const SimulatedPlace p = place(seed);
    EXPECT_GT(p.mapped.bodies.size(), 5u);
    std::set<Material> materials;
    for (const Rectangle& r : p.mapped.rectangles) materials.insert(r.material);
    EXPECT_EQ(materials.size(), 3u);
  }
}

// ---- Ways ----

double turn(const Vector2d& from, const Vector2d& to) {
  return std::abs(std::atan2(cross(from, to), from.dot(to))) / kDegree;
}

/** How many images a robot takes before it comes to each waypoint. */
std::vector<double> imagesBefore(const Route& route, double step, double step_deg) {
  std::vector<double> images = {0};
  const auto ways = stretches(route);
  for (std::size_t i = 0; i + 1 < ways.size(); ++i) {
    const Vector2d way = ways[i].to - ways[i].from;
    const double turned = turn(way, ways[i + 1].to - ways[i + 1].from) + std::abs(route[i + 1].look_deg);
    images.push_back(images.back() + way.norm() / step + turned / step_deg);
  }
  return images;
}

TEST_P(SimulatedPlaces, OneRoomIsOnTheSecondWayOnly) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const SimulatedPlace p = place(seed);
    ASSERT_FALSE(p.unmapped_rooms.empty());
    for (const Eigen::AlignedBox2d& room : p.unmapped_rooms) {
      constexpr double kApart = 1.0, kStep = 0.05;  // [m]
      for (const Stretch& way : stretches(p.mapping_route))
        for (double s = 0; s <= 1; s += kStep / (way.to - way.from).norm())
          ASSERT_GE(room.exteriorDistance(Vector2d(way.from + s * (way.to - way.from))), kApart);
    }
    const std::vector<double> images = imagesBefore(p.query_route, 0.5, 5);
    double earliest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < images.size(); ++i)
      for (const Eigen::AlignedBox2d& room : p.unmapped_rooms)
        if (room.contains(p.query_route[i].place)) earliest = std::min(earliest, images[i]);
    EXPECT_LT(earliest, 250) << "images, of 348";
  }
}

TEST_P(SimulatedPlaces, OneCycleFitsTheImagesOfTheRuns) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    const SimulatedPlace p = place(seed);
    EXPECT_LT(imagesBefore(p.mapping_route, 0.25, 5).back(), 1.3 * 444);
    EXPECT_LT(imagesBefore(p.query_route, 0.5, 5).back(), 1.3 * 348);
  }
}

/** Upright at the height of a robot's camera. */
Eigen::Isometry3d standing(const Vector2d& position, double yaw) {
  constexpr double kHeight = 1.0;  // [m]
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Vector3d forward(std::cos(yaw), std::sin(yaw), 0), down(0, 0, -1);
  T.linear() << down.cross(forward), down, forward;
  T.translation() << position, kHeight;
  return T;
}

TEST_P(SimulatedPlaces, AreClosed) {
  constexpr int kSide = 24;  // [px]; four images look all around
  constexpr float kFarthest = 30;
  const Intrinsics quarter{kSide, kSide, kSide / 2.0, kSide / 2.0, (kSide - 1) / 2.0, (kSide - 1) / 2.0};
  const SimulatedCamera camera(quarter, SimulatedNoise(), 1);
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    SimulatedPlace p = place(seed);
    for (auto& r : p.later.rectangles) r.material = Material::matt;  // surfaces behind windows do not count
    for (const Waypoint& waypoint : p.query_route)
      for (const double yaw_deg : {0, 90, 180, 270}) {
        const auto frame = camera.renderExact(p.later, standing(waypoint.place, yaw_deg * kDegree));
        const auto [nearest, farthest] =
            std::minmax_element(frame.depth.depth.begin(), frame.depth.depth.end());
        ASSERT_GT(*nearest, 0) << waypoint.place.transpose() << ", " << yaw_deg;
        ASSERT_LT(*farthest, kFarthest) << waypoint.place.transpose() << ", " << yaw_deg;
      }
  }
}

INSTANTIATE_TEST_SUITE_P(Furnished, SimulatedPlaces, testing::Values("office", "home", "hall"),
                         [](const auto& test) { return test.param; });

TEST(SimulatedPlace, UnknownNamesAreRefused) {
  EXPECT_THROW(simulatedPlace("ship", 1), std::invalid_argument);
}

}  // namespace
}  // namespace facetloc
