// SPDX-License-Identifier: BSD-3-Clause
#include "batch/batch.h"

#include "cli/text.h"

#include <facetloc/io/error.h>

#include <fmt/core.h>

namespace facetloc {

Stopped::Stopped(std::size_t done, std::size_t total)
    : std::runtime_error(fmt::format("stopped after {} of {}", done, counted(total, "image"))) {}

int Batch::workersFor(int threads, std::size_t items) {
  const std::size_t wanted = threads > 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
  return static_cast<int>(std::clamp<std::size_t>(wanted, 1, std::max<std::size_t>(items, 1)));
}

ItemFailure Batch::failureOf(const Name& name, std::size_t index, const std::function<void()>& job) {
  try {
    job();
    return {};
  } catch (const WriteError&) {
    throw;
  } catch (const IoError& e) {
    return {e.what(), e.what()};  // names the file already
  } catch (const std::exception& e) {
    return {e.what(), fmt::format("{}: {}", name(index), e.what())};
  } catch (...) {
    return {"failed for an unknown reason", name(index) + ": failed for an unknown reason"};
  }
}

Batch::Batch(int threads, std::size_t total, const Console& console)
    : workers_(workersFor(threads, total)), total_(total), console_(console), progress_(console, total) {}

void Batch::run(const Name& name, const Job& job) {
  std::vector<ItemFailure> ended(total_);
  OrderedJobs jobs(
      workers_, ended.size(), ended.size(),
      [&](std::size_t i, int worker) { ended[i] = failureOf(name, i, [&] { job(i, worker); }); }, stop_);
  for (std::size_t i = 0; i < total_; ++i) {
    if (!jobs.next()) throw Stopped(i, total_);
    progress_.step();
    if (!ended[i].message.empty()) failures_.push_back(ended[i].message);
  }
}

int Batch::report() const { return report(failures_, total_, console_); }

int Batch::report(const std::vector<std::string>& failures, std::size_t total, const Console& console) {
  if (failures.empty()) return kOk;
  for (const std::string& failure : failures) console.error(failure);
  console.error(fmt::format("{} of {} failed", failures.size(), counted(total, "item")));
  return kFailed;
}

}  // namespace facetloc
