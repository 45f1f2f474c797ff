// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "cli/progress.h"
#include "cli/stop_signal.h"

#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace facetloc {

/** \brief The user has pressed Ctrl-C; the message says how far the work has come. */
class Stopped : public std::runtime_error {
public:
  Stopped(std::size_t done, std::size_t total);
};

/** \brief Why an item failed; both are empty if it did not. */
struct ItemFailure {
  std::string reason;
  std::string message;  ///< names the item, too
};

/** \brief Work on many items with several threads, where one bad item stops nothing.
 *
 * Jobs store their results by index, so that the output is the same for any number of threads. Jobs that
 * throw are remembered with their cause, but for WriteError: if one item cannot be written, the next one
 * cannot either. Work that several processes share is a SharedBatch. */
class Batch {
public:
  /** \param threads 0 = all cores; \param total how many items there will be in all. */
  Batch(int threads, std::size_t total, const Console& console);

  /** \brief The number of workers: never more than items. */
  int workers() const { return workers_; }

  using Job = std::function<void(std::size_t index, int worker)>;
  using Name = std::function<std::string(std::size_t index)>;
  /** \brief Calls job for each item, once. \param name of an item, for messages. Throws WriteError of a job,
   * and Stopped at the first Ctrl-C or SIGTERM, once the items that were begun are done. */
  void run(const Name& name, const Job& job);

  /** \brief Name and cause of each item that failed so far, in the order of the items. */
  const std::vector<std::string>& failures() const { return failures_; }
  /** \brief Lists the failures on console.err. \return kFailed if there are any, else kOk. */
  int report() const;

  /** \brief As many workers as threads, 0 = all cores, but never more than items. */
  static int workersFor(int threads, std::size_t items);
  /** \brief Runs the job of an item; its failure, if it throws. Throws WriteError of its job. */
  static ItemFailure failureOf(const Name& name, std::size_t index, const std::function<void()>& job);
  static int report(const std::vector<std::string>& failures, std::size_t total, const Console& console);

private:
  int workers_;
  std::size_t total_;
  const Console& console_;
  Progress progress_;
  StopSignal stop_;
  std::vector<std::string> failures_;
};

}  // namespace facetloc
