// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/keyframe_selection.h"

#include "poses/pose_fusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr double kLongStep = 0.2;                     // after which the next image may show another place [s]
constexpr double kSparse = 0.02, kSparseTurnDeg = 1;  // least motion of a camera between images [m, deg]
constexpr int kLooks = 3;    // keyframes of a place that an image is compared with before it becomes another
constexpr int kCrowded = 3;  // keyframes of one place, after which it gets no more
constexpr std::size_t kLatest = 100;                             // intervals that make the rhythm
constexpr double kUsual = 0.9;                                   // share of them that are no gaps
constexpr double kRhythm = 2;                                    // usual intervals that a gap is longer than
constexpr double kShortest = 0.1;                                // duration that tells a speed from noise [s]
constexpr double kExpected = 0.8, kExpectedTurn = 40 * kDegree;  // two standard deviations of a step [m]
constexpr double kWalking = 1.5, kSurge = 2;  // speed of any camera [m/s], and factor beyond the fastest seen
// Overlap of a lost image with a keyframe that it is attached to.
constexpr double kSureAgreement = 0.95, kSureOverlap = 0.7;
constexpr double kSureStd = 0.05;  // standard deviation of its position relative to that keyframe [m]

/** A small picture of inverse depths, to find similar keyframes first. */
constexpr int kThumbColumns = 8, kThumbRows = 6;
using Thumbnail = std::array<double, kThumbColumns * kThumbRows>;

Thumbnail thumbnail(const DepthPicture& picture) {
  Thumbnail sum = {}, n = {};
  const int width = picture.camera.width, height = picture.camera.height;
  for (std::size_t i = 0; i < picture.inverse_depth.size(); ++i) {
    const int u = static_cast<int>(i) % width, v = static_cast<int>(i) / width;
    const int cell = v * kThumbRows / height * kThumbColumns + u * kThumbColumns / width;
    sum[cell] += picture.inverse_depth[i];
    n[cell] += picture.inverse_depth[i] > 0;
  }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = n[i] > 0 ? sum[i] / n[i] : 0;
  return sum;
}

double difference(const Thumbnail& a, const Thumbnail& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0, std::plus<>(),
                            [](double x, double y) { return std::abs(x - y); });
}

std::vector<int> inOrder(std::vector<std::pair<double, int>> by_distance) {
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<int> numbers;
  for (const auto& [ignored, number] : by_distance) numbers.push_back(number);
  return numbers;
}

// Other keyframes of the same part near a pose, the nearest first.
std::vector<int> keyframesAround(const Eigen::Isometry3d& T_w_c, int current,
                                 const ViewOdometryParams& params, const TrajectoryGraph& graph) {
  std::vector<std::pair<double, int>> around;
  for (int k = 0; k < graph.size(); ++k)
    if (k != current && graph[k].part == graph[current].part &&
        isNear(graph[k].T_w_c.T, T_w_c, params.key_distance, params.key_rotation_deg))
      around.push_back({viewDistance(graph[k].T_w_c.T, T_w_c), k});
  return inOrder(around);
}

// All keyframes, those first whose depth is most similar to the view's.
std::vector<int> similarKeyframes(const View& view, const TrajectoryGraph& graph) {
  const Thumbnail of_view = thumbnail(view.depth);
  std::vector<std::pair<double, int>> similar;
  for (int k = 0; k < graph.size(); ++k)
    similar.push_back({difference(of_view, thumbnail(graph[k].view->depth)), k});
  return inOrder(similar);
}

// Does a view show the same as a keyframe? A lost one needs more evidence.
bool showsSame(const PlacedView& placed, bool is_lost) {
  if (!is_lost) return isClear(placed);
  return placed.agreement >= kSureAgreement && placed.overlap >= kSureOverlap &&
         largestTranslationStd(measured(placed).P) <= kSureStd;
}

// The poses of two views that count as a comparison, the likeliest first.
std::vector<PlacedView> comparisons(std::vector<PlacedView> modes) {
  const auto counts = [](const PlacedView& mode) {
    return mode.agreement >= kLeastAgreement && mode.overlap >= kLeastOverlap;
  };
  modes.erase(std::remove_if(modes.begin(), modes.end(), std::not_fn(counts)), modes.end());
  return modes;
}

// True if an image has been guessed near a keyframe, and both together leave it free to be farther away.
bool mayBeElsewhere(const RelativePosition& at, double distance) {
  return at.guessed && at.placed && largestTranslationStd(measured(*at.placed).P) > distance;
}

RelativePosition moved(const RelativePosition& from, const RelativePosition& step) {
  RelativePosition out;
  out.by_motion = from.by_motion * step.by_motion;
  out.T = from.T * step.T;
  out.known = from.known && step.known;
  out.guessed = from.guessed || step.guessed;
  return out;
}

}  // namespace

void CameraSpeed::addInterval(double dt) {
  intervals_.push_back(dt);
  if (intervals_.size() > kLatest) intervals_.pop_front();
}

