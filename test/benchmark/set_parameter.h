// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <type_traits>

namespace facetloc::benchmarks {

/** \brief Sets the parameter of that name; false if there is none. */
template <class Params>
bool setParameter(Params& params, const std::string& name, double value) {
  bool found = false;
  Params::describe(params, [&](const char* of_field, auto& field, auto, auto, const char*) {
    if (name != of_field) return;
    field = static_cast<std::decay_t<decltype(field)>>(value);
    found = true;
  });
  return found;
}

}  // namespace facetloc::benchmarks
