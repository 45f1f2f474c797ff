// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"
#include "bytes/files.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <string_view>
#include <vector>

/** \file
 * CSV with a header line and RFC 4180 quotes, private to io. */

namespace facetloc::csv {

struct Row {
  int line = 0;  ///< where it begins, counted from 1
  std::vector<std::string> cells;
  std::string text;  ///< as it is in the file, with the end of its line
};

/** \brief A row that ends before its line does. */
class TornRow : public IoError {
public:
  using IoError::IoError;
};

/** \brief Splits a file into rows; blank lines are left out. */
class Scanner {
public:
  Scanner(std::string_view content, std::string path) : content_(content), path_(std::move(path)) {}

  /** \param found receives the rows, also those before a torn one. */
  void scan(std::vector<Row>& found) {
    while (position_ < content_.size()) {
      Row row = scanRow();
      if (row.cells.size() > 1 || !row.cells.front().empty()) found.push_back(std::move(row));
    }
  }

private:
  Row scanRow() {
    const std::size_t begin = position_;
    Row row{line_, {}, {}};
    do row.cells.push_back(scanCell());
    while (take(','));
    take('\r');
    if (!take('\n') && position_ < content_.size())
      throw IoError(path_, fmt::format("line {}: a comma or the end of the line is missing", line_));
    ++line_;
    row.text = content_.substr(begin, position_ - begin);
    return row;
  }

  std::string scanCell() {
    if (take('"')) return scanQuoted();
    const auto end = std::min(content_.find_first_of(",\r\n", position_), content_.size());
    std::string found(content_.substr(position_, end - position_));
    position_ = end;
    return found;
  }

  std::string scanQuoted() {
    const int first_line = line_;
    std::string found;
    while (position_ < content_.size()) {
      const char c = content_[position_++];
      if (c == '"' && !take('"')) return found;
      if (c == '\n') ++line_;
      found += c;
    }
    throw TornRow(path_, fmt::format("line {}: a quote is not closed", first_line));
  }

  bool take(char c) {
    if (position_ == content_.size() || content_[position_] != c) return false;
    ++position_;
    return true;
  }

  std::string_view content_;
  std::string path_;
  std::size_t position_ = 0;
  int line_ = 1;
};

/** \brief A CSV file whose columns are found by their names in the header line. */
class Table {
public:
  /** \brief Throws IoError for a file that is no table.
   * \param forgive_torn The last row is left out unless its line ends: it may be torn, as a program leaves it
   * that is killed while it writes. */
  explicit Table(const fs::path& path, bool forgive_torn = false) : path_(path.string()) {
    const std::string content = files::readText(path);
    forgive_torn = forgive_torn && !content.empty() && content.back() != '\n';
    try {
      Scanner(content, path_).scan(rows_);
    } catch (const TornRow&) {
      if (!forgive_torn) throw;
      torn_ = true;
    }
    if (rows_.empty()) throw IoError(path_, "is empty: it has not even a header line");
    header_ = std::move(rows_.front().cells);
    rows_.erase(rows_.begin());
    if (forgive_torn && !torn_ && !rows_.empty()) {
      torn_ = true;
      rows_.pop_back();
    }
    for (const Row& row : rows_)
      if (row.cells.size() != header_.size())
        fail(row, fmt::format("has {} columns, the header has {}", row.cells.size(), header_.size()));
  }

  /** \brief Was the last row left out? */
  bool isTorn() const { return torn_; }
  const std::vector<Row>& rows() const { return rows_; }

  bool has(std::string_view name) const {
    return std::find(header_.begin(), header_.end(), name) != header_.end();
  }
  /** \brief The place of a column. */
  std::size_t column(std::string_view name) const {
    const auto found = std::find(header_.begin(), header_.end(), name);
    if (found == header_.end()) throw IoError(path_, "line 1: there is no column " + text::quoted(name));
    return found - header_.begin();
  }
  const std::string& string(const Row& row, std::string_view name) const { return row.cells[column(name)]; }
  double real(const Row& row, std::string_view name) const {
    const double value = number<double>(row, name);
    if (!std::isfinite(value)) fail(row, std::string(name) + " is not finite");
    return value;
  }
  /** \brief A number that cannot be negative. */
  int count(const Row& row, std::string_view name) const {
    const int value = number<int>(row, name);
    if (value < 0) fail(row, std::string(name) + " is negative");
    return value;
  }

  [[noreturn]] void fail(const Row& row, const std::string& cause) const {
    throw IoError(path_, fmt::format("line {}: {}", row.line, cause));
  }

private:
  template <typename Number>
  Number number(const Row& row, std::string_view name) const {
    const auto word = text::trimmed(string(row, name));
    const auto value = text::to<Number>(word);
    if (!value) fail(row, fmt::format("{} = '{}' is not a number", name, word));
    return *value;
  }

  std::string path_;
  std::vector<std::string> header_;
  std::vector<Row> rows_;
  bool torn_ = false;
};

}  // namespace facetloc::csv
