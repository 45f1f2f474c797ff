// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <dlfcn.h>
#include <string>

/** \file
 * Parts with large dependencies are modules: loaded when they are needed, and possibly not installed.
 */

namespace facetloc::internal {

/** \brief A function of a module, which stays loaded; null and the cause if it is missing. It is looked for
 * where the library or program that calls this looks for its own libraries (RUNPATH). */
template <class Function>
Function* loadFunction(const char* module, const char* name, std::string& problem) {
  void* const loaded = dlopen(module, RTLD_NOW | RTLD_GLOBAL);
  void* const found = loaded ? dlsym(loaded, name) : nullptr;
  if (!found)
    if (const char* why = dlerror()) problem = why;
  return reinterpret_cast<Function*>(found);
}

}  // namespace facetloc::internal
