// SPDX-License-Identifier: BSD-3-Clause
#include "depth/loose_bodies.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace facetloc::internal {
namespace {

constexpr int kColumns = 80;            // the grid: 4 px of 320
constexpr double kLargestPlane = 1;     // a person shows less [m^2]
constexpr double kLargestBody = 2.5;    // diagonal of a person with arms spread [m]
constexpr double kLeastShare = 0.01;    // share of the grid: smaller things hide nothing that matters
constexpr double kJump = 0.05;          // share of inverse depth: a surface seen at 80 deg, on this grid
constexpr float kOutlineMargin = 0.1f;  // around the outline of a plane [m]
constexpr int kMostBodies = std::numeric_limits<std::uint8_t>::max();

/** A plane m . p = 1 that bodies stand on or before. */
struct LargePlane {
  const Segment* segment;
  Eigen::Vector3d m;
};

/** The grid of a picture, and the cells that may belong to bodies. */
class Grid {
public:
  explicit Grid(const View& view)
      : picture_(view.depth),
        errors_(errorsOf(view.depth)),
        step_(gridStep(picture_, kColumns)),
        width_(gridPoints(picture_.camera.width, step_)),
        height_(gridPoints(picture_.camera.height, step_)) {
    for (const Segment& segment : view.segments)
      if (segment.area() >= kLargestPlane && segment.offset() > 0)
        planes_.push_back({&segment, segment.normal() / segment.offset()});
    cells_.resize(std::size_t(width_) * height_);
    for (int v = 0; v < height_; ++v)
      for (int u = 0; u < width_; ++u) cells_[index(u, v)] = isLoose(u, v) ? kLoose : kFixed;
  }

  int step() const { return step_; }
  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t index(int u, int v) const { return std::size_t(v) * width_ + u; }
  double inverseDepth(int u, int v) const {
    const std::size_t row = std::size_t(v * step_ + step_ / 2) * picture_.camera.width;
    return DepthPicture::kQuantum * picture_.inverse_depth[row + u * step_ + step_ / 2];
  }
  /** The connected surface around a cell, which is never found again; empty unless it is a body. */
  std::vector<std::size_t> bodyFrom(int u, int v);

private:
  enum Cell : char { kFixed, kLoose, kFound };
  // Plane and pixels are of one image.
  static DepthErrors errorsOf(const DepthPicture& picture) {
    return DepthComparison(refinedErrors({})).errorsBetween(picture, picture);
  }
  Eigen::Vector3d ray(int u, int v) const {
    return picture_.camera.ray(u * step_ + step_ / 2, v * step_ + step_ / 2);
  }
  bool connects(double a, double b) const {
    return std::abs(a - b) <= kJump * std::max(a, b) + errors_.gate * errors_.absolute;
  }
  bool isLoose(int u, int v) const;

  const DepthPicture& picture_;
  DepthErrors errors_;
  int step_, width_, height_;
  std::vector<LargePlane> planes_;
  std::vector<Cell> cells_;
};

bool Grid::isLoose(int u, int v) const {
  const double rho = inverseDepth(u, v);
  if (!(rho > 0)) return false;
  const Eigen::Vector3d b = ray(u, v);
  return std::none_of(planes_.begin(), planes_.end(), [&](const LargePlane& plane) {
    if (std::abs(plane.m.dot(b) - rho) > errors_.tolerance(rho)) return false;
    const Eigen::Vector3d p = plane.segment->R.transpose() * (b / rho - plane.segment->t);
    return plane.segment->hull.contains(p.head<2>().cast<float>(), kOutlineMargin);
  });
}

std::vector<std::size_t> Grid::bodyFrom(int u0, int v0) {
  if (cells_[index(u0, v0)] != kLoose) return {};
  std::vector<std::size_t> found{index(u0, v0)};
  cells_[found.front()] = kFound;
  Eigen::AlignedBox3d extent;
  int farther = 0, beside = 0;  // neighbours that are no part of it
  for (std::size_t k = 0; k < found.size(); ++k) {
    const int u = static_cast<int>(found[k] % width_), v = static_cast<int>(found[k] / width_);
    const double rho = inverseDepth(u, v);
    extent.extend(ray(u, v) / rho);
    for (const auto& [du, dv] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
      const int nu = u + du, nv = v + dv;
      if (nu < 0 || nv < 0 || nu >= width_ || nv >= height_) continue;
      const double other = inverseDepth(nu, nv);
      if (!(other > 0)) continue;
      Cell& cell = cells_[index(nu, nv)];
      const bool is_connected = connects(rho, other);
      if (cell == kLoose && is_connected) {
        cell = kFound;
        found.push_back(index(nu, nv));
      } else if (cell == kFixed || !is_connected) {
        ++(other < rho && !is_connected ? farther : beside);
      }
    }
  }
  const bool is_body = double(found.size()) >= kLeastShare * double(cells_.size()) &&
                       extent.sizes().norm() <= kLargestBody && farther > beside;
  return is_body ? found : std::vector<std::size_t>();
}

}  // namespace

