// SPDX-License-Identifier: BSD-3-Clause
#include "base/pose_stream.h"

#include <facetloc/io/text.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <initializer_list>
#include <variant>

namespace facetloc {
namespace {

constexpr const char* kNothing = "null";
constexpr int kStampDigits = 6;

/** In quotes; of names and reasons, which may hold anything. */
std::string quotedJson(const std::string& s) {
  std::string out = "\"";
  for (const char c : s) {
    if (c == '"' || c == '\\') {
      out.append(1, '\\').append(1, c);
    } else if (static_cast<unsigned char>(c) < 0x20) {
      std::array<char, 8> code{};
      std::snprintf(code.data(), code.size(), "\\u%04x", static_cast<unsigned>(c));
      out += code.data();
    } else {
      out += c;
    }
  }
  return out + "\"";
}

template <typename Numbers>
std::string listOf(const Numbers& numbers) {
  std::string out = "[";
  for (const double value : numbers) out.append(out.size() > 1 ? "," : "").append(text::significant(value));
  return out + "]";
}

std::string poseJson(const Eigen::Isometry3d& T) {
  Eigen::Quaterniond q = Eigen::Quaterniond(T.linear()).normalized();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const auto& t = T.translation();
  return "{\"position\":" + listOf(std::initializer_list<double>{t.x(), t.y(), t.z()}) +
         ",\"quaternion\":" + listOf(std::initializer_list<double>{q.x(), q.y(), q.z(), q.w()}) + "}";
}

std::string covarianceJson(const Matrix6d& P) {
  std::vector<double> upper;
  for (int r = 0; r < 6; ++r)
    for (int c = r; c < 6; ++c) upper.push_back(P(r, c));
  return listOf(upper);
}

/** Of hypotheses.csv; null where there is none. */
std::string columnJson(const std::string& name, const ResultRow& row) {
  const auto& columns = resultColumns();
  const auto column = std::find_if(columns.begin(), columns.end(),
                                   [&](const ResultColumn& candidate) { return candidate.name == name; });
  struct Json {
    std::string operator()(const std::string& text) const { return quotedJson(text); }
    std::string operator()(int number) const { return std::to_string(number); }
    std::string operator()(double number) const { return text::significant(number); }
    std::string operator()(AnswerState state) const { return quotedJson(toString(state)); }
    std::string operator()(const std::optional<Eigen::Isometry3d>& T) const {
      return T ? poseJson(*T) : kNothing;
    }
  };
  return std::visit([&row](auto member) { return Json()(row.*member); }, column->value);
}

}  // namespace

std::string toJson(const FrameResult& frame, const std::optional<CameraMounting>& mounting) {
  const ResultRow& best = frame.rows.front();
  std::string line = "{";
  const auto add = [&line](const std::string& key, const std::string& value) {
    line.append(line.size() > 1 ? ",\"" : "\"").append(key).append("\":").append(value);
  };
  add("stamp", text::decimals(frame.stamp, kStampDigits));
  for (const char* key : {"frame", "state", "probability"}) add(key, columnJson(key, best));
  add("model", best.rank > 0 ? columnJson("model", best) : kNothing);
  for (const char* key : {"part", "T_w_c"}) add(key, columnJson(key, best));
  add("T_w_b", best.T_w_c && mounting ? poseJson(*best.T_w_c * mounting->T_b_c().inverse()) : kNothing);
  add("covariance", best.P_w_c ? covarianceJson(*best.P_w_c) : kNothing);
  add("reason", columnJson("reason", best));
  return line + "}";
}

void PoseStream::put(std::size_t index, const FrameResult& frame) {
  const std::string line = toJson(frame, mounting_) + "\n";
  const std::lock_guard lock(mutex_);
  waiting_.emplace(index, line);
  std::string text;
  for (auto first = waiting_.begin(); first != waiting_.end() && first->first == next_; ++next_) {
    text += first->second;
    first = waiting_.erase(first);
  }
  out_ << text << std::flush;
}

void addStreamOption(CommandLine& line, bool& streams) {
  line.addSwitch(
      "stream", streams,
      "Write each answer to standard output as one line of JSON; all else goes to standard error.");
}

Console besideStream(const Console& console) {
  return {console.err, console.err, console.terminal, console.quiet, console.tool};
}

}  // namespace facetloc
