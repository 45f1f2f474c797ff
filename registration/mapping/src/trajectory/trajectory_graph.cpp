// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/trajectory_graph.h"

#include "depth/depth_consistency.h"
#include "motion/step_prior.h"
#include "poses/pose_fusion.h"

#include <facetloc/registration/pose_prior.h>

#include <cmath>
#include <deque>
#include <fmt/format.h>
#include <stdexcept>
#include <vector>

namespace facetloc::internal {
namespace {

using Source = KeyframeMotion::Source;

constexpr double kErrorBesideKeyframe = 0.003;  // error of an image relative to its keyframe [m, rad]

/** Index of the local model that is nearest in the order of images to each keyframe, of the same part. */
std::vector<int> nearestModels(const CameraTrajectory& trajectory, const std::vector<std::size_t>& images) {
  std::vector<int> nearest(trajectory.keyframes.size(), -1);
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    const Keyframe& keyframe = trajectory.keyframes[k];
    const auto after = std::lower_bound(images.begin(), images.end(), keyframe.image);
    std::size_t least = 0;
    for (const auto candidate : {after, after == images.begin() ? images.end() : after - 1}) {
      if (candidate == images.end()) continue;
      if (trajectory.partOf(trajectory.images[*candidate]) != keyframe.part) continue;
      const std::size_t distance =
          *candidate > keyframe.image ? *candidate - keyframe.image : keyframe.image - *candidate;
      if (nearest[k] >= 0 && distance >= least) continue;
      least = distance;
      nearest[k] = static_cast<int>(candidate - images.begin());
    }
  }
  return nearest;
}

constexpr double kUnknown = 100;  // standard deviation of motions that two views leave free [m, rad]
constexpr PoseRadius kSameTrajectory{0.1, 1};

DepthAgreement agreementAt(const Eigen::Isometry3d& T_a_b, const View& a, const View& b) {
  return DepthComparison(DepthCalibration{}).compareBoth(b.depth, a.depth, T_a_b, kFineColumns);
}

double overlapOf(const DepthAgreement& seen, const DepthPicture& picture) {
  const int step = gridStep(picture, kFineColumns);
  const int pixels = gridPoints(picture.camera.width, step) * gridPoints(picture.camera.height, step);
  return (seen.agree + seen.contradict) / (2.0 * std::max(1, pixels));
}

bool agrees(const DepthAgreement& seen) {
  return seen.agree >= kLeastAgreement * (seen.agree + seen.contradict);
}

// Share of the overlaps of two pieces that contradict their pose, beyond noise and things that moved: within
// a piece it is up to 0.025, of a right bond 0, of a wrong one 0.07 to 0.8.
constexpr double kContradicted = 0.05;

bool isContradicted(const OverlapVerdicts& v) { return v.contradictedShare() > kContradicted; }

// Bonds of a shortest path between two pieces; empty if no path joins them.
std::vector<PiecePair> pathBetween(const PiecePair& ends, const PieceBonds& bonds) {
  std::map<int, int> before{{ends.first, ends.first}};
  std::deque<int> open{ends.first};
  while (!open.empty() && before.count(ends.second) == 0) {
    const int piece = open.front();
    open.pop_front();
    for (const auto& [pair, ignored] : bonds)
      for (const auto& [from, to] : {pair, PiecePair(pair.second, pair.first)})
        if (from == piece && before.emplace(to, piece).second) open.push_back(to);
  }
  std::vector<PiecePair> path;
  if (before.count(ends.second) == 0) return path;
  for (int piece = ends.second; piece != ends.first; piece = before.at(piece))
    path.emplace_back(std::minmax(piece, before.at(piece)));
  return path;
}

/** The graph of keyframes at their poses. All comparisons of one keyframe share its errors: together they
 * have the information of those with the keyframe before and the one after.
 *
 * \param mounting if known, all stand on one floor \param key_distance distance between keyframes, by which
 * the unevenness under them is new [m] */
template <class AnyKeyframe>
PoseGraph graphOf(const std::vector<AnyKeyframe>& keyframes, const std::vector<KeyframeMotion>& motions,
                  const std::optional<CameraMounting>& mounting, double key_distance) {
  constexpr double kFloorLength = 0.7;  // distance after which a robot stands on other unevenness [m]
  const auto isComparison = [](const KeyframeMotion& m) { return m.source != Source::odometry; };
  std::vector<int> comparisons(keyframes.size(), 0);
  for (const KeyframeMotion& m : motions)
    if (isComparison(m)) ++comparisons[m.from], ++comparisons[m.to];
  PoseGraph graph;
  for (const AnyKeyframe& k : keyframes) graph.T_w_n.push_back(k.T_w_c.T);
  for (const KeyframeMotion& m : motions) {
    PoseEdge edge{m.from, m.to, m.T_from_to, isComparison(m)};
    edge.others = m.others;
    if (isComparison(m)) {
      const double shared = std::max(1.0, (comparisons[m.from] + comparisons[m.to]) / 4.0);
      edge.T_from_to.P *= shared;
      for (AlternativeMotion& other : edge.others) other.T_from_to.P *= shared;
    }
    graph.edges.push_back(edge);
  }
  if (mounting) {
    const double repeated = std::max(1.0, kFloorLength / key_distance);
    graph.floor = LevelFloor{mounting->T_b_c(), repeated * floorCovariance({})};
  }
  return graph;
}

}  // namespace

