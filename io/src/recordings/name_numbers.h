// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace facetloc::internal {

/** \brief The numbers by which names differ. */
struct NameNumbers {
  std::vector<double> numbers;  ///< sorted as the names
  bool decimal = false;         ///< one is written with a point
  bool padded = false;          ///< one is written with leading zeros
};

/** \brief The number of each name, which is the name, or a time of PCL's recorders in it, or anywhere in
 * names that are otherwise equal: of several, one that differs from name to name, and has a point if one
 * does. Empty if there are no such numbers. */
std::optional<NameNumbers> numbersInNames(const std::vector<std::string>& names);

/** \brief The series of each name, from 0 in their order: names of several cameras differ in a word or a
 * number that comes with the same other numbers in each of them, as cam0_17 and cam1_17, or left-17 and
 * right-17. All 0 for names of one series. */
std::vector<std::size_t> seriesInNames(const std::vector<std::string>& names);

/** \brief The numbers in a name as they are written, with blanks between them: files with the same ones
 * belong together. */
std::string numbersOf(const std::string& name);

/** \brief The time that the name of an image is or has in it, as those of PCL's recorders do, [s]. */
std::optional<double> stampInName(const std::string& name);

/** \brief Is the word there, between what are no letters or at a change from lower to upper case? In lower
 * case; the name in any. */
bool hasWord(const std::string& name, const std::string& word);

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