LooseBodies::LooseBodies(const View& view) : view_(view) {
  const DepthPicture& picture = view.depth;
  if (picture.empty()) return;
  Grid grid(view);
  const int columns = picture.camera.width, rows = picture.camera.height, step = grid.step();
  for (int v = 0; v < grid.height(); ++v)
    for (int u = 0; u < grid.width() && count_ < kMostBodies; ++u) {
      const std::vector<std::size_t> cells = grid.bodyFrom(u, v);
      if (cells.empty()) continue;
      body_.resize(picture.inverse_depth.size(), 0);
      ++count_;
      // One cell more on each side is its silhouette.
      for (const std::size_t cell : cells) {
        const int left = static_cast<int>(cell % grid.width()) * step,
                  top = static_cast<int>(cell / grid.width()) * step;
        for (int y = std::max(0, top - step); y < std::min(rows, top + 2 * step); ++y)
          std::fill_n(body_.begin() + std::ptrdiff_t(y) * columns + std::max(0, left - step),
                      std::min(columns, left + 2 * step) - std::max(0, left - step),
                      static_cast<std::uint8_t>(count_));
      }
    }
}

LooseBodies::Chosen LooseBodies::labelled(DepthLabel label, const Eigen::Isometry3d& T_w_c,
                                          const std::vector<PosedPicture>& pictures,
                                          const DepthComparison& comparison) const {
  Chosen chosen(count_, 0);
  if (empty()) return chosen;
  const DepthPicture& depth = view_.depth;
  std::vector<int> balance(count_ + 1, 0);  // verdicts of this kind on a body, minus all others
  const int step = gridStep(depth, kFineColumns);
  DepthLabels labels;
  for (const PosedPicture& other : pictures) {
    if (other.picture->empty()) continue;
    const DepthComparator comparator(comparison, depth, *other.picture, other.T_w_c.inverse() * T_w_c);
    for (int v = step / 2; v < depth.camera.height; v += step) {
      comparator.row(v, step, labels);
      const std::uint8_t* row = &body_[std::size_t(v) * depth.camera.width];
      for (std::size_t i = 0; i < labels.size(); ++i)
        if (labels[i] != DepthLabel::outside)
          balance[row[step / 2 + i * step]] += labels[i] == label ? 1 : -1;
    }
  }
  for (int i = 0; i < count_; ++i) chosen[i] = balance[i + 1] > 0;
  return chosen;
}

LooseBodies::Chosen LooseBodies::before(const Eigen::Isometry3d& T_w_c,
                                        const std::vector<PosedPicture>& pictures,
                                        const DepthComparison& comparison) const {
  return otherThanFurniture(labelled(DepthLabel::contradict, T_w_c, pictures, comparison));
}

LooseBodies::Chosen LooseBodies::otherThanFurniture(Chosen bodies) const {
  if (!furniture_.empty())
    std::transform(bodies.begin(), bodies.end(), furniture_.begin(), bodies.begin(),
                   [](char chosen, char is_furniture) { return chosen && !is_furniture; });
  return bodies;
}

DepthPicture LooseBodies::pictureWithout(const Chosen& bodies) const {
  DepthPicture rest = view_.depth;
  for (std::size_t i = 0; i < body_.size(); ++i)
    if (body_[i] > 0 && bodies[body_[i] - 1]) rest.inverse_depth[i] = 0, rest.extremes[i] = {};
  return rest;
}

bool anyOf(const LooseBodies::Chosen& bodies) {
  return std::any_of(bodies.begin(), bodies.end(), [](char chosen) { return chosen != 0; });
}

}  // namespace facetloc::internal
