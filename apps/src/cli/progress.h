// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "cli/text.h"

#include <chrono>
#include <csignal>
#include <cstddef>
#include <memory>
#include <mutex>
#include <ostream>
#include <string>

/** \file
 * Long work as a person at a terminal sees it, and ends it. */

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

/** \brief Shows that work goes on if nothing is printed for a second: the time it has taken, in the line of
 * progress on a terminal, else a dot every two seconds. Output through console() comes whole, on
 * lines of its own. Nothing if quiet. */
class Heartbeat {
public:
  Heartbeat(const Console& console, const std::string& what);
  ~Heartbeat();

  /** \brief For work whose results go to a stream of its own, which does not count as output here. */
  Console console(std::ostream& out) const;
  /** \brief For work that prints to the console given. */
  Console console() const;
  double seconds() const;

private:
  class Watch;
  const Console& console_;
  std::unique_ptr<Watch> watch_;
  Relay out_relay_, err_relay_;
  mutable std::ostream out_{&out_relay_}, err_{&err_relay_};
};

/** \brief Turns the first Ctrl-C or SIGTERM into a flag, for as long as the object lives; the second one
 * kills as ever. Objects may be nested: the flag stays raised until the outermost one is gone. They are made
 * and destroyed by one thread. */
class StopSignal {
public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  bool raised() const;

private:
  struct sigaction interrupt_before_ = {};
  struct sigaction terminate_before_ = {};
};

}  // namespace facetloc
