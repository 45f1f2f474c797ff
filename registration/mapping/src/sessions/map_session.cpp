// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/image_run.h"
#include "sessions/map_review.h"
#include "sessions/session_place.h"

#include <facetloc/mapping/map_session.h>

#include <fmt/format.h>

namespace facetloc {

using namespace internal;

namespace {

constexpr double kKeyShare = 0.5;  // share of the distance of local models, for images with given poses

}  // namespace

std::string MapChanges::toString() const {
  return fmt::format("{} local model{} added, {} replaced, {} retired, {} without moved surfaces",
                     added.size(), added.size() == 1 ? "" : "s", replaced.size(), retired.size(),
                     edited.size());
}

void noteSession(const std::string& words, Map& map) {
  int n = 2;  // the first one made the map
  while (map.meta.count(fmt::format("session {}", n))) ++n;
  map.meta[fmt::format("session {}", n)] = words;
}

struct MapSession::Impl {
  Impl(std::shared_ptr<const Map> the_map, const Camera& camera, const MapUpdateParams& the_params)
      : map(std::move(the_map)), params(the_params) {
    checkRanges(params.session);
    checkRanges(params.places);
    checkRanges(params.trajectory);
    checkRanges(params.view);
    run.camera = camera;
    run.view = params.view;
  }

  std::vector<std::size_t> keyImages() const;
  CameraTrajectory alongPoses(std::vector<UnreadImage>& unread);
  const CameraTrajectory& trajectory() const { return *findings.trajectory; }
  std::vector<SessionImage> images() const;
  const MapReview& review();

  std::shared_ptr<const Map> map;
  MapUpdateParams params;
  ImageRun run;
  MapFindings findings;
  std::vector<std::size_t> numbers;  // image numbers of the trajectory
  SessionPlace place;
  std::vector<SessionImage> placed;         // images that have a place in the map
  std::optional<const MapReview> reviewed;  // once asked for
};

/** Images with poses, at half the distance of local models. */
std::vector<std::size_t> MapSession::Impl::keyImages() const {
  MapBuilderParams between = params.places;
  between.distance *= kKeyShare, between.rotation_deg *= kKeyShare;
  MapBuilder rule(between);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < run.images.size(); ++i)
    if (run.images[i].T_w_c && rule.accept(*run.images[i].T_w_c)) chosen.push_back(i);
  return chosen;
}

CameraTrajectory MapSession::Impl::alongPoses(std::vector<UnreadImage>& unread) {
  CameraTrajectory along;
  run.buildViews(
      keyImages(), MapProgress::Stage::trajectory, unread, [&](std::size_t i, std::optional<View> view) {
        if (!view) return;
        const MapImage& image = run.images[i];
        along.images.push_back({image.stamp, *image.T_w_c, static_cast<int>(along.keyframes.size())});
        along.keyframes.push_back({numbers.size(),
                                   std::make_shared<const View>(std::move(*view)),
                                   {*image.T_w_c, Matrix6d::Zero()},
                                   0});
        numbers.push_back(i);
      });
  return along;
}

/** The keyframes that have a place in the map. */
std::vector<SessionImage> MapSession::Impl::images() const {
  std::vector<SessionImage> images;
  for (std::size_t k = 0; k < place.T_w_k.size(); ++k) {
    const Keyframe& keyframe = trajectory().keyframes[k];
    const MapImage& image = run.images[numbers[keyframe.image]];
    if (place.T_w_k[k])
      images.push_back({image.name, image.stamp, keyframe.view, *place.T_w_k[k], place.confirmed[k]});
  }
  return images;
}

/** The evidence of the session about the map, made at the first request. */
const MapReview& MapSession::Impl::review() {
  if (reviewed) return *reviewed;
  placed = images();
  return reviewed.emplace(*map, placed, run.threads);
}

MapSession::MapSession(std::shared_ptr<const Map> map, const Camera& camera, const MapUpdateParams& params)
    : impl_(std::make_unique<Impl>(std::move(map), camera, params)) {}
MapSession::MapSession(MapSession&&) noexcept = default;
MapSession& MapSession::operator=(MapSession&&) noexcept = default;
MapSession::~MapSession() = default;

void MapSession::setNumberOfThreads(int n) { impl_->run.threads = n; }
void MapSession::setProgress(MapProgressCallback progress) { impl_->run.progress = std::move(progress); }
void MapSession::setOdometry(PosesByTime odometry) { impl_->run.odometry = std::move(odometry); }
void MapSession::add(MapImage image) { impl_->run.images.push_back(std::move(image)); }
const MapFindings& MapSession::findings() const { return impl_->findings; }

void MapSession::findTrajectory() {
  Impl& m = *impl_;
  m.numbers.clear();
  m.findings.unread.clear();
  if (m.run.hasPoses()) {
    m.findings.trajectory = m.alongPoses(m.findings.unread);
  } else {
    m.findings.trajectory = m.run.findTrajectory(m.params.trajectory, m.findings);
    m.numbers = m.run.all();
  }
}

const SessionPlace& MapSession::find() {
  Impl& m = *impl_;
  m.reviewed.reset();
  if (!m.findings.trajectory) findTrajectory();
  const GlobalLocalization localization(m.map);
  m.place = m.run.hasPoses()
                ? placeRigidly(localization, m.trajectory(), m.params.places, m.params.session, m.run.threads,
                               m.run.progress)
                : placeInMap(localization, m.trajectory(), m.params.session, m.run.threads, m.run.progress);
  return m.place;
}

std::size_t MapSession::placed() const { return impl_->images().size(); }

std::vector<TrajectoryPose> MapSession::poses() const {
  const Impl& m = *impl_;
  std::vector<TrajectoryPose> poses;
  if (!m.place.found()) return poses;
  for (const TrajectoryPose& image : m.trajectory().images)
    if (const auto& T_w_k = m.place.T_w_k[image.keyframe]) {
      const Eigen::Isometry3d T_k_w = m.trajectory().keyframes[image.keyframe].T_w_c.T.inverse();
      poses.push_back({image.stamp, *T_w_k * T_k_w * image.T_w_c, image.keyframe});
    }
  return poses;
}

std::vector<SurfaceChange> MapSession::changes() const { return impl_->review().changes(); }

MapChanges MapSession::update(Map& map) const {
  Impl& m = *impl_;
  const MapReview& review = m.review();
  return updateMap(map, m.placed, review, m.params.places, m.params.session);
}

}  // namespace facetloc
