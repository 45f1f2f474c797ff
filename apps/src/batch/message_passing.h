// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>

/** \file
 * The part of MPI that Ranks needs, in a library of its own (message_passing_mpi.cpp), which Ranks loads. A
 * process that waits sleeps meanwhile, and leaves the processor to others. */

namespace facetloc::mpi {

struct ProcessId {
  int rank;
  int size;
  int ranks_here;  ///< on this machine
};

/** \brief The functions of the library. */
struct Calls {
  /** \brief Throws std::runtime_error. The other functions need it first. */
  ProcessId (*join)();
  void (*leave)();
  void (*abort)(int code);
  /** \brief Begins to send, and waits only if much is on its way already. */
  void (*send)(const std::string& bytes, int to);
  /** \brief Waits until all that was sent is received, or on its way without this process. */
  void (*flush)();
  /** \brief Nothing if it is given up before there is a message. */
  std::optional<std::string> (*receive)(int from, const std::function<bool()>& givesUp);
};
extern "C" const Calls* facetlocMessagePassing();

}  // namespace facetloc::mpi
