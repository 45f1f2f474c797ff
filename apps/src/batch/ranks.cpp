// SPDX-License-Identifier: BSD-3-Clause
#include "batch/ranks.h"

#include "batch/message_passing.h"

#include <algorithm>
#include <cstdlib>
#include <dlfcn.h>
#include <sched.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace facetloc {
namespace {

constexpr char kMessage = 'm', kFailure = 'f', kEnd = 'e';  // first byte of a message to rank 0

Ranks g_here;
const mpi::Calls* g_mpi = nullptr;  // set by join(); a process alone sends nothing
int g_to_hear = 2;                  // messages of the first that a rank has not heard yet: see SharedBatch

/** Tested by the variables that mpirun and srun set: Open MPI, PMIx; MPICH and its kin. */
bool startedByMpirun() {
  const auto has = [](const char* name) { return std::getenv(name) != nullptr; };
  return has("OMPI_COMM_WORLD_SIZE") || has("PMIX_RANK") || has("PMI_RANK");
}

/** The functions of a module, which is possibly not installed, and stays loaded. */
const mpi::Calls& load() {
  std::string problem = "it was built without MPI";
  if (*FACETLOC_MPI_MODULE) {
    void* const loaded = dlopen(FACETLOC_MPI_MODULE, RTLD_NOW | RTLD_GLOBAL);
    void* const found = loaded ? dlsym(loaded, "facetlocMessagePassing") : nullptr;
    if (found) return *reinterpret_cast<const mpi::Calls* (*)()>(found)();
    if (const char* why = dlerror()) problem = why;
  }
  throw std::runtime_error(
      "cannot be started by mpirun: install the package facetloc-tools-mpi, or start it without (" + problem +
      ")");
}

/** The machine's cores over its ranks, and no more than mpirun has bound this one to. */
int threadsFor(int ranks_here) {
  const int share = static_cast<int>(std::thread::hardware_concurrency()) / ranks_here;
  cpu_set_t bound;
  const int allowed = sched_getaffinity(0, sizeof bound, &bound) == 0 ? CPU_COUNT(&bound) : share;
  return std::max(1, std::min(share, allowed));
}

const auto kNever = [] { return false; };

}  // namespace

const Ranks& Ranks::here() { return g_here; }

void Ranks::join() {
  if (!startedByMpirun()) return;
  g_mpi = &load();
  const mpi::ProcessId place = g_mpi->join();
  g_here.rank_ = place.rank;
  g_here.size_ = place.size;
  g_here.threads_ = threadsFor(place.ranks_here);
  g_here.joined_ = true;
}

void Ranks::leave() const {
  if (joined_) g_mpi->leave();
}

void Ranks::abort(int code) const {
  if (joined_) g_mpi->abort(code);
}

void Ranks::fail(int code, const std::string& what) const {
  while (g_to_hear > 0) hear();  // the first may be waiting for that
  g_mpi->send(kFailure + toBytes(std::vector<std::string>{std::to_string(code), what}), 0);
  g_mpi->flush();
  while (true) pause();  // until the first one, which may fail for the same reason, ends the job
}

void Ranks::tell(const std::string& bytes) const {
  for (int rank = 1; rank < size_; ++rank) g_mpi->send(bytes, rank);
  if (g_mpi) g_mpi->flush();
}

std::string Ranks::hear() const {
  std::string bytes = *g_mpi->receive(0, kNever);
  --g_to_hear;
  return bytes;
}

void Ranks::send(const std::string& bytes) const { g_mpi->send(kMessage + bytes, 0); }

std::optional<std::string> Ranks::receive(int rank, const std::function<bool()>& givesUp) const {
  auto bytes = g_mpi->receive(rank, givesUp);
  if (!bytes) return {};
  const char kind = bytes->at(0);
  bytes->erase(0, 1);
  if (kind != kFailure) return bytes;
  const auto words = fromBytes<std::vector<std::string>>(*bytes);
  throw RankFailed(rank, std::atoi(words.at(0).c_str()), words.at(1));
}

void Ranks::finish() const {
  g_mpi->send(std::string(1, kEnd), 0);
  g_mpi->flush();
}

void Ranks::waitForOthers() const {
  for (int rank = 1; rank < size_; ++rank) receive(rank, kNever);
}

}  // namespace facetloc
