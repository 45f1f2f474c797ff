// SPDX-License-Identifier: BSD-3-Clause
//
// A simulated robot that is not sure turns on the spot until it is: by the advice of Localizer::nextLook(),
// or one way.
//
//   score_looks FOLDER FIRST_SEED LAST_SEED [SCENE...]
//
// The maps of the floors (SCENE-SEED) are those of score_large_maps, kept in FOLDER. The robot starts where
// the later run has taken images, looks every 15 deg, and has a wheel odometry with its usual errors. It
// gives up after 360 deg. Starts where the first image is sure do not count.
#include "programs.h"
#include "simulated_floors.h"

#include <facetloc/localization/localizer.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace facetloc;
using benchmarks::percent;

constexpr int kStepDeg = 15, kRoundDeg = 360;
constexpr double kSecondsPerStep = 1.0 / 3;
constexpr int kWaySteps = 2;  // that the robot goes on where no turn is advised

enum Policy { kLeft, kRight, kAdvised, kPolicies };

/** How a robot has become sure, or not. */
struct Turned {
  int degrees = kRoundDeg;
  bool sure = false, right = false;
};

struct Sum {
  std::size_t starts = 0;
  double degrees = 0, advice_ms = 0;
  std::size_t advices = 0, sure = 0, right = 0, within_quarter = 0;

  void add(const Turned& turned) {
    ++starts;
    degrees += turned.degrees;
    sure += turned.sure, right += turned.right, within_quarter += turned.sure && turned.degrees <= 90;
  }
};

/** A place where a robot stands; its views by heading, the same for all policies. */
class Start {
public:
  Start(const SimulatedWorld& world, const SimulatedCamera& camera, const Camera& of_map,
        const Eigen::Isometry3d& T_w_c, std::size_t number)
      : world_(world),
        camera_(camera),
        builder_(of_map),
        mounting_(*of_map.mounting),
        T_w_c_(T_w_c),
        number_(number) {}

  Eigen::Isometry3d pose(int degrees) const {
    const Eigen::Isometry3d T_b_c = mounting_.T_b_c();
    return T_w_c_ * T_b_c.inverse() * Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d::UnitZ()) * T_b_c;
  }
  const View& view(int degrees) {
    const int heading = (degrees % kRoundDeg + kRoundDeg) % kRoundDeg;
    const auto known = views_.find(heading);
    if (known != views_.end()) return known->second;
    const std::size_t frame = 1000 + kRoundDeg * number_ + static_cast<std::size_t>(heading);
    return views_.emplace(heading, builder_.build(camera_.render(world_, pose(heading), frame).depth))
        .first->second;
  }
  /** The odometry of a step, with an error. */
  PoseWithCovariance step(int from, int to, std::mt19937& random) const {
    PoseWithCovariance motion = motionByOdometry(pose(from).inverse() * pose(to), mounting_);
    Vector6d error;
    std::normal_distribution<double> gauss;
    for (int k = 0; k < 6; ++k) error[k] = gauss(random);
    motion.T = boxplus(motion.T, Eigen::LLT<Matrix6d>(motion.P).matrixL() * error);
    return motion;
  }

private:
  const SimulatedWorld& world_;
  const SimulatedCamera& camera_;
  ViewBuilder builder_;
  CameraMounting mounting_;
  Eigen::Isometry3d T_w_c_;
  std::size_t number_;
  std::map<int, View> views_;
};

Turned turn(Start& start, Policy policy, Localizer& localizer, Sum& sum) {
  localizer.reset();
  std::mt19937 random(1);
  int heading = 0, goal = 0, side = policy == kRight ? -1 : 1;
  Turned turned;
  for (int way = 0; way <= kRoundDeg; way += kStepDeg) {
    std::optional<PoseWithCovariance> motion;
    if (way > 0) motion = start.step(heading, heading + side * kStepDeg, random), heading += side * kStepDeg;
    const View& view = start.view(heading);
    const Localization answer = localizer.update(view, kSecondsPerStep * way / kStepDeg, motion);
    if (answer.state == AnswerState::sure) {
      turned = {way, true, isNear(*answer.hypotheses.front().T_w_c, start.pose(heading), 0.3, 5)};
      break;
    }
    if (policy != kAdvised || heading != goal) continue;
    const auto begin = std::chrono::steady_clock::now();
    const std::optional<NextLook> look = localizer.nextLook(view, answer);
    sum.advice_ms += benchmarks::milliseconds(begin), ++sum.advices;
    const int steps =
        look && look->ahead == 0 ? static_cast<int>(std::lround(look->yaw / kDegree / kStepDeg)) : 0;
    if (steps != 0) side = steps < 0 ? -1 : 1;
    goal = heading + kStepDeg * (steps != 0 ? steps : side * kWaySteps);
  }
  return turned;
}

