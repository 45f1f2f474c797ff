// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/lanes.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace facetloc::internal {

/** \brief Edges between regions, the cheapest first, ties by index.
 *
 * Most edges are out of date before their turn, since either region has changed. So only those of the lowest
 * costs are kept in order, in a heap; the others wait in slices of cost, and those that are out of date by
 * then leave without having been sorted. */
class EdgeQueue {
public:
  struct Edge {
    float cost = 0;  ///< not negative
    std::int32_t a = 0, b = 0;
    std::uint32_t version_a = 0, version_b = 0;
  };

  /** \brief Empties it, for costs up to a largest one. */
  void clear(double max_cost) {
    slices_per_cost_ = static_cast<float>((kSlices - 1) / max_cost);
    first_.fill(-1);
    waiting_.clear();
    heap_.clear();
    slice_ = 0;
  }

  void push(const Edge& edge) {
    const int slice = static_cast<int>(edge.cost * slices_per_cost_);
    if (slice <= slice_) {
      heap_.push_back(edge);
      std::push_heap(heap_.begin(), heap_.end(), isDearer);
      return;
    }
    waiting_.push_back({edge, first_[slice]});
    first_[slice] = static_cast<std::int32_t>(waiting_.size()) - 1;
  }

  /** \brief Takes out the cheapest edge that is current, and those before it. \return false if none is left.
   */
  template <class IsCurrent>
  bool pop(Edge& cheapest, const IsCurrent& is_current) {
    for (;;) {
      while (!heap_.empty()) {
        cheapest = heap_.front();
        std::pop_heap(heap_.begin(), heap_.end(), isDearer);
        heap_.pop_back();
        if (is_current(cheapest)) return true;
      }
      if (++slice_ >= kSlices) return false;
      for (int i = first_[slice_]; i >= 0; i = waiting_[i].next)
        if (is_current(waiting_[i].edge)) heap_.push_back(waiting_[i].edge);
      std::make_heap(heap_.begin(), heap_.end(), isDearer);
    }
  }

private:
  static constexpr int kSlices = 256;

  struct Waiting {
    Edge edge;
    std::int32_t next;  // index in the same slice; -1 = the last
  };
  static std::uint64_t order(const Edge& e) { return bitsOf(e.cost) << 32 | static_cast<std::uint32_t>(e.a); }
  static bool isDearer(const Edge& x, const Edge& y) {
    return order(x) != order(y) ? order(x) > order(y) : x.b > y.b;
  }

  float slices_per_cost_ = 0;
  std::array<std::int32_t, kSlices> first_{};  // first edge of each slice, in waiting_
  std::vector<Waiting> waiting_;
  std::vector<Edge> heap_;  // edges of all slices up to slice_
  int slice_ = 0;
};

}  // namespace facetloc::internal
