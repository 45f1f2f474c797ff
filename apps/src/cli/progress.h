// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace facetloc {

inline double millisecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/** \brief "  37/250   12.3/s   17 s left" */
std::string progressLine(std::size_t done, std::size_t total, double seconds);

/** \brief One line on a terminal with the share of work done; nothing without a terminal. Thread-safe. */
class Progress {
public:
  Progress(const Console& console, std::size_t total);
  ~Progress();

  void step();

private:
  void clear();

  using Clock = std::chrono::steady_clock;

  const Console& console_;
  bool visible_;
  const std::size_t total_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point shown_;
  std::size_t done_ = 0;
  std::mutex mutex_;
};

}  // namespace facetloc