using Sums = std::array<Sum, kPolicies>;

void print(const std::string& name, const Sums& sums) {
  constexpr std::array<const char*, kPolicies> kNames = {"left", "right", "advised"};
  for (int policy = 0; policy < kPolicies; ++policy) {
    const Sum& s = sums[policy];
    std::printf("%-10s %-8s %6zu %8.1f deg %7.1f %% %7.1f %% %5zu / %-5zu", name.c_str(), kNames[policy],
                s.starts, s.starts > 0 ? s.degrees / static_cast<double>(s.starts) : 0.0,
                percent(s.within_quarter, s.starts), percent(s.sure, s.starts), s.right, s.sure);
    if (s.advices > 0) std::printf(" %7.1f ms", s.advice_ms / static_cast<double>(s.advices));
    std::printf("\n");
  }
  std::fflush(stdout);
}

void scoreFloor(const std::filesystem::path& folder, const std::string& scene, std::uint64_t seed,
                Sums& sums) {
  const SimulatedFloor floor = simulatedFloor(folder, scene, seed);
  const SimulatedPlace place = simulatedPlace(scene, seed);
  const SimulatedCamera camera(kinectIntrinsics().subsampled(2), SimulatedNoise{}, seed);
  const auto map = std::make_shared<const Map>(floor.map);
  const int n = static_cast<int>(floor.query.models.size());
  std::vector<std::array<Turned, kPolicies>> turned(n);
  std::vector<Sum> advice(n);
#pragma omp parallel for schedule(dynamic)
  for (int i = 0; i < n; ++i) {
    Start start(place.later, camera, map->camera, *floor.query.models[i].T_w_m, static_cast<std::size_t>(i));
    Localizer localizer(map);
    for (int policy = 0; policy < kPolicies; ++policy) {
      turned[i][policy] = turn(start, static_cast<Policy>(policy), localizer, advice[i]);
      if (turned[i][policy].sure && turned[i][policy].degrees == 0) break;
    }
  }
  for (int i = 0; i < n; ++i) {
    if (turned[i][kLeft].degrees == 0) continue;
    for (int policy = 0; policy < kPolicies; ++policy) sums[policy].add(turned[i][policy]);
    sums[kAdvised].advice_ms += advice[i].advice_ms, sums[kAdvised].advices += advice[i].advices;
  }
}

void run(int argc, char** argv) {
  if (argc < 4) throw benchmarks::Usage{"score_looks FOLDER FIRST_SEED LAST_SEED [SCENE...]"};
  const std::uint64_t first = std::strtoull(argv[2], nullptr, 10), last = std::strtoull(argv[3], nullptr, 10);
  std::vector<std::string> scenes(argv + 4, argv + argc);
  if (scenes.empty()) scenes = {"office", "home", "hall", "hotel"};
  std::printf("scene      policy   starts  turned till sure  <= 90 deg    sure  right / sure   per advice\n");
  Sums all;
  for (const std::string& scene : scenes) {
    Sums of_scene;
    for (std::uint64_t seed = first; seed <= last; ++seed) scoreFloor(argv[1], scene, seed, of_scene);
    print(scene, of_scene);
    for (int policy = 0; policy < kPolicies; ++policy) {
      Sum& sum = all[policy];
      const Sum& s = of_scene[policy];
      sum.starts += s.starts, sum.degrees += s.degrees, sum.sure += s.sure, sum.right += s.right;
      sum.within_quarter += s.within_quarter, sum.advices += s.advices, sum.advice_ms += s.advice_ms;
    }
  }
  print("all", all);
}

}  // namespace

int main(int argc, char** argv) {
  return benchmarks::runProgram("score_looks", [&] { run(argc, argv); });
}
