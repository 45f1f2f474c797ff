// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>

#include <cstdlib>
#include <string>
#include <type_traits>

namespace facetloc::benchmarks {

/** \brief Sets the parameter of that path, such as "ekf.iterations", to the value in a text; false if it does
 * not exist. \param group of a struct of fields */
template <class Params>
bool setParameter(Params& params, const std::string& name, const std::string& value,
                  const std::string& group = {}) {
  bool found = false;
  forEachParam(
      params,
      [&](const ParamInfo& info, auto& field, auto, auto) {
        using Field = std::decay_t<decltype(field)>;
        if (name != info.name) return;
        if constexpr (std::is_enum_v<Field>)
          field = choiceOf<Field>(value);
        else
          field = static_cast<Field>(std::atof(value.c_str()));
        found = true;
      },
      group);
  return found;
}

/** \brief Sets a parameter by an argument of the form --name=value; false if it is none. */
template <class Params>
bool setByArgument(Params& params, const std::string& argument) {
  const std::size_t equals = argument.find('=');
  return argument.rfind("--", 0) == 0 && equals != std::string::npos &&
         setParameter(params, argument.substr(2, equals - 2), argument.substr(equals + 1));
}

}  // namespace facetloc::benchmarks
