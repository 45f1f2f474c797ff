// SPDX-License-Identifier: BSD-3-Clause
//
// Speed of localization on one thread: one view against maps of cluttered rooms.
#include "cluttered_room.h"
#include "ranking/global_localization.h"

#include <facetloc/segmentation/view_builder.h>

#include <benchmark/benchmark.h>

#include <map>
#include <memory>
#include <random>

namespace {

using namespace facetloc;
using namespace facetloc::benchmarks;

constexpr int kPerRoom = 12;   // local models of one room
constexpr int kSegments = 20;  // per model and scene, at most

Camera robotCamera() {
  Camera camera;
  camera.mounting = CameraMounting{1.0, 10.0};
  return camera;
}

View viewOf(const SimulatedWorld& scene, const Eigen::Isometry3d& T_w_c, std::uint64_t frame) {
  static ViewBuilder builder(robotCamera());
  const SimulatedCamera camera(kinectIntrinsics().subsampled(2), SimulatedNoise{}, kSeed);
  View view = builder.build(camera.render(scene, T_w_c, frame).depth);
  if (view.segments.size() > kSegments) view.segments.resize(kSegments);
  return view;
}

// Local models of up to 20 segments, in cluttered rooms.
std::shared_ptr<const Map> mapOfRooms(int models) {
  auto map = std::make_shared<Map>();
  map->camera = robotCamera();
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> heading(0, 6.28), place(-0.8, 0.8);
  for (int i = 0; i < models; ++i) {
    const std::uint64_t room = static_cast<std::uint64_t>(i) / kPerRoom;
    const Eigen::Isometry3d T = cameraPose(place(random), place(random), heading(random));
    map->models.emplace_back("", 0, Eigen::Translation3d(20.0 * static_cast<double>(room), 0, 0) * T,
                             viewOf(clutteredRoom(kSeed + room), T, static_cast<std::uint64_t>(i)));
  }
  return map;
}

void localization(benchmark::State& state) {
  const int models = static_cast<int>(state.range(0));
  static std::map<int, std::shared_ptr<const Map>> maps;
  std::shared_ptr<const Map>& map = maps[models];
  if (!map) map = mapOfRooms(models);
  GlobalLocalizationParams params;
  const bool dense = state.range(1) != 0;
  params.steps.depth_assistance = params.evidence.enabled = dense;
  if (!dense) params.calibration.score.free_space_weight = 0;
  params.shortlist.size = state.range(2) != 0 ? params.shortlist.size : 0;
  params.shortlist.exhaustive_up_to = 0;
  const internal::GlobalLocalization localizer(map, params);
  std::vector<View> scenes;
  for (int i = 0; i < 8; ++i)
    scenes.push_back(
        viewOf(clutteredRoom(kSeed + static_cast<std::uint64_t>(i)), cameraPose(0.2, 0.1, 0.8 * i), 1000));
  std::size_t next = 0, hypotheses = 0;
  for (auto _ : state) hypotheses += localizer.localize(scenes[next++ % scenes.size()]).hypotheses.size();
  double segments = 0;
  for (int i = 0; i < models; ++i) segments += static_cast<double>(map->view(i)->segments.size()) / models;
  state.SetItemsProcessed(state.iterations() * models);
  state.counters["segments_per_model"] = segments;
  state.counters["places"] = static_cast<double>(hypotheses) / static_cast<double>(state.iterations());
}
// 142 local models are the paper's map. Small maps tell from how many on a shortlist is worth its time.
BENCHMARK(localization)
    ->ArgNames({"models", "dense", "shortlist"})
    ->ArgsProduct({{kPerRoom, 142}, {0, 1}, {1}})
    ->ArgsProduct({{2, 5, 30}, {1}, {1}})
    ->ArgsProduct({{2, 5, kPerRoom, 30, 142}, {1}, {0}})
    ->ArgsProduct({{142}, {0}, {0}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
