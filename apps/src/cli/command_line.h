// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>

#include <functional>
#include <map>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace boost::program_options {
class options_description;
class value_semantic;
}  // namespace boost::program_options

namespace facetloc {

/** \brief The command line, or a file of parameters, asks for something that does not exist: exit code 2. */
class UsageError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/** \brief The names of the parameter files in apps/presets, which ship with the tools. */
std::vector<std::string> presetNames();
/** \brief The text of one of them. Throws UsageError, which lists them, for another name. */
std::string presetText(const std::string& name);

/** \brief The options of a tool: Boost.Program_options with the habits of GNU and PCL.
 *
 * `--name value`, `--name=value` and `-name value` are the same, and so are dashes and underscores within a
 * name. An argument that is no option is refused, never ignored. Options are bound to variables, whose values
 * are the defaults that the help shows. A switch needs no value; a parameter of type bool may have one
 * (`--score.by_overlap`, `--score.by_overlap=0`). The `method` of a group of parameters can
 * also go by the name of the group (`--split quadtree` is `--split.method quadtree`).
 *
 * --help shows the common options and two examples, on 40 lines at most; --help-all every parameter: those
 * for users first, those for experts by group. */
class CommandLine {
public:
  /** \param tool its name, as in `facetloc_segment`; \param synopsis the rest of the usage line;
   * \param about one paragraph. */
  CommandLine(std::string tool, std::string synopsis, std::string about);
  ~CommandLine();

  /** \brief An argument without a name, of the kind of its word in the usage. Optional ones
   * come last. */
  void addArgument(const std::string& word, std::string& value, bool required = true);
  /** \brief At least one argument, and all that the others leave. */
  void addArguments(const std::string& word, std::vector<std::string>& values);

  /** \brief An option with a value; "name,n" gives it a short form. Strings are shown without their default.
   * A list of strings has one for each time that it is given. */
  template <class T>
  void addOption(const std::string& name, T& value, const std::string& value_name, const std::string& help) {
    add(common(), name, bound(value, value_name), help);
  }
  void addSwitch(const std::string& name, bool& value, const std::string& help);
  /** \brief Options that are added from now on are listed by --help-all alone. */
  void rareFromHere() { rare_ = true; }
  /** \brief Where the options of a group of parameters are shown. */
  enum class Shown { in_help, in_help_all, nowhere };
  /** \brief One option for each field of a parameter struct (features/params.h), validated after parsing.
   * \param name of the group, for a struct of fields */
  template <class Params>
  void addParams(Params& params, const std::string& name = {}, Shown shown = Shown::in_help_all) {
    forEachParam(
        params,
        [&](const ParamInfo& info, auto& value, auto, auto) {
          addParameter(groupOf(info, shown), info.name, value, info.help);
        },
        name);
    checks_.push_back([&params, name] { checkRanges(params, name); });
  }
  /** \brief --preset: a set of parameters that is shipped; those that this tool lacks are left out. */
  void addPresets();

  /** \brief A call that --help shows at its end: its arguments and its purpose. */
  void addExample(const std::string& arguments, const std::string& what) {
    examples_.push_back({arguments, what});
  }

  /** \brief Called when the options have their values; throws UsageError if they make no sense. */
  void addCheck(const std::function<void()>& check) { checks_.push_back(check); }

  /** \brief Reads the arguments (without the program's name) and the file of --params; the command line wins.
   * Both win over a preset. \return false if --help, --help-all or --version was asked for and printed.
   * Throws UsageError. */
  bool parse(const std::vector<std::string>& arguments, std::ostream& out);

  /** \brief The options of every tool beside --help, --version and --params. */
  void addGeneralOptions(int& threads, bool& quiet, std::string& findings);

  /** \brief True if the option was given, be it on the command line or in the file of --params. */
  bool given(const std::string& name) const;
  /** \brief Takes over those fields of a group of numbers, options of addParams(), that were given. */
  template <class Params>
  void takeGiven(Params& params, const Params& options, const std::string& name) const {
    std::map<std::string, double> values;
    forEachParam(
        options, [&](const ParamInfo& info, double value, auto...) { values[info.name] = value; }, name);
    forEachParam(
        params,
        [&](const ParamInfo& info, double& value, auto...) {
          if (given(info.name)) value = values[info.name];
        },
        name);
  }
  /** \brief Does the tool know such an option? */
  bool has(const std::string& name) const;
  /** \brief The file of --params; empty = none. */
  const std::string& paramsFile() const { return params_file_; }
  void printHelp(std::ostream& out, bool all) const;

private:
  using Options = boost::program_options::options_description;
  using Semantic = const boost::program_options::value_semantic;

  enum class Needs { Value, Nothing, Either };
  struct Option {
    std::string name;  // as declared
    Needs needs = Needs::Value;
    bool in_files = true;
  };
  struct Argument {
    std::string word;
    bool required = true;
    std::string* value = nullptr;
    std::vector<std::string>* values = nullptr;  // instead, for a list
  };

  /** For bool, int, double, std::string, and lists of strings. */
  template <class T>
  static Semantic* bound(T& value, const std::string& value_name);
  void add(Options& group, const std::string& name, Semantic* semantic, const std::string& help,
           Needs needs = Needs::Value);
  Options& common();
  Options& groupOf(const ParamInfo& info, Shown shown);
  template <class T>
  void addParameter(Options& group, const std::string& name, T& value, const std::string& help) {
    if constexpr (std::is_same_v<T, bool>) {
      add(group, name, bound(value, "BOOL"), help, Needs::Either);
    } else if constexpr (!std::is_enum_v<T>) {
      add(group, name, bound(value, std::is_integral_v<T> ? "INTEGER" : "NUMBER"), help);
    } else {
      addChoice(group, name, numberText(value), help, [&value, name](const std::string& text) {
        try {
          value = choiceOf<T>(text);
        } catch (const std::invalid_argument& e) {
          throw UsageError(name + ": " + e.what());
        }
      });
    }
  }
  void addChoice(Options& group, const std::string& name, const std::string& value, const std::string& help,
                 const std::function<void(const std::string&)>& assign);

  const Option* find(std::string name) const;
  std::vector<std::string> names() const;
  std::vector<std::string> spelledOut(const std::vector<std::string>& arguments,
                                      std::vector<std::string>& unnamed) const;
  void assign(const std::vector<std::string>& unnamed) const;
  void requireKinds() const;
  enum class Unknown { refused, skipped };
  std::vector<std::string> parametersIn(std::string_view content, const std::string& path,
                                        Unknown unknown) const;
  void storeFrom(const std::string& path, const std::vector<std::string>& arguments);
  void store(const std::vector<std::string>& arguments);

  std::string tool_;
  std::string synopsis_;
  std::string about_;
  std::vector<Argument> arguments_;
  std::map<std::string, Option> options_;  // keys: the name with underscores only, and the short name
  std::vector<std::pair<std::string, std::string>> examples_;  // arguments, purpose
  std::string params_file_;
  std::string preset_;
  bool rare_ = false;
  struct Declared;  // with Boost, whose headers take longer to compile than most tools
  std::unique_ptr<Declared> declared_;
  std::vector<std::function<void()>> checks_;
};

}  // namespace facetloc
