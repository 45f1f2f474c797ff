// SPDX-License-Identifier: BSD-3-Clause
#include "simulated_floors.h"

#include <facetloc/io/map_database.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>

#include <vector>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

// Those of facetloc_simulate.
constexpr std::size_t kMapFrames = 444, kQueryFrames = 348;
constexpr double kMapStep = 0.25;     // [m]
constexpr double kSwayDeg = 10;       // sway of the later run
constexpr double kQueryStart = 1000;  // [s]

Map seen(const SimulatedRun& run, const SimulatedCamera& camera, const CameraMounting& mounting,
         const std::vector<std::size_t>& frames, std::size_t first_frame, double first_stamp) {
  const std::vector<double> times = drivingTimes(basePoses(run.poses, mounting));
  Map map;
  map.camera.mounting = mounting;
  map.models.resize(frames.size());
  const int n = static_cast<int>(frames.size());
#pragma omp parallel
  {
    ViewBuilder builder(map.camera);
#pragma omp for schedule(dynamic)
    for (int i = 0; i < n; ++i) {
      const std::size_t frame = frames[i];
      map.models[i] = {std::to_string(frame), first_stamp + times[frame], run.poses[frame],
                       builder.build(camera.render(run.world, run.poses[frame], first_frame + frame).depth)};
    }
  }
  return map;
}

}  // namespace

SimulatedFloor simulatedFloor(const fs::path& folder, const std::string& scene, std::uint64_t seed) {
  const std::string name = scene + "-" + std::to_string(seed);
  const fs::path map_file = folder / (name + "-map.flmap"), query_file = folder / (name + "-query.flmap");
  if (fs::exists(map_file) && fs::exists(query_file)) return {readMap(map_file), readMap(query_file)};

  const SimulatedCamera camera(kinectIntrinsics().subsampled(2), SimulatedNoise{}, seed);
  DriveParams drive;
  drive.step = kMapStep;
  const SimulatedRun mapping =
      simulatedRun(scene, seed, kMappingRun, kMapFrames, drive, {}, RouteEnd::go_round);
  drive.step = DriveParams{}.step;
  drive.sway_deg = kSwayDeg;
  const SimulatedRun later =
      simulatedRun(scene, seed, kLaterRun, kQueryFrames, drive, {}, RouteEnd::go_round);

  std::vector<std::size_t> models, queries;
  MapBuilder rule;
  for (std::size_t i = 0; i < mapping.poses.size(); ++i)
    if (rule.accept(mapping.poses[i])) models.push_back(i);
  for (std::size_t i = kQueryStep / 2; i < later.poses.size(); i += kQueryStep) queries.push_back(i);
  SimulatedFloor floor{seen(mapping, camera, drive.mounting(), models, 0, 0),
                       seen(later, camera, drive.mounting(), queries, kMapFrames, kQueryStart)};
  writeMap(query_file, floor.query);
  writeMap(map_file, floor.map);
  return floor;
}

}  // namespace facetloc
