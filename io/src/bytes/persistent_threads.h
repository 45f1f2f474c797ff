// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <functional>
#include <future>
#include <memory>

/** \file
 * Threads that never end, private to io.
 *
 * OpenNI2 keeps the errors of each thread that calls it, and when a new one does, asks the system which of
 * the others are still alive. To ask a thread that has ended is to read memory that may be gone. So
 * programs crash in the end that call OpenNI2 on threads that come and go; the threads on which its streams
 * call back are such, for its own C++ wrapper calls it there before anything else.
 */

namespace facetloc {

/** \brief Runs a task on such a thread, at once. It must not throw. */
void runOnPersistentThread(std::function<void()> task);

/** \brief Runs a task on such a thread and waits for it; its exception is thrown here. */
template <typename Task>
void callOnPersistentThread(const Task& task) {
  const auto done = std::make_shared<std::promise<void>>();  // still told while we go on already
  std::future<void> result = done->get_future();
  runOnPersistentThread([&task, done] {
    try {
      task();
      done->set_value();
    } catch (...) {
      done->set_exception(std::current_exception());
    }
  });
  result.get();
}

}  // namespace facetloc
