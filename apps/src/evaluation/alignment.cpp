// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/alignment.h"

#include "shared/median.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

constexpr double kOnALine = 0.05;  // standard deviation of positions across a line that is none [m]
constexpr double kLever = 0.1;     // to the points that stand for orientations [m]
constexpr double kFarthest = 3;    // of the median distance
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
    throw std::invalid_argument("there are " + std::to_string(pairs.size()) +
                                " pairs of an estimated and a true pose, and an alignment needs " +
                                std::to_string(kLeastPairs));
}

}  // namespace

double distanceAfter(const Eigen::Isometry3d& T_true_estimated, const PosePair& pair) {
  return (T_true_estimated * pair.estimated.translation() - pair.truth.translation()).norm();
}

Alignment aligned(const std::vector<PosePair>& pairs) {
  require(pairs);
  std::vector<Eigen::Vector3d> points = {Eigen::Vector3d::Zero()};  // in the camera's frame
  if (areOnALine(pairs))
    for (int axis = 0; axis < 3; ++axis) points.emplace_back(kLever * Eigen::Vector3d::Unit(axis));
  const auto columns = static_cast<Eigen::Index>(pairs.size() * points.size());
  Eigen::Matrix3Xd estimated(3, columns), truth(3, columns);
  Eigen::Index column = 0;
  for (const PosePair& pair : pairs)
    for (const Eigen::Vector3d& point : points) {
      estimated.col(column) = pair.estimated * point;
      truth.col(column++) = pair.truth * point;
    }
  Alignment alignment;
  alignment.T_true_estimated = Eigen::Isometry3d(Eigen::umeyama(estimated, truth, false));
  alignment.used = pairs.size();
  for (const PosePair& pair : pairs) {
    const double distance = distanceAfter(alignment.T_true_estimated, pair);
    alignment.residual += distance * distance / static_cast<double>(pairs.size());
  }
  alignment.residual = std::sqrt(alignment.residual);
  return alignment;
}

Alignment robustlyAligned(const std::vector<PosePair>& pairs) {
  require(pairs);
  std::vector<PosePair> kept = pairs;
  std::vector<char> is_kept(pairs.size(), 1);
  for (int round = 0;; ++round) {
    const Alignment alignment = aligned(kept);
    std::vector<double> distances;
    for (const PosePair& pair : pairs) distances.push_back(distanceAfter(alignment.T_true_estimated, pair));
    const double farthest = std::max(kExact, kFarthest * internal::median(distances));
    std::vector<char> near;
    for (const double distance : distances) near.push_back(distance <= farthest);
    if (near == is_kept || round == kMostRounds) return alignment;
    is_kept = near;
    kept.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (is_kept[i]) kept.push_back(pairs[i]);
    if (kept.size() < kLeastPairs) return alignment;
  }
}

}  // namespace facetloc
