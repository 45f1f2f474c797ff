// SPDX-License-Identifier: BSD-3-Clause
#include "models/fused_surface.h"
#include "sessions/map_review.h"
#include "sessions/parallel_stage.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/mapping/densified_map.h>
#include <facetloc/mapping/map_builder.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <set>
#include <stdexcept>

namespace facetloc {

using namespace internal;

namespace {

constexpr double kBody = 0.2;   // radius of the robot or person with the camera [m]
constexpr int kDirections = 8;  // to the sides of a driven pose

/** Pose of an image of a drive. */
struct DrivenPose {
  Eigen::Isometry3d T_w_c;
  Eigen::Vector3d up;  // unit vector in the world
};

/** Where a view may be rendered. */
struct PlaceBeside {
  Eigen::Isometry3d T_w_c;
  std::size_t beside = 0;  // index of the driven pose that it belongs to
  double known_share = 0;  // share of its pixels
};

/** Is there room for a camera and what carries it? \param level axes in the world whose z is upwards */
bool hasRoom(const SeenSpace& space, const Eigen::Vector3d& place, const Eigen::Matrix3d& level) {
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * EIGEN_PI * k / kDirections;
    if (!space.isFree(place + kBody * (std::cos(angle) * level.col(0) + std::sin(angle) * level.col(1))))
      return false;
  }
  return true;
}

struct Standpoint {
  Eigen::Vector3d place;
  std::size_t beside;
};

/** On the drive itself first, then farther and farther from it. */
std::vector<Standpoint> standpoints(const std::vector<DrivenPose>& drive, const SeenSpace& space,
                                    const DensifyParams& params) {
  std::vector<Standpoint> found;
  const double apart = params.spacing / 2;
  const auto isNew = [&](const Eigen::Vector3d& place) {
    return std::none_of(found.begin(), found.end(),
                        [&](const Standpoint& s) { return (s.place - place).norm() < apart; });
  };
  for (double distance = 0; distance <= params.reach + 1e-9; distance += apart)
    for (std::size_t i = 0; i < drive.size(); ++i) {
      const Eigen::Matrix3d level =
          Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), drive[i].up).toRotationMatrix();
      const Eigen::Vector3d& from = drive[i].T_w_c.translation();
      for (int k = 0; k < (distance > 0 ? kDirections : 1); ++k) {
        const double angle = 2 * EIGEN_PI * k / kDirections;
        const Eigen::Vector3d place =
            from + distance * (std::cos(angle) * level.col(0) + std::sin(angle) * level.col(1));
        if (!isNew(place)) continue;
        if (distance > 0 && !(hasRoom(space, place, level) && space.isFreeBetween(from, place))) continue;
        found.push_back({place, i});
      }
    }
  return found;
}

/** Poses within reach of a drive that no image of it is near, as high and as inclined as the driven
 * one that they are beside, in all headings; only where the way from there is free. */
std::vector<PlaceBeside> placesBeside(const std::vector<DrivenPose>& drive, const SeenSpace& space,
                                      const DensifyParams& params) {
  std::vector<PlaceBeside> places;
  const int headings = static_cast<int>(std::ceil(720 / params.rotation_deg));
  for (const Standpoint& standpoint : standpoints(drive, space, params)) {
    const DrivenPose& beside = drive[standpoint.beside];
    for (int k = 0; k < headings; ++k) {
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.linear() = Eigen::AngleAxisd(2 * EIGEN_PI * k / headings, beside.up) * beside.T_w_c.linear();
      T.translation() = standpoint.place;
      const bool is_shown = std::any_of(drive.begin(), drive.end(), [&](const DrivenPose& pose) {
        return isNear(pose.T_w_c, T, params.spacing, params.rotation_deg);
      });
      if (!is_shown) places.push_back({T, standpoint.beside});
    }
  }
  return places;
}

