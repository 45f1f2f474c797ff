// SPDX-License-Identifier: BSD-3-Clause
#include "base/batch.h"

#include "base/text.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>

namespace facetloc {
namespace {

int workersFor(int threads, std::size_t total) {
  const std::size_t wanted = threads > 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
  return static_cast<int>(std::clamp<std::size_t>(wanted, 1, std::max<std::size_t>(total, 1)));
}

/** Name and cause of what job throws; empty if it comes through. Throws WriteError. */
std::string failureOf(const Batch::Name& name, const Batch::Job& job, std::size_t index, int worker) {
  try {
    job(index, worker);
    return {};
  } catch (const WriteError&) {
    throw;
  } catch (const IoError& e) {
    return e.what();  // names the file already
  } catch (const std::exception& e) {
    return name(index) + ": " + e.what();
  } catch (...) {
    return name(index) + ": failed for an unknown reason";
  }
}

}  // namespace

Stopped::Stopped(std::size_t done, std::size_t total)
    : std::runtime_error("stopped after " + std::to_string(done) + " of " + counted(total, "image")) {}

Batch::Batch(int threads, std::size_t total, const Console& console, const Ranks& ranks)
    : workers_(workersFor(threads, ranks.share(total))),
      total_(total),
      console_(console),
      ranks_(ranks),
      progress_(console, ranks.share(total)) {}

std::vector<bool> Batch::run(std::size_t first, std::size_t last, const Name& name, const Job& job) {
  std::vector<std::string> causes(last - first);
  std::atomic<std::size_t> next{first}, ended{0};
  std::atomic<bool> hopeless{false};
  std::exception_ptr why;
  std::mutex of_why;
  const auto work = [&](int worker) {
    for (std::size_t i = next++; i < last && !hopeless && !stop_.raised(); i = next++) {
      if (!ranks_.owns(i - first)) continue;
      try {
        causes[i - first] = failureOf(name, job, i, worker);
      } catch (const WriteError&) {
        const std::lock_guard<std::mutex> lock(of_why);
        hopeless = true;
        why = std::current_exception();
        return;
      }
      ++ended;
      progress_.step();
    }
  };
  std::vector<std::thread> others;
  try {
    for (int worker = 1; worker < workers_; ++worker) others.emplace_back(work, worker);
  } catch (const std::system_error&) {  // there may be no more threads: those that there are do all the work
  }
  work(0);
  for (std::thread& thread : others) thread.join();
  done_ += ended;
  if (why) std::rethrow_exception(why);
  if (stop_.raised() && done_ < ranks_.share(total_)) throw Stopped(done_, ranks_.share(total_));
  ranks_.collect(causes);

  std::vector<bool> done;
  for (const std::string& cause : causes) {
    done.push_back(cause.empty());
    if (!cause.empty()) failures_.push_back(cause);
  }
  return done;
}

int Batch::report() const {
  if (failures_.empty() || !ranks_.isFirst()) return kOk;
  for (const std::string& failure : failures_) console_.error(failure);
  console_.error(std::to_string(failures_.size()) + " of " + counted(total_, "item") + " failed");
  return kFailed;
}

}  // namespace facetloc
