// SPDX-License-Identifier: BSD-3-Clause
#include "depth_triangulation.h"
#include "disparity_image.h"
#include "region_merging.h"
#include "relabel.h"
#include "shared/lanes.h"

#include <facetloc/segmentation/plane_segmenter.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace facetloc {

using namespace internal;
namespace {

// Labels the pixels in the rows that lie near a plane. \return how many.
FACETLOC_MULTIVERSION int labelPixels(const DisparityImage& image, TriangleRows rows, const PixelPlane& plane,
                                      float tolerance, std::uint16_t label, std::uint16_t* labels) {
  const float* const end = image.d.data() + image.d.size();
  const std::uint16_t* const labels_end = labels + image.d.size();
  const float slope = static_cast<float>(plane.a);
  const Shorts of_plane = Shorts{} + static_cast<std::int16_t>(label);
  Ints labelled{};
  for (; !rows.done(); rows.next()) {
    const std::size_t first = static_cast<std::size_t>(rows.v()) * image.camera.width + rows.first();
    const std::int32_t length = rows.last() - rows.first() + 1;
    const float start = static_cast<float>(plane.at(rows.first(), rows.v()));
    Floats offset = kLaneOffset;
    Ints rest = length - kLane;
    for (std::int32_t k = 0; k < length; k += kLanes) {
      Floats d;
      load(image.d.data() + first + k, end, d);
      const Floats e = d - (start + slope * offset);
      const Ints is_near = (d > 0) & (e <= tolerance) & (e >= -tolerance) & (rest > 0);
      const Shorts mask = __builtin_convertvector(is_near, Shorts);
      Shorts out;
      load(labels + first + k, labels_end, out);
      out = (out & ~mask) | (of_plane & mask);
      store(out, labels + first + k, labels_end);
      labelled -= is_near;
      offset += static_cast<float>(kLanes), rest -= kLanes;
    }
  }
  int sum = 0;
  for (int k = 0; k < kLanes; ++k) sum += labelled[k];
  return sum;
}

// Lists the columns of a row where a pixel has a label and one of its four neighbours has another.
// \return how many they are.
FACETLOC_MULTIVERSION int listBorders(const std::uint16_t* row, const std::uint16_t* above,
                                      const std::uint16_t* below, int width, std::int32_t* columns) {
  int n = 0;
  const auto look = [&](int u) {
    const std::uint16_t k = row[u], left = row[std::max(0, u - 1)], right = row[std::min(u + 1, width - 1)];
    columns[n] = u;
    n += (k != 0) & (((k ^ left) | (k ^ right) | (k ^ above[u]) | (k ^ below[u])) != 0);
  };
  int u = 0;
  for (; u < std::min(1, width); ++u) look(u);
  for (; u + kLanes < width; u += kLanes) {
    Shorts here, left, right, up, down;
    std::memcpy(&here, row + u, sizeof here);
    std::memcpy(&left, row + u - 1, sizeof left);
    std::memcpy(&right, row + u + 1, sizeof right);
    std::memcpy(&up, above + u, sizeof up);
    std::memcpy(&down, below + u, sizeof down);
    const Shorts differs = (here ^ left) | (here ^ right) | (here ^ up) | (here ^ down);
    const Shorts is_border = (here != 0) & (differs != 0);
    std::uint64_t any[2];
    std::memcpy(any, &is_border, sizeof any);
    if ((any[0] | any[1]) == 0) continue;
    for (int k = 0; k < kLanes; ++k) columns[n] = u + k, n -= is_border[k];
  }
  for (; u < width; ++u) look(u);
  return n;
}

}  // namespace

struct PlaneSegmenter::Impl {
  Impl(const SegmentationParams& params, const SensorNoise& noise)
      : params_(params), noise_(noise), split_(params.split), merge_(params.merge) {}

  void segment(const DepthImage& image, LabelledPlanes& out);

  struct Pixel {
    std::int32_t u, v;
  };
  void label(LabelledPlanes& out);
  void reassignBoundaries(LabelImage& labels);
  void keepLargeRegions(LabelledPlanes& out, double min_support);

  SegmentationParams params_;
  SensorNoise noise_;
  DisparityImage disparity_;
  DepthTriangulation split_;
  RegionMerging merge_;
  std::vector<PixelPlane> region_planes_;  // by provisional label, in units of the disparity image
  std::vector<int> support_;               // of it [px]
  std::vector<std::uint16_t> label_of_region_, order_;
  std::vector<std::int32_t> columns_;  // of a row, and room for one more
  std::vector<Pixel> front_;
  std::vector<float> scratch_;
};

PlaneSegmenter::PlaneSegmenter(const SegmentationParams& params, const SensorNoise& noise)
    : impl_(std::make_unique<Impl>(params, noise)) {}
