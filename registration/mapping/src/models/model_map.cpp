// SPDX-License-Identifier: BSD-3-Clause
#include "models/viewpoints.h"
#include "sessions/image_run.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/mapping/map_making.h>
#include <facetloc/mapping/model_map.h>

#include <cmath>
#include <fmt/core.h>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace internal;

namespace {

/** The error of a scan changes slowly from place to place: all of a segment shares it, so that no number of
 * pixels averages it out. */
void addSurfaceError(double std, std::vector<Segment>& segments) {
  constexpr double kLength = 1;  // over which it changes by about itself [m]
  const double slope = std / kLength;
  for (Segment& segment : segments)
    segment.Sigma_q.diagonal() += Eigen::Vector3d(slope * slope, slope * slope, std * std);
}

MapSurfaces surfacesOf(const Surface& surface) {
  if (surface.isIncomplete()) return MapSurfaces::incomplete;
  return surface.isDrawn() ? MapSurfaces::fixed : MapSurfaces::seen;
}

constexpr double kStepsPerSpacing = 2;  // candidates per spacing

/** Where a camera in the hand is held [m], and how it is inclined [deg]. */
const std::vector<double> kHeightsInHand{1.1, 1.6}, kTiltsInHand{0, 30};

}  // namespace

struct ModelMap::Impl {
  ViewpointSearch given;  // with the camera of the map, and places in the frame of the surface
  ModelMapParams params;
  ViewParams view;
  std::optional<std::vector<Eigen::Isometry3d>> viewpoints;
  std::optional<Eigen::Vector3d> up = Eigen::Vector3d::UnitZ();  // none = the surface's own
  std::optional<Eigen::Vector3d> usual_up;
  int width = kWorkingWidth, threads = 1;
  MapProgressCallback progress;
  std::optional<SurfaceOrientation> orientation;
  ModelFindings findings;

  const SurfaceOrientation& surfaceOrientation();
  bool findUp();
  Intrinsics intrinsics() const;
  Camera viewCamera() const;
  ViewpointSearch search() const;
  Map build();
};

const SurfaceOrientation& ModelMap::Impl::surfaceOrientation() {
  if (!orientation) {
    orientation = orientationOf(*given.surface, threads);
    orientation->usual = usual_up;
  }
  return *orientation;
}

/** \return false if the surface has to know and does not */
bool ModelMap::Impl::findUp() {
  const std::optional<Eigen::Vector3d> found = up ? up : surfaceOrientation().up();
  if (found)
    findings.up = *found;
  else
    findings.problem = "its planes do not show which direction is up";
  return found.has_value();
}

Intrinsics ModelMap::Impl::intrinsics() const {
  const Intrinsics& of_map = given.camera.intrinsics;
  const Intrinsics full = of_map.valid() ? of_map : kinectIntrinsics();
  return full.subsampled(subsamplingStep(full, width));
}

/** Rendered images are ideal but for the surface's own error. */
Camera ModelMap::Impl::viewCamera() const {
  Camera ideal = given.camera;
  ideal.distortion.reset();
  ideal.noise.depth_std = std::hypot(given.camera.noise.depth_std, params.surface_std);
  return ideal;
}

ViewpointSearch ModelMap::Impl::search() const {
  ViewpointSearch search = given;
  const auto& mounting = given.camera.mounting;
  search.camera.intrinsics = intrinsics();
  search.tilts_deg = mounting ? std::vector{mounting->tilt_deg} : kTiltsInHand;
  search.T_w_up.linear() = rotationBetween(Eigen::Vector3d::UnitZ(), findings.up);
  PlaceRules& places = search.places;
  places.step = params.spacing / kStepsPerSpacing;
  places.clearance = params.clearance;
  places.stands = mounting || !places.heights.empty();
  if (places.heights.empty()) places.heights = mounting ? std::vector{mounting->height} : kHeightsInHand;
  for (Eigen::Vector3d& place : places.inside) place = search.T_w_up.inverse() * place;
  search.forEach = [this](std::size_t n, const std::function<void(std::size_t)>& job) {
    ParallelStage(MapProgress::Stage::viewpoints, n, threads, progress).run(job);
  };
  return search;
}

