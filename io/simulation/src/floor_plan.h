// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "furniture.h"
#include "scene_builder.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace facetloc {

/** \brief A rectangle of the floor: depth along the x axis of its spot, width along y [m]. */
struct Footprint {
  Spot spot;
  double depth = 0;
  double width = 0;

  std::array<Eigen::Vector2d, 4> corners() const {
    const double x = depth / 2, y = width / 2;
    return {spot.relative(-x, -y).place, spot.relative(x, -y).place, spot.relative(x, y).place,
            spot.relative(-x, y).place};
  }

  bool overlaps(const Footprint& other) const {
    return !isApartAlongAxesOf(*this, other) && !isApartAlongAxesOf(other, *this);
  }

  bool isWithin(const Eigen::AlignedBox2d& area) const {
    const auto all = corners();
    return std::all_of(all.begin(), all.end(), [&](const Eigen::Vector2d& p) { return area.contains(p); });
  }

  /** \brief The distance of a stretch of way; 0 if it leads through. */
  double distanceTo(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    const Eigen::Rotation2Dd to_own(-spot.yaw);
    const Eigen::AlignedBox2d box(Eigen::Vector2d(-depth / 2, -width / 2),
                                  Eigen::Vector2d(depth / 2, width / 2));
    const Eigen::Vector2d a = to_own * (from - spot.place), b = to_own * (to - spot.place);
    if (crosses(box, a, b)) return 0;
    double distance = std::min(box.exteriorDistance(a), box.exteriorDistance(b));
    for (const auto corner : {Eigen::AlignedBox2d::BottomLeft, Eigen::AlignedBox2d::BottomRight,
                              Eigen::AlignedBox2d::TopLeft, Eigen::AlignedBox2d::TopRight}) {
      const Eigen::Vector2d p = box.corner(corner), ab = b - a;
      const double length2 = ab.squaredNorm();
      const double share = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
      distance = std::min(distance, (p - a - share * ab).norm());
    }
    return distance;
  }

private:
  static bool isApartAlongAxesOf(const Footprint& a, const Footprint& b) {
    const Eigen::Rotation2Dd to_a(-a.spot.yaw);
    Eigen::AlignedBox2d bounds;
    for (const Eigen::Vector2d& p : b.corners()) bounds.extend(Eigen::Vector2d(to_a * (p - a.spot.place)));
    return bounds.min().x() > a.depth / 2 || bounds.max().x() < -a.depth / 2 ||
           bounds.min().y() > a.width / 2 || bounds.max().y() < -a.width / 2;
  }

  /** Clips the line at the box's sides, one after the other. */
  static bool crosses(const Eigen::AlignedBox2d& box, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    double enter = 0, leave = 1;
    for (int axis = 0; axis < 2; ++axis) {
      const double step = b[axis] - a[axis];
      double first = (box.min()[axis] - a[axis]) / step, last = (box.max()[axis] - a[axis]) / step;
      if (step == 0) {
        if (a[axis] < box.min()[axis] || a[axis] > box.max()[axis]) return false;
        continue;
      }
      if (first > last) std::swap(first, last);
      enter = std::max(enter, first);
      leave = std::min(leave, last);
    }
    return enter <= leave;
  }
};

/** \brief The heights that something takes: bits. */
enum Height : unsigned { kLow = 1, kHigh = 2, kAllHeights = 3 };

/** \brief The occupied parts of a floor, and the robot's lanes, which stay free of things low enough to be
 * hit.
 */
class FloorPlan {
public:
  void keepFree(const Route& route) { routes_.push_back(route); }
  void take(const Footprint& footprint, unsigned heights = kAllHeights) {
    taken_.push_back({footprint, heights});
  }

  bool isFree(const Footprint& footprint, unsigned heights = kAllHeights) const {
    if ((heights & kLow) && isOnALane(footprint)) return false;
    return std::none_of(taken_.begin(), taken_.end(), [&](const Taken& other) {
      return (other.heights & heights) && other.footprint.overlaps(footprint);
    });
  }

private:
  static constexpr double kClearance = 0.46;  // distance from the lanes' middle lines [m]

  struct Taken {
    Footprint footprint;
    unsigned heights;
  };

  bool isOnALane(const Footprint& footprint) const {
    for (const Route& route : routes_)
      for (std::size_t i = 0; i < route.size(); ++i)
        if (footprint.distanceTo(route[i].place, route[(i + 1) % route.size()].place) < kClearance)
          return true;
    return false;
  }

  std::vector<Taken> taken_;
  std::vector<Route> routes_;
};

