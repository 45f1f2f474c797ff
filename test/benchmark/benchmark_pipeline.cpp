// SPDX-License-Identifier: BSD-3-Clause
//
// Speed of the stages and of the whole, on one thread, on simulated images.
#include <facetloc/io/simulated_camera.h>
#include <facetloc/registration/global_localization.h>
#include <facetloc/segmentation/view_builder.h>

#include <benchmark/benchmark.h>

#include <memory>
#include <random>

namespace {

using namespace facetloc;

constexpr std::uint64_t kSeed = 7;
constexpr int kModels = 142;   // the paper's map
constexpr int kSegments = 20;  // per model and scene, at most
constexpr int kBoxes = 90;     // of a cluttered room

Eigen::Isometry3d cameraPose(double x, double y, double heading) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = expSO3({0, 0, heading});
  T.translation() << x, y, 0;
  return T * CameraMounting{1.0, 10.0}.T_b_c();
}

// A room full of boxes, on the floor and on shelves, with free space in the middle: about twenty segments per
// view.
Scene clutteredRoom(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&random](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  Scene scene;
  std::uint16_t id = 1;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().z() = 1.5;
  addBox(scene, T, {5, 5, 1.5}, id);
  for (int i = 0; i < kBoxes; ++i) {
    const double bearing = uniform(0, 360 * kDegree), distance = uniform(2.0, 4.5);
    T.translation() << distance * std::cos(bearing), distance * std::sin(bearing), uniform(0.2, 2.4);
    T.linear() = expSO3({0, 0, uniform(0, 90 * kDegree)});
    addBox(scene, T, {uniform(0.15, 0.5), uniform(0.15, 0.5), uniform(0.1, 0.4)}, id);
  }
  return scene;
}

// A Kinect image of a cluttered room at the given width.
DepthImage roomImage(int width, double heading) {
  const SimulatedCamera camera(kinectIntrinsics(), SimulatedNoise{}, kSeed);
  const DepthImage image = camera.render(clutteredRoom(kSeed), cameraPose(0.3, -0.2, heading), 0).depth;
  return subsampled(image, subsamplingStep(image.camera, width));
}

void segmentation(benchmark::State& state) {
  const DepthImage image = roomImage(static_cast<int>(state.range(0)), 0.4);
  PlaneSegmenter segmenter;
  LabelledPlanes result;
  for (auto _ : state) segmenter.segment(image, result);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(image.depth.size()));
  state.counters["segments"] = static_cast<double>(result.planes.size());
}
BENCHMARK(segmentation)->Arg(320)->Arg(640)->Unit(benchmark::kMillisecond);

void segmentationWithFeatures(benchmark::State& state) {
  const DepthImage image = roomImage(static_cast<int>(state.range(0)), 0.4);
  ViewBuilder builder;
  for (auto _ : state) benchmark::DoNotOptimize(builder.build(image));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(image.depth.size()));
}
BENCHMARK(segmentationWithFeatures)->Arg(320)->Arg(640)->Unit(benchmark::kMillisecond);

// The yardstick: one pass over the image that accumulates the moments of inverse depth.
void momentsOnly(benchmark::State& state) {
  const DepthImage image = roomImage(static_cast<int>(state.range(0)), 0.4);
  for (auto _ : state) {
    PlaneMoments m;
    for (int v = 0, i = 0; v < image.camera.height; ++v)
      for (int u = 0; u < image.camera.width; ++u, ++i)
        if (image.depth[i] > 0) m.add(u, v, 1.0 / image.depth[i]);
    benchmark::DoNotOptimize(m);
  }
}
BENCHMARK(momentsOnly)->Arg(320)->Arg(640)->Unit(benchmark::kMillisecond);

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
