// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/distortion_calibration.h"

#include "depth/depth_consistency.h"
#include "depth/depth_difference.h"
#include "nearby/view_alignment.h"
#include "threads/in_parallel.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

namespace facetloc {

using namespace internal;
namespace {

constexpr int kNodes = DepthDistortion::kNodes;
using NodeVector = Eigen::Matrix<double, kNodes, 1>;
using NodeMatrix = Eigen::Matrix<double, kNodes, kNodes>;
using NodesByMotion = Eigen::Matrix<double, 6, kNodes>;

constexpr double kCorrelationLength = 0.4;  // [normalised ray]: a third of a Kinect's image
constexpr double kLeastShare = 0.01;        // least standard deviation of the field at any node, by the noise
constexpr double kRoughness = 1e-4;         // uncorrelated share of its variance: keeps the prior regular
constexpr ViewReach kReach{2.5, 60 * kDegree};
constexpr std::size_t kPairsPerPicture = 8;
constexpr int kFewestPixels = 40;        // common pixels of two pictures on a coarse grid
constexpr double kPixelError = 1.5;      // difference of two inverse depths [noise std]: sqrt 2 and a bit
constexpr double kCorrelatedPixels = 8;  // as good as one: errors of neighbours are correlated
constexpr double kGate = 3;      // differences beyond this number of standard deviations have no weight
constexpr int kIterations = 10;  // at most, of which all but the last ones see a share of the pairs
constexpr int kLastIterations = 3;
constexpr std::size_t kFirstPairs = 500;  // that first iterations see, about
constexpr std::size_t kPairsAtOnce = 16;  // whose equations are added up, however many threads there are
constexpr PoseAccuracy kExact{0.01 * kDegree, 0.0003};  // no poses are known better
constexpr PoseAccuracy kGoodEnough{0.3 * kDegree, 0.015};
constexpr double kConverged = 0.01;  // change of the field [its prior's standard deviation]

/** Two pictures that see the same. */
struct Pair {
  const DepthPicture *a, *b;
  Eigen::Isometry3d T_b_a;
  Vector6d motion = Vector6d::Zero();  // change of T_b_a so far
};

/** Normal equations of one pair: of the field's nodes, and of the error of T_b_a. */
struct PairEquations {
  NodeMatrix A = NodeMatrix::Zero();
  NodeVector h = NodeVector::Zero();
  NodesByMotion coupling = NodesByMotion::Zero();
  Matrix6d of_motion = Matrix6d::Zero();
  Vector6d h_motion = Vector6d::Zero();
};

class DistortionProblem {
public:
  DistortionProblem(const std::vector<PosedPicture>& pictures, const SensorNoise& noise,
                    const PoseAccuracy& poses, int threads)
      : threads_(threads),
        field_(DepthDistortion::extentOf(pictures.front().picture->camera)),
        error_(kPixelError * noise.ofInverseDepth(DepthNoise::kUsualDepth)) {
    for (int i = 0; i < kNodes; ++i) {
      const double across = field_.rayOf(i).norm();
      prior_std_[i] = std::max(kLeastShare * noise.ofInverseDepth(DepthNoise::kUsualDepth),
                               std::hypot(noise.distortion_offset, noise.distortion_slope * across));
    }
    NodeMatrix covariance;
    for (int i = 0; i < kNodes; ++i)
      for (int k = 0; k < kNodes; ++k) {
        const double d = (field_.rayOf(i) - field_.rayOf(k)).norm() / kCorrelationLength;
        covariance(i, k) = prior_std_[i] * prior_std_[k] * (std::exp(-d * d / 2) + (i == k ? kRoughness : 0));
      }
    prior_information_ = covariance.llt().solve(NodeMatrix::Identity());
    setPoseAccuracy(poses);
    choosePairs(pictures);
  }

  bool empty() const { return pairs_.empty(); }

  DistortionEstimate solve() {
    const std::size_t first_share = std::max<std::size_t>(1, pairs_.size() / kFirstPairs);
    for (int i = kLastIterations; i < kIterations && improve(first_share) > kConverged; ++i) {
    }
    for (int i = 0; i < kLastIterations && improve(1) > kConverged; ++i) {
    }
    return {field_, poses_};
  }

private:
  void choosePairs(const std::vector<PosedPicture>& pictures);
  bool overlap(const Pair& pair) const;
  template <class Visitor>
  void forEachDifference(const Pair& pair, int columns, const Visitor& visit) const;
  PairEquations equationsOf(const Pair& pair) const;
  /** One Gauss-Newton step by each pair of a share, and the pose accuracy that it shows. \return its size
   * [standard deviations of the prior]. */
  double improve(std::size_t share);
  void setPoseAccuracy(const PoseAccuracy& poses);

