// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <exception>

/** \file
 * Shared by the programs that measure. */
namespace facetloc::benchmarks {

/** \brief A share in percent; 0 of nothing. */
inline double percent(std::size_t n, std::size_t of) {
  return of == 0 ? 0 : 100.0 * static_cast<double>(n) / static_cast<double>(of);
}

inline double milliseconds(std::chrono::steady_clock::time_point since) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - since).count();
}

/** \brief Exit code of a run; an exception is printed to stderr and fails it. */
template <class Run>
int runProgram(const char* name, const Run& run, int failed = 1) {
  try {
    return run();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
    return failed;
  }
}

/** \brief The same for an App of the command line. */
template <class SomeApp>
int runProgram(int argc, char** argv) {
  SomeApp app;
  return runApp(app, argc, argv);
}

}  // namespace facetloc::benchmarks
