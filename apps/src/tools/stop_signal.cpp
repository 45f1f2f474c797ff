// SPDX-License-Identifier: BSD-3-Clause
#include "tools/stop_signal.h"

namespace facetloc {
namespace {

volatile std::sig_atomic_t g_raised = 0;
int g_objects = 0;

/** Either signal: what comes next, of whichever kind, has its usual effect. */
void raiseFlag(int) {
  g_raised = 1;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

}  // namespace

StopSignal::StopSignal() {
  if (g_objects++ == 0) g_raised = 0;
  struct sigaction action = {};
  action.sa_handler = raiseFlag;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, &interrupt_before_);
  sigaction(SIGTERM, &action, &terminate_before_);
}

StopSignal::~StopSignal() {
  --g_objects;
  sigaction(SIGINT, &interrupt_before_, nullptr);
  sigaction(SIGTERM, &terminate_before_, nullptr);
}

bool StopSignal::raised() const { return g_raised != 0; }

}  // namespace facetloc
