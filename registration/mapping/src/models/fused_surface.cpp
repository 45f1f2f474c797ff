// SPDX-License-Identifier: BSD-3-Clause
#include "models/fused_surface.h"

#include "depth/depth_consistency.h"
#include "nearby/view_alignment.h"
#include "threads/in_parallel.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

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
      const Eigen::Vector3d m = picture.at(u, v).cast<double>(), ray = picture.camera.ray(u, v);
      if (m.isZero(0)) continue;
      const Eigen::Vector3d p = T * Eigen::Vector3d(ray / m.dot(ray));
      if (p.z() <= 0) continue;
      const Eigen::Vector2d pixel = camera.project(p);
      shared += pixel.x() > 0 && pixel.y() > 0 && pixel.x() < camera.width && pixel.y() < camera.height;
    }
  return shared;
}

constexpr double kCell = 0.1;           // [m], as long as the grid is not too large
constexpr double kLargestCell = 0.5;    // [m]
constexpr double kMostCells = 1 << 27;  // one byte each
constexpr double kNoises = 3;

/** The nearest that a picture shows around a pixel [m]; 0 if it is unknown. */
double nearestAt(const DepthPicture& picture, int u, int v) {
  const auto highest = picture.extremes[static_cast<std::size_t>(v) * picture.camera.width + u].highest;
  return highest == 0 ? 0 : 1 / (DepthPicture::kQuantum * highest);
}

/** The space that a picture can show, up to a depth, in the world. */
Eigen::AlignedBox3d boxOf(const PosedPicture& posed, double depth) {
  Eigen::AlignedBox3d box(posed.T_w_c.translation());
  const Intrinsics& camera = posed.picture->camera;
  for (const double u : {-0.5, camera.width - 0.5})
    for (const double v : {-0.5, camera.height - 0.5})
      box.extend(posed.T_w_c * Eigen::Vector3d(depth * camera.ray(u, v)));
  return box;
}

double farthestOf(const DepthPicture& picture) {
  std::uint16_t least = 0;
  for (const std::uint16_t rho : picture.inverse_depth)
    if (rho != 0 && (least == 0 || rho < least)) least = rho;
  return least == 0 ? 0 : std::min(SeenSpace::kFarthest, 1 / (DepthPicture::kQuantum * least));
}

/** Throws std::invalid_argument for a space that no grid can hold. */
double cellFor(const Eigen::Vector3d& size) {
  for (double cell = kCell; cell < kLargestCell; cell *= 1.1)
    if (((size / cell).array().ceil() + 3).prod() <= kMostCells) return cell;
  throw std::invalid_argument(
      "the places of the map are too far apart for one surface; are all of its poses right?");
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

SeenSpace::SeenSpace(const std::vector<PosedPicture>& pictures) {
  Eigen::AlignedBox3d box;
  for (const PosedPicture& p : pictures) box.extend(boxOf(p, farthestOf(*p.picture)));
  if (box.isEmpty()) return;
  cell_ = cellFor(box.sizes());
  origin_ = box.min().array() - cell_;
  size_ = ((box.sizes() / cell_).array().ceil() + 3).cast<int>();
  cells_.assign(static_cast<std::size_t>(size_.x()) * size_.y() * size_.z(), 0);
  for (const PosedPicture& p : pictures) look(p);
  for (const PosedPicture& p : pictures) stand(p.T_w_c.translation());
}

std::uint8_t SeenSpace::at(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d p = (point - origin_) / cell_;
  if (!(p.minCoeff() >= 0) || !((p - size_.cast<double>()).maxCoeff() < 0)) return 0;
  const Eigen::Vector3i i = p.cast<int>();
  return cells_[(static_cast<std::size_t>(i.z()) * size_.y() + i.y()) * size_.x() + i.x()];
}

void SeenSpace::look(const PosedPicture& posed) {
  const DepthPicture& picture = *posed.picture;
  const double diagonal = std::sqrt(3.0) * cell_;
  const Eigen::AlignedBox3d box = boxOf(posed, farthestOf(picture));
  const Eigen::Vector3i first = ((box.min() - origin_) / cell_).cast<int>(),
                        last = ((box.max() - origin_) / cell_).cast<int>();
  const Eigen::Isometry3d T_c_w = posed.T_w_c.inverse();
  const Eigen::Vector3d step = T_c_w.linear().col(0) * cell_;
  for (int z = first.z(); z <= last.z(); ++z)
    for (int y = first.y(); y <= last.y(); ++y) {
      std::uint8_t* row = &cells_[(static_cast<std::size_t>(z) * size_.y() + y) * size_.x()];
      Eigen::Vector3d p = T_c_w * (origin_ + cell_ * Eigen::Vector3d(first.x() + 0.5, y + 0.5, z + 0.5));
      for (int x = first.x(); x <= last.x(); ++x, p += step) {
        if (p.z() <= 0 || p.z() > kFarthest) continue;
        const Eigen::Vector2d pixel = picture.camera.project(p);
        if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < picture.camera.width - 0.5 &&
              pixel.y() < picture.camera.height - 0.5))
          continue;
        const double nearest =
            nearestAt(picture, static_cast<int>(pixel.x() + 0.5), static_cast<int>(pixel.y() + 0.5));
        if (nearest == 0) continue;
        const double error = kNoises * picture.noise.ofDepth(nearest);
        if (p.z() <= nearest + diagonal + error) row[x] |= kKnown;
        if (p.z() + diagonal + error <= nearest) row[x] |= kFree;
      }
    }
}

// The camera was there, and its robot or person.
void SeenSpace::stand(const Eigen::Vector3d& point) {
  const int reach = 2;
  const Eigen::Vector3i middle = ((point - origin_) / cell_).cast<int>();
  for (int z = -reach; z <= reach; ++z)
    for (int y = -reach; y <= reach; ++y)
      for (int x = -reach; x <= reach; ++x) {
        const Eigen::Vector3i i = middle + Eigen::Vector3i(x, y, z);
        if (i.minCoeff() < 0 || (i - size_).maxCoeff() >= 0) continue;
        cells_[(static_cast<std::size_t>(i.z()) * size_.y() + i.y()) * size_.x() + i.x()] |= kKnown | kFree;
      }
}

bool SeenSpace::isFreeBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
  const int steps = static_cast<int>(std::ceil((b - a).norm() / cell_));
  for (int i = 0; i <= steps; ++i)
    if (!isFree(a + (b - a) * (steps > 0 ? double(i) / steps : 0))) return false;
  return true;
}

bool SeenSpace::isKnownBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
  const int steps = static_cast<int>((b - a).norm() / cell_);
  const Eigen::Vector3d step = (b - a).normalized() * cell_;
  bool was_known = true;
  for (int i = 0; i <= steps; ++i) {
    const bool is_known = isKnown(a + i * step);
    if (!is_known && !was_known) return false;
    was_known = is_known;
  }
  return true;
}

}  // namespace facetloc::internal
