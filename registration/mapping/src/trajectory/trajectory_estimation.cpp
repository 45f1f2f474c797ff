// SPDX-License-Identifier: BSD-3-Clause
#include "graph/graph_covariance.h"
#include "graph/independent_ties.h"
#include "graph/loop_consistency.h"
#include "motion/step_prior.h"
#include "motion/view_odometry.h"
#include "motion/view_placing.h"
#include "poses/pose_fusion.h"
#include "poses/pose_radius.h"
#include "threads/in_parallel.h"
#include "trajectory/camera_speed.h"
#include "trajectory/keyframe_graph.h"
#include "trajectory/overlap_verdict.h"
#include "trajectory/piece_bonds.h"
#include "trajectory/tie_search.h"

#include <facetloc/features/chi_square.h>
#include <facetloc/mapping/trajectory_estimation.h>
#include <facetloc/registration/pose_prior.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace internal;

namespace {

using Source = KeyframeMotion::Source;
using Progress = std::function<void(double)>;

constexpr double kFarEllipsoid = chiSquareQuantile(6, 0.999);
constexpr double kLongStep = 0.2;                     // after which the next image may show another place [s]
constexpr double kSparse = 0.02, kSparseTurnDeg = 1;  // least motion of a camera between images [m, deg]
constexpr double kClearAgreement = 0.9;               // agreement of an image with the keyframes before it
constexpr double kLoopOverlap = 0.3;                  // share that an uncertain loop must have in common
constexpr double kReachAngle = 45 * kDegree;  // between the viewing directions of keyframes that are compared
// Standard deviations of a relative pose, beyond which a lone loop is not believed [m, rad].
constexpr double kTrustedStd = 0.3, kTrustedRotation = 5 * kDegree;
constexpr int kConsistentLoops = 3;  // that must agree before an uncertain one of them is believed
constexpr int kPasses = 4;           // comparisons of all keyframes, each followed by an optimization
constexpr double kUncertainStd = 1,
                 kUncertainRotation = 10 * kDegree;  // beyond which several rooms may fit [m]
constexpr int kMostUncertain = 15;        // earlier keyframes that one is compared with far from certainty
constexpr int kLocal = 20;                // keyframes in a row between which no loop is closed
constexpr double kSameLookOverlap = 0.5;  // share of the pixels of two keyframes that show the same thing
constexpr int kIndependentTies = 2;       // that must agree before two pieces become one
constexpr double kMoved = 0.02,
                 kTurned = 0.5;  // change of a prior after which a pair is compared anew [m, deg]
constexpr int kLooks = 3;  // keyframes of a place that an image is compared with before it becomes another
constexpr double kSureAgreement = 0.95,
                 kSureOverlap = 0.7;  // overlap of a lost image with a keyframe that it is attached to
constexpr double kSureStd = 0.05;     // standard deviation of its position relative to that keyframe [m]
constexpr int kCrowded = 3;           // keyframes of one place, after which it gets no more

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
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum;
}

std::vector<int> inOrder(std::vector<std::pair<double, int>> by_distance) {
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<int> numbers;
  for (const auto& [ignored, number] : by_distance) numbers.push_back(number);
  return numbers;
}

using Comparisons = std::map<std::pair<int, int>, Comparison>;
using Ties = std::map<std::pair<int, int>, std::optional<PlacedView>>;

bool isTrusted(const Matrix6d& P) {
  return largestTranslationStd(P) <= kTrustedStd && largestRotationStd(P) <= kTrustedRotation;
}

// Calls a function with 0 .. n - 1 in parallel, and tells the progress in between.
void inChunks(int n, int threads, const Progress& progress, const std::function<void(int)>& function) {
  constexpr int kChunk = 64;
  for (int first = 0; first < n; first += kChunk) {
    if (progress) progress(double(first) / n);
    forEachInParallel(std::min(kChunk, n - first), threads, [&](int i) { function(first + i); });
  }
}

// Puts parts that have been tied where their first ties say, so that the optimization begins near its end.
void alignParts(const std::vector<KeyframeMotion>& all, std::vector<PoseWithCovariance>& T_w_k,
                std::vector<int>& part) {
  for (const KeyframeMotion& m : all) {
    if (part[m.from] == part[m.to]) continue;
    const bool forward = part[m.from] < part[m.to];  // the later part moves
    const int moved = forward ? part[m.to] : part[m.from], kept = forward ? part[m.from] : part[m.to];
    const Eigen::Isometry3d T_w_moved =
        forward ? T_w_k[m.from].T * m.T_from_to.T * T_w_k[m.to].T.inverse()
                : T_w_k[m.to].T * m.T_from_to.T.inverse() * T_w_k[m.from].T.inverse();
    for (std::size_t i = 0; i < part.size(); ++i)
      if (part[i] == moved) {
        T_w_k[i].T = T_w_moved * T_w_k[i].T;
        part[i] = kept;
      }
  }
}

}  // namespace

std::vector<int> CameraTrajectory::parts() const {
  std::map<int, int> size;
  for (const Keyframe& k : keyframes) ++size[k.part];
  std::vector<int> out;
  for (const auto& [part, n] : size) out.push_back(part);
  std::stable_sort(out.begin(), out.end(), [&](int a, int b) { return size[a] > size[b]; });
  return out;
}

