// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_mapping.h"

#include "base/provenance.h"
#include "base/text.h"

#include <facetloc/io/error.h>
#include <facetloc/io/text.h>

#include <algorithm>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace facetloc {
namespace {

constexpr int kBackgroundPriority = 10;        // as of nice: images go first
constexpr double kStep = 0.05;                 // of the way: less is noise [m]
constexpr double kMoved = 0.05;                // of keyframes, after which the trail is drawn anew [m]
constexpr std::chrono::seconds kLeastRest(1);  // between improvements

/** The planes of local models, which a plan is drawn of. */
class Planes : public MapStore {
public:
  explicit Planes(std::vector<std::shared_ptr<const View>> views) : views_(std::move(views)) {}
  std::shared_ptr<const View> view(int i) const override { return views_[static_cast<std::size_t>(i)]; }
  std::unique_ptr<std::istream> placeIndex() const override { return nullptr; }

private:
  std::vector<std::shared_ptr<const View>> views_;
};

TrajectoryEstimation endless(const MappingParams& params) {
  TrajectoryEstimation trajectory(params);
  trajectory.setEndless(true);
  return trajectory;
}

}  // namespace

std::string LiveMapState::inWords() const {
  return text::decimals(way, 1) + " m, " + counted(static_cast<std::size_t>(keyframes), "keyframe") + ", " +
         counted(static_cast<std::size_t>(loops), "loop") + ", " + counted(map->models.size(), "local model");
}

LiveMapping::LiveMapping(const LiveMappingOptions& options)
    : path_(options.map),
      camera_(options.camera),
      trajectory_(endless(options.trajectory)),
      places_(options.places),
      database_(MapDatabase::create(options.map)) {
  database_.setCamera(options.camera);
  database_.setMeta("parameters", options.parameters);
  database_.setMeta(kStateKey, kUnderWay);
  state_.map = std::make_shared<Map>();
  thread_ = std::thread([this] { work(); });
}

LiveMapping::~LiveMapping() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

LiveMapState LiveMapping::update(const View& view, const std::string& name, double stamp,
                                 const std::optional<Eigen::Isometry3d>& motion) {
  takeResult();
  follow(view, name, stamp, motion);
  const Clock::time_point now = Clock::now();
  const bool improve = compared_ < trajectory_.keyframes() && now >= next_improvement_;
  if (improve || !unwritten_.empty()) begin(improve);
  return state_;
}

void LiveMapping::follow(const View& view, const std::string& name, double stamp,
                         const std::optional<Eigen::Isometry3d>& motion) {
  trajectory_.add(view, stamp, motion);
  if (places_.visit(trajectory_, view, name, stamp)) unwritten_.push_back({name, stamp, {}, view});
  state_.keyframes = trajectory_.keyframes();
  if (trajectory_.part(trajectory_.latestKeyframe()) != main_part_) {
    state_.T_w_c.reset();
    trail_.interrupt();
    last_place_.reset();
  } else {
    state_.T_w_c = trajectory_.latest();
    const Eigen::Vector3d place = state_.T_w_c->T.translation();
    trail_.add(place);
    const double step = last_place_ ? (place - *last_place_).norm() : 0;
    if (step >= kStep) state_.way += step;
    if (step >= kStep || !last_place_) last_place_ = place;
  }
  state_.trail = trail_;
}

/** Of the background, if it has finished something. */
void LiveMapping::takeResult() {
  std::unique_ptr<Job> done;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (error_) std::rethrow_exception(error_);
    done = std::move(done_);
  }
  if (!done) return;
  state_.map = done->map;
  if (!done->improve) return;
  const int n = done->trajectory.keyframes();
  double moved = main_part_ == done->main_part ? 0 : kMoved;
  for (int k = 0; k < n; ++k)
    moved = std::max(moved,
                     (done->trajectory.pose(k).T.translation() - trajectory_.pose(k).T.translation()).norm());
  trajectory_.adopt(done->trajectory);
  compared_ = n;
  main_part_ = done->main_part;
  state_.loops = done->loops;
  const Clock::time_point now = Clock::now();
  next_improvement_ = now + std::max<Clock::duration>(kLeastRest, now - improved_);
  if (moved < kMoved) return;
  trail_ = {};
  for (int k = 0; k < trajectory_.keyframes(); ++k)
    if (trajectory_.part(k) == main_part_) trail_.add(trajectory_.pose(k).T.translation());
  trail_.interrupt();
  last_place_.reset();
}

/** Unless the background has still something to do. */
void LiveMapping::begin(bool improve) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (busy_ || to_do_ || done_) return;
  }
  auto job = std::make_unique<Job>(Job{
      trajectory_.clone(), places_, std::move(unwritten_), improve, compared_, main_part_, state_.loops, {}});
  unwritten_.clear();
  if (improve) improved_ = Clock::now();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    to_do_ = std::move(job);
  }
  changed_.notify_all();
}

void LiveMapping::work() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kBackgroundPriority);
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return to_do_ || ended_; });
    if (!to_do_) return;
    std::unique_ptr<Job> job = std::move(to_do_);
    busy_ = true;
    lock.unlock();
    std::exception_ptr error;
    try {
      carryOut(*job);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    busy_ = false;
    error_ = error;
    done_ = std::move(job);
    changed_.notify_all();
    if (error) return;
  }
}

/** First what would be lost if somebody killed the program now. */
void LiveMapping::carryOut(Job& job) {
  std::vector<std::optional<Eigen::Isometry3d>> poses = job.places.poses(job.trajectory, job.main_part);
  const std::size_t first_new = poses.size() - job.models.size();
  for (std::size_t i = 0; i < job.models.size(); ++i) {
    job.models[i].T_w_m = poses[first_new + i];
    database_.add(job.models[i]);
  }
  job.models.clear();
  if (job.improve) {
    job.trajectory.improve({}, job.first);
    const std::vector<int> parts = job.trajectory.trajectory().parts();
    job.main_part = parts.empty() ? 0 : parts.front();
    poses = job.places.poses(job.trajectory, job.main_part);
  }
  const CameraTrajectory trajectory = job.trajectory.trajectory();
  job.loops = trajectory.loops();
  const std::vector<Link> links = job.places.links(trajectory);
  if (job.improve)
    database_.setPoses(poses, links);
  else
    for (const Link& link : links)
      if (link.to >= static_cast<int>(first_new)) database_.add(link);
  job.map = mapOf(job, links);
}

std::shared_ptr<const Map> LiveMapping::mapOf(const Job& job, const std::vector<Link>& links) const {
  auto map = std::make_shared<Map>();
  map->camera = camera_;
  map->links = links;
  const auto poses = job.places.poses(job.trajectory, job.main_part);
  std::vector<std::shared_ptr<const View>> views;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const MappedPlace& place = job.places.places()[i];
    map->models.push_back({place.name, place.stamp, poses[i], {}});
    views.push_back(place.view);
  }
  map->store = std::make_shared<Planes>(std::move(views));
  return map;
}

void LiveMapping::finish() {
  const auto wait = [this] {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return !to_do_ && !busy_; });
  };
  wait();
  takeResult();
  if (places_.places().empty()) {
    std::filesystem::remove(path_);
    throw IoError(path_.string(), "is not written: none of the images makes a local model");
  }
  begin(true);
  wait();
  takeResult();
  database_.setMeta(kStateKey, kWhole);
}

}  // namespace facetloc
