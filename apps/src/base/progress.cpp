// SPDX-License-Identifier: BSD-3-Clause
#include "base/progress.h"

#include <facetloc/io/text.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

constexpr auto kRefresh = std::chrono::milliseconds(100);

std::string duration(double seconds) {
  const auto s = static_cast<long long>(std::ceil(seconds));
  if (s < 120) return std::to_string(s) + " s";
  if (s < 7200) return std::to_string((s + 30) / 60) + " min";
  return text::decimals(static_cast<double>(s) / 3600, 1) + " h";
}

}  // namespace

std::string progressLine(std::size_t done, std::size_t total, double seconds) {
  const std::string all = std::to_string(total), so_far = std::to_string(done);
  std::string line = std::string(all.size() - std::min(all.size(), so_far.size()), ' ') + so_far + "/" + all;
  if (done == 0 || !(seconds > 0)) return line;
  const double rate = static_cast<double>(done) / seconds;
  line += "  " + text::decimals(rate, 1) + "/s";
  if (done < total) line += "  " + duration(static_cast<double>(total - done) / rate) + " left";
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
  if (done_ == total_) clear();  // what follows begins on an empty line
}

}  // namespace facetloc