int CameraTrajectory::loops() const {
  return static_cast<int>(std::count_if(motions.begin(), motions.end(),
                                        [](const KeyframeMotion& m) { return m.source == Source::loop; }));
}

double CameraTrajectory::length() const {
  double sum = 0;
  for (std::size_t i = 1; i < images.size(); ++i)
    if (keyframes[images[i].keyframe].part == keyframes[images[i - 1].keyframe].part)
      sum += (images[i].T_w_c.translation() - images[i - 1].T_w_c.translation()).norm();
  return sum;
}

struct TrajectoryEstimation::Impl {
  explicit Impl(const MappingParams& the_params)
      : params(checked(the_params)),
        odometry(params.odometry, alignmentWithCovariance(), DepthComparison(DepthCalibration{})) {}

  struct Image {
    double stamp;
    int keyframe;
    Eigen::Isometry3d T_k_c;  // pose in its keyframe
  };
  struct Node {
    std::size_t image;
    std::shared_ptr<const View> view;
    int before;                                 // the keyframe that the way led from
    int piece;                                  // number of the first keyframe that motions led from
    int run;                                    // number of interruptions before it
    std::optional<Eigen::Isometry3d> T_before;  // pose in that one, as found with it
  };
  /** Motion from one image to the next. */
  struct Motion {
    PoseWithCovariance T;    // pose by all but comparisons with keyframes
    Eigen::Isometry3d best;  // pose by all information
    bool known, guessed;
  };
  /** Position of an image relative to the latest keyframe. */
  struct Position {
    PoseWithCovariance by_motion;  // motion by all but comparisons with that keyframe
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    bool known = true;                 // nothing has broken since
    bool guessed = false;              // how a camera may move is all that by_motion comes from
    bool follows = true;               // odometry is right
    std::optional<PlacedView> placed;  // if it has been compared with that keyframe, and agrees
  };

  bool add(View&& view, double stamp, const std::optional<Eigen::Isometry3d>& motion);
  Motion motionOf(const ViewMotion& seen, bool is_sparse,
                  const std::optional<Eigen::Isometry3d>& given) const;
  PoseWithCovariance withDrift(const Eigen::Isometry3d& motion) const;
  PoseWithCovariance guessedStep() const;
  Position moved(const Position& from, const Motion& step) const;
  Position place(const std::shared_ptr<const View>& view, const Position& thought) const;
  bool beginAgain(const std::shared_ptr<const View>& view, double stamp);
  PiecePair piecesOf(const KeyframeMotion& m) const {
    return std::minmax(nodes[m.from].piece, nodes[m.to].piece);
  }
  double stampOf(int keyframe) const { return images[nodes[keyframe].image].stamp; }
  bool attach(const std::shared_ptr<const View>& view, const Position& at);
  bool attachToKnown(const View& view, const Position& at);
  void attachTo(int keyframe, const PoseWithCovariance& T_k_c);
  std::vector<int> keyframesAround(const Eigen::Isometry3d& T_w_c) const;
  std::vector<int> similarKeyframes(const View& view) const;
  void takeKeyframe(const std::shared_ptr<const View>& view, const Position& at);
  void begin(const std::shared_ptr<const View>& view);
  bool slides() const;
  std::optional<CameraMounting> mounting() const;
  void improve(const Progress& progress, int first);
  void adopt(const Impl& improved);
  void optimize(std::vector<KeyframeMotion> relations);
  PoseGraph graphOf(const std::vector<KeyframeMotion>& all) const;
  std::vector<KeyframeMotion> compareKeyframes(const GraphCovariance& known, int first,
                                               const Progress& progress);
  std::vector<KeyframeMotion> tieParts(const GraphCovariance& known, int first, const Progress& progress);
  void compareTies(const std::vector<std::pair<int, int>>& pairs, const Progress& progress);
  PieceVerdicts verdicts() const;
  PieceBonds bonds() const;
  NodesApart keyframesApart() const;
  NodesApart viewsApart() const;
  bool cutContradicted();
  void cut(const PiecePair& pieces);
  const Comparison* comparisonOf(const std::pair<int, int>& pair) const;
  std::optional<PlacedView> compare(int a, int b, const PoseWithCovariance& prior, bool search) const;
  bool agrees(const KeyframeMotion& m) const;

  MappingParams params;
  ViewOdometry odometry;
  ViewPlacing placing;
  int threads = 1;
  bool endless = false, interrupted = false;
  int run = 0, cut_bonds = 0;
  CameraSpeed speed;
  std::vector<Image> images;
  std::vector<Node> nodes;
  std::vector<KeyframeMotion> chain, relations;
  std::vector<PoseWithCovariance> T_w_k;
  std::vector<int> part;
  std::shared_ptr<const Comparisons> compared = std::make_shared<Comparisons>();
  Comparisons compared_since;          // not yet included in compared
  Ties ties;                           // keyframes of different pieces, compared anywhere; empty if refused
  int current = 0;                     // the keyframe that the latest image is attached to
  Position since;                      // that keyframe
  std::shared_ptr<const View> latest;  // view
};

