// SPDX-License-Identifier: BSD-3-Clause
#include "base/ranks.h"

#include "base/message_passing.h"

#include <algorithm>
#include <cstdlib>
#include <sched.h>
#include <thread>

namespace facetloc {
namespace {

/** By what mpirun and srun leave in the environment: Open MPI, PMIx; MPICH and its kin. */
bool startedByMpirun() {
  const auto has = [](const char* name) { return std::getenv(name) != nullptr; };
  return has("OMPI_COMM_WORLD_SIZE") || has("PMIX_RANK") || has("PMI_RANK");
}

/** The machine's cores over its ranks, and no more than mpirun has bound this one to. */
int threadsFor(int ranks_here) {
  const int share = static_cast<int>(std::thread::hardware_concurrency()) / ranks_here;
  cpu_set_t bound;
  const int allowed = sched_getaffinity(0, sizeof bound, &bound) == 0 ? CPU_COUNT(&bound) : share;
  return std::max(1, std::min(share, allowed));
}

}  // namespace

Ranks Ranks::join() {
  Ranks ranks;
  if (!startedByMpirun()) return ranks;
  const mpi::Place place = mpi::join();
  ranks.rank_ = place.rank;
  ranks.size_ = place.size;
  ranks.threads_ = threadsFor(place.ranks_here);
  ranks.joined_ = true;
  return ranks;
}

void Ranks::leave() const {
  if (joined_) mpi::leave();
}

void Ranks::abort(int code) const {
  if (joined_) mpi::abort(code);
}

std::string Ranks::broadcastBytes(std::string of_first) const {
  mpi::broadcast(of_first);
  return of_first;
}

std::vector<std::string> Ranks::gatherBytes(const std::string& mine) const {
  if (!isFirst()) return mpi::send(mine, 0), std::vector<std::string>();
  std::vector<std::string> all = {mine};
  for (int rank = 1; rank < size_; ++rank) all.push_back(mpi::receive(rank));
  return all;
}

}  // namespace facetloc
