// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace facetloc {

/** \file
 * Parameters are plain structs with defaults. Each has one static template
 *
 *     template <class Self, class Visitor> static void describe(Self& p, Visitor&& field) {
 *       field("name", p.name, lowest, highest, "A sentence with unit and source.");
 *     }
 *
 * and this one list drives validation, command-line options, parameter files, help texts and what is
 * recorded beside maps and results. Fields are bool, int or double; angles named *_deg are in degrees. */

/** \brief Throws std::invalid_argument naming the first field that lies outside its range (NaN does). */
template <class Params>
void checkRanges(const Params& params) {
  Params::describe(params, [](const char* name, const auto& value, auto lowest, auto highest, const char*) {
    if (value >= lowest && value <= highest) return;
    std::ostringstream message;
    message << "parameter " << name << " = " << value << " is outside [" << lowest << ", " << highest << "]";
    throw std::invalid_argument(message.str());
  });
}

/** \brief The parameters, which have been checked; for the lists of constructors and for setters. */
template <class Params>
const Params& checked(const Params& params) {
  checkRanges(params);
  return params;
}

/** \brief A number as the shortest text that reads back as the same number; bool as 0 or 1. */
template <typename T>
std::string numberText(T value) {
  char text[32];
  if constexpr (std::is_same_v<T, bool>)
    return value ? "1" : "0";
  else
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/** \brief The parameters as "name = value" lines, in the order of their description. */
template <class Params>
std::string toIni(const Params& params) {
  std::string out;
  Params::describe(params, [&out](const char* name, const auto& value, auto, auto, const char*) {
    out += std::string(name) + " = " + numberText(value) + "\n";
  });
  return out;
}

}  // namespace facetloc