std::optional<CameraMounting> TrajectoryEstimation::Impl::mounting() const {
  if (nodes.empty() || !nodes.front().view->camera) return {};
  return nodes.front().view->camera->mounting;
}

// Has a robot been seen to move sideways more often than errors explain?
bool TrajectoryEstimation::Impl::slides() const {
  constexpr double kSure = 3, kOften = 0.1;
  constexpr int kFewest = 10;  // steps
  const auto m = mounting();
  if (!m) return true;
  int seen = 0, sideways = 0;
  for (const KeyframeMotion& step : relations) {
    if (step.to != step.from + 1) continue;
    const SidewaysShift s = sidewaysShift(step.T_from_to, *m);
    if (s.variance > kSidewaysStd * kSidewaysStd) continue;
    ++seen;
    sideways += std::abs(s.shift) > kSure * std::sqrt(s.variance + kSidewaysStd * kSidewaysStd);
  }
  return seen >= kFewest && sideways > kOften * seen;
}

void TrajectoryEstimation::Impl::begin(const std::shared_ptr<const View>& view) {
  PoseWithCovariance T;
  if (view->camera && view->camera->mounting) T.T = view->camera->mounting->T_b_c();
  T_w_k.push_back(T);
  part.push_back(static_cast<int>(nodes.size()) - 1);
}

bool TrajectoryEstimation::Impl::add(View&& moved_view, double stamp,
                                     const std::optional<Eigen::Isometry3d>& given) {
  const auto view = std::make_shared<const View>(std::move(moved_view));
  const double dt = images.empty() ? 0 : std::max(0.0, stamp - images.back().stamp);
  if (nodes.empty()) {
    odometry.add(*view, dt);
    images.push_back({stamp, 0, Eigen::Isometry3d::Identity()});
    nodes.push_back({0, latest = view, 0, 0, run, {}});
    begin(view);
    return true;
  }
  if (std::exchange(interrupted, false)) {
    ++run;
    return beginAgain(view, stamp);
  }
  const bool is_gap = !given && speed.isGap(dt);
  speed.addInterval(dt);
  if (is_gap) return beginAgain(view, stamp);
  const ViewMotion seen = odometry.add(*view, dt);
  const bool is_sparse = dt > kLongStep;
  const Motion step = motionOf(seen, is_sparse, given);
  const bool shows_anything = !view->segments.empty() || !view->depth.empty();
  Position at = moved(since, step);
  if (shows_anything && (is_sparse || seen.broken || seen.agreement < kClearAgreement)) {
    at = place(view, at);
    if (!at.placed && latest && latest != nodes[current].view) {
      attach(latest, since);
      at = place(view, moved(since, step));
    }
    if (!at.follows) {
      odometry.reset();
      odometry.add(*view, 0);
    }
  }
  since = std::move(at);
  if (since.known && (since.placed || !since.guessed)) speed.addMotion(since.T, stamp - stampOf(current));
  latest = shows_anything ? view : nullptr;
  if (endless && nodes.back().image + 1 < images.size()) images.pop_back();
  images.push_back({stamp, current, since.T});
  const double way = is_sparse ? kSparse : params.odometry.key_distance,
               turn_deg = is_sparse ? kSparseTurnDeg : params.odometry.key_rotation_deg;
  if (!shows_anything || (since.known && isNear(since.T, Eigen::Isometry3d::Identity(), way, turn_deg)))
    return false;
  if (!since.placed) since = place(view, since);
  return attach(view, Position(since));
}

// Those of the same part where an image is, the nearest first.
std::vector<int> TrajectoryEstimation::Impl::keyframesAround(const Eigen::Isometry3d& T_w_c) const {
  std::vector<std::pair<double, int>> around;
  for (int k = 0; k < static_cast<int>(nodes.size()); ++k)
    if (k != current && part[k] == part[current] &&
        isNear(T_w_k[k].T, T_w_c, params.odometry.key_distance, params.odometry.key_rotation_deg))
      around.push_back({viewDistance(T_w_k[k].T, T_w_c), k});
  return inOrder(around);
}

// All of them; those whose depth pictures look most like the view's come first.
std::vector<int> TrajectoryEstimation::Impl::similarKeyframes(const View& view) const {
  const Thumbnail of_view = thumbnail(view.depth);
  std::vector<std::pair<double, int>> similar;
  for (int k = 0; k < static_cast<int>(nodes.size()); ++k)
    similar.push_back({difference(of_view, thumbnail(nodes[k].view->depth)), k});
  return inOrder(similar);
}

void TrajectoryEstimation::Impl::attachTo(int keyframe, const PoseWithCovariance& T_k_c) {
  current = keyframe;
  since = {};
  since.T = T_k_c.T;
  since.by_motion = T_k_c;
}

