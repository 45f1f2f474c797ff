// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/pose_stream.h"

#include "base/text.h"
#include "cli/findings_file.h"

#include <fmt/core.h>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

constexpr const char* kNothing = "null";
constexpr int kStampDigits = 6;

/** Keeps lines whole: answers and findings come by several threads. */
std::mutex& writing() {
  static std::mutex mutex;
  return mutex;
}

/** JSON string of a name or a reason, which may hold anything. */
std::string quotedJson(const std::string& s) {
  std::string out = "\"";
  for (const char c : s) {
    if (c == '"' || c == '\\') {
      out.append(1, '\\').append(1, c);
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string listOf(const std::vector<double>& numbers) {
  std::string out = "[";
  for (const double value : numbers) out.append(out.size() > 1 ? "," : "").append(text::significant(value));
  return out + "]";
}

std::string poseJson(const std::optional<Eigen::Isometry3d>& T) {
  if (!T) return kNothing;
  Eigen::Quaterniond q = Eigen::Quaterniond(T->linear()).normalized();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const auto& t = T->translation();
  return fmt::format(R"({{"position":{},"quaternion":{}}})", listOf({t.x(), t.y(), t.z()}),
                     listOf({q.x(), q.y(), q.z(), q.w()}));
}

std::string covarianceJson(const Matrix6d& P) {
  std::vector<double> upper;
  for (int r = 0; r < 6; ++r)
    for (int c = r; c < 6; ++c) upper.push_back(P(r, c));
  return listOf(upper);
}

/** JSON object of numbers by their names. */
template <class Named>
std::string objectOf(const Named& numbers) {
  std::string out;
  for (const auto& [name, number] : numbers)
    out += fmt::format("{}{}:{}", out.empty() ? "{" : ",", quotedJson(name), text::significant(number));
  return out + "}";
}

std::string sharesJson(const ViewShares& shares) {
  std::vector<std::pair<std::string, double>> named;
  for (const auto& [name, share] : ViewShares::kNamed) named.emplace_back(name, shares.*share);
  return objectOf(named);
}

std::string lookJson(const std::optional<NextLook>& look) {
  if (!look) return kNothing;
  return fmt::format(R"({{"yaw_deg":{},"ahead":{},"sure":{},"gain":{}}})",
                     text::significant(look->yaw / kDegree), text::significant(look->ahead),
                     text::significant(look->sure), text::significant(look->gain));
}

}  // namespace

std::string toJson(const FrameResult& frame, const std::optional<CameraMounting>& mounting) {
  const ResultRow& best = frame.rows.front();
  std::optional<Eigen::Isometry3d> T_w_b;
  if (best.T_w_c && mounting) T_w_b = *best.T_w_c * mounting->T_b_c().inverse();
  return fmt::format(
      R"({{"stamp":{},"frame":{},"state":{},"probability":{},"model":{},"part":{},"T_w_c":{},"T_w_b":{},)"
      R"("covariance":{},"reason":{},"not_in_map":{},"shares":{},"next_look":{}{}}})",
      text::decimals(frame.stamp, kStampDigits), quotedJson(best.frame), quotedJson(toString(best.state)),
      text::significant(best.probability), best.rank > 0 ? quotedJson(best.model) : kNothing,
      quotedJson(best.part), poseJson(best.T_w_c), poseJson(T_w_b),
      best.P_w_c ? covarianceJson(*best.P_w_c) : kNothing, quotedJson(best.reason),
      best.not_in_map ? text::significant(*best.not_in_map) : kNothing,
      best.shares ? sharesJson(*best.shares) : kNothing, lookJson(best.next_look),
      best.maps.empty() ? "" : R"(,"maps":)" + objectOf(best.maps));
}

void PoseStream::put(std::size_t index, const FrameResult& frame) {
  const std::string line = toJson(frame, mounting_) + "\n";
  const std::lock_guard lock(writing());
  waiting_.emplace(index, line);
  std::string text;
  for (auto first = waiting_.begin(); first != waiting_.end() && first->first == next_; ++next_) {
    text += first->second;
    first = waiting_.erase(first);
  }
  out_ << text << std::flush;
}

void addStreamOption(CommandLine& line, bool& streams) {
  line.addSwitch("stream", streams,
                 "Write each answer to standard output as a line of JSON, all else to standard error.");
}

Console besideStream(const Console& console) {
  const auto publish = [&stream = console.out](const Finding& finding) {
    const std::string line = toJson(finding) + "\n";
    const std::lock_guard lock(writing());
    stream << line << std::flush;
  };
  return {console.err,  console.err,     console.terminal, console.quiet,
          console.tool, console.watched, console.findings, publish};
}

}  // namespace facetloc
