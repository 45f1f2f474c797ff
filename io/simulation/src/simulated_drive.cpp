// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_drive.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr double kPi = 180 * kDegree;
constexpr double kSpacing = 0.1;        // spacing of the points that stand for surfaces [m]
constexpr double kFloor = 0.05;         // lower things are driven over [m]
constexpr double kShortestDrive = 0.8;  // between two looks around [m]
constexpr double kDriveStep = 0.01;     // [m]
constexpr double kTurnStep = 0.5 * kDegree;
constexpr double kRounding = 1e-9;
constexpr double kDisplacement =
    0.1;  // displacement of waypoints from round to round [m]: the robot still fits through doors
constexpr int kTries = 2000;  // to find a free place
constexpr int kGoals = 10;    // to choose the next one from

class Random {
public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double lowest, double highest) {
    return lowest + (highest - lowest) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  double normal(double std) { return std * normal_(engine_); }

private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

/** The room as a robot sees it: where it may stand. */
class FloorPlan {
public:
  FloorPlan(const SimulatedWorld& world, double robot_height, double clearance) : clearance_(clearance) {
    for (const Rectangle& r : world.rectangles) addExtent(r);
    for (const Rectangle& r : world.rectangles) addObstacle(r, robot_height);
  }

  std::optional<Eigen::Vector2d> freePlace(Random& random) const {
    for (int i = 0; i < kTries; ++i) {
      const double x = random.uniform(box_.min().x(), box_.max().x());
      const double y = random.uniform(box_.min().y(), box_.max().y());
      if (isFree({x, y})) return Eigen::Vector2d(x, y);
    }
    return {};
  }

  bool isFreeWay(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    const int steps = static_cast<int>(std::ceil((to - from).norm() / kSpacing));
    for (int i = 0; i <= steps; ++i)
      if (!isFree(from + (to - from) * (static_cast<double>(i) / std::max(steps, 1)))) return false;
    return true;
  }

private:
  void addExtent(const Rectangle& r) {
    for (const double u : {-r.half_u, r.half_u})
      for (const double v : {-r.half_v, r.half_v}) box_.extend(r.centre + u * r.axis_u + v * r.axis_v);
  }

  /** Covers of boxes block at any height, so that no route starts inside a cupboard; the ceiling does not. */
  void addObstacle(const Rectangle& r, double robot_height) {
    const bool level = r.axis_u.cross(r.axis_v).normalized().cwiseAbs().z() > 0.9;
    const double ceiling = box_.max().z() - kFloor;
    const double top = level ? ceiling : robot_height;
    const int nu = static_cast<int>(std::ceil(2 * r.half_u / kSpacing));
    const int nv = static_cast<int>(std::ceil(2 * r.half_v / kSpacing));
    for (int i = 0; i <= nu; ++i)
      for (int j = 0; j <= nv; ++j) {
        const Eigen::Vector3d p = r.centre + (2.0 * i / std::max(nu, 1) - 1) * r.half_u * r.axis_u +
                                  (2.0 * j / std::max(nv, 1) - 1) * r.half_v * r.axis_v;
        if (p.z() > kFloor && p.z() < top) obstacles_.push_back(p.head<2>());
      }
  }

  bool isFree(const Eigen::Vector2d& place) const {
    for (const Eigen::Vector2d& p : obstacles_)
      if ((p - place).squaredNorm() < clearance_ * clearance_) return false;
    return true;
  }

  double clearance_;
  Eigen::AlignedBox3d box_;
  std::vector<Eigen::Vector2d> obstacles_;
};

/** The height of an uneven floor, some waves of all directions. */
class UnevenFloor {
public:
  UnevenFloor(double std, Random& random) {
    constexpr int kWaves = 12;
    constexpr double kShortest = 0.4, kLongest = 1.2;  // about the size of the robot [m]
    amplitude_ = std * std::sqrt(2.0 / kWaves);
    for (int i = 0; i < kWaves; ++i) {
      const double direction = random.uniform(-kPi, kPi);
      const double wave_number = 2 * kPi / random.uniform(kShortest, kLongest);
      const double phase = random.uniform(-kPi, kPi);
      waves_.push_back({wave_number * std::cos(direction), wave_number * std::sin(direction), phase});
    }
  }
  double height(const Eigen::Vector2d& p) const {
    double sum = 0;
    for (const Eigen::Vector3d& w : waves_) sum += std::sin(w.x() * p.x() + w.y() * p.y() + w.z());
    return amplitude_ * sum;
  }

private:
  double amplitude_;
  std::vector<Eigen::Vector3d> waves_;  // (wave vector, phase)
};

/** The robot: its pose, and the views of its camera. */
class Robot {
public:
  Robot(const DriveParams& params, const std::optional<PaceParams>& pace, Random& random, std::size_t frames)
      : params_(params),
        pace_(pace),
        random_(random),
        frames_(frames),
        T_b_c_(params.mounting().T_b_c()),
        sway_phase_(random.uniform(-kPi, kPi)) {
    if (pace) floor_.emplace(params.robot.floor_std, random);
  }

  bool done() const { return poses_.size() >= frames_; }
  const Eigen::Vector2d& place() const { return place_; }
  std::vector<Eigen::Isometry3d> poses() && { return std::move(poses_); }

  void putDown(const Eigen::Vector2d& place, double course) {
    place_ = place;
    course_ = course;
    look();
  }
  void turn(double angle) {
    const double end = course_ + angle;
    while (!done() && course_ != end) {
      const double left = end - course_;
      const double due = pace_ ? timeLeft() * turnRate() : params_.turn_deg * kDegree - turned();
      const double step = std::min({std::abs(left), kTurnStep, due});
      course_ = std::abs(left) <= step ? end : course_ + std::copysign(step, left);
      if (pace_) time_ += step / turnRate();
      lookIfDue();
    }
  }
  void driveTo(const Eigen::Vector2d& goal) {
    const Eigen::Vector2d way = goal - place_;
    turn(std::remainder(std::atan2(way.y(), way.x()) - course_, 2 * kPi));
    const double length = way.norm();
    double gone = 0;
    while (!done() && gone < length) {
      const double left = length - gone;
      const double due = pace_ ? timeLeft() * pace_->speed : params_.step - driven_;
      const double step = std::min({left, kDriveStep, due});
      gone = step >= left ? length : gone + step;
      if (pace_)
        place_ += step * ahead();
      else
        place_ = step >= left ? goal : Eigen::Vector2d(place_ + step / left * (goal - place_));
      driven_ += step;
      odometer_ += step;
      if (pace_) time_ += step / pace_->speed;
      lookIfDue();
    }
  }

private:
  double heading() const {
    const double sway = std::sin(2 * kPi * odometer_ / kSwayLength + sway_phase_);
    return course_ + params_.sway_deg * kDegree * sway;
  }
  /** Wheels do not slip sideways: in time, a robot that sways weaves about the line. Images that are taken
   * now and then show the line with other headings. */
  Eigen::Vector2d ahead() const { return {std::cos(heading()), std::sin(heading())}; }
  /** Since the last image. */
  double turned() const { return std::abs(std::remainder(heading() - heading_seen_, 2 * kPi)); }
  double turnRate() const { return pace_->turn_rate_deg * kDegree; }
  /** Until the next image is due; images are counted, so that no rounding adds up. */
  double timeLeft() const { return static_cast<double>(poses_.size()) / pace_->rate - time_; }
  bool due() const {
    if (pace_) return timeLeft() <= kRounding;
    return driven_ >= params_.step - kRounding || turned() >= params_.turn_deg * kDegree - kRounding;
  }
  void lookIfDue() {
    if (due()) look();
  }
  void look() {
    driven_ = 0;
    heading_seen_ = heading();
    if (!done()) poses_.push_back(basePose() * T_b_c_);
  }

  /** T_w_b where the floor differs in height under both drive wheels and the caster. */
  Eigen::Isometry3d basePose() {
    const double left = floorAt({0, params_.robot.wheel_track / 2});
    const double right = floorAt({0, -params_.robot.wheel_track / 2});
    const double caster = floorAt({-params_.robot.caster_distance, 0});
    const double axle = (left + right) / 2;
    const double slope_y = (left - right) / params_.robot.wheel_track,
                 slope_x = (axle - caster) / params_.robot.caster_distance;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = expSO3({0, 0, heading()}) * expSO3({slope_y, -slope_x, 0});
    T.translation() << place_, axle;
    return T;
  }

  /** Under a wheel, given in the robot's frame. Images that are taken now and then show any two floors. */
  double floorAt(const Eigen::Vector2d& wheel) {
    if (!floor_) return random_.normal(params_.robot.floor_std);
    return floor_->height(place_ + Eigen::Rotation2Dd(heading()) * wheel);
  }

  const DriveParams& params_;
  const std::optional<PaceParams>& pace_;
  Random& random_;
  std::size_t frames_;
  std::optional<UnevenFloor> floor_;
  Eigen::Isometry3d T_b_c_;
  Eigen::Vector2d place_ = Eigen::Vector2d::Zero();
  double sway_phase_;
  double course_ = 0;        // the heading without the sway [rad]
  double odometer_ = 0;      // [m]
  double driven_ = 0;        // since the last image [m]
  double heading_seen_ = 0;  // at the last image [rad]
  double time_ = 0;          // since the first image [s]
  std::vector<Eigen::Isometry3d> poses_;
};

/** The place farthest from where the robot has been, out of some random ones in sight. */
std::optional<Eigen::Vector2d> nextGoal(const FloorPlan& plan, const Eigen::Vector2d& place,
                                        const std::vector<Eigen::Vector2d>& visited, Random& random) {
  std::optional<Eigen::Vector2d> best;
  double farthest = 0;
  for (int i = 0; i < kGoals; ++i) {
    const auto goal = plan.freePlace(random);
    if (!goal || (*goal - place).norm() < kShortestDrive || !plan.isFreeWay(place, *goal)) continue;
    double distance = std::numeric_limits<double>::max();
    for (const Eigen::Vector2d& v : visited) distance = std::min(distance, (*goal - v).norm());
    if (distance <= farthest) continue;
    farthest = distance;
    best = goal;
  }
  return best;
}

}  // namespace

