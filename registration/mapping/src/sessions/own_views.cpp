// SPDX-License-Identifier: BSD-3-Clause
#include "ranking/global_localization.h"
#include "sessions/parallel_stage.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/pose.h>
#include <facetloc/mapping/map_session.h>

#include <vector>

namespace facetloc {
namespace {

/** Local models that are nearer than this show the same, but for the noise. */
bool isNeighbour(const LocalModel& a, const LocalModel& b) {
  constexpr double kDistance = 0.35, kRotation = 10 * kDegree;
  if (!a.T_w_m || !b.T_w_m || a.part != b.part) return false;
  const Eigen::Isometry3d T = a.T_w_m->inverse() * *b.T_w_m;
  return T.translation().norm() < kDistance && rotationAngle(T.linear()) < kRotation;
}

}  // namespace

void addOwnViews(const std::shared_ptr<const Map>& map, SureCalibration& calibration,
                 const RightPose& is_right, const GlobalLocalizationParams& params, int threads,
                 const MapProgressCallback& progress) {
  const std::vector<char> rendered = renderedViews(*map);  // they may show the surfaces of the excluded image
  std::vector<int> asked;
  for (std::size_t i = 0; i < map->models.size(); ++i)
    if (map->models[i].T_w_m && !rendered[i]) asked.push_back(static_cast<int>(i));
  if (asked.empty()) return;
  struct Answer {
    double probability = 0;
    bool right = false;
  };
  std::vector<Answer> answers(asked.size());
  const internal::GlobalLocalization localization(map, params);
  internal::ParallelStage stage(MapProgress::Stage::ambiguity, asked.size(), threads, progress);
  stage.run([&](std::size_t i) {
    const LocalModel& model = map->models[asked[i]];
    View view = *map->view(asked[i]);
    if (!view.camera) view.camera = std::make_shared<const Camera>(map->camera);
    const Localization found = localization.localize(view, [&](int other) {
      return other == asked[i] || rendered[other] || isNeighbour(model, map->models[other]);
    });
    if (found.hypotheses.empty()) return;
    const Hypothesis& best = found.hypotheses.front();
    answers[i] = {best.probability,
                  best.T_w_c && best.part == model.part && is_right(*best.T_w_c, *model.T_w_m)};
  });
  for (const Answer& answer : answers) calibration.add(answer.probability, answer.right);
}

}  // namespace facetloc
