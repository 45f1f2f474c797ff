// SPDX-License-Identifier: BSD-3-Clause
#include "mapped_place.h"

#include "calibration/distortion_calibration.h"
#include "calibration/map_ambiguity.h"

#include <algorithm>

namespace facetloc::benchmarks {
namespace {

/** The distortion of the camera that made a map; the map's views are uncorrected. */
std::optional<DepthDistortion> distortionOf(const Map& map) {
  std::vector<PosedPicture> pictures;
  for (std::size_t i = 0; i < map.models.size(); ++i)
    pictures.push_back({&map.view(static_cast<int>(i))->depth, *map.models[i].T_w_m});
  const MapBuilderParams poses;
  const auto found = internal::calibrateDistortion(
      pictures, map.camera.noise, {poses.pose_rotation_std_deg * kDegree, poses.pose_translation_std});
  return found && found->reliable() ? std::make_optional(found->distortion) : std::nullopt;
}

}  // namespace

void SeenRun::see(const Camera& camera, const ViewParams& params) {
  views.assign(frames.size(), {});
  const int n = static_cast<int>(frames.size());
#pragma omp parallel
  {
    ViewBuilder builder(camera, params);
#pragma omp for schedule(dynamic)
    for (int i = 0; i < n; ++i) views[i] = builder.build(sequence.load(frames[i], kWorkingWidth));
  }
}

void findAmbiguity(Map& map, const GlobalLocalizationParams& params) {
  const internal::GlobalLocalization localization(std::make_shared<const Map>(map), params);
  internal::AliasScores scores(map.models.size());
  for (const int model : internal::viewsToAsk(map))
    if (const auto wrong = internal::wrongPlace(localization, model)) scores[model] = wrong->score;
  internal::setAmbiguity(scores, map);
}

MappedPlace::MappedPlace(const std::filesystem::path& folder, std::size_t every, const std::string& query)
    : truth_(PlaceTruth::open(folder)),
      query_name_(query),
      mapping_{DepthSequence::open(folder / "map"), {}, {}},
      query_{DepthSequence::open(folder / query), {}, {}} {
  MapBuilder rule;
  const Trajectory poses = truth_.of("map").poses();
  for (std::size_t i = 0; i < mapping_.sequence.frames().size(); ++i) {
    const FrameFile& frame = mapping_.sequence.frames()[i];
    const auto pose = poses.at(frame.stamp, kPoseTolerance);
    if (!pose || !rule.accept(*pose)) continue;
    mapping_.frames.push_back(i);
    models_.push_back({frame.name, frame.stamp, *pose});
  }
  for (std::size_t i = 0; i < query_.sequence.frames().size(); i += every) query_.frames.push_back(i);
}

Map MappedPlace::see(const ViewParams& params, bool calibrated) {
  Camera camera = mapping_.sequence.camera()->camera;
  mapping_.see(camera, params);
  if (calibrated) {
    camera.distortion = distortionOf(map(camera));
    mapping_.see(camera, params);
  }
  Map made = map(camera);
  seeQuery(made, params);
  return made;
}

void MappedPlace::seeQuery(const Map& map, const ViewParams& params) {
  query_.see(map.calibrated(query_.sequence.camera()->camera), params);
}

void MappedPlace::use(const Map& map, const ViewParams& params) {
  models_ = modelPosesOf(map);
  seeQuery(map, params);
}

bool MappedPlace::covers(const Eigen::Isometry3d& T_w_c) const {
  return std::any_of(models_.begin(), models_.end(), [&](const ModelPose& model) {
    const PoseError error = poseError(model.T_w_m, T_w_c);
    return error.translation <= kCoveredDistance && error.rotation_deg <= kCoveredRotationDeg;
  });
}

PosedRun MappedPlace::posedQuery() const {
  const PlaceTruth truth = truth_.of(query_name_);
  PosedRun run;
  for (std::size_t i = 0; i < query_.frames.size(); ++i) {
    const double stamp = query_.sequence.frames()[query_.frames[i]].stamp;
    const auto T_w_c = truth.poses().at(stamp, kPoseTolerance);
    if (!T_w_c) continue;
    run.frames.push_back(query_.frames[i]);
    run.views.push_back(query_.views[i]);
    run.stamps.push_back(stamp);
    run.truth.push_back(*T_w_c);
    run.covered.push_back(covers(*T_w_c));
  }
  return run;
}

Map MappedPlace::map(const Camera& camera) const {
  Map map;
  map.camera = camera;
  for (std::size_t i = 0; i < models_.size(); ++i)
    map.models.emplace_back(models_[i].name, models_[i].stamp, models_[i].T_w_m, mapping_.views[i]);
  return map;
}

}  // namespace facetloc::benchmarks
