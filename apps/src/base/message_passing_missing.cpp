// SPDX-License-Identifier: BSD-3-Clause
#include "base/message_passing.h"

#include <stdexcept>

namespace facetloc::mpi {

Place join() { throw std::runtime_error("was built without MPI: start it without mpirun"); }

// Nobody gets here without having joined.
void leave() {}
void abort(int) {}
void broadcast(std::string&) {}
void send(std::string, int) {}
std::string receive(int) { return {}; }

}  // namespace facetloc::mpi
