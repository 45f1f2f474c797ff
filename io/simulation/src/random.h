// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace facetloc {

/** \brief Random numbers that are the same everywhere: the standard fixes its engines, but not its
 * distributions. */
class Random {
public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /** \brief Uniform random number in [0, 1). */
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double uniform(double lowest, double highest) { return lowest + (highest - lowest) * uniform(); }

  /** \brief Standard normal (Box and Muller). */
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    const double angle = 2 * 3.14159265358979323846 * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

private:
  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

/** \brief A seed of its own for every purpose and index (splitmix64). */
inline std::uint64_t derivedSeed(std::uint64_t seed, std::uint64_t purpose, std::uint64_t index = 0) {
  for (const std::uint64_t part : {purpose, index}) {
    seed += 0x9E3779B97F4A7C15u * (part + 1);
    seed = (seed ^ (seed >> 30)) * 0xBF58476D1CE4E5B9u;
    seed = (seed ^ (seed >> 27)) * 0x94D049BB133111EBu;
    seed ^= seed >> 31;
  }
  return seed;
}

}  // namespace facetloc
