// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/alignment.h"

#include "base/median.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr double kOnALine = 0.05;  // largest standard deviation of positions across their line [m]
constexpr double kLever = 0.1;     // weight of orientations beside positions on a line [m]
constexpr double kFarthest = 3;    // times the median distance
constexpr double kExact = 1e-6;    // [m] closer pairs agree, whatever the median is
constexpr int kMostRounds = 50;

bool areOnALine(const std::vector<PosePair>& pairs) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) mean += pair.truth.translation() / static_cast<double>(pairs.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    const Eigen::Vector3d d = pair.truth.translation() - mean;
    scatter += d * d.transpose() / static_cast<double>(pairs.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter, Eigen::EigenvaluesOnly);
  return axes.eigenvalues()[1] < kOnALine * kOnALine;
}

void require(const std::vector<PosePair>& pairs) {
  if (pairs.size() < kLeastPairs)
    throw std::invalid_argument(
        fmt::format("there are {} pairs of an estimated and a true pose, and an alignment needs {}",
                    pairs.size(), kLeastPairs));
}

// The rotation R that maximises trace(R^T M).
Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs[2] = svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1 : 1;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

// The minimum of the sum in robustlyAligned(): R maximises the trace of R^T with the covariance of the
// centred positions and the sum of the relative rotations.
Eigen::Isometry3d fitted(const std::vector<PosePair>& pairs, double lever) {
  const auto n = static_cast<double>(pairs.size());
  Eigen::Vector3d estimated = Eigen::Vector3d::Zero(), truth = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    estimated += pair.estimated.translation() / n;
    truth += pair.truth.translation() / n;
  }
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    M += (pair.truth.translation() - truth) * (pair.estimated.translation() - estimated).transpose();
    M += lever * lever / 2 * pair.truth.linear() * pair.estimated.linear().transpose();
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = nearestRotation(M);
  T.translation() = truth - T.linear() * estimated;
  return T;
}

}  // namespace

Alignment withResiduals(const Eigen::Isometry3d& T_true_estimated, const std::vector<PosePair>& pairs) {
  const auto rms = [&](double (*error)(const Eigen::Isometry3d&, const PosePair&)) {
    double sum = 0;
    for (const PosePair& pair : pairs) sum += std::pow(error(T_true_estimated, pair), 2);
    return std::sqrt(sum / static_cast<double>(pairs.size()));
  };
  return {T_true_estimated, pairs.size(), rms(distanceAfter), rms(angleAfter) / kDegree};
}

double distanceAfter(const Eigen::Isometry3d& T_true_estimated, const PosePair& pair) {
  return (T_true_estimated * pair.estimated.translation() - pair.truth.translation()).norm();
}

double angleAfter(const Eigen::Isometry3d& T_true_estimated, const PosePair& pair) {
  return rotationAngle(pair.truth.linear().transpose() * T_true_estimated.linear() * pair.estimated.linear());
}

Alignment aligned(const std::vector<PosePair>& pairs) {
  require(pairs);
  return withResiduals(fitted(pairs, areOnALine(pairs) ? kLever : 0), pairs);
}

Alignment robustlyAligned(const std::vector<PosePair>& pairs, double lever) {
  require(pairs);
  std::vector<PosePair> kept = pairs;
  std::vector<char> is_kept(pairs.size(), 1);
  for (int round = 0;; ++round) {
    const Alignment found = withResiduals(fitted(kept, lever), kept);
    std::vector<double> distances;
    for (const PosePair& pair : pairs)
      distances.push_back(std::hypot(distanceAfter(found.T_true_estimated, pair),
                                     lever * angleAfter(found.T_true_estimated, pair)));
    const double farthest = std::max(kExact, kFarthest * internal::median(distances));
    std::vector<char> near;
    for (const double distance : distances) near.push_back(distance <= farthest);
    if (near == is_kept || round == kMostRounds) return found;
    is_kept = near;
    kept.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (is_kept[i]) kept.push_back(pairs[i]);
    if (kept.size() < kLeastPairs) return found;
  }
}

}  // namespace facetloc
