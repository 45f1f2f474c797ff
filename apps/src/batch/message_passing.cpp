// SPDX-License-Identifier: BSD-3-Clause
#include "batch/message_passing.h"

#include "base/module.h"

#include <stdexcept>

namespace facetloc::mpi {
namespace {

const Calls* g_calls = nullptr;  // set by join(); a process alone has sent nothing that could be flushed

const Calls& load() {
  std::string problem = "it was built without MPI";
  const auto calls =
      *FACETLOC_MPI_MODULE
          ? internal::loadFunction<const Calls*()>(FACETLOC_MPI_MODULE, "facetlocMessagePassing", problem)
          : nullptr;
  if (!calls)
    throw std::runtime_error(
        "cannot be started by mpirun: install the package facetloc-tools-mpi, or start it without (" +
        problem + ")");
  return *calls();
}

}  // namespace

ProcessId join() {
  g_calls = &load();
  return g_calls->join();
}

void leave() { g_calls->leave(); }
void abort(int code) { g_calls->abort(code); }
void send(const std::string& bytes, int to) { g_calls->send(bytes, to); }
void flush() {
  if (g_calls) g_calls->flush();
}
std::optional<std::string> receive(int from, const std::function<bool()>& givesUp) {
  return g_calls->receive(from, givesUp);
}

}  // namespace facetloc::mpi