// Finds a keyframe of its place that shows the same, or any of a crowded place.
bool TrajectoryEstimation::Impl::attachToKnown(const View& view, const Position& at) {
  const Eigen::Isometry3d T_w_c = T_w_k[current].T * at.T;
  const Matrix6d step = stepCovariance(mounting(), true);
  const std::vector<int> around = at.known ? keyframesAround(T_w_c) : similarKeyframes(view);
  for (int i = 0; i < std::min<int>(kLooks, around.size()); ++i) {
    const int k = around[i];
    PoseWithCovariance prior{Eigen::Isometry3d::Identity(), step};
    if (at.known) prior.T = T_w_k[k].T.inverse() * T_w_c;
    const auto placed = placing.place(view, *nodes[k].view, prior, !at.known);
    if (!placed || placed->agreement < (at.known ? kClearAgreement : kSureAgreement) ||
        placed->overlap < (at.known ? kLoopOverlap : kSureOverlap) ||
        (!at.known && largestTranslationStd(measured(*placed).P) > kSureStd))
      continue;
    attachTo(
        k, {placed->T_a_b, withSharedErrors(symmetricInverse(placed->information + symmetricInverse(step)))});
    since.placed = placed;
    return true;
  }
  if (!at.known || around.size() < kCrowded) return false;
  const int k = around.front();
  attachTo(k, {T_w_k[k].T.inverse() * T_w_c, guessedStep().P});
  return true;
}

// Begins again with a camera that may be anywhere.
bool TrajectoryEstimation::Impl::beginAgain(const std::shared_ptr<const View>& view, double stamp) {
  odometry.reset();
  odometry.add(*view, 0);
  if (endless && nodes.back().image + 1 < images.size()) images.pop_back();
  images.push_back({stamp, current, Eigen::Isometry3d::Identity()});
  latest = view;
  Position nowhere;
  nowhere.known = false;
  return attach(view, nowhere);
}

// Makes the latest image a keyframe or, in an endless trajectory, attaches it to an existing one.
// Returns true for a new one.
bool TrajectoryEstimation::Impl::attach(const std::shared_ptr<const View>& view, const Position& at) {
  if (endless && attachToKnown(*view, at)) {
    images.back().keyframe = current;
    images.back().T_k_c = since.T;
    return false;
  }
  takeKeyframe(view, at);
  return true;
}

// Motion by a given odometry and by the views, each as well as it knows.
TrajectoryEstimation::Impl::Motion
TrajectoryEstimation::Impl::motionOf(const ViewMotion& seen, bool is_sparse,
                                     const std::optional<Eigen::Isometry3d>& given) const {
  const bool is_seen = !seen.broken && !is_sparse;
  if (!given)
    return is_seen ? Motion{seen.T_a_b, seen.T_a_b.T, true, false}
                   : Motion{guessedStep(), seen.T_a_b.T, !seen.broken, true};
  PoseWithCovariance T = withDrift(*given);
  if (is_seen) T = fused(T, seen.T_a_b);
  return {T, T.T, true, false};
}

PoseWithCovariance TrajectoryEstimation::Impl::withDrift(const Eigen::Isometry3d& motion) const {
  return motionByOdometry(motion, mounting(),
                          {params.odometry_error.drift, params.odometry_error.turn_deg, kSharedTranslation,
                           kSharedRotation / kDegree});
}

PoseWithCovariance TrajectoryEstimation::Impl::guessedStep() const {
  return {Eigen::Isometry3d::Identity(), stepCovariance(mounting(), slides())};
}

TrajectoryEstimation::Impl::Position TrajectoryEstimation::Impl::moved(const Position& from,
                                                                       const Motion& step) const {
  Position out;
  out.by_motion = from.by_motion * step.T;
  out.T = from.T * step.best;
  out.known = from.known && step.known;
  out.guessed = from.guessed || step.guessed;
  return out;
}

// Beside the latest keyframe: where it is thought to be, or elsewhere if the two views say so.
TrajectoryEstimation::Impl::Position
TrajectoryEstimation::Impl::place(const std::shared_ptr<const View>& view, const Position& thought) const {
  PoseWithCovariance prior{Eigen::Isometry3d::Identity(), stepCovariance(mounting(), true)};
  if (thought.known) prior.T = thought.T;
  if (thought.known && !thought.guessed) prior.P = withSharedErrors(thought.by_motion.P);
  Position out = thought;
  std::optional<PlacedView> placed = placing.place(*view, *nodes[current].view, prior, true);
  out.follows = false;
  if (!placed || placed->agreement < kLeastAgreement || placed->overlap < kLeastOverlap) return out;
  out.follows = thought.known && kSameMotion.joins(placed->T_a_b, thought.T);
  const PoseWithCovariance seen = measured(*placed);
  out.T = placed->T_a_b;
  if (!out.guessed) {
    const PoseWithCovariance by_motion{out.by_motion.T, withSharedErrors(out.by_motion.P)};
    if (squaredMahalanobis(seen, by_motion) > kFarEllipsoid)
      out.by_motion = {placed->T_a_b, guessedStep().P};
    else
      out.T = fused(by_motion, seen).T;  // views may leave motions free
  }
  out.placed = std::move(placed);
  out.known = true;
  return out;
}

