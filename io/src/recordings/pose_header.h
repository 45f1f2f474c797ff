// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/** \file
 * Meaning of the columns of a file of poses. Private to io. */

namespace facetloc::internal {

/** \brief A name of a column in lower case, and the unit in brackets behind it. */
struct ColumnName {
  std::string word, unit;

  bool has(const char* part) const { return word.find(part) != std::string::npos; }
  bool begins(const char* part) const { return word.rfind(part, 0) == 0; }
  char last() const { return word.empty() ? ' ' : word.back(); }
  bool isStamp() const;
  /** \brief Seconds that a stamp of that name stands for; 0 if the name does not say it. */
  double seconds() const;
};

/** \brief The cells between commas or semicolons, if there are any, or else between blanks; "[ns]" belongs to
 * the cell before. */
std::vector<ColumnName> columnNames(std::string_view line);

/** \brief Columns, counted from 0. */
struct PoseHeader {
  std::size_t width = 0;      ///< number of columns
  int stamp = -1;             ///< -1: none
  int nanoseconds = -1;       ///< column with the part of the stamp below a second; -1: none
  double unit = 0;            ///< seconds that a stamp stands for, if the header says it; 0: it does not
  int matrix = -1;            ///< where a matrix begins, row by row; -1: a position and a quaternion instead
  std::array<int, 7> pose{};  ///< tx ty tz qx qy qz qw

  /** \brief Columns by a line of names, such as `timestamp tx ty tz qx qy qz qw` or EuRoC's `#timestamp
   * [ns],p_x,...`. Empty if the names are not those of one position and one quaternion. */
  static std::optional<PoseHeader> of(std::string_view names);
  /** \brief tx ty tz qx qy qz qw from a column on. */
  static PoseHeader inOrder(std::size_t width, int stamp, int first);
  static PoseHeader ofMatrix(std::size_t width, int stamp, int first);
  /** \brief A stamp in nanoseconds, a position, and a quaternion w x y z. */
  static PoseHeader ofEuroc(std::size_t width);
};

}  // namespace facetloc::internal