/** \brief Puts things where there is room for them. Some stand elsewhere when the robot comes back. */
class Furnisher {
public:
  Furnisher(SceneBuilder& builder, FloorPlan& plan, Random& random)
      : builder_(builder), plan_(plan), random_(random) {}

  /** \brief A thing with its back to a wall of a room, its heading off by up to a turn; returns its spot, or
   * none if there was no room. A light thing may have moved. */
  std::optional<Spot> atWall(const Kind& kind, const Eigen::AlignedBox2d& room, bool light = false,
                             double turn_deg = 0) {
    return put(kind, light, room, [&] { return drawSpotAtWall(kind, room, turn_deg); });
  }

  /** \brief A thing somewhere in an area, turned anyhow. */
  std::optional<Spot> anywhere(const Kind& kind, const Eigen::AlignedBox2d& area, bool light = true) {
    return put(kind, light, area, [&] { return drawSpot(area); });
  }

  /** \brief A thing at a given spot, or as near as a slack [m] allows. */
  std::optional<Spot> at(const Kind& kind, const Spot& spot, const Eigen::AlignedBox2d& area,
                         bool light = false, double slack = 0, double turn_deg = 0) {
    return put(kind, light, area, [&] {
      const double x = random_.uniform(-slack, slack), y = random_.uniform(-slack, slack);
      return spot.relative(x, y, turn_deg * kDegree * random_.uniform(-1, 1));
    });
  }

  /** \brief A thing that is there in one of the runs only. */
  void passing(const Kind& kind, const Eigen::AlignedBox2d& area, When when) {
    if (const auto spot = takeSpot(kind, area, [&] { return drawSpot(area); }))
      kind.add(builder_, *spot, random_, when);
  }

  /** \brief A spot on the wall for something flat, at a height; none if all walls are covered there. */
  std::optional<Spot> onWall(const Eigen::AlignedBox2d& room, double width, double z) {
    constexpr double kDepth = 0.1;  // [m] things nearer to the wall than this hide it
    const Kind flat{nullptr, kDepth, width};
    for (int i = 0; i < kTries; ++i) {
      const Spot spot = drawSpotAtWall(flat, room, 0);
      if (!plan_.isFree(footprint(flat, spot), kHigh)) continue;
      plan_.take(footprint(flat, spot), kHigh);
      return spot.relative(-spotOffset(flat), 0, 0, z);
    }
    return std::nullopt;
  }

private:
  static constexpr int kTries = 200;
  static constexpr double kShareMoved = 0.25;  // share of the light things
  static constexpr double kGap = 0.01;         // between a thing and its wall [m]

  static double spotOffset(const Kind& kind) { return kind.depth / 2 + kGap; }
  static unsigned heights(const Kind& kind) { return kind.tall ? kAllHeights : kLow; }
  static Footprint footprint(const Kind& kind, const Spot& spot) { return {spot, kind.depth, kind.width}; }

  Spot drawSpot(const Eigen::AlignedBox2d& area) {
    const double x = random_.uniform(area.min().x(), area.max().x());
    const double y = random_.uniform(area.min().y(), area.max().y());
    return {{x, y}, random_.uniform(-180, 180) * kDegree};
  }

  Spot drawSpotAtWall(const Kind& kind, const Eigen::AlignedBox2d& room, double turn_deg) {
    // Long walls get more; the four follow one another around the room, inside to the left.
    const Eigen::Vector2d sizes = room.sizes();
    double along = random_.uniform(0, 2 * sizes.sum());
    int wall = 0;
    while (wall < 3 && along > sizes[wall % 2]) along -= sizes[wall++ % 2];
    const std::array<Eigen::Vector2d, 4> corners = {
        room.min(), {room.max().x(), room.min().y()}, room.max(), {room.min().x(), room.max().y()}};
    const double yaw = 90 * kDegree * (wall + 1);
    const Spot corner{corners[wall], yaw};
    // Snapped to the corner if there is no room for anything else beside it.
    constexpr double kUselessGap = 0.35;  // [m]
    const double end = sizes[wall % 2] - kind.width / 2 - kGap;
    along = std::clamp(along, std::min(kind.width / 2 + kGap, end), end);
    if (along - kind.width / 2 < kUselessGap) along = kind.width / 2 + kGap;
    if (end - along < kUselessGap) along = end;
    const double turn = turn_deg * kDegree * random_.uniform(-1, 1);
    // Turned things keep off the wall with their corners.
    const double off = kind.width / 2 * std::abs(std::sin(turn)) - kind.depth / 2 * (1 - std::cos(turn));
    return corner.relative(spotOffset(kind) + std::max(off, 0.0), -along, turn);
  }

