// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

namespace facetloc::internal {

/** \brief A corner of triangles of an image. */
struct TriangleVertex {
  std::int32_t u = 0, v = 0;  ///< [px]
  float d = 0;                ///< disparity; of the nearest valid pixel at a corner without one
};

/** \brief Where an edge that runs downwards crosses the rows, rounded up to the next column.
 *
 * Exact with steps of fixed precision in images up to 16000 px: they are rounded down, in all by less than
 * 2^14 * 2^-31 px, while a crossing between columns lies at least 1/16000 px right of one. */
class EdgeColumns {
public:
  EdgeColumns() = default;
  EdgeColumns(const TriangleVertex& top, const TriangleVertex& bottom) : column_(top.u * kOne + (kOne - 1)) {
    const std::int32_t rows = bottom.v - top.v, columns = bottom.u - top.u;
    if (rows > 0) step_ = columns * kOne / rows - (columns < 0);  // which had been rounded up
  }
  std::int32_t column() const { return static_cast<std::int32_t>(column_ >> kFractionBits); }
  void next() { column_ += step_; }

private:
  static constexpr int kFractionBits = 32;
  static constexpr std::int64_t kOne = std::int64_t{1} << kFractionBits;

  std::int64_t column_ = 0, step_ = 0;  // [px / kOne]
};

/** \brief Walks through the rows of a triangle from top to bottom.
 *
 * A pixel (u, v) counts as (u + eps, v + eps^2): a pixel on an edge then lies on exactly one side of it, and
 * a row goes from where the left edge crosses it to before where the right edge does. Rows may be empty. */
class TriangleRows {
public:
  TriangleRows(const TriangleVertex& a, const TriangleVertex& b, const TriangleVertex& c) {
    const bool b_above_a = b.v < a.v, c_above_a = c.v < a.v, c_above_b = c.v < b.v;
    std::array<const TriangleVertex*, 3> sorted;  // sorted by row, without branches
    sorted[b_above_a + c_above_a] = &a;
    sorted[!b_above_a + c_above_b] = &b;
    sorted[!c_above_a + !c_above_b] = &c;
    const auto [top, middle, bottom] = sorted;
    v_ = top->v, middle_ = middle->v, bottom_ = bottom->v;
    const std::int64_t side = std::int64_t(bottom->u - top->u) * (middle->v - top->v) -
                              std::int64_t(bottom->v - top->v) * (middle->u - top->u);
    bends_left_ = side > 0;
    (bends_left_ ? right_ : left_) = EdgeColumns(*top, *bottom);
    lower_ = EdgeColumns(*middle, *bottom);
    (bends_left_ ? left_ : right_) = v_ < middle_ ? EdgeColumns(*top, *middle) : lower_;
  }
  bool done() const { return v_ >= bottom_; }
  std::int32_t v() const { return v_; }
  std::int32_t first() const { return left_.column(); }
  std::int32_t last() const { return right_.column() - 1; }
  void next() {
    left_.next(), right_.next();
    if (++v_ == middle_) (bends_left_ ? left_ : right_) = lower_;
  }

private:
  std::int32_t v_, middle_, bottom_;
  bool bends_left_;  // the middle vertex is one of the left edges
  EdgeColumns left_, right_, lower_;
};

}  // namespace facetloc::internal
