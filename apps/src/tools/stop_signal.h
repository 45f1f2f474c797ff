// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>

namespace facetloc {

/** \brief Turns the first Ctrl-C or SIGTERM into a flag, for as long as the object lives; the second one
 * kills as ever. At most one object at a time. */
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
