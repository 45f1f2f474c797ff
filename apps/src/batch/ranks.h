// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "batch/bytes.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

namespace facetloc {

/** \brief Another process of the job has failed. */
struct RankFailed : std::runtime_error {
  RankFailed(int of_rank, int exit_code, const std::string& what)
      : std::runtime_error(what), rank(of_rank), code(exit_code) {}
  int rank, code;
};

/** \brief The processes of an mpirun job, numbered from 0, as App and SharedBatch see them. A process that
 * was started without mpirun is alone: the first and only rank, and MPI is not touched at all.
 *
 * Messages go between the first rank and the others, and arrive in the order in which they were sent. All of
 * it is called by the main thread. */
class Ranks {
public:
  /** \brief This process's; alone until it has joined. */
  static const Ranks& here();
  /** \brief Joins the job that the process was started for, if any. Call it once. Throws std::runtime_error
   * in a job of mpirun if this program was built without MPI. */
  static void join();
  /** \brief The good end: waits for the others. */
  void leave() const;
  /** \brief Ends the whole job with this exit code; returns only if there is no job. */
  void abort(int code) const;
  /** \brief On any rank but the first: hands over to that one why this one fails, which ends the job. */
  [[noreturn]] void fail(int code, const std::string& what) const;

  int rank() const { return rank_; }
  int size() const { return size_; }
  bool isFirst() const { return rank_ == 0; }
  /** \brief Threads for each rank that fill the machine it shares with others; 0 = all cores. */
  int threads() const { return threads_; }

  /** \brief The rank that an item is dealt to. */
  int owner(std::size_t item) const { return static_cast<int>(item % size_); }
  bool owns(std::size_t item) const { return owner(item) == rank_; }
  /** \brief The number of items that this rank owns. */
  std::size_t share(std::size_t items) const { return (items + size_ - 1 - rank_) / size_; }

  /** \brief Sends from the first to all others. */
  void tell(const std::string& bytes) const;
  std::string hear() const;

  /** \brief To the first; it need not have been received yet when this returns. */
  void send(const std::string& bytes) const;
  /** \brief The next message of a rank; nothing if it is given up before there is one. Throws RankFailed. */
  std::optional<std::string> receive(int rank, const std::function<bool()>& givesUp) const;
  /** \brief The last message to the first. */
  void finish() const;
  /** \brief Until all have called finish(). Throws RankFailed. */
  void waitForOthers() const;

private:
  int rank_ = 0;
  int size_ = 1;
  int threads_ = 0;
  bool joined_ = false;
};

}  // namespace facetloc
