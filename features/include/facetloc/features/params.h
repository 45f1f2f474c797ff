// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <charconv>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace facetloc {

/** \file
 * Parameters are plain structs with defaults. A struct of fields is a group; it has a title and a
 * description,
 *
 *     static constexpr const char* kTitle = "Kalman update of a pose by one pair of segments";
 *     template <class Self, class Visitor> static void describe(Self& p, Visitor&& visit) {
 *       visit("iterations", p.iterations, 1, 100, "A sentence that stands alone, with unit and source.");
 *     }
 *
 * and a struct of groups visits these by their names, `visit("ekf", p.ekf)`. A field is known by its path in
 * the struct, `ekf.iterations`. This one list drives validation, command-line options, parameter files, help
 * texts and the records beside maps and results, and its text is the only one of a field; kForUsers
 * after it marks a field that users have a reason to set. Fields are bool, int, double or a choice; angles
 * named
 * *_deg are in degrees.
 *
 * A choice is an enum class that counts from 0 and whose function namesOf(), next to it, returns an array of
 * the names of its values. */

/** \brief Who has a reason to set a field. */
enum class Audience { experts, users };
constexpr Audience kForUsers = Audience::users;  ///< for describe(); a field is for experts unless it says so

/** \brief Attributes of a field other than its value and its range. */
struct ParamInfo {
  const std::string& name;  ///< its path, such as "ekf.iterations"
  const char* group;        ///< title of its group
  const char* help;
  Audience audience;
};

namespace params_detail {

/** Gives each field its path. */
template <class Function>
class PathVisitor {
public:
  PathVisitor(Function& function, std::string prefix, const char* group)
      : function_(function), prefix_(std::move(prefix)), group_(group) {}

  template <class Field, class Bound>
  void operator()(const char* name, Field& field, Bound lowest, Bound highest, const char* help,
                  Audience audience = Audience::experts) const {
    const std::string path = prefix_ + name;
    function_(ParamInfo{path, group_, help, audience}, field, lowest, highest);
  }
  template <class Group>
  void operator()(const char* name, Group& group) const {
    Group::describe(group, PathVisitor(function_, prefix_ + name + ".", Group::kTitle));
  }

private:
  Function& function_;
  std::string prefix_;
  const char* group_;
};

}  // namespace params_detail

/** \brief Calls a function with (ParamInfo, value, lowest, highest) for each field of a parameter struct.
 * \param name of the group, for a struct of fields that is no part of a larger one */
template <class Params, class Function>
void forEachParam(Params& params, Function&& function, const std::string& name = {}) {
  std::decay_t<Params>::describe(
      params, params_detail::PathVisitor<std::remove_reference_t<Function>>(
                  function, name.empty() ? name : name + ".", std::decay_t<Params>::kTitle));
}

/** \brief Throws std::invalid_argument naming the first field that lies outside its range (NaN does).
 * \param name as of forEachParam() */
template <class Params>
void checkRanges(const Params& params, const std::string& name = {}) {
  forEachParam(
      params,
      [](const ParamInfo& info, const auto& value, auto lowest, auto highest) {
        if (value >= lowest && value <= highest) return;
        std::ostringstream message;
        message << "parameter " << info.name;
        if constexpr (std::is_enum_v<std::decay_t<decltype(value)>>)
          message << " has none of its values";
        else
          message << " = " << value << " is outside [" << lowest << ", " << highest << "]";
        throw std::invalid_argument(message.str());
      },
      name);
}

namespace params_detail {

template <class Params>
auto check(const Params& params, int) -> decltype(params.validate()) {
  params.validate();
}
template <class Params>
void check(const Params& params, long) {
  checkRanges(params);
}

}  // namespace params_detail

/** \brief The parameters, which have been checked, also by their own validate() if they have one; for the
 * lists of constructors and for setters. */
template <class Params>
const Params& checked(const Params& params) {
  params_detail::check(params, 0);
  return params;
}

/** \brief A number as the shortest text that reads back as the same number; bool as 0 or 1, a choice as its
 * name. */
template <typename T>
std::string numberText(T value) {
  char text[32];
  if constexpr (std::is_same_v<T, bool>)
    return value ? "1" : "0";
  else if constexpr (std::is_enum_v<T>)
    return namesOf(value)[static_cast<int>(value)];
  else
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/** \brief The value of a choice that has this name; throws std::invalid_argument if none has. */
template <typename Choice>
Choice choiceOf(const std::string& name) {
  std::string names;
  const auto& known = namesOf(Choice{});
  for (std::size_t i = 0; i < std::size(known); ++i) {
    if (name == known[i]) return static_cast<Choice>(i);
    names += (i > 0 ? ", " : "") + std::string(known[i]);
  }
  throw std::invalid_argument("'" + name + "' is none of: " + names);
}

/** \brief The parameters as "name = value" lines below a "[group]" line for each group, in the order of their
 * description. \param name as of forEachParam() */
template <class Params>
std::string toIni(const Params& params, const std::string& name = {}) {
  std::string out, section;
  forEachParam(
      params,
      [&](const ParamInfo& info, const auto& value, auto, auto) {
        const auto dot = info.name.rfind('.');
        const std::string group = dot == std::string::npos ? "" : info.name.substr(0, dot);
        if (group != section) out += "[" + group + "]\n";
        section = group;
        out += info.name.substr(dot == std::string::npos ? 0 : dot + 1) + " = " + numberText(value) + "\n";
      },
      name);
  return out;
}

}  // namespace facetloc
