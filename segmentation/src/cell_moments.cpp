// SPDX-License-Identifier: BSD-3-Clause
#include "cell_moments.h"

#include "base/lanes.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace facetloc::internal {
namespace {

constexpr int kPixels = kSmallestCell * kSmallestCell;
constexpr float kVariance = 1.25f;  // variance of the columns, or rows, of a cell
constexpr int kTogether = kLanes / kSmallestCell;

// Sums over neighbouring cells, as many as one vector holds, lane by lane: those of the left one are in the
// first four lanes.
struct CellSums {
  Floats reference;  // a pixel of the cell
  Floats x, vx, xx;  // sums over x = d - reference, with v counted from the middle of the cell
  std::int32_t is_measured[kTogether];  // all of the cell
};

// The first pixel of each cell in all lanes of the cell.
template <typename Lanes>
FACETLOC_ALWAYS_INLINE void spread(const Lanes& row, Lanes& first) {
  if constexpr (kTogether == 2)
    first = __builtin_shufflevector(row, row, 0, 0, 0, 0, 4, 4, 4, 4);
  else
    first = Lanes{} + row[0];
}

FACETLOC_ALWAYS_INLINE void sumCells(const float* d, int width, CellSums& sums) {
  Floats row[kSmallestCell];
  for (int v = 0; v < kSmallestCell; ++v) std::memcpy(&row[v], d + v * width, sizeof row[v]);
  const Ints measured = (row[0] > 0) & (row[1] > 0) & (row[2] > 0) & (row[3] > 0);
  std::uint64_t halves[2 * kTogether];
  std::memcpy(halves, &measured, sizeof halves);
  for (int i = 0; i < kTogether; ++i) sums.is_measured[i] = (halves[2 * i] & halves[2 * i + 1]) == ~0ull;
  spread(row[1], sums.reference);
  for (Floats& x : row) x -= sums.reference;
  sums.x = (row[0] + row[1]) + (row[2] + row[3]);
  sums.vx = 1.5f * (row[3] - row[0]) + 0.5f * (row[2] - row[1]);
  sums.xx = (row[0] * row[0] + row[1] * row[1]) + (row[2] * row[2] + row[3] * row[3]);
}

FACETLOC_ALWAYS_INLINE float sumOf(const Floats& x, int i) {
  return (x[i] + x[i + 1]) + (x[i + 2] + x[i + 3]);
}

// The cell whose sums begin in a lane and whose first pixel is (u, v); all of its pixels are measured.
FACETLOC_ALWAYS_INLINE void fitMeasured(const CellSums& s, int lane, int u, int v, float max_square,
                                        Cell& cell) {
  const float x = sumOf(s.x, lane), vx = sumOf(s.vx, lane), xx = sumOf(s.xx, lane);
  const float ux = 1.5f * (s.x[lane + 3] - s.x[lane]) + 0.5f * (s.x[lane + 2] - s.x[lane + 1]);
  // Columns and rows are orthogonal about the middle of the cell.
  cell.sse = std::max(0.f, xx - x * x * (1.f / kPixels) - (ux * ux + vx * vx) * (1 / (kPixels * kVariance)));
  cell.flat = cell.sse <= kPixels * max_square;
  if (!cell.flat) return;
  const double mu = u + 1.5, mv = v + 1.5, d0 = s.reference[lane], sum = kPixels * d0 + x;
  PlaneMoments& m = cell.moments;
  m.n = kPixels, m.u = kPixels * mu, m.v = kPixels * mv, m.d = sum;
  m.uu = kPixels * (mu * mu + kVariance), m.uv = kPixels * mu * mv, m.vv = kPixels * (mv * mv + kVariance);
  m.ud = ux + mu * sum, m.vd = vx + mv * sum;
  m.dd = xx + d0 * (sum + x);  // sum of (x + d0)^2
}

// Any cell, whose first pixel is (u, v).
void fitCell(const DisparityImage& image, int u, int v, const CellBounds& bounds, Cell& cell) {
  const int w = image.camera.width, h = image.camera.height;
  const int width = std::min(kSmallestCell, w - u), height = std::min(kSmallestCell, h - v);
  cell.flat = false;
  PlaneMoments m;
  for (int y = v; y < v + height; ++y)
    for (int x = u; x < u + width; ++x) {
      const float d = image.d[static_cast<std::size_t>(y) * w + x];
      if (d > 0) m.add(x, y, d);
    }
  if (m.n == 0 || m.n < bounds.min_fill * width * height) return;
  cell.moments = m;
  cell.sse = static_cast<float>(m.fit().sse);
  cell.flat = cell.sse <= m.n * bounds.max_square;
}

// Whole vectors of cells, as long as the image has pixels for them. \return the first column that is left.
FACETLOC_MULTIVERSION int fitTogether(const DisparityImage& image, int v, const CellBounds& bounds,
                                      Cell* cells) {
  const int width = image.camera.width;
  const float* const d = image.d.data() + static_cast<std::size_t>(v) * width;
  int u = 0;
  for (; u + kLanes <= width; u += kLanes) {
    CellSums sums;
    sumCells(d + u, width, sums);
    for (int i = 0; i < kTogether; ++i) {
      const int first = u + i * kSmallestCell;
      Cell& cell = cells[first / kSmallestCell];
      if (sums.is_measured[i])
        fitMeasured(sums, i * kSmallestCell, first, v, bounds.max_square, cell);
      else
        fitCell(image, first, v, bounds, cell);
    }
  }
  return u;
}

}  // namespace

void fitSmallestCells(const DisparityImage& image, int row, const CellBounds& bounds, Cell* cells) {
  const int v = row * kSmallestCell;
  int u = v + kSmallestCell <= image.camera.height ? fitTogether(image, v, bounds, cells) : 0;
  for (; u < image.camera.width; u += kSmallestCell) fitCell(image, u, v, bounds, cells[u / kSmallestCell]);
}

}  // namespace facetloc::internal
