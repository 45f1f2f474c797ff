// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>

namespace facetloc {

/** \brief The squared Mahalanobis distance that an error of n degrees of freedom does not exceed with this
 * probability, to four digits or more; of a constant of another pair the compiler complains.
 *
 *     constexpr double kGate = chiSquareQuantile(3, 0.99);
 *
 * \throws std::invalid_argument for a pair that is not in the table */
constexpr double chiSquareQuantile(int degrees_of_freedom, double probability) {
  struct Quantile {
    int degrees_of_freedom;
    double probability, value;
  };
  constexpr Quantile kTable[] = {
      {3, 0.95, 7.81}, {3, 0.99, 11.345}, {6, 0.95, 12.59}, {6, 0.99, 16.81}, {6, 0.999, 22.46}};
  for (const Quantile& q : kTable)
    if (q.degrees_of_freedom == degrees_of_freedom && q.probability == probability) return q.value;
  throw std::invalid_argument("no quantile of chi-square is known for this probability");
}

}  // namespace facetloc
