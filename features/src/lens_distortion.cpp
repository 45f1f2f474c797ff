// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/lens_distortion.h>

#include <Eigen/LU>

#include <cmath>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr double kFarthestRay = 10;  // 84 deg from the axis
constexpr double kOfOneSurface =
    0.01;  // share of inverse depth: how far three pixels in a row may be off a line

/** Radial factor. */
double scaleAt(const LensDistortion& lens, double r2) {
  return (1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))) /
         (1 + r2 * (lens.k4 + r2 * (lens.k5 + r2 * lens.k6)));
}

/** Change from pixel to pixel along a row or a column; 0 unless all three are on one surface. */
float slopeAt(float before, float here, float after) {
  if (before <= 0 || after <= 0) return 0;
  if (std::abs(before - 2 * here + after) > static_cast<float>(kOfOneSurface) * here) return 0;
  return (after - before) / 2;
}

}  // namespace

bool LensDistortion::isNone() const { return *this == LensDistortion(); }

bool LensDistortion::operator==(const LensDistortion& o) const {
  return k1 == o.k1 && k2 == o.k2 && k3 == o.k3 && k4 == o.k4 && k5 == o.k5 && k6 == o.k6 && p1 == o.p1 &&
         p2 == o.p2;
}

Eigen::Vector2d LensDistortion::distorted(const Eigen::Vector2d& ray) const {
  const double x = ray.x(), y = ray.y(), r2 = ray.squaredNorm();
  const Eigen::Vector2d tangential(2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                                   p1 * (r2 + 2 * y * y) + 2 * p2 * x * y);
  return scaleAt(*this, r2) * ray + tangential;
}

double LensDistortion::largestRadius() const {
  constexpr double kStep = 1e-3;
  double seen = 0;
  for (double r = kStep; r < kFarthestRay; r += kStep) {
    const double next = r * scaleAt(*this, r * r);
    if (!(next > seen) || !(next < kFarthestRay * kFarthestRay)) return r - kStep;
    seen = next;
  }
  return kFarthestRay;
}

std::optional<Eigen::Vector2d> LensDistortion::undistorted(const Eigen::Vector2d& seen) const {
  constexpr int kSteps = 50;
  constexpr double kDifference = 1e-6, kEnough = 1e-9, kLongest = 0.2;
  Eigen::Vector2d ray = seen;
  for (int i = 0; i < kSteps; ++i) {
    const Eigen::Vector2d error = distorted(ray) - seen;
    if (!error.allFinite()) return {};
    if (error.norm() < kEnough) {
      if (ray.norm() > largestRadius()) return {};
      return ray;
    }
    Eigen::Matrix2d J;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d h = kDifference * Eigen::Vector2d::Unit(k);
      J.col(k) = (distorted(ray + h) - distorted(ray - h)) / (2 * kDifference);
    }
    Eigen::Vector2d step = J.inverse() * error;
    if (!step.allFinite()) return {};
    if (step.norm() > kLongest) step *= kLongest / step.norm();
    ray -= step;
  }
  return {};
}

LensCorrection::LensCorrection(const Intrinsics& camera, const LensDistortion& lens, DepthKind kind)
    : camera_(camera) {
  if (!camera.valid()) throw std::invalid_argument("LensCorrection: the camera is impossible");
  const std::size_t n = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  const auto forEachPixel = [&camera](const auto& use) {
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u) use(u, v);
  };
  if (kind == DepthKind::distance) {
    inverse_factor_.reserve(n);
    forEachPixel([&](int u, int v) {
      const std::optional<Eigen::Vector2d> ray =
          lens.isNone() ? camera.ray(u, v).head<2>() : lens.undistorted(camera.ray(u, v).head<2>());
      inverse_factor_.push_back(ray ? static_cast<float>(std::sqrt(1 + ray->squaredNorm())) : 0.f);
    });
  }
  if (lens.isNone()) return;
  const double largest = lens.largestRadius();
  sources_.reserve(n);
  forEachPixel([&](int u, int v) {
    Source source;
    const Eigen::Vector2d ray = camera.ray(u, v).head<2>(), seen = lens.distorted(ray);
    const double x = camera.fx * seen.x() + camera.cx, y = camera.fy * seen.y() + camera.cy;
    const double column = std::round(x), row = std::round(y);
    if (ray.norm() <= largest && column >= 0 && row >= 0 && column < camera.width && row < camera.height) {
      source.pixel = static_cast<std::int32_t>(row) * camera.width + static_cast<std::int32_t>(column);
      source.du = static_cast<float>(x - column), source.dv = static_cast<float>(y - row);
    }
    sources_.push_back(source);
  });
}

std::vector<float> LensCorrection::inverseDepths(const DepthImage& image) const {
  std::vector<float> inverse(image.depth.size());
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    inverse[i] = isMeasured(image.depth[i]) ? 1 / image.depth[i] : 0;
    if (!inverse_factor_.empty()) inverse[i] *= inverse_factor_[i];
  }
  return inverse;
}

DepthImage LensCorrection::operator()(const DepthImage& image) const {
  const std::size_t n = static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height);
  if (image.camera.width != camera_.width || image.camera.height != camera_.height || image.depth.size() != n)
    return {};
  const std::vector<float> inverse = inverseDepths(image);
  DepthImage out{camera_, std::vector<float>(n, 0.f)};
  const auto width = static_cast<std::size_t>(camera_.width);
  for (std::size_t i = 0; i < n; ++i) {
    if (sources_.empty()) {
      if (inverse[i] > 0) out.depth[i] = 1 / inverse[i];
      continue;
    }
    const Source& source = sources_[i];
    if (source.pixel < 0) continue;
    const auto at = static_cast<std::size_t>(source.pixel);
    float value = inverse[at];
    if (value <= 0) continue;
    if (at % width > 0 && at % width + 1 < width)
      value += source.du * slopeAt(inverse[at - 1], inverse[at], inverse[at + 1]);
    if (at >= width && at + width < n)
      value += source.dv * slopeAt(inverse[at - width], inverse[at], inverse[at + width]);
    if (value > 0) out.depth[i] = 1 / value;
  }
  return out;
}

}  // namespace facetloc