  /** None if there is no room. */
  template <class Draw>
  std::optional<Spot> takeSpot(const Kind& kind, const Eigen::AlignedBox2d& area, const Draw& draw) {
    for (int i = 0; i < kTries; ++i) {
      const Spot spot = draw();
      const Footprint taken = footprint(kind, spot);
      if (!taken.isWithin(area) || !plan_.isFree(taken, heights(kind))) continue;
      plan_.take(taken, heights(kind));
      return spot;
    }
    return std::nullopt;
  }

  template <class Draw>
  std::optional<Spot> put(const Kind& kind, bool light, const Eigen::AlignedBox2d& area, const Draw& draw) {
    const std::optional<Spot> spot = takeSpot(kind, area, draw);
    if (!spot) return spot;
    const bool moves = random_.uniform() < kShareMoved;
    if (!light || !moves) {
      kind.add(builder_, *spot, random_, When::always);
      return spot;
    }
    const Random before = random_;
    kind.add(builder_, *spot, random_, When::mapped);
    if (const std::optional<Spot> later = takeSpot(kind, area, [&] { return pushed(*spot); })) {
      Random again = before;
      kind.add(builder_, *later, again, When::later);
    }
    return spot;
  }

  /** Where somebody may have left a thing again. */
  Spot pushed(const Spot& spot) {
    constexpr double kFar = 1.2, kTurn = 60;  // [m], [deg]
    const double x = random_.uniform(-kFar, kFar), y = random_.uniform(-kFar, kFar);
    return spot.relative(x, y, kTurn * kDegree * random_.uniform(-1, 1));
  }

  SceneBuilder& builder_;
  FloorPlan& plan_;
  Random& random_;
};

/** \brief A floor that is built and furnished. */
class FurnishedFloor {
protected:
  /** \param purpose of the random numbers for its furniture */
  FurnishedFloor(std::uint64_t seed, std::uint64_t purpose)
      : seed_(seed),
        random_(derivedSeed(seed, purpose)),
        builder_(place_),
        furnisher_(builder_, plan_, random_) {}

  /** \brief Random number from least to most, both included. */
  int count(int least, int most) { return least + static_cast<int>((most - least + 1) * random_.uniform()); }

  static constexpr double kPi = 180 * kDegree;

  std::uint64_t seed_;
  Random random_;
  SimulatedPlace place_;
  SceneBuilder builder_;
  FloorPlan plan_;
  Furnisher furnisher_;
  bool mirrored_ = false;
};

/** \brief Turns a place into its mirror image: x becomes width - x. */
inline void mirror(SimulatedPlace& place, double width) {
  const auto point = [width](Eigen::Vector3d p) { return Eigen::Vector3d(width - p.x(), p.y(), p.z()); };
  const auto direction = [](Eigen::Vector3d d) { return Eigen::Vector3d(-d.x(), d.y(), d.z()); };
  for (SimulatedWorld* world : {&place.mapped, &place.later}) {
    for (Rectangle& r : world->rectangles) {
      r.centre = point(r.centre);
      r.axis_u = direction(r.axis_u);
      r.axis_v = direction(r.axis_v);
    }
    for (RoundBody& body : world->bodies) {
      // Round bodies are their own mirror images: a flipped axis of the body makes the frame right-handed
      // again.
      const Eigen::Matrix3d axes = body.T_w_b.linear();
      body.T_w_b.linear() << -direction(axes.col(0)), direction(axes.col(1)), direction(axes.col(2));
      body.T_w_b.translation() = point(body.T_w_b.translation());
    }
  }
  for (Route* route : {&place.mapping_route, &place.query_route}) {
    for (Waypoint& waypoint : *route) {
      waypoint.place.x() = width - waypoint.place.x();
      waypoint.look_deg = -waypoint.look_deg;
    }
  }
  for (std::vector<PlanOutline>* outlines : {&place.walls, &place.doorways})
    for (PlanOutline& outline : *outlines) {
      for (Eigen::Vector2d& corner : outline) corner.x() = width - corner.x();
      std::reverse(outline.begin(), outline.end());
    }
  for (Eigen::AlignedBox2d& room : place.unmapped_rooms)
    room = {Eigen::Vector2d(width - room.max().x(), room.min().y()),
            Eigen::Vector2d(width - room.min().x(), room.max().y())};
}

}  // namespace facetloc