// The latest image becomes one.
void TrajectoryEstimation::Impl::takeKeyframe(const std::shared_ptr<const View>& view, const Position& at) {
  const int a = current, b = static_cast<int>(nodes.size());
  nodes.push_back({images.size() - 1, view, a, at.known ? nodes[a].piece : b, run, {}});
  if (at.known) {
    nodes.back().T_before = at.T;
    chain.push_back({a, b, {at.by_motion.T, withSharedErrors(at.by_motion.P)}, Source::odometry, 0});
    if (at.placed) {
      compared_since[{a, b}] = {at.T, false, at.placed};
      relations.push_back({a, b, measured(*at.placed), Source::overlap, 0});
    }
    T_w_k.push_back(T_w_k[a] * PoseWithCovariance{at.T, chain.back().T_from_to.P});
    part.push_back(part[a]);
  } else {
    begin(view);
  }
  current = b;
  since = {};
  images.back().keyframe = b;
  images.back().T_k_c.setIdentity();
}

std::optional<PlacedView> TrajectoryEstimation::Impl::compare(int a, int b, const PoseWithCovariance& prior,
                                                              bool search) const {
  auto placed = placing.place(*nodes[b].view, *nodes[a].view, prior, search);
  if (placed && (placed->agreement < kLeastAgreement || placed->overlap < kLeastOverlap)) placed.reset();
  return placed;
}

// Compares keyframes of one part. A pair known to the trajectory is an overlap; any other a loop that others
// must confirm.
std::vector<KeyframeMotion> TrajectoryEstimation::Impl::compareKeyframes(const GraphCovariance& known,
                                                                         int first,
                                                                         const Progress& progress) {
  struct Pair {
    int a;
    PoseWithCovariance T_a_b;
    bool certain;
    std::optional<PlacedView> placed;
  };
  const int n = static_cast<int>(nodes.size());
  std::vector<std::vector<Pair>> of_node(n);
  const ViewReach reach{params.reach, kReachAngle};
  inChunks(n - first, threads, progress, [&](int i_b) {
    const int b = first + i_b;
    const auto T_b = known.relativeTo(b);
    std::vector<std::pair<double, Pair>> certain, uncertain;
    for (int a = 0; a < b; ++a) {
      if (!T_b[a]) continue;
      const PoseWithCovariance T = inverse(*T_b[a]);
      const double std = largestTranslationStd(T.P);
      if (isTrusted(T.P)) {
        const double distance = viewDistance(Eigen::Isometry3d::Identity(), T.T, reach);
        if (std::isfinite(distance)) certain.push_back({distance, {a, T, true, {}}});
      } else if (b - a > kLocal && std <= kUncertainStd && largestRotationStd(T.P) <= kUncertainRotation) {
        const double beyond = std::max(0.0, T.T.translation().norm() - params.reach) / std;
        if (beyond < 3) uncertain.push_back({beyond, {a, T, false, {}}});
      }
    }
    for (auto* pairs : {&certain, &uncertain}) {
      std::stable_sort(pairs->begin(), pairs->end(),
                       [](const auto& x, const auto& y) { return x.first < y.first; });
      const int most = pairs == &certain ? params.neighbours : kMostUncertain;
      for (int i = 0; i < std::min<int>(most, pairs->size()); ++i) of_node[b].push_back((*pairs)[i].second);
    }
    const PoseWithCovariance anywhere{Eigen::Isometry3d::Identity(), posePrior(mounting())};
    for (Pair& p : of_node[b]) {
      const Comparison* before = comparisonOf({p.a, b});
      if (before && isNear(before->prior, p.T_a_b.T, kMoved, kTurned))
        p.placed = before->placed;
      else if (p.certain)
        p.placed = compare(p.a, b, p.T_a_b, largestTranslationStd(p.T_a_b.P) > 0.1);
      else
        p.placed = compare(p.a, b, anywhere, true);
    }
  });

  const auto all = std::make_shared<Comparisons>(*compared);
  for (const auto& [pair, comparison] : compared_since) (*all)[pair] = comparison;
  std::vector<KeyframeMotion> out;
  std::vector<PoseEdge> uncertain;
  for (int b = first; b < n; ++b)
    for (Pair& p : of_node[b]) {
      (*all)[{p.a, b}] = {p.T_a_b.T, !p.certain, p.placed};
      if (!p.placed) continue;
      const PoseWithCovariance T = measured(*p.placed);
      if (squaredMahalanobis(p.T_a_b, T) > kFarEllipsoid) continue;
      if (p.certain)
        out.push_back({p.a, b, T, b - p.a > kLocal ? Source::loop : Source::overlap, 0});
      else if (p.placed->overlap >= kLoopOverlap && p.placed->agreement >= kClearAgreement)
        uncertain.push_back({p.a, b, T, true});
    }
  compared = all;
  compared_since.clear();
  const std::vector<bool> confirmed = consistentLoops(uncertain, known, kConsistentLoops, keyframesApart());
  for (std::size_t i = 0; i < uncertain.size(); ++i)
    if (confirmed[i])
      out.push_back({uncertain[i].from, uncertain[i].to, uncertain[i].T_from_to, Source::loop, 0});
  return out;
}

const Comparison* TrajectoryEstimation::Impl::comparisonOf(const std::pair<int, int>& pair) const {
  const auto latest_one = compared_since.find(pair);
  if (latest_one != compared_since.end()) return &latest_one->second;
  const auto earlier = compared->find(pair);
  return earlier == compared->end() ? nullptr : &earlier->second;
}

