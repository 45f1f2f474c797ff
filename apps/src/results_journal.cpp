// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/results_journal.h>
#include <facetloc/apps/text.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <iomanip>
#include <optional>
#include <sstream>

namespace facetloc {
namespace {

constexpr const char* kEnd = "end";  // tells a whole line from a torn one

/** Words on one line: numbers to the last bit, texts in quotes. */
class LineWriter {
public:
  LineWriter& operator<<(double value) { return word(exactNumber(value)); }
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
  std::string str() const { return line_ + kEnd + "\n"; }

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
    if (const auto number = toNumber(word))
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
  /** The line was whole. */
  bool complete() {
    std::string word;
    return in_ >> word && word == kEnd;
  }
  explicit operator bool() const { return !in_.fail(); }

private:
  std::istringstream in_;
};

void write(LineWriter& line, const ResultRow& row) {
  line << row.rank << row.model << row.probability << row.score << row.T_m_c << int(row.T_w_c.has_value());
  if (row.T_w_c) line << *row.T_w_c;
  line << row.sd_rot_deg << row.sd_trans_m << row.reason;
}

void read(LineReader& line, ResultRow& row) {
  int has_world_pose = 0;
  line >> row.rank >> row.model >> row.probability >> row.score >> row.T_m_c >> has_world_pose;
  if (has_world_pose) line >> row.T_w_c.emplace();
  line >> row.sd_rot_deg >> row.sd_trans_m >> row.reason;
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

ResultsJournal::ResultsJournal(const std::filesystem::path& folder) : path_(folder / "partial.txt") {}

bool ResultsJournal::exists() const { return std::filesystem::exists(path_); }

std::map<std::string, FrameResult> ResultsJournal::read() const {
  std::map<std::string, FrameResult> results;
  std::ifstream in(path_);
  if (!in) throw IoError(path_.string(), "cannot be read");
  for (std::string line; std::getline(in, line);)
    if (auto result = resultOf(line)) results[result->timing.frame] = std::move(*result);
  return results;
}

void ResultsJournal::begin(const std::map<std::string, FrameResult>& earlier) {
  writeTextAtomically(path_, [&](std::ostream& out) {
    for (const auto& [frame, result] : earlier) out << lineOf(frame, result);
  });
  out_.open(path_, std::ios::app);
  if (!out_) throw IoError(path_.string(), "cannot be written");
}

void ResultsJournal::append(const std::string& frame, const FrameResult& result) {
  const std::string line = lineOf(frame, result);
  const std::lock_guard<std::mutex> lock(mutex_);
  out_ << line << std::flush;
  if (!out_) throw IoError(path_.string(), "cannot be written");
}

void ResultsJournal::remove() {
  out_.close();
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace facetloc
