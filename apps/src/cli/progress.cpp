// SPDX-License-Identifier: BSD-3-Clause
#include "cli/progress.h"

#include <cmath>
#include <fmt/core.h>

namespace facetloc {
namespace {

constexpr auto kRefresh = std::chrono::milliseconds(100);

std::string duration(double seconds) {
  const auto s = static_cast<long long>(std::ceil(seconds));
  if (s < 120) return fmt::format("{} s", s);
  if (s < 7200) return fmt::format("{} min", (s + 30) / 60);
  return fmt::format("{:.1f} h", static_cast<double>(s) / 3600);
}

}  // namespace

std::string progressLine(std::size_t done, std::size_t total, double seconds) {
  const std::string all = std::to_string(total);
  std::string line = fmt::format("{:>{}}/{}", done, all.size(), all);
  if (done == 0 || !(seconds > 0)) return line;
  const double rate = static_cast<double>(done) / seconds;
  line += fmt::format("  {:.1f}/s", rate);
  if (done < total) line += fmt::format("  {} left", duration(static_cast<double>(total - done) / rate));
  return line;
}

Progress::Progress(const Console& console, std::size_t total)
    : console_(console), visible_(console.terminal && !console.quiet && total > 1), total_(total) {}

Progress::~Progress() { clear(); }

void Progress::clear() {
  if (visible_) console_.show("");
  visible_ = false;
}

void Progress::step() {
  if (!visible_) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  ++done_;
  const Clock::time_point now = Clock::now();
  if (done_ < total_ && now - shown_ < kRefresh) return;
  shown_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  console_.show(progressLine(done_, total_, seconds));
  if (done_ == total_) clear();  // the next output begins on an empty line
}

}  // namespace facetloc
