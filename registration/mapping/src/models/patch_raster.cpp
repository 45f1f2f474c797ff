// SPDX-License-Identifier: BSD-3-Clause
#include "models/patch_raster.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>

namespace facetloc::internal {
namespace {

constexpr int kRadius = 2;       // radius of the neighbourhood of a pixel [px]
constexpr int kFewest = 8;       // pixels of it that must lie on the plane
constexpr double kSteepest = 6;  // tangent of the angle at which a surface is looked at, 80 deg
constexpr double kNoises = 3;    // largest distance of a pixel from the plane [noise std]

constexpr float kHalf = 0.6F;     // size of a patch [px of its picture]: neighbours overlap
constexpr float kNearest = 0.1F;  // [m]
constexpr float kMagnified = 4;   // how often a pixel may be: more would be invented between samples
constexpr float kOneSurface = 3;  // largest difference of two pictures of one surface [std of the difference]

/** The neighbourhood of a pixel: inverse depths relative to it. */
struct Neighbours {
  struct Pixel {
    double u, v, rho;  // relative to the pixel in the middle
  };
  std::array<Pixel, (2 * kRadius + 1) * (2 * kRadius + 1)> pixel;
  std::size_t size = 0;
};

/** Those that a plane through the pixel can show, however it is inclined. */
Neighbours neighboursOf(const DepthPicture& picture, int u, int v, double rho, double noise) {
  Neighbours near;
  const int width = picture.camera.width;
  const double steepest = kSteepest * rho / picture.camera.fx;
  for (int y = std::max(0, v - kRadius); y <= std::min(picture.camera.height - 1, v + kRadius); ++y)
    for (int x = std::max(0, u - kRadius); x <= std::min(width - 1, u + kRadius); ++x) {
      const auto stored = picture.inverse_depth[static_cast<std::size_t>(y) * width + x];
      if (stored == 0) continue;
      const double difference = DepthPicture::kQuantum * stored - rho;
      const int distance = std::max(std::abs(x - u), std::abs(y - v));
      if (std::abs(difference) > kNoises * std::sqrt(2.0) * noise + steepest * distance) continue;
      near.pixel[near.size++] = {double(x - u), double(y - v), difference};
    }
  return near;
}

/** Slopes and offset of the plane through the neighbours; false if they do not define one. */
bool fit(const Neighbours& near, Eigen::Vector3d& plane) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < near.size; ++i) {
    const Eigen::Vector3d row(near.pixel[i].u, near.pixel[i].v, 1);
    A += row * row.transpose();
    b += row * near.pixel[i].rho;
  }
  if (A.determinant() < kFewest * kFewest) return false;
  plane = A.inverse() * b;
  return true;
}

/** The plane that most neighbours lie on; nothing known at an edge and at a lone pixel. */
Eigen::Vector3f patchOf(const DepthPicture& picture, int u, int v) {
  const auto stored = picture.inverse_depth[static_cast<std::size_t>(v) * picture.camera.width + u];
  if (stored == 0) return Eigen::Vector3f::Zero();
  const double rho = DepthPicture::kQuantum * stored;
  const double noise = picture.noise.ofInverseDepth(1 / rho) + DepthPicture::kQuantum;
  Neighbours near = neighboursOf(picture, u, v, rho, noise);
  Eigen::Vector3d plane;
  if (near.size < kFewest || !fit(near, plane)) return Eigen::Vector3f::Zero();
  const auto isOff = [&](const Neighbours::Pixel& p) {
    return std::abs(p.rho - plane.dot(Eigen::Vector3d(p.u, p.v, 1))) > kNoises * noise;
  };
  const auto end =
      std::remove_if(near.pixel.begin(), near.pixel.begin() + static_cast<std::ptrdiff_t>(near.size), isOff);
  near.size = static_cast<std::size_t>(end - near.pixel.begin());
  if (near.size < kFewest || !fit(near, plane) || isOff({0, 0, 0})) return Eigen::Vector3f::Zero();
  const double value = rho + plane.z();
  const Eigen::Vector2d slope(plane.x() * picture.camera.fx, plane.y() * picture.camera.fy);
  if (value <= 0 || slope.norm() > kSteepest * value) return Eigen::Vector3f::Zero();
  const Eigen::Vector3d ray = picture.camera.ray(u, v);
  return {static_cast<float>(slope.x()), static_cast<float>(slope.y()),
          static_cast<float>(value - slope.x() * ray.x() - slope.y() * ray.y())};
}

}  // namespace