std::vector<Eigen::Isometry3d> simulateDrive(const Route& route, std::size_t frames,
                                             const DriveParams& params, std::uint64_t seed,
                                             const std::optional<PaceParams>& pace, RouteEnd end) {
  Random random(seed);
  Robot robot(params, pace, random, frames);
  if (route.size() < 2) throw std::invalid_argument("simulateDrive: a route has at least two waypoints");
  const Eigen::Vector2d way = route[1].place - route[0].place;
  robot.putDown(route[0].place, std::atan2(way.y(), way.x()));
  for (std::size_t next = 1; !robot.done(); ++next) {
    if (end == RouteEnd::stop && next == route.size()) break;
    const Waypoint& waypoint = route[next % route.size()];
    robot.driveTo(waypoint.place);
    robot.turn(waypoint.look_deg * kDegree);
  }
  return std::move(robot).poses();
}

std::vector<Eigen::Isometry3d> simulateDrive(const SimulatedWorld& world, std::size_t frames,
                                             const DriveParams& params, std::uint64_t seed,
                                             const std::optional<Eigen::Vector2d>& start,
                                             const std::optional<PaceParams>& pace) {
  Random random(seed);
  const FloorPlan plan(world, params.camera_height + 0.1, params.clearance);
  const auto first = start ? start : plan.freePlace(random);
  if (!first)
    throw std::runtime_error("the room leaves no place to drive; take another seed or a smaller clearance");
  std::vector<Eigen::Vector2d> visited = {*first};
  Robot robot(params, pace, random, frames);
  robot.putDown(*first, random.uniform(-kPi, kPi));
  while (!robot.done()) {
    const double side = random.uniform(-1, 1) < 0 ? -1 : 1;
    robot.turn(side * random.uniform(kPi / 2, 2 * kPi));
    const auto goal = nextGoal(plan, robot.place(), visited, random);
    if (!goal) continue;
    robot.driveTo(*goal);
    visited.push_back(*goal);
  }
  return std::move(robot).poses();
}