/** Local models without an ambiguity. */
Map ModelMap::Impl::build() {
  ImageRun run;
  run.camera = viewCamera();
  run.view = view;
  run.threads = threads;
  run.progress = progress;
  const Intrinsics k = intrinsics();
  for (std::size_t i = 0; i < findings.viewpoints.size(); ++i) {
    const Eigen::Isometry3d& T_w_c = findings.viewpoints[i];
    run.images.push_back({fmt::format("view-{:05}", i + 1), static_cast<double>(i),
                          [this, k, &T_w_c] { return given.surface->render(k, T_w_c); }, T_w_c});
  }
  Map map;
  map.camera = given.camera;
  setSurfaces(surfacesOf(*given.surface), map);
  map.meta[kConsideredErrorsKey] = toText(ConsideredErrors());  // rendered views tell nothing of a camera
  std::vector<Eigen::Isometry3d> used;
  std::vector<UnreadImage> unread;
  run.buildViews(run.all(), MapProgress::Stage::models, unread,
                 [&](std::size_t i, std::optional<View> built) {
                   if (!built || built->segments.empty()) {
                     ++findings.without_segments;
                     return;
                   }
                   built->camera.reset();  // the map's
                   if (!given.surface->isIncomplete()) addSurfaceError(params.surface_std, built->segments);
                   const MapImage& image = run.images[i];
                   map.models.emplace_back(image.name, image.stamp, image.T_w_c, std::move(*built));
                   used.push_back(*image.T_w_c);
                 });
  findings.viewpoints = std::move(used);
  return map;
}

ModelMap::ModelMap(std::shared_ptr<const Surface> surface, const Camera& camera, const ModelMapParams& params,
                   const ViewParams& view)
    : impl_(std::make_unique<Impl>()) {
  if (!surface) throw std::invalid_argument("ModelMap: there is no surface");
  impl_->given.surface = std::move(surface);
  impl_->given.camera = camera;
  impl_->given.places.most = kMostPlaces;
  impl_->params = checked(params);
  impl_->view = checked(view);
}
ModelMap::ModelMap(ModelMap&&) noexcept = default;
ModelMap& ModelMap::operator=(ModelMap&&) noexcept = default;
ModelMap::~ModelMap() = default;

void ModelMap::setNumberOfThreads(int n) { impl_->threads = n; }
void ModelMap::setProgress(MapProgressCallback progress) { impl_->progress = std::move(progress); }
void ModelMap::setWorkingWidth(int width) { impl_->width = width; }
void ModelMap::setViewpoints(std::vector<Eigen::Isometry3d> viewpoints) {
  for (std::size_t i = 0; i < viewpoints.size(); ++i)
    if (!viewpoints[i].matrix().allFinite())
      throw std::invalid_argument(fmt::format("ModelMap: viewpoint {} is not finite", i + 1));
  impl_->viewpoints = std::move(viewpoints);
}
void ModelMap::setUp(const Eigen::Vector3d& up) {
  if (!(up.norm() > 0 && up.allFinite())) throw std::invalid_argument("ModelMap: up is no direction");
  impl_->up = up.normalized();
}
void ModelMap::setUpBySurface() { impl_->up.reset(); }

void ModelMap::setUsualUp(const Eigen::Vector3d& up) { impl_->usual_up = up; }
const SurfaceOrientation& ModelMap::orientation() { return impl_->surfaceOrientation(); }
void ModelMap::setInside(std::vector<Eigen::Vector3d> places) {
  impl_->given.places.inside = std::move(places);
}
void ModelMap::setHeights(std::vector<double> heights) { impl_->given.places.heights = std::move(heights); }
void ModelMap::setMostPlaces(std::size_t n) { impl_->given.places.most = n; }
const ModelFindings& ModelMap::findings() const { return impl_->findings; }

Map ModelMap::finish() {
  Impl& m = *impl_;
  m.findings = {};
  if (m.viewpoints)
    m.findings.viewpoints = *m.viewpoints;
  else if (m.findUp())
    m.findings.viewpoints = findViewpoints(m.search(), m.params, m.findings);
  if (m.findings.viewpoints.empty()) {
    if (m.findings.problem.empty()) m.findings.problem = "there are no viewpoints";
    return {};
  }
  auto map = std::make_shared<Map>(m.build());
  if (map->models.empty()) {
    m.findings.problem = "no view of the surface shows a plane";
    return {};
  }
  completeMap(map, {false, m.threads, m.progress});
  return std::move(*map);
}

}  // namespace facetloc
