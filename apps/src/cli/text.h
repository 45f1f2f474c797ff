// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>

#include <functional>
#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>
#include <utility>
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

/** \brief Hands each text on to a function as it comes, which returns false if it cannot take it. */
class Relay : public std::streambuf {
public:
  using Take = std::function<bool(const char* text, std::streamsize size)>;
  explicit Relay(Take take) : take_(std::move(take)) {}

protected:
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char text = traits_type::to_char_type(c);
    return take_(&text, 1) ? c : traits_type::eof();
  }
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    return take_(text, size) ? size : 0;
  }

private:
  Take take_;
};

}  // namespace facetloc
