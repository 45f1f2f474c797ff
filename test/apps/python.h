// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "process.h"

namespace facetloc::test {

/** \brief A Python 3 that has these modules; empty if not found. \param modules separated by commas */
inline std::string pythonWith(const std::string& modules) {
  for (const char* python : {"python3", "/usr/bin/python3"})
    if (Process({"/usr/bin/env", python, "-c", "import " + modules}).wait().code == 0) return python;
  return {};
}

}  // namespace facetloc::test
