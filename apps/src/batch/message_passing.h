// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>

/** \file
 * The part of MPI that Ranks needs, in a library of its own (message_passing_mpi.cpp), which join() loads. A
 * process that waits sleeps meanwhile, and leaves the processor to others. */

namespace facetloc::mpi {

struct ProcessId {
  int rank;
  int size;
  int ranks_here;  ///< on this machine
};

/** \brief Throws std::runtime_error, also where the library is missing. The other functions need join()
 * first. */
ProcessId join();
void leave();
void abort(int code);
/** \brief Begins to send, and waits only if much is on its way already. */
void send(const std::string& bytes, int to);
/** \brief Waits until all that was sent is received, or on its way without this process. */
void flush();
/** \brief Nothing if it is given up before there is a message. */
std::optional<std::string> receive(int from, const std::function<bool()>& givesUp);

/** \brief These functions, of the library. */
struct Calls {
  ProcessId (*join)();
  void (*leave)();
  void (*abort)(int code);
  void (*send)(const std::string& bytes, int to);
  void (*flush)();
  std::optional<std::string> (*receive)(int from, const std::function<bool()>& givesUp);
};
extern "C" const Calls* facetlocMessagePassing();

}  // namespace facetloc::mpi
