// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/bytes.h"

#include <cstddef>
#include <string>
#include <vector>

namespace facetloc {

/** \brief The processes of an mpirun job, which work on one task, numbered from 0. A process that was started
 * without mpirun is alone: the first and only rank, and MPI is not touched at all.
 *
 * Items are dealt out like cards, one to each rank in turn: the images of a sequence cost about the same, the
 * more so the closer they are, and nobody has to be asked for the next one.
 *
 * broadcast(), gather() and collect() are called by all ranks in the same order, by one thread each. */
class Ranks {
public:
  /** \brief This process alone. */
  Ranks() = default;
  /** \brief Those of the job that the process was started for. Call it once. Throws std::runtime_error in a
   * job of mpirun if this program was built without MPI. */
  static Ranks join();
  /** \brief The good end: waits for the others. */
  void leave() const;
  /** \brief Ends the whole job with this exit code; returns only if there is none. */
  void abort(int code) const;

  int rank() const { return rank_; }
  int size() const { return size_; }
  bool isFirst() const { return rank_ == 0; }
  /** \brief Threads for each rank that fill the machine it shares with others; 0 = all cores. */
  int threads() const { return threads_; }

  /** \brief Is this item dealt to this rank? */
  bool owns(std::size_t item) const { return item % size_ == static_cast<std::size_t>(rank_); }
  /** \brief How many of the items are. */
  std::size_t share(std::size_t items) const { return (items + size_ - 1 - rank_) / size_; }

  /** \brief The value that the first rank gives, on all ranks. */
  template <class T>
  T broadcast(const T& of_first) const {
    return size_ == 1 ? of_first : fromBytes<T>(broadcastBytes(isFirst() ? toBytes(of_first) : ""));
  }
  /** \brief The values of all ranks, on the first one; nothing elsewhere. */
  template <class T>
  std::vector<T> gather(const T& mine) const {
    if (size_ == 1) return {mine};
    std::vector<T> all;
    for (const std::string& bytes : gatherBytes(toBytes(mine))) all.push_back(fromBytes<T>(bytes));
    return all;
  }
  /** \brief Brings to the first rank the items that the others own. They lose theirs. */
  template <class T>
  void collect(std::vector<T>& items) const {
    if (size_ == 1) return;
    std::vector<T> mine;
    for (std::size_t i = 0; i < items.size() && !isFirst(); ++i)
      if (owns(i)) mine.push_back(std::move(items[i]));
    std::vector<std::vector<T>> all = gather(mine);
    for (std::size_t i = 0; i < items.size() && isFirst(); ++i)
      if (!owns(i)) items[i] = std::move(all[i % size_][i / size_]);
  }

private:
  std::string broadcastBytes(std::string of_first) const;
  std::vector<std::string> gatherBytes(const std::string& mine) const;

  int rank_ = 0;
  int size_ = 1;
  int threads_ = 0;
  bool joined_ = false;
};

}  // namespace facetloc
