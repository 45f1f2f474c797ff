// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_mapping.h"

#include "cli/text.h"
#include "outputs/provenance.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <fmt/format.h>
#include <unistd.h>
#include <utility>

namespace facetloc {
namespace {

constexpr int kPolite = 10;      // as of nice: images go first
constexpr double kStep = 0.05;   // smallest step that counts as motion: less is noise [m]
constexpr double kMoved = 0.05;  // motion of keyframes after which the trajectory is drawn anew [m]
constexpr std::chrono::seconds kLeastRest(1);  // between improvements

}  // namespace

std::string LiveMapState::toString() const {
  return fmt::format(
      "{:.1f} m, {}, {}, {}", distance, counted(static_cast<std::size_t>(keyframes), "keyframe"),
      counted(static_cast<std::size_t>(loops), "loop"), counted(map->models.size(), "local model"));
}

LiveMapping::LiveMapping(std::filesystem::path map, const Camera& camera, const MappingParams& trajectory,
                         const MapBuilderParams& places, const std::string& parameters)
    : path_(std::move(map)),
      camera_(camera),
      map_(trajectory, places),
      database_(MapDatabase::create(path_)) {
  database_.setCamera(camera);
  database_.setMeta("parameters", parameters);
  database_.setMeta(kStateKey, kUnderWay);
  state_.map = std::make_shared<Map>();
}

LiveMapState LiveMapping::update(const View& view, const std::string& name, double stamp,
                                 const std::optional<Eigen::Isometry3d>& motion) {
  takeResult();
  follow(view, name, stamp, motion);
  const Clock::time_point now = Clock::now();
  const bool improve = map_.canBeImproved() && now >= next_improvement_;
  if (improve || !unwritten_.empty()) begin(improve);
  return state_;
}

void LiveMapping::follow(const View& view, const std::string& name, double stamp,
                         const std::optional<Eigen::Isometry3d>& motion) {
  if (map_.add(view, name, stamp, motion)) unwritten_.push_back({{name, stamp}, view});
  state_.keyframes = map_.keyframes();
  state_.T_w_c = map_.latest();
  if (!state_.T_w_c) {
    state_.trajectory.interrupt();
    last_place_.reset();
  } else {
    const Eigen::Vector3d place = state_.T_w_c->T.translation();
    state_.trajectory.add(place);
    const double step = last_place_ ? (place - *last_place_).norm() : 0;
    if (step >= kStep) state_.distance += step;
    if (step >= kStep || !last_place_) last_place_ = place;
  }
}

/** Takes the result of the background, if it has finished something. */
void LiveMapping::takeResult() {
  if (!job_.valid() || job_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  const Job done = job_.get();
  state_.map = done.result;
  if (!done.improve) return;
  const double moved = map_.adopt(done.map);
  state_.loops = map_.loops();
  const Clock::time_point now = Clock::now();
  next_improvement_ = now + std::max<Clock::duration>(kLeastRest, now - improved_);
  if (moved < kMoved) return;
  state_.trajectory = {};
  for (const Eigen::Vector3d& place : map_.trajectory()) state_.trajectory.add(place);
  state_.trajectory.interrupt();
  last_place_.reset();
}

/** Unless the background has still something to do. */
void LiveMapping::begin(bool improve) {
  if (job_.valid()) return;
  if (improve) improved_ = Clock::now();
  job_ = std::async(
      std::launch::async,
      [this](Job job) {
        static_cast<void>(nice(kPolite));  // on Linux this is the thread's alone
        carryOut(job);
        return job;
      },
      Job{map_.clone(), std::exchange(unwritten_, {}), improve, {}});
}

/** Begins with the data that would be lost if the program were killed now. */
void LiveMapping::carryOut(Job& job) {
  const std::size_t first_new = static_cast<std::size_t>(job.map.size()) - job.models.size();
  const auto T_w_m = job.map.poses();
  for (std::size_t i = 0; i < job.models.size(); ++i) {
    job.models[i].model.T_w_m = T_w_m[first_new + i];
    database_.add(job.models[i].model, job.models[i].view);
  }
  job.models.clear();
  if (job.improve) job.map.improve();
  job.result = job.map.map(camera_);
  if (job.improve)
    database_.setPoses(job.map.poses(), job.result->links);
  else
    for (const Link& link : job.result->links)
      if (link.to >= static_cast<int>(first_new)) database_.add(link);
}

void LiveMapping::finish() {
  const auto wait = [this] {
    if (job_.valid()) job_.wait();
    takeResult();
  };
  wait();
  if (map_.size() == 0) {
    std::filesystem::remove(path_);
    throw IoError(path_.string(), "is not written: none of the images makes a local model");
  }
  begin(true);
  wait();
  database_.setMeta(kStateKey, kWhole);
}

}  // namespace facetloc
