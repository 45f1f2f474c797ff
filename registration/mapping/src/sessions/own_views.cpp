// SPDX-License-Identifier: BSD-3-Clause
#include "poses/pose_fusion.h"
#include "ranking/global_localization.h"
#include "sessions/parallel_stage.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/mapping/map_session.h>
#include <facetloc/registration/observability.h>
#include <facetloc/registration/pose_prior.h>

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

/** The motions beyond limits, in axes rounded to the sides and diagonals of a cube: images with about the
 * same free motion count together. \param R turns axes of known into those of the words */
std::string freeMotionsOf(PrincipalStd known, const Eigen::Matrix3d& R, const PoseLimits& limits) {
  for (Eigen::Matrix3d* axes : {&known.rotation_axes, &known.translation_axes}) {
    *axes = R * *axes;
    for (auto axis : axes->colwise())
      axis = (axis / axis.cwiseAbs().maxCoeff()).array().round().matrix().normalized();
  }
  return limits.openMotions(known, Eigen::Matrix3d::Identity());
}

/** The images of a map, each localized in the map without it. Never changes; thread-safe. */
struct OwnImages {
  std::shared_ptr<const Map> map;
  double min_probability;
  RightPose is_right;
  GlobalLocalizationParams params;
  ConsideredErrors errors = consideredErrorsOf(*map);
  internal::GlobalLocalization localization{map, params};
  std::shared_ptr<const Camera> camera = std::make_shared<const Camera>(map->camera);
  std::vector<char> rendered = renderedViews(*map);  // indexed by local model

  std::vector<OwnView> answers(int threads, const MapProgressCallback& progress) const {
    std::vector<int> asked;
    for (std::size_t i = 0; i < map->models.size(); ++i)
      if (map->models[i].T_w_m && !rendered[i]) asked.push_back(static_cast<int>(i));
    std::vector<OwnView> found(asked.size());
    internal::ParallelStage(MapProgress::Stage::own_views, asked.size(), threads, progress)
        .run([&](std::size_t i) { found[i] = answerTo(asked[i]); });
    return found;
  }

  OwnView answerTo(int index) const {
    const LocalModel& model = map->models[index];
    View view = *map->view(index);
    if (!view.camera) view.camera = camera;
    const auto showsTheSame = [&](int other) {  // as rendered views may
      return other == index || rendered[other] || isNeighbour(model, map->models[other]);
    };
    Localization found = localization.without(showsTheSame).localize(view);
    found.decide(min_probability);
    OwnView out;
    out.model = index;
    out.state = found.state;
    out.reason = found.reason;
    if (!found.hypotheses.empty()) {
      if (found.state == AnswerState::unknown) out.reason = kNotInMap;
      judge(found.hypotheses.front(), model, out);
    }
    if (!out.right) out.free_motions = freeByPlanes(view, *model.T_w_m);
    return out;
  }

  /** Without a right place, the planes in view and the floor alone tell which motions they leave free. */
  std::string freeByPlanes(const View& view, const Eigen::Isometry3d& T_w_m) const {
    Matrix6d known = informationOf(view.segments);
    if (params.steps.floor_information) known += floorInformation(map->camera.mounting, params.prior);
    return freeMotionsOf(observability(known), T_w_m.linear(), params.sure);
  }

  void judge(const Hypothesis& best, const LocalModel& model, OwnView& out) const {
    const bool is_comparable = best.T_w_c && best.part == model.part;
    out.probability = best.probability;
    out.right = is_comparable && is_right(*best.T_w_c, *model.T_w_m);
    if (out.right) {
      PoseWithCovariance T_w_c = *map->models[best.model].T_w_m * best.T_m_c;
      out.free_motions = freeMotionsOf(principalStd(T_w_c.P), Eigen::Matrix3d::Identity(), params.sure);
      T_w_c.P = internal::withSharedErrors(T_w_c.P, errors.rotation_std, errors.translation_std);
      out.nees = squaredMahalanobis(T_w_c, *model.T_w_m);  // the stored pose errs as well
      return;
    }
    out.mistaken_for = best.model;
    if (is_comparable) out.distance = (best.T_w_c->translation() - model.T_w_m->translation()).norm();
  }
};

}  // namespace

const char* OwnView::verdict() const {
  if (state == AnswerState::unknown) return "unknown";
  if (!right) return "wrong";
  return state == AnswerState::sure ? "sure" : "right";
}

std::vector<OwnView> localizeOwnViews(const std::shared_ptr<const Map>& map, const RightPose& is_right,
                                      const GlobalLocalizationParams& params, int threads,
                                      const MapProgressCallback& progress) {
  return OwnImages{map, minProbabilityOf(*map), is_right, params}.answers(threads, progress);
}

// Whatever threshold the map has is about to be replaced.
void addOwnViews(const std::shared_ptr<const Map>& map, SureCalibration& calibration,
                 const RightPose& is_right, const GlobalLocalizationParams& params, int threads,
                 const MapProgressCallback& progress) {
  for (const OwnView& view : OwnImages{map, kMinProbability, is_right, params}.answers(threads, progress))
    calibration.add(view.probability, view.right);
}

}  // namespace facetloc