/** The places with enough known pixels, the best known first, without those near a better one. */
std::vector<PlaceBeside> spreadOut(std::vector<PlaceBeside> places, const DensifyParams& params,
                                   std::size_t most) {
  std::stable_sort(places.begin(), places.end(),
                   [](const PlaceBeside& a, const PlaceBeside& b) { return a.known_share > b.known_share; });
  std::vector<PlaceBeside> chosen;
  for (const PlaceBeside& place : places) {
    if (chosen.size() >= most || place.known_share < params.known_share) break;
    const bool is_shown = std::any_of(chosen.begin(), chosen.end(), [&](const PlaceBeside& other) {
      return isNear(other.T_w_c, place.T_w_c, params.spacing, params.rotation_deg);
    });
    if (!is_shown) chosen.push_back(place);
  }
  return chosen;
}

/** Without the digits that its noise leaves meaningless: smooth as a rendered picture is, a file would hold
 * them at great length. */
DepthPicture roundedToNoise(const DepthPicture& picture) {
  constexpr double kStepsPerNoise = 3;
  const double step = std::floor(picture.noise.ofInverseDepth(DepthNoise::kUsualDepth) /
                                 (kStepsPerNoise * DepthPicture::kQuantum));
  if (step < 2) return picture;
  constexpr double kLargest = std::numeric_limits<std::uint16_t>::max();
  std::vector<std::uint16_t> rounded = picture.inverse_depth;
  for (std::uint16_t& rho : rounded)
    if (rho != 0) rho = static_cast<std::uint16_t>(std::clamp(step * std::round(rho / step), 1.0, kLargest));
  DepthPicture out = DepthPicture::fromStored(picture.camera, std::move(rounded));
  out.noise = picture.noise;
  return out;
}

/** Adds views to one part of a map. */
class PartDensifying {
public:
  PartDensifying(Map& map, int part, const DensifyParams& params, const ViewParams& view, int threads,
                 const MapProgressCallback& progress)
      : map_(map), params_(params), view_params_(view), threads_(threads), progress_(progress) {
    for (std::size_t i = 0; i < map.models.size(); ++i) {
      const LocalModel& model = map.models[i];
      if (model.part != part || !model.T_w_m || !model.hasPicture()) continue;
      driven_.push_back(static_cast<int>(i));
      views_.push_back(map.view(static_cast<int>(i)));
    }
  }

  void run(Densification& done) {
    if (driven_.empty()) return;
    std::vector<PosedPicture> pictures;
    std::vector<DrivenPose> poses;
    for (std::size_t i = 0; i < driven_.size(); ++i) {
      const Eigen::Isometry3d& T_w_m = *map_.models[driven_[i]].T_w_m;
      pictures.push_back({&views_[i]->depth, T_w_m});
      poses.push_back({T_w_m, T_w_m.linear() * upwardsIn(i)});
    }
    const FusedSurface surface(pictures, threads_);
    done.driven += driven_.size();
    done.contradicted_share += surface.contradictedShare() * static_cast<double>(driven_.size());
    const std::vector<PlaceBeside> places = chosen(surface, placesBeside(poses, surface.space(), params_));
    std::vector<View> rendered(places.size());
    ParallelStage stage(MapProgress::Stage::models, places.size(), threads_, progress_);
    stage.run([&](std::size_t i) { rendered[i] = viewAt(surface, places[i]); });
    for (std::size_t i = 0; i < places.size(); ++i)
      if (!rendered[i].segments.empty()) add(places[i], std::move(rendered[i])), ++done.rendered;
  }

private:
  /** Upwards in the frame of a view: by the mounting, by gravity, or as its image is. */
  Eigen::Vector3d upwardsIn(std::size_t i) const {
    if (views_[i]->gravity) return -views_[i]->gravity->down;
    if (map_.camera.mounting)
      return map_.camera.mounting->T_b_c().linear().transpose() * Eigen::Vector3d::UnitZ();
    return -Eigen::Vector3d::UnitY();
  }

