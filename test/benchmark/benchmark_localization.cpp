// SPDX-License-Identifier: BSD-3-Clause
//
// Speed of localization on one thread: one view against the paper's map of 142 local models.
#include "cluttered_room.h"

#include <facetloc/registration/global_localization.h>
#include <facetloc/segmentation/view_builder.h>

#include <benchmark/benchmark.h>

#include <memory>

namespace {

using namespace facetloc;
using namespace facetloc::benchmarks;

constexpr int kModels = 142;   // the paper's map
constexpr int kSegments = 20;  // per model and scene, at most

View viewOf(const Scene& scene, const Eigen::Isometry3d& T_w_c, std::uint64_t frame) {
  static ViewBuilder builder;
  const SimulatedCamera camera(kinectIntrinsics().subsampled(2), SimulatedNoise{}, kSeed);
  View view = builder.build(camera.render(scene, T_w_c, frame).depth);
  if (view.segments.size() > kSegments) view.segments.resize(kSegments);
  return view;
}

// 142 local models of up to 20 segments, in cluttered rooms.
std::shared_ptr<const Map> paperSizedMap() {
  auto map = std::make_shared<Map>();
  map->mounting = CameraMounting{1.0, 10.0};
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> heading(0, 6.28), place(-0.8, 0.8);
  for (int i = 0; i < kModels; ++i) {
    LocalModel m;
    const std::uint64_t room = static_cast<std::uint64_t>(i) / 12;  // twelve models per room
    m.T_w_m = cameraPose(place(random), place(random), heading(random));
    m.view = viewOf(clutteredRoom(kSeed + room), *m.T_w_m, static_cast<std::uint64_t>(i));
    m.T_w_m->translation().x() += 20.0 * static_cast<double>(room);
    map->models.push_back(std::move(m));
  }
  return map;
}

void localization(benchmark::State& state) {
  static const std::shared_ptr<const Map> map = paperSizedMap();
  GlobalLocalizationParams params;
  const bool dense = state.range(0) != 0;
  params.registration.depth_assistance = params.ranking.multi_model = dense;
  if (!dense) params.registration.consensus.free_space_weight = 0;
  const GlobalLocalization localizer(map, params);
  std::vector<View> scenes;
  for (int i = 0; i < 8; ++i)
    scenes.push_back(
        viewOf(clutteredRoom(kSeed + static_cast<std::uint64_t>(i)), cameraPose(0.2, 0.1, 0.8 * i), 1000));
  std::size_t next = 0, hypotheses = 0;
  for (auto _ : state) hypotheses += localizer.localize(scenes[next++ % scenes.size()]).hypotheses.size();
  double segments = 0;
  for (const LocalModel& m : map->models) segments += static_cast<double>(m.view.segments.size()) / kModels;
  state.counters["segments_per_model"] = segments;
  state.counters["places"] = static_cast<double>(hypotheses) / static_cast<double>(state.iterations());
}
BENCHMARK(localization)->ArgName("dense")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
