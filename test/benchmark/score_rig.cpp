// SPDX-License-Identifier: BSD-3-Clause
//
// Several cameras on a robot against its first one, in simulated places that one camera has mapped.
//
//   score_rig SEED...
//
// A seed makes a place, its noise, and true poses of the cameras that differ from the stated ones. The case
// "end" has two cameras at a corridor's end, which look along it and back. All others have three cameras, 100
// deg apart, within 0.5 m and 15 deg of a map image. A view of one camera is free if it is not sure, and
// fixed if the view of all cameras is sure and right.
#include "programs.h"

#include <facetloc/localization/localizer.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace facetloc;
using benchmarks::percent;

constexpr int kWidth = 320;
constexpr double kRotationStd = 0.4 * kDegree, kTranslationStd = 0.01;  // calibration of a rig

/** Time of this process, whatever else runs [ms]. */
double milliseconds(std::clock_t since) {
  return 1000.0 * static_cast<double>(std::clock() - since) / CLOCKS_PER_SEC;
}

struct RigCamera {
  CameraMounting stated;
  Eigen::Isometry3d T_b_c;  // true
};

using Rig = std::vector<RigCamera>;

Matrix6d calibrationError() {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(kRotationStd * kRotationStd),
      Eigen::Vector3d::Constant(kTranslationStd * kTranslationStd);
  return variance.asDiagonal();
}

Rig rigOf(const std::vector<double>& pans_deg, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Matrix6d spread = calibrationError().cwiseSqrt();
  Rig rig;
  for (const double pan : pans_deg) {
    CameraMounting mounting = DriveParams().mounting();
    mounting.pan_deg = pan;
    mounting.x = 0.1 * std::cos(pan * kDegree), mounting.y = 0.1 * std::sin(pan * kDegree);
    Vector6d error = Vector6d::NullaryExpr([&] { return normal(random); });
    if (rig.empty()) error.setZero();  // the pose of the view is the one of the first camera
    rig.push_back({mounting, mounting.T_b_c() * boxplus(Eigen::Isometry3d::Identity(), spread * error)});
  }
  return rig;
}

std::vector<Eigen::Isometry3d> statedSides(const Rig& rig) {
  std::vector<Eigen::Isometry3d> T_v_c;
  for (std::size_t k = 1; k < rig.size(); ++k)
    T_v_c.push_back(rig[0].stated.T_b_c().inverse() * rig[k].stated.T_b_c());
  return T_v_c;
}

bool isFirstRight(const Localization& answer, const Eigen::Isometry3d& truth) {
  return !answer.hypotheses.empty() && isNear(*answer.hypotheses[0].T_w_c, truth, 0.3, 5);
}

/** Squared Mahalanobis distance of the first pose from the truth. */
double squaredError(const Localization& answer, const Map& map, const Eigen::Isometry3d& truth) {
  const Hypothesis& h = answer.hypotheses.front();
  const Eigen::Isometry3d T_w_m = *map.models[static_cast<std::size_t>(h.model)].T_w_m;
  const PoseWithCovariance found = T_w_m * PoseWithCovariance{T_w_m.inverse() * *h.T_w_c, h.T_m_c.P};
  return squaredMahalanobis(found, truth);
}

/** Answers to the views of the same cameras. */
struct Answers {
  int sure = 0, wrong = 0;    // wrong ones among the sure
  int right = 0, within = 0;  // those in the ellipsoid among the right
  double nees = 0, ms = 0;

  void add(const Localization& answer, const Map& map, const Eigen::Isometry3d& truth) {
    const bool is_sure = answer.state == AnswerState::sure, is_right = isFirstRight(answer, truth);
    sure += is_sure, wrong += is_sure && !is_right;
    if (!is_right) return;
    const double d2 = squaredError(answer, map, truth);
    ++right, nees += d2, within += d2 <= chiSquareQuantile(6, 0.95);
  }
  void add(const Answers& o) {
    sure += o.sure, wrong += o.wrong, right += o.right, within += o.within, nees += o.nees, ms += o.ms;
  }
};

struct Tally {
  int n = 0, free = 0, fixed = 0;
  double segment_ms = 0;
  Answers one, all;

  void add(const Tally& o) {
    n += o.n, free += o.free, fixed += o.fixed, segment_ms += o.segment_ms;
    one.add(o.one), all.add(o.all);
  }
  void print(const std::string& name) const {
    std::printf("%-12s %4d | %4d %4d %5.1f %% | %4d (%d) %4d (%d) | %6.2f %5.1f %% %6.2f %5.1f %% | %6.1f "
                "%6.1f %6.1f\n",
                name.c_str(), n, free, fixed, percent(fixed, free), one.sure, one.wrong, all.sure, all.wrong,
                one.nees / std::max(1, one.right), percent(one.within, one.right),
                all.nees / std::max(1, all.right), percent(all.within, all.right), segment_ms / n, one.ms / n,
                all.ms / n);
    std::fflush(stdout);
  }
};

struct Place {
  std::shared_ptr<const Map> map;
  SimulatedWorld world;
  std::vector<Eigen::Isometry3d> queries;  // T_w_b
};

Camera cameraOf(const CameraMounting& mounting) {
  Camera camera;
  camera.intrinsics = centredKinect(kWidth);
  camera.mounting = mounting;
  return camera;
}