// Compares keyframes of different parts, each pair once.
void TrajectoryEstimation::Impl::compareTies(const std::vector<std::pair<int, int>>& pairs,
                                             const Progress& progress) {
  std::vector<std::pair<int, int>> missing;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(missing),
               [&](const std::pair<int, int>& pair) { return ties.count(pair) == 0; });
  const PoseWithCovariance anywhere{Eigen::Isometry3d::Identity(), posePrior(mounting())};
  std::vector<std::optional<PlacedView>> placed(missing.size());
  inChunks(static_cast<int>(missing.size()), threads, progress,
           [&](int i) { placed[i] = compare(missing[i].first, missing[i].second, anywhere, true); });
  for (std::size_t i = 0; i < missing.size(); ++i) ties[missing[i]] = placed[i];
}

// Where a chain has broken, by keyframes that show the same on both sides.
std::vector<KeyframeMotion> TrajectoryEstimation::Impl::tieParts(const GraphCovariance& known, int first,
                                                                 const Progress& progress) {
  std::vector<TieEnd> keyframes;
  for (std::size_t k = 0; k < nodes.size(); ++k)
    keyframes.push_back(
        {nodes[k].view, part[k], nodes[k].run, images[nodes[k].image].stamp, T_w_k[k].T.translation()});
  const auto share = [&progress](double begin, double end) -> Progress {
    if (!progress) return {};
    return [&progress, begin, end](double done) { progress(begin + done * (end - begin)); };
  };
  const TieSearch search{{Eigen::Isometry3d::Identity(), posePrior({})}, mounting(), threads, share(0, 0.5)};
  const std::vector<std::pair<int, int>> pairs = tieCandidates(keyframes, first, search);
  compareTies(pairs, share(0.5, 1));
  const TravelBound bound(keyframes, speed, known);
  std::vector<PoseEdge> found;
  for (const auto& pair : pairs) {
    const auto& placed = ties.at(pair);
    if (!placed || placed->overlap < kLoopOverlap || placed->agreement < kClearAgreement) continue;
    const PoseEdge tie{pair.first, pair.second, measured(*placed), true};
    if (bound.allows(tie)) found.push_back(tie);
  }
  const std::vector<bool> confirmed = consistentLoops(found, known, kIndependentTies, viewsApart());
  std::vector<KeyframeMotion> out;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (confirmed[i]) out.push_back({found[i].from, found[i].to, found[i].T_from_to, Source::loop, 0});
  return out;
}

// True for keyframes of one part that are as far apart as a new keyframe is from the last.
NodesApart TrajectoryEstimation::Impl::keyframesApart() const {
  const PoseRadius radius{params.odometry.key_distance, params.odometry.key_rotation_deg};
  return [this, radius](int a, int b) { return !radius.joins(T_w_k[a].T, T_w_k[b].T); };
}

// True for keyframes of one part with little in common. The answers are kept for the poses of now.
NodesApart TrajectoryEstimation::Impl::viewsApart() const {
  const auto known = std::make_shared<std::map<std::pair<int, int>, bool>>();
  return [this, known](int a, int b) {
    if (a == b) return false;
    const auto [answer, is_new] = known->try_emplace(std::minmax(a, b));
    if (is_new)
      answer->second =
          overlapOf(T_w_k[a].T.inverse() * T_w_k[b].T, *nodes[a].view, *nodes[b].view) < kSameLookOverlap;
    return answer->second;
  };
}

// Verdicts on pieces that are tied into one part, and on each with itself, by all keyframes compared.
PieceVerdicts TrajectoryEstimation::Impl::verdicts() const {
  PieceVerdicts out;
  std::vector<std::pair<std::pair<int, int>, const Comparison*>> pairs;
  for (const auto& [pair, comparison] : *compared)
    if (part[pair.first] == part[pair.second]) pairs.emplace_back(pair, &comparison);
  std::vector<OverlapVerdict> verdict(pairs.size());
  forEachInParallel(static_cast<int>(pairs.size()), threads, [&](int i) {
    const auto [a, b] = pairs[i].first;
    verdict[i] =
        verdictOn(T_w_k[a].T.inverse() * T_w_k[b].T, *nodes[a].view, *nodes[b].view, *pairs[i].second);
  });
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [a, b] = pairs[i].first;
    OverlapVerdicts& of_pieces = out[std::minmax(nodes[a].piece, nodes[b].piece)];
    of_pieces.confirmed += verdict[i] == OverlapVerdict::confirms;
    of_pieces.contradicted += verdict[i] == OverlapVerdict::contradicts;
  }
  return out;
}