void CameraSpeed::addMotion(const Eigen::Isometry3d& T_before_after, double duration) {
  if (duration < kShortest) return;
  fastest_ = std::max(fastest_, T_before_after.translation().norm() / duration);
  fastest_turn_ = std::max(fastest_turn_, rotationAngle(T_before_after.linear()) / duration);
}

bool CameraSpeed::isGap(double dt) const {
  if (intervals_.empty()) return false;
  std::vector<double> intervals(intervals_.begin(), intervals_.end());
  const auto rhythm = intervals.begin() + static_cast<std::ptrdiff_t>(kUsual * double(intervals.size() - 1));
  std::nth_element(intervals.begin(), rhythm, intervals.end());
  if (dt <= kRhythm * *rhythm) return false;
  return fastest_ * dt > kExpected || fastest_turn_ * dt > kExpectedTurn;
}

double CameraSpeed::farthest(double duration) const {
  return std::max(kWalking, kSurge * fastest_) * duration;
}

KeyframeSelection::KeyframeSelection(const MappingParams& params)
    : params_(params), odometry_(params.odometry, alignmentWithCovariance()) {}

bool KeyframeSelection::add(const SharedView& view, double stamp,
                            const std::optional<Eigen::Isometry3d>& given, TrajectoryGraph& graph) {
  if (images_.empty()) return beginAgain(view, stamp, graph);
  if (std::exchange(interrupted_, false)) {
    ++run_;
    return beginAgain(view, stamp, graph);
  }
  const double dt = std::max(0.0, stamp - images_.back().stamp);
  const bool is_gap = !given && speed_.isGap(dt);
  speed_.addInterval(dt);
  if (is_gap) return beginAgain(view, stamp, graph);
  const ViewMotion seen = odometry_.add(*view, dt);
  const bool is_sparse = dt > kLongStep, shows_anything = !view->segments.empty() || !view->depth.empty();
  const RelativePosition step = stepBy(seen, dt, given, graph);
  const SharedView before = latest_;
  const Eigen::Isometry3d T_k_before = since_.T;
  if (shows_anything && (is_sparse || seen.broken || seen.agreement < kClearAgreement))
    compareWithKeyframe(view, step, graph);
  else
    since_ = moved(since_, step);
  if (since_.known && (since_.placed || !since_.guessed))
    speed_.addMotion(since_.T, stamp - graph[current_].stamp);
  learnVelocity(before, T_k_before, dt, graph);
  latest_ = shows_anything ? view : nullptr;
  addImage(stamp, since_.T, graph);
  const double distance = is_sparse ? kSparse : params_.odometry.key_distance,
               turn_deg = is_sparse ? kSparseTurnDeg : params_.odometry.key_rotation_deg;
  if (!shows_anything || (since_.known && !mayBeElsewhere(since_, params_.odometry.key_distance) &&
                          isNear(since_.T, Eigen::Isometry3d::Identity(), distance, turn_deg)))
    return false;
  if (!since_.placed) since_ = place(*view, since_, graph);
  return attach(view, since_, graph);
}

// Motion by a given odometry and by the views, each as well as it knows.
RelativePosition KeyframeSelection::stepBy(const ViewMotion& seen, double dt,
                                           const std::optional<Eigen::Isometry3d>& given,
                                           const TrajectoryGraph& graph) const {
  const bool is_seen = !seen.broken && dt <= kLongStep;
  RelativePosition step;
  if (given) {
    step.by_motion = motionByOdometry(*given, graph.mounting(),
                                      {params_.odometry_error.drift, params_.odometry_error.turn_deg,
                                       kSharedTranslation, kSharedRotation / kDegree});
    if (is_seen) step.by_motion = fused(step.by_motion, seen.T_a_b);
    step.T = step.by_motion.T;
    return step;
  }
  if (is_seen) {
    step.by_motion = seen.T_a_b;
  } else {
    step.by_motion = graph.guessedStep();
    step.by_motion.T = velocity_.next(dt, graph.mounting()).T;
  }
  step.T = step.by_motion.T;
  step.known = !seen.broken;
  step.guessed = !is_seen;
  return step;
}

// The velocity since the image before, if that motion is certain. That image may have become the keyframe.
void KeyframeSelection::learnVelocity(const SharedView& before, const Eigen::Isometry3d& T_k_before,
                                      double dt, const TrajectoryGraph& graph) {
  if (!before || !since_.known || (since_.guessed && !(since_.placed && since_.others.empty())))
    return velocity_.interrupt();
  const bool is_keyframe = before == graph[current_].view;
  velocity_.add(is_keyframe ? since_.T : T_k_before.inverse() * since_.T, dt);
}

// Moves on to an image whose motion is in doubt. If it cannot be compared with the keyframe, the image before
// becomes one.
void KeyframeSelection::compareWithKeyframe(const SharedView& view, const RelativePosition& step,
                                            TrajectoryGraph& graph) {
  RelativePosition at = place(*view, moved(since_, step), graph);
  if (!at.placed && latest_ && latest_ != graph[current_].view) {
    attach(latest_, since_, graph);
    at = place(*view, moved(since_, step), graph);
  }
  if (!at.follows) {
    odometry_.reset();
    odometry_.add(*view, 0);
  }
  since_ = std::move(at);
}

