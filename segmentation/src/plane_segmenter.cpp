// SPDX-License-Identifier: BSD-3-Clause
#include "base/image_noise.h"
#include "base/lanes.h"
#include "base/room.h"
#include "depth_triangulation.h"
#include "disparity_image.h"
#include "quad_tree.h"
#include "region_merging.h"
#include "relabel.h"

#include <facetloc/segmentation/plane_segmenter.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace facetloc {

using namespace internal;
namespace {

// The rows of a rectangle of pixels, as those of a triangle.
class RectangleRows {
public:
  RectangleRows(int u, int v, int width, int height)
      : v_(v), end_(v + height), first_(u), last_(u + width - 1) {}
  bool done() const { return v_ >= end_; }
  std::int32_t v() const { return v_; }
  std::int32_t first() const { return first_; }
  std::int32_t last() const { return last_; }
  void next() { ++v_; }

private:
  std::int32_t v_, end_, first_, last_;
};

// Labels the pixels in the rows that lie near a plane. \return how many.
template <class Rows>
FACETLOC_ALWAYS_INLINE int labelRows(const DisparityImage& image, Rows rows, const PixelPlane& plane,
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

FACETLOC_MULTIVERSION int labelPixels(const DisparityImage& image, TriangleRows rows, const PixelPlane& plane,
                                      float tolerance, std::uint16_t label, std::uint16_t* labels) {
  return labelRows(image, rows, plane, tolerance, label, labels);
}

FACETLOC_MULTIVERSION int labelPixels(const DisparityImage& image, RectangleRows rows,
                                      const PixelPlane& plane, float tolerance, std::uint16_t label,
                                      std::uint16_t* labels) {
  return labelRows(image, rows, plane, tolerance, label, labels);
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
    std::uint64_t any[2] = {};
    std::memcpy(any, &is_border, sizeof is_border);
    if ((any[0] | any[1]) == 0) continue;
    for (int k = 0; k < kLanes; ++k) columns[n] = u + k, n -= is_border[k];
  }
  for (; u < width; ++u) look(u);
  return n;
}

}  // namespace

struct PlaneSegmenter::Impl {
  Impl(const SegmentationParams& params, const SensorNoise& noise)
      : params_(params),
        noise_(noise),
        triangulation_(params.split),
        tree_(params.merge.tolerance),
        merge_(params.merge) {}

  void segment(const DepthImage& image, LabelledPlanes& out);

  struct Pixel {
    std::int32_t u, v;
  };
  void splitAndMerge();
  void labelRegions(LabelImage& labels);
  std::uint16_t labelOfLeaf(int leaf) const;
  void labelTriangles(LabelImage& labels);
  void labelCells(LabelImage& labels);
  void reassignBoundaries(LabelImage& labels);
  void keepLargeRegions(LabelledPlanes& out, double min_support);

  SegmentationParams params_;
  SensorNoise noise_;
  DisparityImage disparity_;
  DepthTriangulation triangulation_;  // the one or the other splits
  QuadTree tree_;
  RegionMerging merge_;
  std::vector<PixelPlane> region_planes_;  // indexed by provisional label, in units of the disparity image
  std::vector<int> support_;               // support of each [px]
  std::vector<std::uint16_t> label_of_region_, order_;
  std::vector<std::int32_t> columns_;  // columns of a row, and room for one more
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
  out.correlation_px = noise_.correlation_px;
  out.noise = std::max(SensorNoise::kLeastInverseDepthStd, noise_.ofInverseDepth(usualDepth(image)));
  if (!image.valid()) return;
  if (params_.labels.estimate_noise) measureNoise(image, out.noise, out.correlation_px, scratch_);

  // Smooth noise has fewer independent errors, and the largest of fewer is smaller (METHOD 2.3).
  constexpr double kOfSmooth = 0.7;
  const double unit = out.correlation_px > 0 ? kOfSmooth * out.noise : out.noise;
  toDisparity(image, unit, disparity_);
  splitAndMerge();
  labelRegions(out.labels);
  reassignBoundaries(out.labels);
  keepLargeRegions(out, std::max(3.0, scaledPixels(params_.labels.min_support, image.camera)));
  for (PixelPlane& p : out.planes) p = {p.a * unit, p.b * unit, p.c * unit};
}

void PlaneSegmenter::Impl::splitAndMerge() {
  if (params_.split.method == SplitMethod::quadtree) {
    tree_.compute(disparity_);
    merge_.compute(tree_, disparity_);
  } else {
    triangulation_.compute(disparity_);
    merge_.compute(triangulation_, disparity_);
  }
}

