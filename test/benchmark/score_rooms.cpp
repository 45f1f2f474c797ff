// SPDX-License-Identifier: BSD-3-Clause
//
// Global localization in simulated rooms: random boxes, a robot on an uneven floor, the paper's prior, 200
// images.
//
//   score_rooms [FIRST_SEED]
//
// Each room is mapped by turning on the spot at three places, 15 deg per image. A query is a map pose
// displaced by a draw from the paper's prior (20 deg, 1 m, 1 m). Correct = within 0.2 m and 2 deg. By the
// rendered truth, a query is covered if a local model lies within 1 m and 20 deg, and solvable if the true
// planes of at least 150 px (at 320x240) that it shares with such a model fix all six degrees of freedom to 5
// cm.
#include "evaluation/evaluation.h"
#include "programs.h"
#include "ranking/global_localization.h"

#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace facetloc;
using benchmarks::percent;

constexpr int kRooms = 20, kQueriesPerRoom = 10, kPlaces = 3, kHeadings = 24;
constexpr int kAttempts = 500;      // to find a sensible query; a small, crowded room may have none
constexpr double kFreeView = 1.5;   // distance of the surfaces in view [m]: nearer, a wall fills the view
constexpr double kClearance = 0.6;  // distance of the robot from walls and boxes [m]
constexpr CameraMounting kMounting{1.0, 10.0};

struct Answered {
  bool covered = false, solvable = false, none = false, correct = false, rank1 = false;
  PoseError error;  // error of the first correct hypothesis
  std::string note;
};

// The room's extent is its largest horizontal rectangle, the floor.
Eigen::Vector2d floorHalfSize(const SimulatedWorld& scene, Eigen::Vector2d& centre) {
  const Rectangle* floor = nullptr;
  for (const Rectangle& r : scene.rectangles)
    if (std::abs(r.centre.z()) < 1e-9 && (!floor || r.half_u * r.half_v > floor->half_u * floor->half_v))
      floor = &r;
  centre = floor->centre.head<2>();
  return (floor->half_u * floor->axis_u + floor->half_v * floor->axis_v).head<2>().cwiseAbs();
}

class Room {
public:
  explicit Room(std::uint64_t seed)
      : scene_(furnishedRoom(seed)), random_(seed), camera_(kinectIntrinsics(), SimulatedNoise{}, seed) {
    half_ = floorHalfSize(scene_, centre_);
  }

  double gauss() { return std::normal_distribution<double>()(random_); }
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random_); }
  // Is the robot clear of walls and boxes? All of them stand upright, so their faces are enough.
  bool isFree(const Eigen::Vector2d& p) const {
    if (((p - centre_).cwiseAbs() - half_).maxCoeff() > -kClearance) return false;
    return std::all_of(scene_.rectangles.begin(), scene_.rectangles.end(), [&p](const Rectangle& r) {
      if (r.axis_u.cross(r.axis_v).z() == 0 && r.centre.z() - r.half_v > kMounting.height + 0.3)
        return true;  // above it
      const Eigen::Vector2d u = r.axis_u.head<2>() * r.half_u, v = r.axis_v.head<2>() * r.half_v;
      const bool horizontal = std::abs(r.axis_u.cross(r.axis_v).z()) > 0.5;
      if (horizontal && (r.centre.z() < 0.01 || r.centre.z() > 2)) return true;  // floor and ceiling
      for (double a = -1; a <= 1; a += 0.25)
        for (double b = -1; b <= 1; b += 0.25)
          if ((r.centre.head<2>() + a * u + b * v - p).norm() < kClearance) return false;
      return true;
    });
  }
  Eigen::Vector2d place() {
    Eigen::Vector2d p;
    do p = centre_ + Eigen::Vector2d(uniform(-1, 1) * half_.x(), uniform(-1, 1) * half_.y());
    while (!isFree(p));
    return p;
  }
  // Robot at (x, y, heading) on a floor that deviates under each wheel.
  Eigen::Isometry3d cameraPose(double x, double y, double heading) {
    const PosePriorParams robot;
    const Eigen::Matrix3d L = floorCovariance(robot).llt().matrixL();
    const Eigen::Vector3d tilt = L * Eigen::Vector3d(gauss(), gauss(), gauss());  // roll, pitch, height
    return Eigen::Translation3d(x, y, tilt[2]) *
           Eigen::Isometry3d(expSO3({0, 0, heading}) * expSO3({tilt[0], tilt[1], 0})) * kMounting.T_b_c();
  }
  bool looksIntoTheRoom(const Eigen::Isometry3d& T_w_c) const {
    return pinhole_.renderExact(scene_, T_w_c).depth.at(1, 1) >= kFreeView;  // the central pixel is enough
  }
  View view(const Eigen::Isometry3d& T_w_c) {
    const SimulatedFrame frame = camera_.render(scene_, T_w_c, frame_++);
    return builder_.build(workingImage(frame.depth));
  }
  TrueSegments trueSegmentsOf(const Eigen::Isometry3d& T_w_c) const {
    const SimulatedFrame frame = small_camera_.renderExact(scene_, T_w_c);
    return trueSegments(frame.depth, frame.labels, kVisiblePixels);
  }