SurfacePatches patchesOf(const PosedPicture& posed, const std::vector<char>& left_out) {
  const DepthPicture& picture = *posed.picture;
  SurfacePatches out;
  out.camera = picture.camera;
  out.T_w_c = posed.T_w_c;
  out.noise = picture.noise;
  out.patch.assign(picture.inverse_depth.size(), Eigen::Vector3f::Zero());
  std::size_t at = 0;
  for (int v = 0; v < picture.camera.height; ++v)
    for (int u = 0; u < picture.camera.width; ++u, ++at) {
      if (!left_out.empty() && left_out[at]) continue;
      const Eigen::Vector3f patch = patchOf(picture, u, v);
      const Eigen::Vector3d m = patch.cast<double>(), ray = picture.camera.ray(u, v);
      const double rho = m.dot(ray);
      if (rho <= 0) continue;
      out.patch[at] = patch;
      out.box.extend(out.T_w_c * Eigen::Vector3d(ray / rho));
    }
  return out;
}

double RenderedDepth::knownShare() const {
  const auto known = std::count_if(image.depth.begin(), image.depth.end(), isMeasured);
  return image.depth.empty() ? 0 : static_cast<double>(known) / static_cast<double>(image.depth.size());
}

/** \brief A patch in the image that is drawn. */
struct PatchRaster::Quad {
  std::array<Eigen::Vector2f, 4> corner;
  Eigen::Vector3f plane;  // inverse depth along a ray
  float error_share;      // standard deviation as a share of inverse depth and plane
  bool front;
};

PatchRaster::PatchRaster(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c)
    : camera_(camera), T_c_w_(T_w_c.inverse()) {}

void PatchRaster::draw(const SurfacePatches& picture, int step) {
  const Eigen::Isometry3f T = (T_c_w_ * picture.T_w_c).cast<float>();
  const auto fx = static_cast<float>(picture.camera.fx), fy = static_cast<float>(picture.camera.fy);
  const auto cx = static_cast<float>(picture.camera.cx), cy = static_cast<float>(picture.camera.cy);
  const float half = kHalf * static_cast<float>(step);
  const float largest = kMagnified * 2 * half * static_cast<float>(camera_.fx / picture.camera.fx);
  Quad quad;
  for (int v = step / 2; v < picture.camera.height; v += step)
    for (int u = step / 2; u < picture.camera.width; u += step) {
      const Eigen::Vector3f& m = picture.at(u, v);
      if (m.isZero(0)) continue;
      const Eigen::Vector3f turned = T.linear() * m;
      const float side = 1 + turned.dot(T.translation());
      if (std::abs(side) < 1e-3F) continue;  // the camera is in the plane
      quad.plane = turned / side;
      quad.front = side > 0;
      bool is_ahead = true;
      for (int k = 0; k < 4 && is_ahead; ++k) {
        const float du = k == 0 || k == 3 ? -half : half, dv = k < 2 ? -half : half;
        const Eigen::Vector3f ray((u + du - cx) / fx, (v + dv - cy) / fy, 1);
        const float rho = m.dot(ray);
        const Eigen::Vector3f p =
            rho > 0 ? Eigen::Vector3f(T * Eigen::Vector3f(ray / rho)) : Eigen::Vector3f::Zero();
        is_ahead = p.z() > kNearest;
        if (is_ahead)
          quad.corner[k] = {static_cast<float>(camera_.fx) * p.x() / p.z() + static_cast<float>(camera_.cx),
                            static_cast<float>(camera_.fy) * p.y() / p.z() + static_cast<float>(camera_.cy)};
      }
      if (!is_ahead) continue;
      const float rho = m.dot(Eigen::Vector3f((u - cx) / fx, (v - cy) / fy, 1));
      const auto noise = static_cast<float>(picture.noise.ofInverseDepth(1 / rho));
      quad.error_share = noise / rho * quad.plane.norm() / m.norm();
      fill(quad, largest);
    }
}

