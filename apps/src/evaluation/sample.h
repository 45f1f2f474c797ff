// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief Numbers in ascending order, and their moments, which are zero without any. */
struct Sample {
  std::vector<double> values;
  double mean = 0;
  double std = 0;  ///< the divisor is n - 1
  double rmse = 0;
  double median = 0;  ///< the mean of the middle two of an even number
  double max = 0;

  Sample() = default;
  explicit Sample(std::vector<double> numbers) : values(std::move(numbers)) {
    if (values.empty()) return;
    const auto n = static_cast<double>(values.size());
    mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
    double squares = 0;
    for (const double v : values) squares += (v - mean) * (v - mean);
    if (values.size() > 1) std = std::sqrt(squares / (n - 1));
    std::sort(values.begin(), values.end());
    rmse = std::sqrt(std::inner_product(values.begin(), values.end(), values.begin(), 0.0) / n);
    const std::size_t half = values.size() / 2;
    median = values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
    max = values.back();
  }

  /** \brief The share of the values up to the i-th, from 0. */
  double share(std::size_t i) const {
    return static_cast<double>(i + 1) / static_cast<double>(values.size());
  }
  /** \brief The smallest value that at least this share does not exceed; 0 without values. */
  double bound(double of) const {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (share(i) >= of) return values[i];
    return max;
  }
};

}  // namespace facetloc
