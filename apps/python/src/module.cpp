// SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"

#include <facetloc/io/error.h>

PYBIND11_MODULE(_facetloc, module) {
  using namespace facetloc;
  // With the same sentences; of Python's own kinds, so that nobody needs to know ours.
  pybind11::register_exception<IoError>(module, "IoError", PyExc_OSError);
  python::addRecordings(module);
  python::addLocalization(module);
  python::addMapping(module);
}
