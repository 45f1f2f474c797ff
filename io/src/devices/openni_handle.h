// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <OpenNI.h>

#include <dlfcn.h>
#include <exception>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <string>

/** \file
 * The common part of our uses of OpenNI2, and threads for it that never end. Private to io.
 *
 * OpenNI2 keeps the errors of each thread that calls it, and when a new one does, asks the system which of
 * the others are still alive. To ask a thread that has ended is to read memory that may be gone. So
 * programs crash in the end that call OpenNI2 on threads that come and go; the threads on which its streams
 * call back are such, for its own C++ wrapper calls it there before anything else. */

namespace facetloc {

/** \brief Where the loaded OpenNI2 library looks for drivers. */
inline std::string openniDriverFolder() {
  Dl_info info{};
  if (!dladdr(reinterpret_cast<const void*>(&oniInitialize), &info) || !info.dli_fname) return "unknown";
  return (std::filesystem::path(info.dli_fname).parent_path() / "OpenNI2" / "Drivers").string();
}

/** \brief OpenNI2's message about the last error on this thread, in one line. */
inline std::string openniError() {
  std::string text = openni::OpenNI::getExtendedError();
  for (char& c : text)
    if (c == '\n' || c == '\t' || c == '\r') c = ' ';
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

/** \brief Runs a task on a thread that never ends, at once. It must not throw. */
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