void PatchRaster::fill(const Quad& quad, float largest) {
  Eigen::Array2f least = quad.corner[0], most = quad.corner[0];
  for (const Eigen::Vector2f& c : quad.corner) least = least.min(c.array()), most = most.max(c.array());
  if ((most - least).maxCoeff() > largest) return;
  const int u0 = std::max(0, static_cast<int>(std::ceil(least.x()))),
            u1 = std::min(camera_.width - 1, static_cast<int>(std::floor(most.x()))),
            v0 = std::max(0, static_cast<int>(std::ceil(least.y()))),
            v1 = std::min(camera_.height - 1, static_cast<int>(std::floor(most.y())));
  for (int v = v0; v <= v1; ++v)
    for (int u = u0; u <= u1; ++u) {
      int inside = 0;
      for (int k = 0; k < 4; ++k) {
        const Eigen::Vector2f &a = quad.corner[k], &b = quad.corner[(k + 1) % 4];
        inside += (b.x() - a.x()) * (v - a.y()) - (b.y() - a.y()) * (u - a.x()) >= 0 ? 1 : -1;
      }
      if (std::abs(inside) != 4) continue;
      const float rho = quad.plane.dot(camera_.ray(u, v).cast<float>());
      if (rho <= 0) continue;
      fragments_.push_back({static_cast<std::uint32_t>(v * camera_.width + u), rho,
                            std::max(1e-6F, quad.error_share * rho), quad.front});
    }
}

RenderedDepth PatchRaster::resolve() const {
  RenderedDepth out;
  out.image.camera = camera_;
  out.image.depth.assign(static_cast<std::size_t>(camera_.width) * camera_.height, 0);
  std::vector<std::uint32_t> end(out.image.depth.size() + 1, 0);
  for (const Fragment& f : fragments_) ++end[f.pixel + 1];
  for (std::size_t i = 1; i < end.size(); ++i) end[i] += end[i - 1];
  std::vector<Fragment> sorted(fragments_.size());
  std::vector<std::uint32_t> next(end.begin(), end.end() - 1);
  for (const Fragment& f : fragments_) sorted[next[f.pixel]++] = f;
  double squares = 0, differences = 0;
  for (std::size_t pixel = 0; pixel < out.image.depth.size(); ++pixel) {
    const auto first = sorted.begin() + end[pixel], last = sorted.begin() + end[pixel + 1];
    if (first == last) continue;
    std::sort(first, last, [](const Fragment& a, const Fragment& b) { return a.rho > b.rho; });
    double weights = 0, sum = 0, sum_of_squares = 0, front = 0;
    int n = 0;
    for (auto f = first; f != last; ++f) {
      const double apart = first->rho - f->rho, error = std::hypot(first->error, f->error);
      if (apart > kOneSurface * error) break;
      const double weight = 1.0 / (double(f->error) * f->error);
      weights += weight;
      if (f->front) front += weight;
      sum += weight * f->rho, sum_of_squares += weight * f->rho * f->rho;
      ++n;
    }
    if (2 * front < weights) continue;  // it is seen from behind
    const double rho = sum / weights;
    squares += std::max(0.0, sum_of_squares - rho * sum);
    differences += n - 1;
    out.image.depth[pixel] = static_cast<float>(1 / rho);
  }
  out.disagreement = differences > 0 ? std::sqrt(squares / differences) : 0;
  return out;
}

}  // namespace facetloc::internal
