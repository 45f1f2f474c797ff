// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>

namespace facetloc {

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
