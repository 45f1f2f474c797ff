// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <dlfcn.h>
#include <string>

/** \file
 * Parts that need what not everybody wants to install are modules: loaded when they are needed, or missing.
 */

namespace facetloc::internal {

/** \brief A function of a module, which stays loaded; null, and why, if there is none. It is looked for where
 * the library or program that calls this looks for its own libraries (RUNPATH). */
template <class Function>
Function* loadFunction(const char* module, const char* name, std::string& problem) {
  void* const loaded = dlopen(module, RTLD_NOW | RTLD_GLOBAL);
  void* const found = loaded ? dlsym(loaded, name) : nullptr;
  if (!found)
    if (const char* why = dlerror()) problem = why;
  return reinterpret_cast<Function*>(found);
}

}  // namespace facetloc::internal
