// SPDX-License-Identifier: BSD-3-Clause
#include "base/lanes.h"

#include <facetloc/features/depth_distortion.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace facetloc {

using namespace internal;
namespace {

constexpr double kSameOptics = 0.02;  // largest difference at a border of the image [normalised ray]

/** \param error measured minus true inverse depth of each pixel [1/m] */
FACETLOC_MULTIVERSION void correct(const float* depth, const float* error, std::size_t n, float* out) {
  for (std::size_t i = 0; i < n; i += kLanes) {
    Floats z, e;
    load(depth + i, depth + n, z);
    load(error + i, error + n, e);
    const Floats true_z = z / (1.f - z * e);
    const Ints known = (z >= kNearestMeasured) & (z <= kFarthestMeasured) & (z * e < 1.f);
    store(known ? true_z : Floats{}, out + i, out + n);
  }
}

}  // namespace

Eigen::AlignedBox2d DepthDistortion::extentOf(const Intrinsics& camera) {
  return {camera.ray(0, 0).head<2>(), camera.ray(camera.width - 1, camera.height - 1).head<2>()};
}

DepthDistortion::DepthDistortion(const Eigen::AlignedBox2d& extent, const Values& values)
    : extent_(extent), values_(values) {
  const bool finite = std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
  if (!finite || !extent.min().allFinite() || !extent.max().allFinite() || !(extent.sizes().minCoeff() > 0))
    throw std::invalid_argument("DepthDistortion: a grid over nothing, or values that are no numbers");
}

Eigen::Vector2d DepthDistortion::rayOf(int node) const {
  const Eigen::Vector2d share(double(node % kColumns) / (kColumns - 1),
                              double(node / kColumns) / (kRows - 1));
  const Eigen::Vector2d rest = Eigen::Vector2d::Ones() - share;  // exact at both ends
  return rest.cwiseProduct(extent_.min()) + share.cwiseProduct(extent_.max());
}

DepthDistortion::Weights DepthDistortion::weights(const Eigen::Vector2d& ray) const {
  const Eigen::Vector2d share = (ray - extent_.min()).cwiseQuotient(extent_.sizes());
  const double x = std::clamp(share.x(), 0.0, 1.0) * (kColumns - 1);
  const double y = std::clamp(share.y(), 0.0, 1.0) * (kRows - 1);
  const int column = std::min(static_cast<int>(x), kColumns - 2);
  const int row = std::min(static_cast<int>(y), kRows - 2);
  const double right = x - column, down = y - row;
  const int first = row * kColumns + column;
  return {{first, first + 1, first + kColumns, first + kColumns + 1},
          {(1 - right) * (1 - down), right * (1 - down), (1 - right) * down, right * down}};
}

double DepthDistortion::at(const Eigen::Vector2d& ray) const {
  const Weights w = weights(ray);
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += w.weight[k] * values_[w.node[k]];
  return sum;
}

double DepthDistortion::rms() const {
  return Eigen::Map<const Eigen::Matrix<double, kNodes, 1>>(values_.data()).norm() /
         std::sqrt(double(kNodes));
}

bool DepthDistortion::fits(const Intrinsics& camera) const {
  if (!camera.valid()) return false;
  const Eigen::AlignedBox2d its = extentOf(camera);
  return (its.min() - extent_.min()).cwiseAbs().maxCoeff() < kSameOptics &&
         (its.max() - extent_.max()).cwiseAbs().maxCoeff() < kSameOptics;
}

const DepthImage& DepthCorrection::operator()(const DepthImage& image) {
  const Intrinsics& camera = image.camera;
  if (!image.valid() || !distortion_.fits(camera)) return image;
  if (error_.empty() || camera != corrected_.camera) {
    error_.clear();
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u)
        error_.push_back(static_cast<float>(distortion_.at(camera.ray(u, v).head<2>())));
    corrected_ = image;
  }
  correct(image.depth.data(), error_.data(), error_.size(), corrected_.depth.data());
  return corrected_;
}

}  // namespace facetloc
