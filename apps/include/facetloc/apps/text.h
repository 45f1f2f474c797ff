// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <ostream>
#include <string>
#include <vector>

/** \file Text for people and for tables; numbers are in the classic locale. */

namespace facetloc {

/** \brief As printf("%.*f"). */
std::string fixed(double value, int decimals);
/** \brief As printf("%.9g"): what a table of results needs. */
std::string shortNumber(double value);
/** \brief As many digits as read back to the same double. */
std::string exactNumber(double value);
/** \brief The number that a text is, and nothing but it. */
std::optional<double> toNumber(const std::string& text);
/** \brief A cell of a CSV file, in quotes if it has to be (RFC 4180). */
std::string csvCell(const std::string& text);
/** \brief "1 image", "2 images". */
std::string counted(std::size_t n, const std::string& noun);

/** \brief Columns of text, each as wide as its widest cell; the first column is aligned left, all others
 * right. */
class TextTable {
public:
  explicit TextTable(std::vector<std::string> header);
  void add(std::vector<std::string> row);
  /** \brief The last column is aligned left as well: it holds words. */
  void setWordsLast() { words_last_ = true; }
  bool wordsLast() const { return words_last_; }

  const std::vector<std::vector<std::string>>& rows() const { return rows_; }
  friend std::ostream& operator<<(std::ostream& out, const TextTable& table);

private:
  std::vector<std::vector<std::string>> rows_;  // the first one is the header
  bool words_last_ = false;
};

}  // namespace facetloc
