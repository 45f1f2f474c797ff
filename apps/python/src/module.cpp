// SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"

#include <facetloc/io/error.h>

PYBIND11_MODULE(_facetloc, module) {
  using namespace facetloc;
  // Built-in exception types with the messages of the C++ exceptions.
  pybind11::register_exception<IoError>(module, "IoError", PyExc_OSError);
  module.attr("__version__") = FACETLOC_VERSION;
  python::addRecordings(module);
  python::addLocalization(module);
  python::addMapping(module);
}
