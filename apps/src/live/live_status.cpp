// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_status.h"

#include "base/text.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace facetloc {
namespace {

std::size_t terminalWidth() {
  constexpr std::size_t kUsual = 80;
  winsize size = {};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

}  // namespace

std::string stateText(const LiveResult& result) {
  const std::string remark = result.remark();
  return result.state() + (remark.empty() ? "" : ": " + remark);
}

std::string timesText(const LiveResult& result, double rate) {
  std::string words = fmt::format("{:.1f} frames/s,  segmentation {:.1f} ms,  features {:.1f} ms", rate,
                                  result.segment_ms, result.features_ms);
  if (result.mapped) words += fmt::format(",  mapping {:.1f} ms", result.localize_ms);
  if (result.answer) words += fmt::format(",  localization {:.1f} ms", result.localize_ms);
  return words +
         fmt::format(",  age {:.0f} ms,  {} of {} dropped", result.age_ms, result.dropped, result.received);
}

void FrameRate::update(std::uint64_t frames) {
  constexpr double kLeastInterval = 1.0;  // [s]
  const Clock::time_point now = Clock::now();
  const double seconds = std::chrono::duration<double>(now - since_).count();
  if (started_ && seconds < kLeastInterval) return;
  if (started_) value_ = static_cast<double>(frames - frames_) / seconds;
  started_ = true;
  since_ = now;
  frames_ = frames;
}

void LiveStatus::show(const LiveResult& result, double rate) {
  if (!visible_) return;
  std::string line = stateText(result);
  if (const PoseWithCovariance* pose = result.isLocalized() ? result.pose() : nullptr) {
    const Eigen::Vector3d p = pose->T.translation();
    line += fmt::format("  {} {} {} m", text::decimals(p.x(), 2), text::decimals(p.y(), 2),
                        text::decimals(p.z(), 2));
  }
  line += fmt::format("  {:.1f}/s  {} of {} dropped", rate, result.dropped, result.received);
  console_.show(line.substr(0, terminalWidth() - 1));
  shown_ = true;
}

void LiveStatus::clear() {
  if (shown_) console_.show("");
  shown_ = false;
}

}  // namespace facetloc