std::shared_ptr<const Map> mapOf(const SimulatedWorld& world, const std::vector<Eigen::Isometry3d>& poses,
                                 std::uint64_t seed) {
  auto map = std::make_shared<Map>();
  map->camera = cameraOf(DriveParams().mounting());
  const SimulatedCamera camera(map->camera.intrinsics, {}, seed);
  ViewBuilder builder(map->camera);
  for (std::size_t i = 0; i < poses.size(); ++i)
    map->models.emplace_back(std::to_string(i), static_cast<double>(i), poses[i],
                             builder.build(camera.render(world, poses[i], i).depth));
  return map;
}

Place placeOf(const std::string& name, std::uint64_t seed) {
  const bool is_end = name == "end";
  const std::string kind = is_end ? "corridor" : name;
  const DriveParams drive;
  const SimulatedRun mapping = simulatedRun(kind, seed, kMappingRun, 160, drive);
  Place place;
  place.map = mapOf(mapping.world, mapping.poses, seed);
  const SimulatedRun later = simulatedRun(kind, seed, kLaterRun, 160, drive);
  place.world = later.world;
  place.queries = basePoses(later.poses, drive.mounting());
  if (!is_end) {
    std::vector<Eigen::Isometry3d> covered;
    for (std::size_t i = 0; i < later.poses.size(); i += 3)
      if (std::any_of(mapping.poses.begin(), mapping.poses.end(),
                      [&](const Eigen::Isometry3d& T) { return isNear(T, later.poses[i], 0.5, 15); }))
        covered.push_back(place.queries[i]);
    place.queries = covered;
    return place;
  }
  place.queries.clear();
  std::mt19937_64 random(seed);
  const auto uniform = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  for (int i = 0; i < 12; ++i) {
    Eigen::Isometry3d T(Eigen::AngleAxisd(uniform(-8, 8) * kDegree, Eigen::Vector3d::UnitZ()));
    T.translation() = Eigen::Vector3d(uniform(38.5, 39.1), uniform(-0.3, 0.3), 0);
    place.queries.push_back(T);
  }
  return place;
}

Tally score(const std::string& name, const std::vector<double>& pans_deg, std::uint64_t seed) {
  const Place place = placeOf(name, seed);
  const Rig stated = rigOf(pans_deg, seed);
  const Localizer one(place.map), all(mapForRig(place.map, statedSides(stated)));
  std::vector<ViewBuilder> builders;
  for (const RigCamera& camera : stated) builders.emplace_back(cameraOf(camera.stated));
  Tally tally;
  for (std::size_t i = 0; i < place.queries.size(); ++i) {
    const Rig rig = rigOf(pans_deg, 1000 * seed + i);
    const Eigen::Isometry3d T_v_b = rig[0].stated.T_b_c().inverse();
    std::vector<std::shared_ptr<const View>> views;
    for (std::size_t k = 0; k < rig.size(); ++k) {
      const SimulatedCamera camera(centredKinect(kWidth), {}, seed + 100 * k);
      const DepthImage image = camera.render(place.world, place.queries[i] * rig[k].T_b_c, 1000 + i).depth;
      const std::clock_t start = std::clock();
      views.push_back(std::make_shared<const View>(builders[k].build(image)));
      tally.segment_ms += milliseconds(start);
    }
    const Eigen::Isometry3d truth = place.queries[i] * rig[0].T_b_c;
    auto start = std::clock();
    const Localization by_one = one.localize(*views[0]);
    tally.one.ms += milliseconds(start);
    std::vector<PosedView> others;
    for (std::size_t k = 1; k < rig.size(); ++k)
      others.push_back({views[k], T_v_b * PoseWithCovariance{rig[k].stated.T_b_c(), calibrationError()}});
    all.localize(joined(*views[0], others));  // the views of the map are joined now
    start = std::clock();
    const Localization by_all = all.localize(joined(*views[0], others));
    tally.all.ms += milliseconds(start);

    ++tally.n;
    const bool is_free = by_one.state != AnswerState::sure;
    const bool is_fixed = isFirstRight(by_all, truth) && by_all.state == AnswerState::sure;
    tally.free += is_free, tally.fixed += is_free && is_fixed;
    tally.one.add(by_one, *place.map, truth);
    tally.all.add(by_all, *place.map, truth);
  }
  return tally;
}

void run(const std::vector<std::uint64_t>& seeds) {
  std::printf("%-12s %4s | %4s %4s         | sure: one, all    | NEES, in 95 %%: one, all     | ms: "
              "segments, one, all\n",
              "", "n", "free", "fixed");
  const std::vector<std::pair<std::string, std::vector<double>>> cases = {{"end", {0, 180}},
                                                                          {"corridor", {0, 100, -100}},
                                                                          {"office", {0, 100, -100}},
                                                                          {"home", {0, 100, -100}},
                                                                          {"hall", {0, 100, -100}}};
  for (const auto& [name, pans] : cases) {
    Tally sum;
    for (const std::uint64_t seed : seeds) sum.add(score(name, pans, seed));
    sum.print(name);
  }
}

}  // namespace

int main(int argc, char** argv) {
  return benchmarks::runProgram("score_rig", [&] {
    std::vector<std::uint64_t> seeds;
    for (int i = 1; i < argc; ++i) seeds.push_back(std::stoull(argv[i]));
    run(seeds);
  });
}