private:
  SimulatedWorld scene_;
  std::mt19937_64 random_;
  SimulatedCamera camera_, small_camera_{kinectIntrinsics().subsampled(2), SimulatedNoise{}, 0};
  SimulatedCamera pinhole_{Intrinsics{3, 3, 1.0, 1.0, 1.0, 1.0}, SimulatedNoise{}, 0};
  ViewBuilder builder_{Camera{{}, {}, kMounting, {}}};
  Eigen::Vector2d centre_, half_;
  std::uint64_t frame_ = 0;
};

struct RobotPose {
  double x, y, heading;
};

Answered judge(const Localization& answer, const Eigen::Isometry3d& truth) {
  Answered a;
  a.none = answer.hypotheses.empty();
  a.note = answer.reason;
  for (std::size_t k = 0; k < answer.hypotheses.size() && !a.correct; ++k) {
    a.error = poseError(*answer.hypotheses[k].T_w_c, truth);
    a.correct = a.error.translation <= 0.2 && a.error.rotation_deg <= 2;
    a.rank1 = a.correct && k == 0;
  }
  return a;
}

std::vector<Answered> localizeInRoom(std::uint64_t seed) {
  Room room(seed);
  auto map = std::make_shared<Map>();
  map->camera.mounting = kMounting;
  std::vector<RobotPose> mapped;
  for (int p = 0; p < kPlaces; ++p) {
    const Eigen::Vector2d place = room.place();
    for (int h = 0; h < kHeadings; ++h) {
      mapped.push_back({place.x(), place.y(), h * 360.0 / kHeadings * kDegree});
      const Eigen::Isometry3d T_w_m = room.cameraPose(place.x(), place.y(), mapped.back().heading);
      map->models.emplace_back("", 0, T_w_m, room.view(T_w_m));
    }
  }
  const internal::GlobalLocalization localization(map);
  std::vector<TrueSegments> true_segments;
  for (const LocalModel& m : map->models) true_segments.push_back(room.trueSegmentsOf(*m.T_w_m));
  std::vector<Answered> answers;
  for (int q = 0; q < kQueriesPerRoom; ++q) {
    Eigen::Isometry3d truth;
    bool sensible = false;
    for (int attempt = 0; attempt < kAttempts && !sensible; ++attempt) {
      const RobotPose& from =
          mapped[static_cast<std::size_t>(room.uniform(0, static_cast<double>(mapped.size())))];
      const Eigen::Vector2d at(from.x + room.gauss(), from.y + room.gauss());
      truth = room.cameraPose(at.x(), at.y(), from.heading + 20 * kDegree * room.gauss());
      sensible = room.isFree(at) && room.looksIntoTheRoom(truth) &&
                 room.looksIntoTheRoom(room.cameraPose(from.x, from.y, from.heading));
    }
    if (!sensible) continue;
    Answered a = judge(localization.localize(room.view(truth)), truth);
    const TrueSegments seen = room.trueSegmentsOf(truth);
    for (std::size_t i = 0; i < map->models.size(); ++i) {
      const LocalModel& m = map->models[i];
      if (!isNear(*m.T_w_m, truth, kCoveredDistance, kCoveredRotationDeg)) continue;
      a.covered = true;
      a.solvable = a.solvable || sharedPlanesSuffice(seen, true_segments[i], kSolvablePosition,
                                                     kSolvableRotationDeg * kDegree);
    }
    answers.push_back(a);
  }
  return answers;
}

template <typename Filter>
void report(const char* name, const std::vector<Answered>& answers, Filter counts) {
  std::size_t n = 0, none = 0, correct = 0, rank1 = 0;
  double translation = 0, rotation_deg = 0;
  for (const Answered& a : answers) {
    if (!counts(a)) continue;
    ++n, none += a.none, correct += a.correct, rank1 += a.rank1;
    if (a.correct) translation += a.error.translation, rotation_deg += a.error.rotation_deg;
  }
  const auto found = static_cast<double>(std::max<std::size_t>(1, correct));
  std::printf("%-9s %6zu %8.1f %% %8.1f %% %8.1f %% %8.1f mm %6.2f deg\n", name, n, percent(none, n),
              percent(correct, n), percent(rank1, n), 1000 * translation / found, rotation_deg / found);
}

}  // namespace

int main(int argc, char** argv) {
  const std::uint64_t first_seed = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1;
  std::vector<std::vector<Answered>> rooms(kRooms);
#pragma omp parallel for schedule(dynamic)
  for (int r = 0; r < kRooms; ++r) rooms[r] = localizeInRoom(first_seed + r);

  std::vector<Answered> all;
  for (int r = 0; r < kRooms; ++r)
    for (const Answered& a : rooms[r]) {
      if (!a.correct)
        std::printf("room %2d image %d: %s; %s%s\n", r + static_cast<int>(first_seed),
                    static_cast<int>(&a - &rooms[r][0]), a.none ? a.note.c_str() : "no correct hypothesis",
                    a.covered ? "covered" : "not covered", a.solvable ? ", solvable by planes" : "");
      all.push_back(a);
    }
  std::printf("\nimages         n       none    correct     rank 1   mean error of the first correct\n");
  report("all", all, [](const Answered&) { return true; });
  report("covered", all, [](const Answered& a) { return a.covered; });
  report("solvable", all, [](const Answered& a) { return a.solvable; });
}