std::vector<KeyframeMotion> TrajectoryGraph::motions() const {
  std::vector<KeyframeMotion> all;
  for (int k = 0; k < size(); ++k)
    if (const RelativePosition& at = nodes_[k].at; at.known)
      all.push_back(
          {nodes_[k].before, k, {at.by_motion.T, withSharedErrors(at.by_motion.P)}, Source::odometry});
  for (const KeyframeMotion& m : relations_) {
    all.push_back(m);
    if (m.from == nodes_[m.to].before) all.back().others = nodes_[m.to].at.others;
  }
  return all;
}

std::optional<CameraMounting> TrajectoryGraph::mounting() const {
  if (nodes_.empty() || !nodes_.front().view->camera) return {};
  return nodes_.front().view->camera->mounting;
}

// Has a robot been seen to move sideways more often than errors explain?
bool TrajectoryGraph::slides(const CameraMounting& mounting) const {
  constexpr double kSure = 3, kOften = 0.1;
  constexpr int kFewest = 10;  // steps
  int seen = 0, sideways = 0;
  for (const KeyframeMotion& step : relations_) {
    if (step.to != step.from + 1) continue;
    const SidewaysShift s = sidewaysShift(step.T_from_to, mounting);
    if (s.variance > kSidewaysStd * kSidewaysStd) continue;
    ++seen;
    sideways += std::abs(s.shift) > kSure * std::sqrt(s.variance + kSidewaysStd * kSidewaysStd);
  }
  return seen >= kFewest && sideways > kOften * seen;
}

PoseWithCovariance TrajectoryGraph::guessedStep() const {
  const auto m = mounting();
  return {Eigen::Isometry3d::Identity(), stepCovariance(m, !m || slides(*m))};
}

PoseGraph TrajectoryGraph::poseGraph() const {
  return graphOf(nodes_, motions(), mounting(), params_.key_distance);
}

void TrajectoryGraph::add(TrajectoryNode node) {
  node.piece = node.part = size();
  if (node.at.known) {
    node.piece = nodes_[node.before].piece;
    follow(node);
    if (node.at.placed)
      relations_.push_back({node.before, size(), measured(*node.at.placed), Source::overlap});
  } else if (node.view->camera && node.view->camera->mounting) {
    node.T_w_c.T = node.view->camera->mounting->T_b_c();
  }
  nodes_.push_back(std::move(node));
}

// Moves a keyframe rigidly with the one before.
void TrajectoryGraph::follow(TrajectoryNode& node) const {
  const TrajectoryNode& before = nodes_[node.before];
  node.T_w_c = before.T_w_c * PoseWithCovariance{node.at.T, withSharedErrors(node.at.by_motion.P)};
  node.part = before.part;
}

