// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/segmentation/plane_segmenter.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace facetloc {
PlaneSegmenter::PlaneSegmenter(const SegmentationParams& params, const SensorNoise& noise)
    : params_(params), noise_(noise), split_(params.split), merge_(params.merge) {}

void PlaneSegmenter::segment(const DepthImage& image, LabelledPlanes& out) {
  out.camera = image.camera;
  out.planes.clear();
  out.support.clear();
  out.labels.width = image.camera.width;
  out.labels.height = image.camera.height;
  out.labels.label.assign(image.depth.size(), 0);
  out.noise = noise_.inverse_depth_std;
  if (!image.valid()) return;
  if (params_.estimate_noise) out.noise = std::max(out.noise, estimateNoise(image));

  toDisparity(image, out.noise, disparity_);
  split_.compute(disparity_);
  merge_.compute(split_, disparity_);
  label(out);
  reassignBoundaries(out.labels);
  keepLargeRegions(out, std::max(3.0, scaledPixels(params_.min_support, image.camera)));
  for (PixelPlane& p : out.planes) p = {p.a * out.noise, p.b * out.noise, p.c * out.noise};
}

// Provisional labels: every pixel of a region that lies near its plane. Specks are left for their neighbours
// to take.
void PlaneSegmenter::label(LabelledPlanes& out) {
  constexpr double kSpeck =
      0.3;  // share of the minimum support below which a region gets no label of its own
  const double min_region = std::max(3.0, kSpeck * scaledPixels(params_.min_support, disparity_.camera));
  region_planes_.assign(1, {});
  std::vector<std::uint16_t> label_of_region(merge_.regions().size(), 0);
  for (std::size_t r = 0; r < merge_.regions().size() && region_planes_.size() < 65535; ++r) {
    if (merge_.regions()[r].moments.n < min_region) continue;
    label_of_region[r] = static_cast<std::uint16_t>(region_planes_.size());
    region_planes_.push_back(merge_.regions()[r].plane);
  }
  const float tolerance = static_cast<float>(params_.label_tolerance);
  for (std::size_t t = 0; t < split_.triangles().size(); ++t) {
    const int r = merge_.regionOfTriangle()[t];
    if (r < 0 || label_of_region[r] == 0) continue;
    const PixelPlane& plane = region_planes_[label_of_region[r]];
    split_.spans(split_.triangles()[t], spans_);
    for (const DepthTriangulation::Span& s : spans_) {
      const std::size_t base = static_cast<std::size_t>(s.v) * disparity_.camera.width;
      for (int u = s.first; u <= s.last; ++u) {
        const float d = disparity_.d[base + u];
        if (d > 0 && std::fabs(d - static_cast<float>(plane.at(u, s.v))) <= tolerance)
          out.labels.label[base + u] = label_of_region[r];
      }
    }
  }
}

// Triangles follow the outlines only roughly. Breadth first from all borders, a pixel goes to the
// neighbouring region whose plane it fits better (METHOD 3.2 (ii)).
void PlaneSegmenter::reassignBoundaries(LabelImage& labels) {
  const int w = labels.width, h = labels.height;
  std::vector<std::uint16_t>& label = labels.label;
  const auto residual = [&](std::int32_t i, std::uint16_t k) {
    return std::fabs(disparity_.d[i] - static_cast<float>(region_planes_[k].at(i % w, i / w)));
  };
  const auto forEachNeighbour = [w, h](std::int32_t i, auto f) {
    const int u = i % w, v = i / w;
    if (u > 0) f(i - 1);
    if (u + 1 < w) f(i + 1);
    if (v > 0) f(i - w);
    if (v + 1 < h) f(i + w);
  };
  front_.clear();
  for (std::int32_t i = 0; i < w * h; ++i) {
    if (label[i] == 0) continue;
    const int u = i % w, v = i / w;
    const bool border = (u > 0 && label[i - 1] != label[i]) || (u + 1 < w && label[i + 1] != label[i]) ||
                        (v > 0 && label[i - w] != label[i]) || (v + 1 < h && label[i + w] != label[i]);
    if (border) front_.push_back(i);
  }
  const float tolerance = static_cast<float>(params_.label_tolerance);
  for (std::size_t f = 0; f < front_.size(); ++f) {
    const std::uint16_t k = label[front_[f]];
    forEachNeighbour(front_[f], [&](std::int32_t j) {
      if (label[j] == k || !(disparity_.d[j] > 0)) return;
      const float r = residual(j, k);
      if (r > tolerance || (label[j] != 0 && residual(j, label[j]) <= r)) return;
      label[j] = k;
      front_.push_back(j);
    });
  }
}

// Final labels: regions of enough support, the largest first, ties by provisional label.
void PlaneSegmenter::keepLargeRegions(LabelledPlanes& out, double min_support) {
  std::vector<int> support(region_planes_.size(), 0);
  for (const std::uint16_t k : out.labels.label) ++support[k];
  std::vector<std::uint16_t> order(region_planes_.size() - 1);
  std::iota(order.begin(), order.end(), std::uint16_t{1});
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return support[a] > support[b]; });
  std::vector<std::uint16_t> final_label(region_planes_.size(), 0);
  for (const std::uint16_t k : order) {
    if (support[k] < min_support) break;
    out.planes.push_back(region_planes_[k]);
    out.support.push_back(support[k]);
    final_label[k] = static_cast<std::uint16_t>(out.planes.size());
  }
  for (std::uint16_t& k : out.labels.label) k = final_label[k];
}

}  // namespace facetloc