// Those that leave the relative pose of their pieces loose have no ties.
PieceBonds TrajectoryEstimation::Impl::bonds() const {
  std::map<PiecePair, std::vector<std::pair<int, int>>> between;
  for (const KeyframeMotion& m : relations) {
    const PiecePair pieces = piecesOf(m);
    if (pieces.first == pieces.second) continue;
    const bool forward = nodes[m.from].piece == pieces.first;
    between[pieces].emplace_back(forward ? m.from : m.to, forward ? m.to : m.from);
  }
  PieceBonds out;
  if (between.empty()) return out;
  std::vector<KeyframeMotion> all = chain;
  all.insert(all.end(), relations.begin(), relations.end());
  const GraphCovariance known(graphOf(all), threads);
  const auto isTight = [&](const std::pair<int, int>& tie) {
    const auto T = known.between(tie.first, tie.second);
    return T && isTrusted(T->P);
  };
  const NodesApart apart = viewsApart();
  for (const auto& [pieces, found] : between)
    out[pieces] = std::any_of(found.begin(), found.end(), isTight) ? independentTies(found, apart) : 0;
  return out;
}

PoseGraph TrajectoryEstimation::Impl::graphOf(const std::vector<KeyframeMotion>& all) const {
  std::vector<Eigen::Isometry3d> T;
  for (const PoseWithCovariance& k : T_w_k) T.push_back(k.T);
  return keyframeGraph(T, all, mounting(), params.odometry.key_distance);
}

// Depth at the poses found.
bool TrajectoryEstimation::Impl::agrees(const KeyframeMotion& m) const {
  const DepthComparison comparison(DepthCalibration{});
  const Eigen::Isometry3d T = T_w_k[m.from].T.inverse() * T_w_k[m.to].T;
  const DepthAgreement seen =
      comparison.compareBoth(nodes[m.to].view->depth, nodes[m.from].view->depth, T, kFineColumns);
  return seen.agree >= kLeastAgreement * (seen.agree + seen.contradict);
}

void TrajectoryEstimation::Impl::optimize(std::vector<KeyframeMotion> found) {
  relations = std::move(found);
  for (const bool last : {false, true}) {
    std::vector<KeyframeMotion> all = chain;
    all.insert(all.end(), relations.begin(), relations.end());
    alignParts(all, T_w_k, part);
    const GraphPoses poses = optimized(graphOf(all), last);
    T_w_k = poses.nodes;
    part = poses.part;
    for (std::size_t i = 0; i < all.size(); ++i) all[i].mismatch = poses.mismatch[i];
    std::copy_n(all.begin(), chain.size(), chain.begin());
    std::copy(all.begin() + static_cast<std::ptrdiff_t>(chain.size()), all.end(), relations.begin());
    if (last) break;
    relations.erase(std::remove_if(relations.begin(), relations.end(),
                                   [&](const KeyframeMotion& m) {
                                     return m.mismatch > kFarEllipsoid ||
                                            (m.source == Source::loop && !agrees(m));
                                   }),
                    relations.end());
  }
}

void TrajectoryEstimation::Impl::improve(const Progress& progress, int asked) {
  if (nodes.size() < 2) return;
  const int first = std::clamp(asked, 0, static_cast<int>(nodes.size()));
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto share = [&](double begin, double end) -> Progress {
      if (!progress) return {};
      return [&progress, pass, begin, end](double done) {
        progress((pass + begin + done * (end - begin)) / kPasses);
      };
    };
    std::vector<KeyframeMotion> all = chain;
    all.insert(all.end(), relations.begin(), relations.end());
    const GraphCovariance known(graphOf(all), threads);
    known.ofNodes();  // computed by all threads, before each of them asks for some
    std::vector<KeyframeMotion> found = compareKeyframes(known, first, share(0, 0.5));
    const bool is_last = pass + 1 == kPasses;  // ties are judged by the pass after them
    const std::vector<KeyframeMotion> new_ties =
        is_last ? std::vector<KeyframeMotion>() : tieParts(known, first, share(0.5, 1));
    found.insert(found.end(), new_ties.begin(), new_ties.end());
    for (const KeyframeMotion& m : relations)  // those of earlier keyframes; ties of parts that are one now
      if (m.to < first || ((m.source == Source::loop || m.from == nodes[m.to].before) &&
                           std::none_of(found.begin(), found.end(), [&](const KeyframeMotion& f) {
                             return f.from == m.from && f.to == m.to;
                           })))
        found.push_back(m);
    const std::vector<PoseWithCovariance> before = T_w_k;
    optimize(std::move(found));
    const bool is_cut = cutContradicted();
    double moved = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
      moved = std::max(moved, (before[i].T.translation() - T_w_k[i].T.translation()).norm());
    if (moved < kMoved && new_ties.empty() && !is_cut) break;
  }
  if (progress) progress(1);
}

// Takes out the weakest bond between pieces that contradict each other, again and again.
bool TrajectoryEstimation::Impl::cutContradicted() {
  bool is_cut = false;
  for (;;) {
    const PieceVerdicts all = verdicts();
    const auto bond = weakestBond(all, bonds(), kIndependentTies);
    if (!bond) return is_cut;
    cut(*bond);
    is_cut = true;
  }
}

void TrajectoryEstimation::Impl::cut(const PiecePair& pieces) {
  std::vector<KeyframeMotion> left;
  for (const KeyframeMotion& m : relations)
    if (piecesOf(m) != pieces)
      left.push_back(m);
    else if (const auto tie = ties.find({m.from, m.to}); tie != ties.end())
      tie->second.reset();
  ++cut_bonds;
  optimize(std::move(left));
}