PlaneSegmenter::PlaneSegmenter(const PlaneSegmenter& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
PlaneSegmenter& PlaneSegmenter::operator=(const PlaneSegmenter& other) {
  impl_ = std::make_unique<Impl>(*other.impl_);
  return *this;
}
PlaneSegmenter::PlaneSegmenter(PlaneSegmenter&&) noexcept = default;
PlaneSegmenter& PlaneSegmenter::operator=(PlaneSegmenter&&) noexcept = default;
PlaneSegmenter::~PlaneSegmenter() = default;

void PlaneSegmenter::segment(const DepthImage& image, LabelledPlanes& out) { impl_->segment(image, out); }

void PlaneSegmenter::Impl::segment(const DepthImage& image, LabelledPlanes& out) {
  out.camera = image.camera;
  out.planes.clear();
  out.support.clear();
  out.labels.width = image.camera.width;
  out.labels.height = image.camera.height;
  out.labels.label.assign(image.depth.size(), 0);
  out.noise = std::max(SensorNoise::kLeastInverseDepthStd, noise_.inverse_depth_std);
  if (!image.valid()) return;
  if (params_.labels.estimate_noise) out.noise = estimateNoise(image, out.noise, scratch_);

  toDisparity(image, out.noise, disparity_);
  split_.compute(disparity_);
  merge_.compute(split_, disparity_);
  label(out);
  reassignBoundaries(out.labels);
  keepLargeRegions(out, std::max(3.0, scaledPixels(params_.labels.min_support, image.camera)));
  for (PixelPlane& p : out.planes) p = {p.a * out.noise, p.b * out.noise, p.c * out.noise};
}

// Provisional labels: every pixel of a region that lies near its plane. Specks are left for their neighbours
// to take.
void PlaneSegmenter::Impl::label(LabelledPlanes& out) {
  constexpr double kSpeck =
      0.3;  // share of the minimum support below which a region gets no label of its own
  const double min_region =
      std::max(3.0, kSpeck * scaledPixels(params_.labels.min_support, disparity_.camera));
  region_planes_.assign(1, {});
  label_of_region_.assign(merge_.regions().size(), 0);
  for (std::size_t r = 0; r < merge_.regions().size() && region_planes_.size() < 65535; ++r) {
    if (merge_.regions()[r].moments.n < min_region) continue;
    label_of_region_[r] = static_cast<std::uint16_t>(region_planes_.size());
    region_planes_.push_back(merge_.regions()[r].plane);
  }
  support_.assign(region_planes_.size(), 0);
  const float tolerance = static_cast<float>(params_.labels.tolerance);
  for (std::size_t t = 0; t < split_.triangles().size(); ++t) {
    const int r = merge_.regionOfTriangle()[t];
    if (r < 0 || label_of_region_[r] == 0) continue;
    const std::uint16_t k = label_of_region_[r];
    support_[k] += labelPixels(disparity_, split_.rows(split_.triangles()[t]), region_planes_[k], tolerance,
                               k, out.labels.label.data());
  }
}

// Triangles follow the outlines only roughly. Breadth first from all borders, a pixel goes to the
// neighbouring region whose plane it fits better (METHOD 5.2).
void PlaneSegmenter::Impl::reassignBoundaries(LabelImage& labels) {
  const int w = labels.width, h = labels.height;
  std::uint16_t* const label = labels.label.data();
  front_.clear();
  columns_.resize(w + 1);
  for (int v = 0; v < h; ++v) {
    const std::uint16_t* row = label + static_cast<std::size_t>(v) * w;
    const int n = listBorders(row, v > 0 ? row - w : row, v + 1 < h ? row + w : row, w, columns_.data());
    for (int i = 0; i < n; ++i) front_.push_back({columns_[i], v});
  }
  const float tolerance = static_cast<float>(params_.labels.tolerance);
  for (std::size_t f = 0; f < front_.size(); ++f) {
    const auto [u, v] = front_[f];
    const std::uint16_t k = label[v * w + u];
    const auto offer = [&](int x, int y) {
      const int j = y * w + x;
      const float d = disparity_.d[j];
      const std::uint16_t other = label[j];
      if (other == k || !(d > 0)) return;
      const float e = std::fabs(d - static_cast<float>(region_planes_[k].at(x, y)));
      if (e > tolerance) return;
      if (other != 0) {
        if (std::fabs(d - static_cast<float>(region_planes_[other].at(x, y))) <= e) return;
        --support_[other];
      }
      ++support_[k];
      label[j] = k;
      front_.push_back({x, y});
    };
    if (u > 0) offer(u - 1, v);
    if (u + 1 < w) offer(u + 1, v);
    if (v > 0) offer(u, v - 1);
    if (v + 1 < h) offer(u, v + 1);
  }
}

// Final labels: regions of enough support, the largest first, ties by provisional label.
void PlaneSegmenter::Impl::keepLargeRegions(LabelledPlanes& out, double min_support) {
  order_.resize(region_planes_.size() - 1);
  std::iota(order_.begin(), order_.end(), std::uint16_t{1});
  std::sort(order_.begin(), order_.end(),
            [&](int a, int b) { return support_[a] > support_[b] || (support_[a] == support_[b] && a < b); });
  std::vector<std::uint16_t>& final_label = label_of_region_;
  final_label.assign(region_planes_.size(), 0);
  for (const std::uint16_t k : order_) {
    if (support_[k] < min_support) break;
    out.planes.push_back(region_planes_[k]);
    out.support.push_back(support_[k]);
    final_label[k] = static_cast<std::uint16_t>(out.planes.size());
  }
  relabel(out.labels.label, final_label);
}

}  // namespace facetloc