// Position relative to the latest keyframe: where it is thought to be, or elsewhere if the two views say so.
RelativePosition KeyframeSelection::place(const View& view, const RelativePosition& thought,
                                          const TrajectoryGraph& graph) const {
  PoseWithCovariance prior{Eigen::Isometry3d::Identity(), stepCovariance(graph.mounting(), true)};
  if (thought.known) prior.T = thought.T;
  if (thought.known && !thought.guessed) prior.P = withSharedErrors(thought.by_motion.P);
  RelativePosition out = thought;
  const View& keyframe = *graph[current_].view;
  if (thought.known && !thought.guessed) {
    out.placed = registered(placing_, view, keyframe, prior, true);
  } else if (const auto found = comparisons(placing_.modes(view, keyframe, prior)); !found.empty()) {
    out.placed = found.front();
    for (std::size_t i = 1; i < found.size(); ++i)
      out.others.push_back({measured(found[i]), found[i].log_likelihood - found.front().log_likelihood});
  }
  out.follows = out.placed && thought.known && kSameMotion.joins(out.placed->T_a_b, thought.T);
  if (!out.placed) return out;
  const PoseWithCovariance seen = measured(*out.placed);
  out.T = seen.T;
  out.known = true;
  if (out.guessed) return out;
  const PoseWithCovariance by_motion{out.by_motion.T, withSharedErrors(out.by_motion.P)};
  if (squaredMahalanobis(seen, by_motion) > kFarEllipsoid)
    out.by_motion = {seen.T, graph.guessedStep().P};
  else
    out.T = fused(by_motion, seen).T;  // views may leave motions free
  return out;
}

// An endless trajectory keeps no images other than keyframes and the latest one.
void KeyframeSelection::addImage(double stamp, const Eigen::Isometry3d& T_k_c, const TrajectoryGraph& graph) {
  if (endless_ && graph.size() > 0 && graph.nodes().back().image + 1 < images_.size()) images_.pop_back();
  images_.push_back({stamp, current_, T_k_c});
}

// Begins again with a camera that may be anywhere.
bool KeyframeSelection::beginAgain(const SharedView& view, double stamp, TrajectoryGraph& graph) {
  odometry_.reset();
  odometry_.add(*view, 0);
  velocity_.interrupt();
  addImage(stamp, Eigen::Isometry3d::Identity(), graph);
  latest_ = view;
  RelativePosition nowhere;
  nowhere.known = false;
  return attach(view, nowhere, graph);
}

// Makes the latest image a keyframe or, in an endless trajectory, attaches it to an existing one.
// Returns true for a new one.
bool KeyframeSelection::attach(const SharedView& view, const RelativePosition& at, TrajectoryGraph& graph) {
  const bool is_new = !(endless_ && attachToKnown(*view, at, graph));
  Image& image = images_.back();
  if (is_new) {
    TrajectoryNode node;
    node.image = images_.size() - 1;
    node.view = view;
    node.stamp = image.stamp;
    node.run = run_;
    node.before = current_;
    node.at = at;
    graph.add(std::move(node));
    current_ = graph.size() - 1;
    since_ = {};
  }
  image.keyframe = current_;
  image.T_k_c = since_.T;
  return is_new;
}

// Finds a keyframe of its place that shows the same, or any of a crowded place.
bool KeyframeSelection::attachToKnown(const View& view, const RelativePosition& at,
                                      const TrajectoryGraph& graph) {
  if (graph.size() == 0) return false;
  const Eigen::Isometry3d T_w_c = graph[current_].T_w_c.T * at.T;
  const Matrix6d step = stepCovariance(graph.mounting(), true);
  const bool is_lost = !at.known;
  const std::vector<int> around =
      is_lost ? similarKeyframes(view, graph) : keyframesAround(T_w_c, current_, params_.odometry, graph);
  for (std::size_t i = 0; i < std::min<std::size_t>(kLooks, around.size()); ++i) {
    const int k = around[i];
    PoseWithCovariance prior{Eigen::Isometry3d::Identity(), step};
    if (!is_lost) prior.T = graph[k].T_w_c.T.inverse() * T_w_c;
    const auto placed = placing_.place(view, *graph[k].view, prior, is_lost);
    if (!placed || !showsSame(*placed, is_lost)) continue;
    attachTo(
        k, {placed->T_a_b, withSharedErrors(symmetricInverse(placed->information + symmetricInverse(step)))});
    since_.placed = placed;
    return true;
  }
  if (is_lost || around.size() < kCrowded) return false;
  attachTo(around.front(), {graph[around.front()].T_w_c.T.inverse() * T_w_c, graph.guessedStep().P});
  return true;
}

void KeyframeSelection::attachTo(int keyframe, const PoseWithCovariance& T_k_c) {
  current_ = keyframe;
  since_ = {};
  since_.T = T_k_c.T;
  since_.by_motion = T_k_c;
}

}  // namespace facetloc::internal