void TrajectoryEstimation::Impl::adopt(const Impl& improved) {
  const std::size_t n = improved.nodes.size();
  if (n > nodes.size() || improved.chain.size() > chain.size())
    throw std::invalid_argument("TrajectoryEstimation: only a clone of this trajectory can be adopted");
  const auto isLater = [n](const KeyframeMotion& m) { return m.to >= static_cast<int>(n); };
  std::copy(improved.chain.begin(), improved.chain.end(), chain.begin());
  std::vector<KeyframeMotion> all = improved.relations;
  std::copy_if(relations.begin(), relations.end(), std::back_inserter(all), isLater);
  relations = std::move(all);
  Comparisons later = improved.compared_since;
  for (const auto& [pair, comparison] : compared_since)
    if (pair.second >= static_cast<int>(n)) later[pair] = comparison;
  compared = improved.compared;
  compared_since = std::move(later);
  std::copy(improved.T_w_k.begin(), improved.T_w_k.end(), T_w_k.begin());
  std::copy(improved.part.begin(), improved.part.end(), part.begin());
  for (const KeyframeMotion& m : chain) {
    if (!isLater(m)) continue;
    T_w_k[m.to] = T_w_k[m.from] * PoseWithCovariance{*nodes[m.to].T_before, m.T_from_to.P};
    part[m.to] = part[m.from];
  }
}

std::string OverlapVerdicts::toString() const {
  return fmt::format("{:.1f} % of {} overlaps of images contradict it by more than 1 deg or 0.1 m",
                     100 * contradictedShare(), judged());
}

TrajectoryEstimation::TrajectoryEstimation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TrajectoryEstimation::TrajectoryEstimation(const MappingParams& params)
    : impl_(std::make_unique<Impl>(params)) {}
TrajectoryEstimation::TrajectoryEstimation(TrajectoryEstimation&&) noexcept = default;
TrajectoryEstimation& TrajectoryEstimation::operator=(TrajectoryEstimation&&) noexcept = default;
TrajectoryEstimation::~TrajectoryEstimation() = default;

void TrajectoryEstimation::setNumberOfThreads(int n) { impl_->threads = n; }
void TrajectoryEstimation::interrupt() { impl_->interrupted = impl_->images.size() > 0; }
void TrajectoryEstimation::setEndless(bool endless) { impl_->endless = endless; }

bool TrajectoryEstimation::add(View view, double stamp, const std::optional<Eigen::Isometry3d>& motion) {
  return impl_->add(std::move(view), stamp, motion);
}

PoseWithCovariance TrajectoryEstimation::latest() const {
  return impl_->T_w_k[impl_->current] * PoseWithCovariance{impl_->since.T, impl_->since.by_motion.P};
}

int TrajectoryEstimation::keyframes() const { return static_cast<int>(impl_->nodes.size()); }
int TrajectoryEstimation::latestKeyframe() const { return impl_->current; }
int TrajectoryEstimation::part(int keyframe) const { return impl_->part.at(keyframe); }
const PoseWithCovariance& TrajectoryEstimation::pose(int keyframe) const { return impl_->T_w_k.at(keyframe); }

TrajectoryEstimation TrajectoryEstimation::clone() const {
  return TrajectoryEstimation(std::make_unique<Impl>(*impl_));
}

void TrajectoryEstimation::adopt(const TrajectoryEstimation& improved) { impl_->adopt(*improved.impl_); }

void TrajectoryEstimation::improve(const std::function<void(double)>& progress, int first) {
  impl_->improve(progress, first);
}

// An image between two keyframes of one part: by odometry from the first, whose error at the second is spread
// evenly over the images.
CameraTrajectory TrajectoryEstimation::trajectory() const {
  const Impl& m = *impl_;
  CameraTrajectory out;
  for (std::size_t k = 0; k < m.nodes.size(); ++k)
    out.keyframes.push_back({m.nodes[k].image, m.nodes[k].view, m.T_w_k[k], m.part[k]});
  out.motions = m.chain;
  out.motions.insert(out.motions.end(), m.relations.begin(), m.relations.end());
  for (const auto& [ignored, v] : m.verdicts()) {
    out.overlaps.confirmed += v.confirmed;
    out.overlaps.contradicted += v.contradicted;
  }
  out.cut_bonds = m.cut_bonds;
  for (std::size_t i = 0; i < m.images.size(); ++i) {
    const Impl::Image& image = m.images[i];
    out.images.push_back({image.stamp, m.T_w_k[image.keyframe].T * image.T_k_c, image.keyframe});
  }
  for (std::size_t k = 1; k < m.nodes.size(); ++k) {
    if (!m.nodes[k].T_before || m.nodes[k].before + 1 != static_cast<int>(k)) continue;
    const std::size_t first = m.nodes[k - 1].image, last = m.nodes[k].image;
    const Vector6d error = perturbation(m.T_w_k[k - 1].T * *m.nodes[k].T_before, m.T_w_k[k].T);
    for (std::size_t i = first + 1; i < last; ++i)
      if (out.images[i].keyframe + 1 == static_cast<int>(k))
        out.images[i].T_w_c =
            perturbed(out.images[i].T_w_c, error * (double(i - first) / double(last - first)));
  }
  return out;
}

}  // namespace facetloc
