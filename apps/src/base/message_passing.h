// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

/** \file
 * The little that Ranks needs of MPI: message_passing_mpi.cpp, or message_passing_missing.cpp where
 * there is none. */

namespace facetloc::mpi {

struct Place {
  int rank;
  int size;
  int ranks_here;  ///< on this machine
};

Place join();
void leave();
void abort(int code);
/** \brief From rank 0 to all. */
void broadcast(std::string& bytes);
void send(std::string bytes, int to);
std::string receive(int from);

}  // namespace facetloc::mpi