void TrajectoryGraph::keepRelations(int first, std::vector<KeyframeMotion>& found) const {
  for (const KeyframeMotion& m : relations_)
    if (m.to < first || ((m.source == Source::loop || m.from == nodes_[m.to].before) &&
                         std::none_of(found.begin(), found.end(), [&](const KeyframeMotion& f) {
                           return f.from == m.from && f.to == m.to;
                         })))
      found.push_back(m);
}

// Moves parts that have been tied to where their first ties place them, close to the solution.
void TrajectoryGraph::alignParts() {
  for (const KeyframeMotion& m : motions()) {
    const bool forward = nodes_[m.from].part < nodes_[m.to].part;  // the later part moves
    const TrajectoryNode &a = nodes_[forward ? m.from : m.to], &b = nodes_[forward ? m.to : m.from];
    const int kept = a.part, moved = b.part;
    if (kept == moved) continue;
    const Eigen::Isometry3d T_a_b = forward ? m.T_from_to.T : m.T_from_to.T.inverse();
    const Eigen::Isometry3d T_kept_moved = a.T_w_c.T * T_a_b * b.T_w_c.T.inverse();
    for (TrajectoryNode& node : nodes_)
      if (node.part == moved) {
        node.T_w_c.T = T_kept_moved * node.T_w_c.T;
        node.part = kept;
      }
  }
}

double TrajectoryGraph::optimize(std::vector<KeyframeMotion> found) {
  std::vector<Eigen::Isometry3d> before;
  for (const TrajectoryNode& node : nodes_) before.push_back(node.T_w_c.T);
  relations_ = std::move(found);
  for (const bool last : {false, true}) {
    alignParts();
    const GraphPoses poses = optimized(poseGraph(), last);
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      nodes_[k].T_w_c = poses.nodes[k];
      nodes_[k].part = poses.part[k];
    }
    if (last) break;
    const std::vector<double>& mismatch = poses.mismatch;
    auto of_relation = mismatch.end() - static_cast<std::ptrdiff_t>(relations_.size());
    std::vector<KeyframeMotion> kept;
    for (const KeyframeMotion& m : relations_)
      if (!(*of_relation++ > kFarEllipsoid) &&
          (m.source != Source::loop ||
           agrees(agreementAt(between(m.from, m.to), *nodes_[m.from].view, *nodes_[m.to].view))))
        kept.push_back(m);
    relations_ = std::move(kept);
  }
  double moved = 0;
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    moved = std::max(moved, (before[k].translation() - nodes_[k].T_w_c.T.translation()).norm());
  return moved;
}

void TrajectoryGraph::adopt(const TrajectoryGraph& improved) {
  const int n = improved.size();
  if (n > size())
    throw std::invalid_argument("TrajectoryEstimation: only a clone of this trajectory can be adopted");
  std::vector<KeyframeMotion> all = improved.relations_;
  std::copy_if(relations_.begin(), relations_.end(), std::back_inserter(all),
               [n](const KeyframeMotion& m) { return m.to >= n; });
  relations_ = std::move(all);
  for (int k = 0; k < size(); ++k) {
    if (k < n) {
      nodes_[k].T_w_c = improved[k].T_w_c;
      nodes_[k].part = improved[k].part;
    } else if (nodes_[k].at.known) {
      follow(nodes_[k]);
    }
  }
}

PoseGraph keyframeGraph(const CameraTrajectory& trajectory, const std::optional<CameraMounting>& mounting) {
  return graphOf(trajectory.keyframes, trajectory.motions, mounting, MappingParams().odometry.key_distance);
}

std::vector<Link> trajectoryLinks(const CameraTrajectory& trajectory,
                                  const std::vector<std::size_t>& images) {
  for (const std::size_t image : images)
    if (image >= trajectory.images.size())
      throw std::invalid_argument(fmt::format("links: there is no image {}", image));
  std::set<std::pair<int, int>> pairs;
  std::map<int, int> latest;  // model of each part
  for (int i = 0; i < static_cast<int>(images.size()); ++i) {
    const auto [before, is_first] = latest.try_emplace(trajectory.partOf(trajectory.images[images[i]]), i);
    if (!is_first) pairs.emplace(std::exchange(before->second, i), i);
  }
  const std::vector<int> nearest = nearestModels(trajectory, images);
  for (const KeyframeMotion& m : trajectory.motions) {
    const int a = nearest[m.from], b = nearest[m.to];
    if (a >= 0 && b >= 0 && a != b) pairs.insert(std::minmax(a, b));
  }

  std::vector<PlaceOnTrajectory> places;
  for (const std::size_t image : images) {
    const TrajectoryPose& pose = trajectory.images[image];
    places.push_back({pose.keyframe, trajectory.keyframes[pose.keyframe].T_w_c.T.inverse() * pose.T_w_c});
  }
  return linksBetween(trajectory, places, pairs);
}