  /** The places of which the map shows enough, the best known first, none of them near another one. */
  std::vector<PlaceBeside> chosen(const FusedSurface& surface, std::vector<PlaceBeside> places) const {
    constexpr int kCoarse = 8;  // step of the pixels of a first look; pictures have half as many
    ParallelStage stage(MapProgress::Stage::place, places.size(), threads_, progress_);
    stage.run([&](std::size_t i) {
      const Intrinsics camera = views_[places[i].beside]->intrinsics.subsampled(kCoarse);
      places[i].known_share = surface.renderWithErrors(camera, places[i].T_w_c, kCoarse / 2).knownShare();
    });
    return spreadOut(std::move(places), params_,
                     static_cast<std::size_t>(params_.growth * static_cast<double>(driven_.size())));
  }

  View viewAt(const FusedSurface& surface, const PlaceBeside& place) const {
    const View& beside = *views_[place.beside];
    const RenderedDepth rendered = surface.renderWithErrors(beside.intrinsics, place.T_w_c);
    Camera camera = map_.camera;
    camera.distortion.reset();  // rendered images are free of it
    static_cast<DepthNoise&>(camera.noise) = camera.noise.scaledTo(
        std::max(1.0, rendered.disagreement) * camera.noise.ofInverseDepth(DepthNoise::kUsualDepth),
        DepthNoise::kUsualDepth);
    std::optional<Gravity> gravity = beside.gravity;
    const Eigen::Isometry3d& T_w_m = *map_.models[driven_[place.beside]].T_w_m;
    if (gravity) gravity->down = place.T_w_c.linear().transpose() * T_w_m.linear() * gravity->down;
    View view = ViewBuilder(camera, view_params_).build(rendered.image, gravity);
    view.depth = roundedToNoise(view.depth);
    view.camera.reset();  // the map's
    return view;
  }

  void add(const PlaceBeside& place, View view) {
    const int from = driven_[place.beside];
    const LocalModel& source = map_.models[from];
    LocalModel model(nameBeside(source.name), source.stamp, place.T_w_c, std::move(view));
    model.part = source.part;
    model.by_links = source.by_links;
    map_.links.push_back(
        MapBuilder().link(from, static_cast<int>(map_.models.size()), *source.T_w_m, place.T_w_c));
    map_.meta[kRenderedKey] += model.name + "\n";
    map_.models.push_back(std::move(model));
  }

  std::string nameBeside(const std::string& name) {
    if (names_.empty())
      for (const LocalModel& model : map_.models) names_.insert(model.name);
    std::string unique;
    for (int k = 1; !names_.insert(unique = fmt::format("{}_beside{}", name, k)).second; ++k) {
    }
    return unique;
  }

  Map& map_;
  DensifyParams params_;
  ViewParams view_params_;
  int threads_;
  const MapProgressCallback& progress_;
  std::vector<int> driven_;  // indices of local models
  std::vector<std::shared_ptr<const View>> views_;
  std::set<std::string> names_;
};

}  // namespace

Densification densify(Map& map, const DensifyParams& params, const ViewParams& view, int threads,
                      const MapProgressCallback& progress) {
  checkRanges(params);
  checkRanges(view);
  if (map.store()) throw std::invalid_argument("a map is densified in memory: read it with readMap()");
  Densification done;
  const std::vector<char> rendered = renderedViews(map);
  removeModels(rendered, map);
  map.meta.erase(kRenderedKey);
  done.removed = rendered.size() - map.models.size();
  int parts = 0;
  for (const LocalModel& model : map.models) parts = std::max(parts, model.part + 1);
  for (int part = 0; part < parts; ++part)
    PartDensifying(map, part, params, view, threads, progress).run(done);
  if (done.driven > 0) done.contradicted_share /= static_cast<double>(done.driven);
  if (done.rendered + done.removed > 0) {
    map.ambiguity.reset();
    map.meta.erase(kSureKey);
    for (LocalModel& model : map.models) model.alias_score.reset();
  }
  return done;
}

}  // namespace facetloc
