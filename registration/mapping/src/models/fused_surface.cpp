// SPDX-License-Identifier: BSD-3-Clause
#include "models/fused_surface.h"

#include "depth/depth_consistency.h"
#include "nearby/view_alignment.h"
#include "threads/in_parallel.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace facetloc::internal {
namespace {

constexpr ViewReach kSameSurfaces{6, 100 * kDegree};  // reach of pictures that may show the same
constexpr std::size_t kMostSources = 24;              // pictures that an image is rendered of
constexpr int kSampleStep = 12;                       // spacing of the pixels by which these are chosen

/** Flags the pixels of a picture that more of the others look through than agree with. */
std::vector<char> contradicted(const std::vector<PosedPicture>& pictures, std::size_t i,
                               const DepthComparison& comparison) {
  const PosedPicture& own = pictures[i];
  const auto width = static_cast<std::size_t>(own.picture->camera.width);
  std::vector<int> votes(own.picture->inverse_depth.size(), 0);
  DepthLabels verdicts;
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    if (k == i || !std::isfinite(viewDistance(own.T_w_c, pictures[k].T_w_c, kSameSurfaces))) continue;
    const DepthComparator judge(comparison, *own.picture, *pictures[k].picture,
                                pictures[k].T_w_c.inverse() * own.T_w_c);
    for (int v = 0; v < own.picture->camera.height; ++v) {
      judge.row(v, 1, verdicts);
      for (std::size_t u = 0; u < width; ++u)
        votes[v * width + u] += (verdicts[u] == DepthLabel::contradict) - (verdicts[u] == DepthLabel::agree);
    }
  }
  std::vector<char> out(votes.size());
  std::transform(votes.begin(), votes.end(), out.begin(), [](int sum) { return sum > 0; });
  return out;
}

/** How many sampled pixels of a picture an image may show. */
int sharedPixels(const SurfacePatches& picture, const Intrinsics& camera, const Eigen::Isometry3d& T_c_w) {
  const Eigen::Isometry3d T = T_c_w * picture.T_w_c;
  int shared = 0;
  for (int v = kSampleStep / 2; v < picture.camera.height; v += kSampleStep)
    for (int u = kSampleStep / 2; u < picture.camera.width; u += kSampleStep) {
      const SurfacePatches::Patch& patch = picture.at(u, v);
      if (!patch.known()) continue;
      const Eigen::Vector3d ray = picture.camera.ray(u, v);
      const Eigen::Vector3d p =
          T * Eigen::Vector3d(ray / Eigen::Vector3d(patch.m_x, patch.m_y, patch.m_z).dot(ray));
      if (p.z() <= 0) continue;
      const Eigen::Vector2d pixel = camera.project(p);
      shared += pixel.x() > 0 && pixel.y() > 0 && pixel.x() < camera.width && pixel.y() < camera.height;
    }
  return shared;
}

}  // namespace

FusedSurface::FusedSurface(const std::vector<PosedPicture>& pictures, int threads)
    : pictures_(pictures.size()), space_(pictures) {
  const DepthComparison comparison{DepthCalibration()};
  std::vector<std::size_t> left_out(pictures.size()), pixels(pictures.size());
  forEachInParallel(static_cast<int>(pictures.size()), threads, [&](int i) {
    const std::vector<char> gone = contradicted(pictures, i, comparison);
    left_out[i] = static_cast<std::size_t>(std::count(gone.begin(), gone.end(), 1));
    pixels[i] =
        gone.size() - static_cast<std::size_t>(std::count(pictures[i].picture->inverse_depth.begin(),
                                                          pictures[i].picture->inverse_depth.end(), 0));
    pictures_[i] = patchesOf(pictures[i], gone);
  });
  for (const SurfacePatches& picture : pictures_)
    if (!picture.box.isEmpty()) bounds_.extend(picture.box);
  const double all = std::accumulate(pixels.begin(), pixels.end(), 0.0);
  if (all > 0) contradicted_ = std::accumulate(left_out.begin(), left_out.end(), 0.0) / all;
}

// The pictures that have most in common with an image.
std::vector<std::size_t> FusedSurface::sourcesFor(const Intrinsics& camera,
                                                  const Eigen::Isometry3d& T_w_c) const {
  const Eigen::Isometry3d T_c_w = T_w_c.inverse();
  std::vector<std::pair<int, std::size_t>> found;
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    if (pictures_[i].box.exteriorDistance(T_w_c.translation()) > SeenSpace::kFarthest) continue;
    if (const int shared = sharedPixels(pictures_[i], camera, T_c_w); shared > 0)
      found.emplace_back(-shared, i);
  }
  std::sort(found.begin(), found.end());
  found.resize(std::min(found.size(), kMostSources));
  std::vector<std::size_t> sources;
  for (const auto& source : found) sources.push_back(source.second);
  return sources;
}

RenderedDepth FusedSurface::renderWithErrors(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c,
                                             int step) const {
  PatchRaster raster(camera, T_w_c);
  for (const std::size_t i : sourcesFor(camera, T_w_c)) raster.draw(pictures_[i], step);
  RenderedDepth out = raster.resolve();
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      float& depth = out.image.depth[static_cast<std::size_t>(v) * camera.width + u];
      if (depth > 0 &&
          !space_.isKnownBetween(T_w_c.translation(), T_w_c * Eigen::Vector3d(depth * camera.ray(u, v))))
        depth = 0;
    }
  return out;
}

DepthImage FusedSurface::render(const Intrinsics& camera, const Eigen::Isometry3d& T_w_c) const {
  return renderWithErrors(camera, T_w_c).image;
}

}  // namespace facetloc::internal