Route roundsOf(const Route& route, int rounds, std::uint64_t seed) {
  Random random(seed);
  Route all = route;
  for (int round = 1; round < rounds; ++round)
    for (Waypoint waypoint : route) {
      waypoint.place.x() += random.uniform(-kDisplacement, kDisplacement);
      waypoint.place.y() += random.uniform(-kDisplacement, kDisplacement);
      all.push_back(waypoint);
    }
  return all;
}

std::vector<double> drivingTimes(const std::vector<Eigen::Isometry3d>& T_w_b, const PaceParams& pace) {
  const auto heading = [](const Eigen::Isometry3d& T) { return std::atan2(T(1, 0), T(0, 0)); };
  std::vector<double> times;
  if (!T_w_b.empty()) times.push_back(0);
  for (std::size_t i = 1; i < T_w_b.size(); ++i) {
    const Eigen::Isometry3d &from = T_w_b[i - 1], &to = T_w_b[i];
    const double distance = (to.translation() - from.translation()).head<2>().norm();
    const double turn = std::abs(std::remainder(heading(to) - heading(from), 2 * kPi));
    times.push_back(times.back() +
                    std::max({distance / pace.speed, turn / (pace.turn_rate_deg * kDegree), 1 / pace.rate}));
  }
  return times;
}

std::vector<Eigen::Isometry3d> basePoses(const std::vector<Eigen::Isometry3d>& T_w_c,
                                         const CameraMounting& mounting) {
  const Eigen::Isometry3d T_c_b = mounting.T_b_c().inverse();
  std::vector<Eigen::Isometry3d> T_w_b;
  for (const Eigen::Isometry3d& T : T_w_c) T_w_b.push_back(T * T_c_b);
  return T_w_b;
}

}  // namespace facetloc
