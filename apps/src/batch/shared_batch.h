// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "batch/batch.h"
#include "batch/ranks.h"

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief Work on many items that the processes of an mpirun job share, each with several threads; without
 * mpirun, one process does it all. The items handed out are the same for any number of
 * processes and threads.
 *
 * Items are dealt out like cards, one to each process in turn: the images of a sequence cost about the same,
 * the more so the closer they are. All processes make the same SharedBatch; the first one decides on the
 * order and receives the results, item by item, the others only help:
 *
 *     SharedBatch<Order, Result> batch(threads(), console, start);
 *     if (batch.helped()) return kOk;
 *     ...
 *     batch.run(order, items, take);
 *
 * Messages are of the types that bytes.cpp lists. */
template <class Order, class Result>
class SharedBatch {
public:
  /** \brief The work on an item, and the item's name for messages. */
  struct Work {
    Batch::Name name;
    std::function<Result(std::size_t item, int worker)> job;
  };
  /** \brief Called in each process when the order is known; 0 <= worker < workers. */
  using Start = std::function<Work(const Order& order, int workers)>;
  /** \brief Receives the outcome of an item: its result, or nothing and the reason. */
  using Take =
      std::function<void(std::size_t item, std::optional<Result>&& result, const std::string& reason)>;

  /** \param threads of each process; 0 = all cores */
  SharedBatch(int threads, const Console& console, Start start)
      : threads_(threads), console_(console), start_(std::move(start)) {}

  /** \brief Does this process's share of the batch that the first one runs, unless it is the first one.
   * \return true if so: nothing is left to do here. Throws as run(). */
  bool helped() const {
    const Ranks& ranks = Ranks::here();
    if (ranks.isFirst()) return false;
    const auto items = fromBytes<std::size_t>(ranks.hear());
    const auto order = fromBytes<Order>(ranks.hear());
    Share share(*this, order, items);
    for (std::size_t item = ranks.rank(); item < items; item += ranks.size()) {
      const Ended ended = share.next(item);
      ranks.send(toBytes(std::vector<std::string>{ended.failure.reason, ended.failure.message}));
      if (ended.result) ranks.send(toBytes(*ended.result));
    }
    ranks.finish();
    return true;
  }

  /** \brief Hands each item to take, in the order of the items and as soon as it is done. Throws WriteError
   * of a job, and Stopped at the first Ctrl-C or SIGTERM, once all items that were done in a row are handed
   * out. */
  void run(const Order& order, std::size_t items, const Take& take) {
    const Ranks& ranks = Ranks::here();
    total_ = items;
    ranks.tell(toBytes(items));
    ranks.tell(toBytes(order));
    Progress progress(console_, items);
    Share share(*this, order, items);
    for (std::size_t item = 0; item < items; ++item) {
      Ended ended = ranks.owns(item) ? share.next(item) : received(ranks, item, share.stop);
      if (!ended.failure.message.empty()) failures_.push_back(ended.failure.message);
      take(item, std::move(ended.result), ended.failure.reason);
      progress.step();
    }
    ranks.waitForOthers();
  }

  const std::vector<std::string>& failures() const { return failures_; }
  /** \brief Lists the failures on console.err. \return kFailed if there are any, else kOk. */
  int report() const { return Batch::report(failures_, total_, console_); }

private:
  static constexpr std::size_t kAheadPerThread = 8;  // items that are kept until those before them are done

  struct Ended {
    ItemFailure failure;
    std::optional<Result> result;
  };

  /** The items of this process. */
  struct Share {
    Share(const SharedBatch& batch, const Order& order, std::size_t all)
        : items(all),
          ended(Ranks::here().share(all)),
          workers(Batch::workersFor(batch.threads_, ended.size())),
          work(batch.start_(order, workers)),
          jobs(
              workers, ended.size(), kAheadPerThread * static_cast<std::size_t>(workers),
              [this](std::size_t i, int worker) {
                const std::size_t item = i * Ranks::here().size() + Ranks::here().rank();
                ended[i].failure =
                    Batch::failureOf(work.name, item, [&] { ended[i].result = work.job(item, worker); });
              },
              stop) {}
    Ended next(std::size_t item) {
      if (!jobs.next()) throw Stopped(item, items);
      return std::move(ended[item / Ranks::here().size()]);
    }

    std::size_t items;
    StopSignal stop;
    std::vector<Ended> ended;
    int workers;
    Work work;
    OrderedJobs jobs;
  };

  Ended received(const Ranks& ranks, std::size_t item, const StopSignal& stop) const {
    const auto receive = [&] {
      auto bytes = ranks.receive(ranks.owner(item), [&stop] { return stop.raised(); });
      if (!bytes) throw Stopped(item, total_);
      return *std::move(bytes);
    };
    const auto failure = fromBytes<std::vector<std::string>>(receive());
    Ended ended{{failure.at(0), failure.at(1)}, {}};
    if (ended.failure.message.empty()) ended.result = fromBytes<Result>(receive());
    return ended;
  }

  int threads_;
  const Console& console_;
  Start start_;
  std::size_t total_ = 0;
  std::vector<std::string> failures_;
};

}  // namespace facetloc
