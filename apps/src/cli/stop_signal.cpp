// SPDX-License-Identifier: BSD-3-Clause
#include "cli/stop_signal.h"

#include <atomic>

namespace facetloc {
namespace {

std::atomic<bool> g_raised{false};  // looked at by all threads
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");
int g_objects = 0;

/** Handles either signal once: the next one, of whichever kind, has its usual effect. */
void raiseFlag(int) {
  g_raised = true;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

}  // namespace

StopSignal::StopSignal() {
  if (g_objects++ == 0) g_raised = false;
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

bool StopSignal::raised() const { return g_raised; }

}  // namespace facetloc
