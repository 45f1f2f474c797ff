// SPDX-License-Identifier: BSD-3-Clause
#include "base/results_journal.h"

#include "base/provenance.h"

#include <facetloc/io/error.h>
#include <facetloc/io/text.h>

#include <fstream>
#include <iomanip>
#include <optional>
#include <regex>
#include <sstream>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

std::string fileName(int rank) { return rank == 0 ? kPartial : "partial." + std::to_string(rank) + ".txt"; }

/** Is it the fileName() of any rank? */
bool isJournal(const std::string& name) {
  static const std::regex names("partial\\.([1-9][0-9]*\\.)?txt");
  return std::regex_match(name, names);
}

/** Words on one line: numbers to the last bit, texts in quotes. */
class LineWriter {
public:
  LineWriter& operator<<(double value) { return word(text::shortest(value)); }
  LineWriter& operator<<(int value) { return word(std::to_string(value)); }
  LineWriter& operator<<(const std::string& text) {
    std::ostringstream quoted;
    quoted << std::quoted(text);
    return word(quoted.str());
  }
  LineWriter& operator<<(const Eigen::Isometry3d& T) {
    for (int row = 0; row < 3; ++row)
      for (int col = 0; col < 4; ++col) *this << T(row, col);
    return *this;
  }
  LineWriter& operator<<(const Matrix6d& symmetric) {
    for (int row = 0; row < 6; ++row)
      for (int col = row; col < 6; ++col) *this << symmetric(row, col);
    return *this;
  }
  template <class T>
  LineWriter& operator<<(const std::optional<T>& value) {
    *this << int(value.has_value());
    return value ? *this << *value : *this;
  }
  /** With a checksum, by which a line is known that was torn or damaged. */
  std::string str() const { return line_ + checksumOf(line_) + "\n"; }

private:
  LineWriter& word(const std::string& text) {
    line_ += text + " ";
    return *this;
  }
  std::string line_;
};

class LineReader {
public:
  explicit LineReader(const std::string& line) : in_(line) {}

  LineReader& operator>>(double& value) {
    std::string word;
    in_ >> word;
    if (const auto number = text::to<double>(word))
      value = *number;
    else
      in_.setstate(std::ios::failbit);
    return *this;
  }
  LineReader& operator>>(int& value) { return in_ >> value, *this; }
  LineReader& operator>>(std::string& text) { return in_ >> std::quoted(text), *this; }
  LineReader& operator>>(Eigen::Isometry3d& T) {
    T = Eigen::Isometry3d::Identity();
    for (int row = 0; row < 3; ++row)
      for (int col = 0; col < 4; ++col) *this >> T(row, col);
    return *this;
  }
  LineReader& operator>>(Matrix6d& symmetric) {
    for (int row = 0; row < 6; ++row)
      for (int col = row; col < 6; ++col) {
        *this >> symmetric(row, col);
        symmetric(col, row) = symmetric(row, col);
      }
    return *this;
  }
  template <class T>
  LineReader& operator>>(std::optional<T>& value) {
    int has_value = 0;
    *this >> has_value;
    return has_value ? *this >> value.emplace() : *this;
  }
  LineReader& operator>>(AnswerState& state) {
    std::string name;
    *this >> name;
    if (const auto known = answerStateOf(name))
      state = *known;
    else
      in_.setstate(std::ios::failbit);
    return *this;
  }
  /** The line was whole, and is as it was written. */
  bool complete() {
    const auto words = in_.tellg();
    std::string sum;
    return words >= 0 && in_ >> sum && sum == checksumOf(in_.str().substr(0, std::size_t(words) + 1));
  }
  explicit operator bool() const { return !in_.fail(); }

private:
  std::istringstream in_;
};

void write(LineWriter& line, const ResultRow& row) {
  line << row.rank << row.model << row.probability << row.score << row.T_m_c << row.T_w_c << row.P_w_c
       << row.sd_rot_deg << row.sd_trans_m << row.reason << std::string(toString(row.state)) << row.part;
}

void read(LineReader& line, ResultRow& row) {
  line >> row.rank >> row.model >> row.probability >> row.score >> row.T_m_c >> row.T_w_c >> row.P_w_c >>
      row.sd_rot_deg >> row.sd_trans_m >> row.reason >> row.state >> row.part;
}

std::string lineOf(const std::string& frame, const FrameResult& result) {
  LineWriter line;
  const TimingRow& t = result.timing;
  line << frame << result.stamp << t.segment_ms << t.features_ms << t.localize_ms << t.models
       << static_cast<int>(result.rows.size());
  for (const ResultRow& row : result.rows) write(line, row);
  return line.str();
}

std::optional<FrameResult> resultOf(const std::string& text) {
  LineReader line(text);
  std::string frame;
  FrameResult result;
  int rows = 0;
  TimingRow& t = result.timing;
  line >> frame >> result.stamp >> t.segment_ms >> t.features_ms >> t.localize_ms >> t.models >> rows;
  t.frame = frame;
  for (int i = 0; i < rows && line; ++i) {
    ResultRow row;
    row.frame = frame;
    read(line, row);
    result.rows.push_back(std::move(row));
  }
  if (!line || rows < 1 || !line.complete()) return {};
  return result;
}

}  // namespace

ResultsJournal::ResultsJournal(const fs::path& folder, int rank)
    : folder_(folder), path_(folder / fileName(rank)), rank_(rank) {}

/** Those of all ranks; how many these were is not known. */
std::vector<fs::path> ResultsJournal::files() const {
  std::vector<fs::path> files;
  if (!fs::is_directory(folder_)) return files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
    if (isJournal(entry.path().filename().string()) && fs::is_regular_file(entry.symlink_status()))
      files.push_back(entry.path());
  return files;
}

bool ResultsJournal::exists() const { return !files().empty(); }

std::map<std::string, FrameResult> ResultsJournal::read() const {
  std::map<std::string, FrameResult> results;
  for (const fs::path& file : files()) {
    std::ifstream in(file);
    if (!in) throw IoError(file.string(), "cannot be read");
    for (std::string line; std::getline(in, line);)
      if (auto result = resultOf(line)) results[result->timing.frame] = std::move(*result);
  }
  return results;
}

void ResultsJournal::begin(const std::map<std::string, FrameResult>& earlier) {
  std::string lines;
  for (const auto& [frame, result] : earlier) lines += lineOf(frame, result);
  out_.emplace(path_, lines);
  for (const fs::path& file : files())
    if (rank_ == 0 && file != path_) fs::remove(file);  // its frames are among the earlier ones
}

void ResultsJournal::append(const std::string& frame, const FrameResult& result) {
  const std::string line = lineOf(frame, result);
  const std::lock_guard<std::mutex> lock(mutex_);
  out_.value().append(line);
}

void ResultsJournal::remove() {
  out_.reset();
  std::error_code ignored;
  for (const fs::path& file : files()) fs::remove(file, ignored);
}

}  // namespace facetloc
