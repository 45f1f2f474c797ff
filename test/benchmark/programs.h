// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <type_traits>

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

/** \brief Sets a parameter by an argument of the form --PATH=VALUE, such as --ekf.iterations=3; false if it
 * is none. Throws std::invalid_argument for a choice that does not exist. */
template <class Params>
bool setByArgument(Params& params, const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (argument.rfind("--", 0) != 0 || equals == std::string::npos) return false;
  const std::string name = argument.substr(2, equals - 2), value = argument.substr(equals + 1);
  bool found = false;
  forEachParam(params, [&](const ParamInfo& info, auto& field, auto, auto) {
    using Field = std::decay_t<decltype(field)>;
    if (name != info.name) return;
    if constexpr (std::is_enum_v<Field>)
      field = choiceOf<Field>(value);
    else
      field = static_cast<Field>(std::atof(value.c_str()));
    found = true;
  });
  return found;
}

/** \brief Thrown where a program is not called as it has to be: its name and arguments. */
struct Usage {
  const char* synopsis;
};

/** \brief Exit code of a run; an exception is printed to stderr and fails it. */
template <class Run>
int runProgram(const char* name, const Run& run) {
  try {
    run();
    return 0;
  } catch (const Usage& usage) {
    std::fprintf(stderr, "usage: %s\n", usage.synopsis);
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", name, e.what());
    return 1;
  }
}

/** \brief The same for an App of the command line. */
template <class SomeApp>
int runProgram(int argc, char** argv) {
  SomeApp app;
  return runApp(app, argc, argv);
}

}  // namespace facetloc::benchmarks
