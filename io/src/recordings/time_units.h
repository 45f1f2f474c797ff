// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

/** \file
 * Units of the numbers that name images and poses. Private to io. */

namespace facetloc::internal {

/** \brief Meaning of numbers in the order of images. */
struct TimeUnit {
  double seconds = 1;    ///< that one unit stands for
  bool counted = false;  ///< the numbers count images, and are no times

  /** \brief "nanoseconds". */
  std::string toString() const;
};

constexpr double kFrameRate = 30;  ///< rate of images that are only counted [Hz]

/** \brief The unit of time stamps, by their size and their steps: no clock of seconds shows 1e11, and no
 * camera waits half an hour between two images. Never counted. */
TimeUnit unitOfStamps(std::vector<double> stamps);

/** \brief The unit of the numbers of images: whole numbers that are no times since 1970 are counters, unless
 * they have no leading zeros and their steps are nearly, but not quite, equal, as those of milliseconds are.
 * \param decimal a number is written with a point \param padded a number is written with leading zeros */
TimeUnit unitOfNumbers(const std::vector<double>& numbers, bool decimal, bool padded);

}  // namespace facetloc::internal
