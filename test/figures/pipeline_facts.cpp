// SPDX-License-Identifier: BSD-3-Clause
#include "facts.h"
#include "ranking/global_localization.h"

#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>

#include <memory>
#include <stdexcept>

namespace facetloc::figures {

Json::Value pipelineFacts() {
  constexpr std::uint64_t kSeed = 1;
  constexpr std::size_t kMapped = 120, kLater = 80;
  const char* const kPlace = "home";
  DriveParams drive;
  Camera camera;
  camera.intrinsics = centredKinect(320);
  camera.mounting = drive.mounting();
  ViewBuilder builder(camera);
  SimulatedCamera sensor(camera.intrinsics, {}, kSeed);

  auto map = std::make_shared<Map>();
  map->camera = camera;
  const SimulatedRun mapping = simulatedRun(kPlace, kSeed, kMappingRun, kMapped, drive);
  for (std::size_t i = 0; i < mapping.poses.size(); ++i) {
    View view = builder.build(sensor.render(mapping.world, mapping.poses[i], i).depth);
    map->models.emplace_back(std::to_string(i), static_cast<double>(i), mapping.poses[i], std::move(view));
  }
  const SimulatedRun later = simulatedRun(kPlace, kSeed, kLaterRun, kLater, drive);
  const internal::GlobalLocalization localization(map);
  Json::Value out;
  double most = 0;  // probability of a second place
  for (std::size_t i = 0; i < later.poses.size(); ++i) {
    const DepthImage image = sensor.render(later.world, later.poses[i], 1000 + i).depth;
    const View view = builder.build(image);
    const Localization answer = localization.localize(view);
    // The image whose first place is sure, and has many pairs, and whose second one is the most likely.
    if (answer.hypotheses.size() < 3 || answer.hypotheses[0].pairs.size() < 4) continue;
    if (answer.state != AnswerState::sure || answer.hypotheses[1].probability <= most) continue;
    most = answer.hypotheses[1].probability;
    out.clear();
    const auto model = map->view(answer.hypotheses[0].model);
    out["image"] = static_cast<int>(i);
    out["depth"] = smallDepth(image), out["outlines"] = outlines(view),
    out["model_outlines"] = outlines(*model);
    for (const SegmentPair& pair : answer.hypotheses[0].pairs) {
      Json::Value both;
      both["scene"] = numbers(pixelOf(view.intrinsics, view.segments[pair.scene].t), 1);
      both["model"] = numbers(pixelOf(model->intrinsics, model->segments[pair.model].t), 1);
      both["indices"].append(pair.scene), both["indices"].append(pair.model);
      out["pairs"].append(both);
    }
    for (const Hypothesis& h : answer.hypotheses) {
      Json::Value place;
      place["at"] = numbers(Eigen::Vector3d(h.T_w_c->translation()), 3);
      place["axis"] = numbers(Eigen::Vector3d(h.T_w_c->linear().col(2)), 3);
      place["score"] = rounded(h.score, 1), place["probability"] = rounded(h.probability, 4);
      place["off"] = rounded((h.T_w_c->translation() - later.poses[i].translation()).norm(), 3);
      out["places"].append(place);
    }
    out["not_in_map"] = rounded(*answer.not_in_map, 4);
    out["truth"] = numbers(Eigen::Vector3d(later.poses[i].translation()), 3);
  }
  if (out.isNull()) throw std::runtime_error("no image of the drive has several places");
  for (const LocalModel& model : map->models) {
    Json::Value one;
    one["at"] = numbers(Eigen::Vector3d(model.T_w_m->translation()), 3);
    one["axis"] = numbers(Eigen::Vector3d(model.T_w_m->linear().col(2)), 3);
    out["models"].append(one);
  }
  return out;
}

}  // namespace facetloc::figures
