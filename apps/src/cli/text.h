// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>

#include <ostream>
#include <string>
#include <string_view>
#include <vector>

/** \file
 * Text for people; of numbers see base/text.h. */

namespace facetloc {

/** \brief A text whose control characters, but for line feeds and tabs, are spelled out: names of files and
 * texts of maps must not command a terminal. */
std::string printable(std::string_view text);

/** \brief "1 image", "2 images". */
std::string counted(std::size_t n, const std::string& noun);

/** \brief - and _ are the same in names. */
std::string underscored(std::string name);

/** \brief The known word that was probably meant, written as it is known; empty if none is near: a third of
 * the characters may be wrong. Of a word in groups, such as ekf.iterations, the last part alone may be meant.
 * The first one of several that are equally near. */
std::string nearestWord(const std::string& word, const std::vector<std::string>& known);

/** \brief "; did you mean '--map'?", or nothing. \param prefix of the word as it is shown */
std::string didYouMean(const std::string& word, const std::vector<std::string>& known,
                       const std::string& prefix = "");

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
