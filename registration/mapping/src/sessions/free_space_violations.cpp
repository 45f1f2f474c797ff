// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/free_space_violations.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr double kThick = 0.03;       // thickness of a segment, beyond its pixels' noise [m]
constexpr double kNoises = 3;         // largest distance of a pixel from its segment, in standard deviations
constexpr float kHullMargin = 0.02F;  // [m]
constexpr int kFewestPixels = 12;     // known pixels of a segment in the depth picture
constexpr double kLeastJudged = 0.2;  // share of a segment's pixels that must say anything
constexpr double kMostOfSegment = 0.25;  // share of these by which it is not the surface that it was
constexpr int kNone = -1;

/** The segment that each pixel of a view's depth picture belongs to; kNone for others. */
std::vector<int> segmentsOfPixels(const View& view) {
  const DepthPicture& picture = view.depth;
  std::vector<int> out(picture.inverse_depth.size(), kNone);
  std::size_t at = 0;
  for (int v = 0; v < picture.camera.height; ++v)
    for (int u = 0; u < picture.camera.width; ++u, ++at) {
      if (picture.inverse_depth[at] == 0) continue;
      const double rho = DepthPicture::kQuantum * picture.inverse_depth[at];
      const Eigen::Vector3d p = picture.camera.ray(u, v) / rho;
      double least = kThick + kNoises * picture.noise.ofInverseDepth(1 / rho) / (rho * rho);
      for (std::size_t i = 0; i < view.segments.size(); ++i) {
        const Segment& s = view.segments[i];
        const Eigen::Vector3d in_plane = s.R.transpose() * (p - s.t);
        if (std::abs(in_plane.z()) >= least ||
            !s.hull.contains(in_plane.head<2>().cast<float>(), kHullMargin))
          continue;
        least = std::abs(in_plane.z());
        out[at] = static_cast<int>(i);
      }
    }
  return out;
}

struct Count {
  int pixels = 0, judged = 0;
  std::vector<std::size_t> gone;
};

}  // namespace

SurfaceReview reviewSurfaces(const View& model, const std::vector<PosedPicture>& others,
                             const DepthComparison& comparison, int looks) {
  SurfaceReview review;
  const DepthPicture& picture = model.depth;
  review.gone.assign(picture.inverse_depth.size(), 0);
  if (picture.empty()) return review;
  const auto width = static_cast<std::size_t>(picture.camera.width);
  std::vector<int> through(review.gone.size(), 0), agree(review.gone.size(), 0);
  DepthLabels verdicts;
  for (const PosedPicture& other : others) {
    if (other.picture->empty()) continue;
    const DepthComparator judge(comparison, picture, *other.picture, other.T_w_c.inverse());
    for (int v = 0; v < picture.camera.height; ++v) {
      judge.row(v, 1, verdicts);
      for (std::size_t u = 0; u < width; ++u) {
        through[v * width + u] += verdicts[u] == DepthLabel::contradict;
        agree[v * width + u] += verdicts[u] == DepthLabel::agree;
      }
    }
  }

  const std::vector<int> segment_of = segmentsOfPixels(model);
  std::vector<Count> counts(model.segments.size());
  for (std::size_t i = 0; i < review.gone.size(); ++i) {
    if (picture.inverse_depth[i] == 0) continue;
    const bool judged = agree[i] > 0 || through[i] >= looks;
    const bool gone = through[i] >= looks && through[i] > agree[i];
    review.judged += judged;
    review.gone_pixels += gone;
    review.gone[i] = gone;
    if (segment_of[i] == kNone) continue;
    Count& count = counts[segment_of[i]];
    ++count.pixels, count.judged += judged;
    if (gone) count.gone.push_back(i);
  }
  std::vector<char> is_gone(counts.size(), 0);
  for (std::size_t k = 0; k < counts.size(); ++k) {
    Count& c = counts[k];
    if (c.judged < std::max<double>(kFewestPixels, kLeastJudged * c.pixels)) continue;
    ++review.judged_segments;
    is_gone[k] = static_cast<double>(c.gone.size()) > kMostOfSegment * c.judged;
    if (!is_gone[k]) continue;
    review.gone_segments.push_back(static_cast<int>(k));
    review.gone_pixels_of.push_back(std::move(c.gone));
  }
  for (std::size_t i = 0; i < review.gone.size(); ++i)
    if (segment_of[i] != kNone) review.gone[i] = is_gone[segment_of[i]];
  return review;
}

std::vector<std::optional<double>> sharesLookedThrough(const DepthPicture& picture,
                                                       const std::vector<std::size_t>& pixels,
                                                       const std::vector<PosedPicture>& others,
                                                       const DepthComparison& comparison) {
  std::vector<std::optional<double>> shares(others.size());
  const auto width = static_cast<std::size_t>(picture.camera.width);
  for (std::size_t k = 0; k < others.size(); ++k) {
    if (others[k].picture->empty()) continue;
    const DepthComparator judge(comparison, picture, *others[k].picture, others[k].T_w_c.inverse());
    int through = 0, agree = 0;
    for (const std::size_t i : pixels) {
      const DepthLabel label = judge(static_cast<int>(i % width), static_cast<int>(i / width));
      through += label == DepthLabel::contradict, agree += label == DepthLabel::agree;
    }
    if (through + agree > 0) shares[k] = through / double(through + agree);
  }
  return shares;
}

View withoutGone(const View& model, const SurfaceReview& review) {
  View out = model;
  out.segments.clear();
  for (std::size_t k = 0; k < model.segments.size(); ++k)
    if (!std::binary_search(review.gone_segments.begin(), review.gone_segments.end(), static_cast<int>(k)))
      out.segments.push_back(model.segments[k]);
  if (model.depth.empty()) return out;
  std::vector<std::uint16_t> left = model.depth.inverse_depth;
  for (std::size_t i = 0; i < left.size(); ++i)
    if (review.gone[i]) left[i] = 0;
  out.depth = DepthPicture::fromStored(model.depth.camera, std::move(left));
  out.depth.noise = model.depth.noise;
  return out;
}

}  // namespace facetloc::internal