  int threads_;
  DepthDistortion field_;
  double error_;
  NodeVector prior_std_;
  NodeMatrix prior_information_;
  PoseAccuracy poses_;
  Vector6d motion_variance_;  // variance of the difference of two poses
  std::vector<Pair> pairs_;
};

/** Calls visit(ray in a, inverse depth there, ray in b's axes, difference) for the pixels of a grid that b
 * saw too. */
template <class Visitor>
void DistortionProblem::forEachDifference(const Pair& pair, int columns, const Visitor& visit) const {
  const DepthPicture& a = *pair.a;
  const int step = gridStep(a, columns);
  for (int v = step / 2; v < a.camera.height; v += step)
    for (int u = step / 2; u < a.camera.width; u += step) {
      const Eigen::Vector3d ray = a.camera.ray(u, v);
      const double measured =
          DepthPicture::kQuantum * a.inverse_depth[static_cast<std::size_t>(v) * a.camera.width + u];
      if (measured < DepthDifference::kFarthest) continue;
      const double inverse_depth = measured - field_.at(ray.head<2>());
      if (!(inverse_depth > 0)) continue;
      const Eigen::Vector3d turned = pair.T_b_a.linear() * ray;
      DepthDifference d;
      if (!compareDepth(turned, pair.T_b_a.translation(), inverse_depth, *pair.b, error_, d)) continue;
      d.residual += field_.at({d.x, d.y});
      visit(ray, inverse_depth, turned, d);
    }
}

bool DistortionProblem::overlap(const Pair& pair) const {
  int common = 0;
  const double largest = kGate * prior_std_.maxCoeff();
  forEachDifference(pair, kCoarseColumns,
                    [&](const Eigen::Vector3d&, double, const Eigen::Vector3d&, const DepthDifference& d) {
                      common += std::abs(d.residual) < largest;
                    });
  return common >= kFewestPixels;
}

/** For each picture some of those that overlap with it, from all around. */
void DistortionProblem::choosePairs(const std::vector<PosedPicture>& pictures) {
  std::vector<std::vector<Pair>> of_picture(pictures.size());
  forEachInParallel(static_cast<int>(pictures.size()), threads_, [&](int i) {
    const PosedPicture& a = pictures[static_cast<std::size_t>(i)];
    std::vector<Pair> possible;
    for (const PosedPicture& b : pictures) {
      if (&a == &b || !std::isfinite(viewDistance(a.T_w_c, b.T_w_c, kReach))) continue;
      const Pair pair{a.picture, b.picture, b.T_w_c.inverse() * a.T_w_c};
      if (overlap(pair)) possible.push_back(pair);
    }
    std::vector<Pair>& chosen = of_picture[static_cast<std::size_t>(i)];
    const std::size_t n = std::min(kPairsPerPicture, possible.size());
    for (std::size_t k = 0; k < n; ++k) chosen.push_back(possible[k * possible.size() / n]);
  });
  for (const std::vector<Pair>& pairs : of_picture) pairs_.insert(pairs_.end(), pairs.begin(), pairs.end());
}

PairEquations DistortionProblem::equationsOf(const Pair& pair) const {
  PairEquations e;
  const double information = 1 / (error_ * error_ * kCorrelatedPixels);
  const double field_variance = 2 * prior_std_.squaredNorm() / kNodes;
  forEachDifference(
      pair, kFineColumns,
      [&](const Eigen::Vector3d& ray, double inverse_depth, const Eigen::Vector3d& turned,
          const DepthDifference& d) {
        Vector6d J;
        J << (turned / inverse_depth).cross(d.by_point), d.by_point;
        const double largest2 =
            kGate * kGate * (error_ * error_ + field_variance + J.cwiseAbs2().dot(motion_variance_));
        const double residual2 = d.residual * d.residual;
        if (residual2 >= largest2) return;
        const double weight = information * std::pow(1 - residual2 / largest2, 2);  // Tukey's
        // The nodes about the pixel in a, which change the point, and those about its place in b.
        const double by_inverse_depth = -d.by_point.dot(turned) / (inverse_depth * inverse_depth);
        const auto in_a = field_.weights(ray.head<2>()), in_b = field_.weights({d.x, d.y});
        std::array<int, 8> node;
        std::array<double, 8> by_node;
        for (int k = 0; k < 4; ++k) {
          node[k] = in_a.node[k], by_node[k] = -by_inverse_depth * in_a.weight[k];
          node[k + 4] = in_b.node[k], by_node[k + 4] = in_b.weight[k];
        }
        for (int k = 0; k < 8; ++k) {
          for (int l = 0; l < 8; ++l) e.A(node[k], node[l]) += weight * by_node[k] * by_node[l];
          e.h[node[k]] += weight * by_node[k] * d.residual;
          e.coupling.col(node[k]) += weight * by_node[k] * J;
        }
        e.of_motion += weight * J * J.transpose();
        e.h_motion += weight * d.residual * J;
      });
  e.of_motion.diagonal() += motion_variance_.cwiseInverse();
  e.h_motion += pair.motion.cwiseQuotient(motion_variance_);
  return e;
}

void DistortionProblem::setPoseAccuracy(const PoseAccuracy& poses) {
  poses_ = {std::max(poses.rotation_std, kExact.rotation_std),
            std::max(poses.translation_std, kExact.translation_std)};
  motion_variance_ << Eigen::Vector3d::Constant(2 * poses_.rotation_std * poses_.rotation_std),
      Eigen::Vector3d::Constant(2 * poses_.translation_std * poses_.translation_std);
}

double DistortionProblem::improve(std::size_t share) {
  struct Motion {
    Vector6d alone;         // step if the field stays
    NodesByMotion by_node;  // and how the field changes it
    Vector6d variance;
  };
  struct FieldEquations {
    NodeMatrix A = NodeMatrix::Zero();
    NodeVector h = NodeVector::Zero();
  };
  const std::size_t used = (pairs_.size() + share - 1) / share;
  std::vector<Motion> motions(used);
  std::vector<FieldEquations> sums((used + kPairsAtOnce - 1) / kPairsAtOnce);
  forEachInParallel(static_cast<int>(sums.size()), threads_, [&](int block) {
    FieldEquations& sum = sums[static_cast<std::size_t>(block)];
    const std::size_t first = static_cast<std::size_t>(block) * kPairsAtOnce;
    for (std::size_t i = first; i < std::min(used, first + kPairsAtOnce); ++i) {
      const PairEquations e = equationsOf(pairs_[i * share]);
      const Eigen::LLT<Matrix6d> solver(e.of_motion);
      motions[i] = {solver.solve(e.h_motion), solver.solve(e.coupling),
                    solver.solve(Matrix6d::Identity()).diagonal()};
      sum.A += e.A - e.coupling.transpose() * motions[i].by_node;
      sum.h += e.h - e.coupling.transpose() * motions[i].alone;
    }
  });
  NodeVector values = Eigen::Map<const NodeVector>(field_.values().data());
  NodeMatrix A = prior_information_;
  NodeVector h = prior_information_ * values;
  for (const FieldEquations& sum : sums) A += sum.A, h += sum.h;
  const NodeVector step = -A.llt().solve(h);
  if (!step.allFinite()) return 0;
  values += step;
  DepthDistortion::Values nodes;
  std::copy(values.data(), values.data() + kNodes, nodes.begin());
  field_ = DepthDistortion(field_.extent(), nodes);
  Vector6d squares = Vector6d::Zero();
  for (std::size_t i = 0; i < used; ++i) {
    Pair& pair = pairs_[i * share];
    const Vector6d motion = -(motions[i].alone + motions[i].by_node * step);
    pair.motion += motion;
    pair.T_b_a = boxplus(pair.T_b_a, motion);
    squares += pair.motion.cwiseAbs2() + motions[i].variance;
  }
  const double n = 2 * 3 * static_cast<double>(used);  // two poses, three axes
  setPoseAccuracy({std::sqrt(squares.head<3>().sum() / n), std::sqrt(squares.tail<3>().sum() / n)});
  return std::sqrt(step.cwiseQuotient(prior_std_).squaredNorm() / kNodes);
}

}  // namespace

bool DistortionEstimate::reliable() const {
  return poses.rotation_std <= kGoodEnough.rotation_std &&
         poses.translation_std <= kGoodEnough.translation_std;
}

std::optional<DistortionEstimate> internal::calibrateDistortion(const std::vector<PosedPicture>& pictures,
                                                                const SensorNoise& noise,
                                                                const PoseAccuracy& poses, int threads) {
  std::vector<PosedPicture> used;
  for (const PosedPicture& p : pictures)
    if (!p.picture->empty()) used.push_back(p);
  if (used.empty()) return {};
  const Intrinsics& camera = used.front().picture->camera;
  if (camera.width < 2 || camera.height < 2) return {};  // no field on a line
  if (std::any_of(used.begin(), used.end(),
                  [&](const PosedPicture& p) { return p.picture->camera != camera; }))
    return {};
  DistortionProblem calibration(used, noise, poses, threads);
  if (calibration.empty()) return {};
  return calibration.solve();
}

}  // namespace facetloc
