// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/keyframe_selection.h"
#include "trajectory/loop_search.h"

#include <facetloc/mapping/trajectory_estimation.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <utility>

namespace facetloc {

using namespace internal;

namespace {

constexpr int kPasses = 4;         // comparisons of all keyframes, each followed by an optimization
constexpr double kSettled = 0.02;  // motion of a keyframe in the last pass [m]

double largestOf(const std::vector<Keyframe>& keyframes, double (*stdOf)(const Matrix6d&)) {
  double largest = 0;
  for (const Keyframe& k : keyframes) largest = std::max(largest, stdOf(k.T_w_c.P));
  return largest;
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
  return static_cast<int>(std::count_if(motions.begin(), motions.end(), [](const KeyframeMotion& m) {
    return m.source == KeyframeMotion::Source::loop;
  }));
}

double CameraTrajectory::length() const {
  double sum = 0;
  for (std::size_t i = 1; i < images.size(); ++i)
    if (partOf(images[i]) == partOf(images[i - 1]))
      sum += (images[i].T_w_c.translation() - images[i - 1].T_w_c.translation()).norm();
  return sum;
}

double CameraTrajectory::positionStd() const { return largestOf(keyframes, largestTranslationStd); }
double CameraTrajectory::rotationStd() const { return largestOf(keyframes, largestRotationStd); }

std::string OverlapVerdicts::toString() const {
  return fmt::format("{:.1f} % of {} overlaps of images contradict it by more than 1 deg or 0.1 m",
                     100 * contradictedShare(), judged());
}

struct TrajectoryEstimation::Impl {
  explicit Impl(const MappingParams& params)
      : graph(checked(params).odometry), keyframes(params), loops(params) {}

  bool improveOnce(int first, const ChunkedWork& work, bool is_last);

  int threads = 1;
  TrajectoryGraph graph;
  KeyframeSelection keyframes;
  LoopSearch loops;
};

TrajectoryEstimation::TrajectoryEstimation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TrajectoryEstimation::TrajectoryEstimation(const MappingParams& params)
    : impl_(std::make_unique<Impl>(params)) {}
TrajectoryEstimation::TrajectoryEstimation(TrajectoryEstimation&&) noexcept = default;
TrajectoryEstimation& TrajectoryEstimation::operator=(TrajectoryEstimation&&) noexcept = default;
TrajectoryEstimation::~TrajectoryEstimation() = default;

void TrajectoryEstimation::setNumberOfThreads(int n) { impl_->threads = n; }
void TrajectoryEstimation::interrupt() { impl_->keyframes.interrupt(); }
void TrajectoryEstimation::setEndless(bool endless) { impl_->keyframes.setEndless(endless); }

bool TrajectoryEstimation::add(View view, double stamp, const std::optional<Eigen::Isometry3d>& motion) {
  return impl_->keyframes.add(std::make_shared<const View>(std::move(view)), stamp, motion, impl_->graph);
}

PoseWithCovariance TrajectoryEstimation::latest() const {
  const RelativePosition& at = impl_->keyframes.position();
  return pose(latestKeyframe()) * PoseWithCovariance{at.T, at.by_motion.P};
}

int TrajectoryEstimation::keyframes() const { return impl_->graph.size(); }
int TrajectoryEstimation::latestKeyframe() const { return impl_->keyframes.current(); }
int TrajectoryEstimation::part(int keyframe) const { return impl_->graph.nodes().at(keyframe).part; }
const PoseWithCovariance& TrajectoryEstimation::pose(int keyframe) const {
  return impl_->graph.nodes().at(keyframe).T_w_c;
}

TrajectoryEstimation TrajectoryEstimation::clone() const {
  return TrajectoryEstimation(std::make_unique<Impl>(*impl_));
}

void TrajectoryEstimation::adopt(const TrajectoryEstimation& improved) {
  impl_->graph.adopt(improved.impl_->graph);
  impl_->loops.adopt(improved.impl_->loops);
}

// Returns false if nothing is left to be improved.
bool TrajectoryEstimation::Impl::improveOnce(int first, const ChunkedWork& work, bool is_last) {
  std::vector<KeyframeMotion> found, ties;
  {
    const GraphCovariance known(graph.poseGraph(), threads);
    known.ofNodes();  // computed by all threads, before each of them asks for some
    found = loops.withinParts(graph, known, first, work.section(0, 0.5));
    if (!is_last)  // ties are judged by the pass after them
      ties = loops.betweenParts(graph, known, first, keyframes.speed(), work.section(0.5, 1));
  }
  found.insert(found.end(), ties.begin(), ties.end());
  graph.keepRelations(first, found);
  const double moved = graph.optimize(std::move(found));
  const bool is_cut = loops.cutContradicted(graph, threads);
  return !(moved < kSettled) || !ties.empty() || is_cut;
}

void TrajectoryEstimation::improve(const std::function<void(double)>& progress, int first) {
  const int n = keyframes();
  if (n < 2) return;
  const ChunkedWork work{impl_->threads, progress};
  for (int pass = 0; pass < kPasses; ++pass)
    if (!impl_->improveOnce(std::clamp(first, 0, n),
                            work.section(double(pass) / kPasses, (pass + 1.0) / kPasses),
                            pass + 1 == kPasses))
      break;
  if (progress) progress(1);
}

// An image between two keyframes of one part: by odometry from the first, whose error at the second is spread
// evenly over the images.
CameraTrajectory TrajectoryEstimation::trajectory() const {
  const TrajectoryGraph& graph = impl_->graph;
  CameraTrajectory out;
  out.keyframes.assign(graph.nodes().begin(), graph.nodes().end());
  out.motions = graph.motions();
  for (const auto& [ignored, v] : impl_->loops.verdicts(graph, impl_->threads)) {
    out.overlaps.confirmed += v.confirmed;
    out.overlaps.contradicted += v.contradicted;
  }
  out.cut_bonds = impl_->loops.cutBonds();
  for (const KeyframeSelection::Image& image : impl_->keyframes.images())
    out.images.push_back({image.stamp, graph[image.keyframe].T_w_c.T * image.T_k_c, image.keyframe});
  for (int k = 1; k < graph.size(); ++k) {
    const RelativePosition& at = graph[k].at;
    if (!at.known || graph[k].before + 1 != k) continue;
    const std::size_t first = graph[k - 1].image, last = graph[k].image;
    const Vector6d error = boxminus(graph[k].T_w_c.T, graph[k - 1].T_w_c.T * at.T);
    for (std::size_t i = first + 1; i < last; ++i)
      if (out.images[i].keyframe + 1 == k)
        out.images[i].T_w_c =
            boxplus(out.images[i].T_w_c, error * (double(i - first) / double(last - first)));
  }
  return out;
}

}  // namespace facetloc
