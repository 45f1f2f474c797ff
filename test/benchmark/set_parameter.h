// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>

#include <string>
#include <type_traits>

namespace facetloc::benchmarks {

/** \brief Sets the parameter of that path, such as "ekf.iterations"; false if there is none.
 * \param group of a struct of fields */
template <class Params>
bool setParameter(Params& params, const std::string& name, double value, const std::string& group = {}) {
  bool found = false;
  forEachParam(
      params,
      [&](const ParamInfo& info, auto& field, auto, auto) {
        if (name != info.name) return;
        field = static_cast<std::decay_t<decltype(field)>>(value);
        found = true;
      },
      group);
  return found;
}

}  // namespace facetloc::benchmarks
