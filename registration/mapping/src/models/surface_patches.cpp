// SPDX-License-Identifier: BSD-3-Clause
#include "models/surface_patches.h"

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
SurfacePatches::Patch patchOf(const DepthPicture& picture, int u, int v) {
  const auto stored = picture.inverse_depth[static_cast<std::size_t>(v) * picture.camera.width + u];
  if (stored == 0) return {};
  const double rho = DepthPicture::kQuantum * stored;
  const double noise = picture.noise.ofInverseDepth(1 / rho) + DepthPicture::kQuantum;
  Neighbours near = neighboursOf(picture, u, v, rho, noise);
  Eigen::Vector3d plane;
  if (near.size < kFewest || !fit(near, plane)) return {};
  const auto isOff = [&](const Neighbours::Pixel& p) {
    return std::abs(p.rho - plane.dot(Eigen::Vector3d(p.u, p.v, 1))) > kNoises * noise;
  };
  const auto end =
      std::remove_if(near.pixel.begin(), near.pixel.begin() + static_cast<std::ptrdiff_t>(near.size), isOff);
  near.size = static_cast<std::size_t>(end - near.pixel.begin());
  if (near.size < kFewest || !fit(near, plane) || isOff({0, 0, 0})) return {};
  const double value = rho + plane.z();
  const Eigen::Vector2d slope(plane.x() * picture.camera.fx, plane.y() * picture.camera.fy);
  if (value <= 0 || slope.norm() > kSteepest * value) return {};
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
  out.patch.resize(picture.inverse_depth.size());
  std::size_t at = 0;
  for (int v = 0; v < picture.camera.height; ++v)
    for (int u = 0; u < picture.camera.width; ++u, ++at) {
      if (!left_out.empty() && left_out[at]) continue;
      const SurfacePatches::Patch patch = patchOf(picture, u, v);
      const Eigen::Vector3d ray = picture.camera.ray(u, v);
      const double rho = Eigen::Vector3d(patch.m_x, patch.m_y, patch.m_z).dot(ray);
      if (rho <= 0) continue;
      out.patch[at] = patch;
      out.box.extend(out.T_w_c * Eigen::Vector3d(ray / rho));
    }
  return out;
}

}  // namespace facetloc::internal