std::vector<Link> linksBetween(const CameraTrajectory& trajectory,
                               const std::vector<PlaceOnTrajectory>& places,
                               const std::set<std::pair<int, int>>& pairs) {
  if (pairs.empty()) return {};
  const auto& camera = trajectory.keyframes.front().view->camera;
  const GraphCovariance known(keyframeGraph(trajectory, camera ? camera->mounting : std::nullopt));
  std::vector<Link> links;
  for (const auto& [a, b] : pairs) {
    const PlaceOnTrajectory &from = places[a], &to = places[b];
    std::optional<PoseWithCovariance> T_key_key = known.between(from.keyframe, to.keyframe);
    if (!T_key_key) continue;
    T_key_key->P.diagonal().array() += kErrorBesideKeyframe * kErrorBesideKeyframe;
    links.push_back(
        {a, b, from.T_k_c.inverse() * (*T_key_key * PoseWithCovariance{to.T_k_c, Matrix6d::Zero()})});
  }
  return links;
}

PoseWithCovariance measured(const PlacedView& placed) {
  Matrix6d information = placed.information;
  information.diagonal().array() += 1 / (kUnknown * kUnknown);
  return {placed.T_a_b, withSharedErrors(symmetricInverse(information))};
}

std::optional<PlacedView> registered(const ViewPlacing& placing, const View& view, const View& other,
                                     const PoseWithCovariance& prior, bool search) {
  auto placed = placing.place(view, other, prior, search);
  if (placed && (placed->agreement < kLeastAgreement || placed->overlap < kLeastOverlap)) placed.reset();
  return placed;
}

bool isClear(const PlacedView& placed) {
  return placed.agreement >= kClearAgreement && placed.overlap >= kLoopOverlap;
}

double overlapOf(const Eigen::Isometry3d& T_a_b, const View& a, const View& b) {
  return overlapOf(agreementAt(T_a_b, a, b), b.depth);
}

std::optional<bool> isConfirmed(const Eigen::Isometry3d& T_a_b, const View& a, const View& b,
                                const Comparison& compared) {
  const DepthAgreement seen = agreementAt(T_a_b, a, b);
  if (overlapOf(seen, b.depth) < kLeastOverlap) return {};
  const bool is_elsewhere = compared.placed && !compared.anywhere &&
                            !kSameTrajectory.joins(compared.placed->T_a_b, T_a_b) &&
                            squaredMahalanobis(measured(*compared.placed), T_a_b) > kFarEllipsoid;
  return agrees(seen) && !is_elsewhere;
}

std::optional<PiecePair> weakestBond(const PieceVerdicts& verdicts, const PieceBonds& bonds, int least_ties) {
  for (const auto& [pair, ties] : bonds)
    if (ties < least_ties) return pair;
  const auto share = [&](const PiecePair& pair) {
    const auto found = verdicts.find(pair);
    return found == verdicts.end() ? 0 : found->second.contradictedShare();
  };
  std::optional<PiecePair> worst;
  for (const auto& [pair, v] : verdicts)
    if (pair.first != pair.second && isContradicted(v) && (!worst || share(pair) > share(*worst)))
      worst = pair;
  if (!worst) return {};
  const std::vector<PiecePair> path = pathBetween(*worst, bonds);
  const auto weakest =
      std::max_element(path.begin(), path.end(), [&](const PiecePair& a, const PiecePair& b) {
        return share(a) != share(b) ? share(a) < share(b) : bonds.at(a) > bonds.at(b);
      });
  return weakest == path.end() ? std::nullopt : std::optional(*weakest);
}

}  // namespace facetloc::internal