// Provisional labels: every pixel of a region that lies near its plane. Specks are left for their neighbours
// to take.
void PlaneSegmenter::Impl::labelRegions(LabelImage& labels) {
  constexpr double kSpeck =
      0.3;  // share of the minimum support below which a region gets no label of its own
  const double min_region =
      std::max(3.0, kSpeck * scaledPixels(params_.labels.min_support, disparity_.camera));
  const std::size_t most = merge_.regions().size() + 1;
  makeRoom(region_planes_, most), makeRoom(label_of_region_, most), makeRoom(support_, most);
  region_planes_.assign(1, {});
  label_of_region_.assign(merge_.regions().size(), 0);
  for (std::size_t r = 0; r < merge_.regions().size() && region_planes_.size() < 65535; ++r) {
    if (merge_.regions()[r].moments.n < min_region) continue;
    label_of_region_[r] = static_cast<std::uint16_t>(region_planes_.size());
    region_planes_.push_back(merge_.regions()[r].plane);
  }
  support_.assign(region_planes_.size(), 0);
  if (params_.split.method == SplitMethod::quadtree)
    labelCells(labels);
  else
    labelTriangles(labels);
}

// The provisional label of a leaf of the split; 0 = none.
std::uint16_t PlaneSegmenter::Impl::labelOfLeaf(int leaf) const {
  const int region = leaf < 0 ? -1 : merge_.regionOfLeaf()[leaf];
  return region < 0 ? 0 : label_of_region_[region];
}

void PlaneSegmenter::Impl::labelTriangles(LabelImage& labels) {
  const float tolerance = static_cast<float>(params_.labels.tolerance);
  for (std::size_t t = 0; t < triangulation_.triangles().size(); ++t) {
    const std::uint16_t k = labelOfLeaf(static_cast<int>(t));
    if (k == 0) continue;
    support_[k] += labelPixels(disparity_, triangulation_.rows(triangulation_.triangles()[t]),
                               region_planes_[k], tolerance, k, labels.label.data());
  }
}

// Neighbouring cells of a row that are in the same region are one rectangle.
void PlaneSegmenter::Impl::labelCells(LabelImage& labels) {
  const float tolerance = static_cast<float>(params_.labels.tolerance);
  for (int row = 0; row < tree_.rows(); ++row) {
    const std::int32_t* const leaf = tree_.leafOfCell().data() + std::size_t(row) * tree_.columns();
    const int v = row * kSmallestCell, height = std::min(kSmallestCell, labels.height - v);
    for (int begin = 0, end; begin < tree_.columns(); begin = end) {
      const std::uint16_t k = labelOfLeaf(leaf[begin]);
      for (end = begin + 1; end < tree_.columns() && labelOfLeaf(leaf[end]) == k;) ++end;
      if (k == 0) continue;
      const int u = begin * kSmallestCell, width = std::min(end * kSmallestCell, labels.width) - u;
      support_[k] += labelPixels(disparity_, RectangleRows(u, v, width, height), region_planes_[k], tolerance,
                                 k, labels.label.data());
    }
  }
}

// Triangles and cells follow the outlines only roughly. Breadth first from all borders, a pixel goes to the
// neighbouring region whose plane it fits better (METHOD 6.2).
void PlaneSegmenter::Impl::reassignBoundaries(LabelImage& labels) {
  const int w = labels.width, h = labels.height;
  std::uint16_t* const label = labels.label.data();
  const float* const disparity = disparity_.d.data();
  front_.clear();
  front_.reserve(labels.label.size());  // a pixel rarely changes hands twice
  columns_.resize(w + 1);
  for (int v = 0; v < h; ++v) {
    const std::uint16_t* row = label + static_cast<std::size_t>(v) * w;
    const int n = listBorders(row, v > 0 ? row - w : row, v + 1 < h ? row + w : row, w, columns_.data());
    for (int i = 0; i < n; ++i) front_.push_back({columns_[i], v});
  }
  const float tolerance = static_cast<float>(params_.labels.tolerance);
  for (std::size_t f = 0; f < front_.size(); ++f) {
    const auto [u, v] = front_[f];
    const int i = v * w + u;
    const std::uint16_t k = label[i];
    const PixelPlane plane = region_planes_[k];
    const double here = plane.at(u, v);
    const auto offer = [&](int x, int y, int j, double expected) {
      const float d = disparity[j], e = std::fabs(d - static_cast<float>(expected));
      const std::uint16_t other = label[j];
      // All at once, since no processor foresees them.
      if (!(int{other != k} & int{d > 0} & int{e <= tolerance})) return;
      if (other != 0) {
        if (std::fabs(d - static_cast<float>(region_planes_[other].at(x, y))) <= e) return;
        --support_[other];
      }
      ++support_[k];
      label[j] = k;
      front_.push_back({x, y});
    };
    if (u > 0) offer(u - 1, v, i - 1, here - plane.a);
    if (u + 1 < w) offer(u + 1, v, i + 1, here + plane.a);
    if (v > 0) offer(u, v - 1, i - w, here - plane.b);
    if (v + 1 < h) offer(u, v + 1, i + w, here + plane.b);
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
