// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "cli/app.h"
#include "cli/text.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/results.h>

#include <boost/program_options.hpp>

#include <cctype>
#include <filesystem>
#include <fmt/format.h>
#include <set>
#include <sstream>
#include <utility>

namespace po = boost::program_options;

namespace facetloc {
namespace {

constexpr unsigned kHelpWidth = 110;
constexpr const char* kNats =
    "Scores and evidence are logarithms of odds in nats: each nat multiplies the odds by 2.7.";
constexpr const char* kUsersTitle = "For users";  // heading of those that --help does not list

/** A name may contain a '#': only the first one of a word begins a comment. */
std::string withoutComment(const std::string& line) {
  for (auto i = line.find('#'); i != std::string::npos; i = line.find('#', i + 1))
    if (i == 0 || std::isspace(static_cast<unsigned char>(line[i - 1]))) return line.substr(0, i);
  return line;
}

std::string trimmed(const std::string& line) { return std::string(text::trimmed(line)); }

bool isTruthValue(const std::string& text) {
  static const std::set<std::string> known = {"0", "1", "false", "true", "no", "yes", "off", "on"};
  return known.count(text) > 0;
}

/** "-5" and "-0.5,2" begin with a number, "-x" and "--x" ask for an option. */
bool asksForOption(const std::string& argument) {
  return argument.size() > 1 && argument[0] == '-' &&
         !text::to<double>(argument.substr(0, argument.find(',')));
}

/** Is it a map, by its name? */
bool isMap(const std::string& path) { return text::lowerExtension(path) == ".flmap"; }

/** Is a path not of the kind of its word in the usage: MAP.flmap, RECORDING, RESULTS, ...? Cheap, and without
 * doubt: else the tool itself finds out. */
bool isMisplaced(const std::string& word, const std::string& path) {
  std::error_code ignored;
  if (isMap(word)) return std::filesystem::is_directory(path, ignored);
  if (word == "INPUT") return false;  // any kind
  return isMap(path) || (word == "GROUNDTRUTH" && isResultsFolder(path));
}

/** Kind of a misplaced input. */
std::string kindOf(const std::string& path) {
  if (isMap(path)) return "a map";
  if (isResultsFolder(path)) return "a folder of results";
  try {
    RecordingHints hints;
    hints.segments = true;
    DepthSequence::open(path, hints);
    return "a recording";
  } catch (const std::exception&) {
    return "a folder";
  }
}

std::string wrapped(const std::string& paragraph) {
  std::string out, line;
  for (const std::string_view word : text::words(paragraph)) {
    if (!line.empty() && line.size() + 1 + word.size() > kHelpWidth) {
      out += line + "\n";
      line.clear();
    }
    line.append(line.empty() ? "" : " ").append(word);
  }
  return out + line + "\n";
}

}  // namespace

struct CommandLine::Declared {
  struct Group {
    std::string title;
    Shown shown;
    std::unique_ptr<Options> options;
  };
  Options common{"Options", kHelpWidth}, rare{"Rarely needed", kHelpWidth}, general{"General", kHelpWidth};
  std::vector<Group> groups;  // groups of parameters, in the order of addParams()
  po::variables_map values;
};

CommandLine::CommandLine(std::string tool, std::string synopsis, std::string about)
    : tool_(std::move(tool)),
      synopsis_(std::move(synopsis)),
      about_(std::move(about)),
      declared_(std::make_unique<Declared>()) {
  add(declared_->general, "help,h", po::bool_switch(), "Print this help.", Needs::Nothing);
  add(declared_->general, "help-all", po::bool_switch(),
      "Print all options, with those of the algorithms by group.", Needs::Nothing);
  add(declared_->general, "version", po::bool_switch(), "Print the version.", Needs::Nothing);
  add(declared_->general, "params", bound(params_file_, "FILE"),
      "Read options from a file of 'name = value' lines, with [group] lines for those of the algorithms; the "
      "command line wins.");
}
CommandLine::~CommandLine() = default;

CommandLine::Options& CommandLine::common() { return rare_ ? declared_->rare : declared_->common; }

void CommandLine::addGeneralOptions(int& threads, bool& quiet, std::string& findings) {
  add(declared_->general, "threads", bound(threads, "N"), "Threads; 0 = all cores.");
  add(declared_->general, "quiet,q", po::bool_switch(&quiet), "No progress and no remarks.", Needs::Nothing);
  add(declared_->general, "findings", bound(findings, "FILE"),
      "Write what was found about the input, as JSON (FINDINGS.md).");
  checks_.push_back([&threads] {
    if (threads < 0) throw UsageError(fmt::format("threads = {} is negative", threads));
  });
}

void CommandLine::addArgument(const std::string& word, std::string& value, bool required) {
  arguments_.push_back({word, required, &value});
}

void CommandLine::addArguments(const std::string& word, std::vector<std::string>& values) {
  arguments_.push_back({word, true, nullptr, &values});
}

void CommandLine::addSwitch(const std::string& name, bool& value, const std::string& help) {
  add(common(), name, po::bool_switch(&value), help, Needs::Nothing);
}

template <class T>
CommandLine::Semantic* CommandLine::bound(T& value, const std::string& value_name) {
  auto* semantic = po::value(&value)->value_name(value_name);
  if constexpr (std::is_floating_point_v<T>) semantic->default_value(value, fmt::format("{:g}", value));
  if constexpr (std::is_integral_v<T>) semantic->default_value(value, fmt::format("{:d}", value));
  return semantic;
}
template CommandLine::Semantic* CommandLine::bound(bool&, const std::string&);
template CommandLine::Semantic* CommandLine::bound(int&, const std::string&);
template CommandLine::Semantic* CommandLine::bound(double&, const std::string&);
template CommandLine::Semantic* CommandLine::bound(std::string&, const std::string&);
template CommandLine::Semantic* CommandLine::bound(std::vector<std::string>&, const std::string&);

void CommandLine::add(Options& group, const std::string& name, Semantic* semantic, const std::string& help,
                      Needs needs) {
  group.add_options()(name.c_str(), semantic, help.c_str());
  const auto comma = name.find(',');
  const Option option{name.substr(0, comma), needs, &group != &declared_->general || name == "threads"};
  options_[underscored(option.name)] = option;
  if (comma != std::string::npos) options_[name.substr(comma + 1)] = option;
}

CommandLine::Options& CommandLine::groupOf(const ParamInfo& info, Shown shown) {
  const bool for_users = info.audience == Audience::users && shown == Shown::in_help_all;
  const std::string title = for_users ? kUsersTitle : info.group;
  for (const Declared::Group& group : declared_->groups)
    if (group.title == title && group.shown == shown) return *group.options;
  declared_->groups.push_back({title, shown, std::make_unique<Options>(title, kHelpWidth)});
  return *declared_->groups.back().options;
}

void CommandLine::addChoice(Options& group, const std::string& name, const std::string& value,
                            const std::string& help, const std::function<void(const std::string&)>& assign) {
  add(group, name, po::value<std::string>()->value_name("NAME")->default_value(value)->notifier(assign),
      help);
  const auto dot = name.rfind(".method");
  if (dot != std::string::npos) options_[name.substr(0, dot)] = options_[name];
}

void CommandLine::addPresets() {
  addOption("preset", preset_, "NAME",
            fmt::format("Predefined set of parameters: {}.", fmt::join(presetNames(), ", ")));
}

const CommandLine::Option* CommandLine::find(std::string name) const {
  const auto found = options_.find(underscored(std::move(name)));
  return found == options_.end() ? nullptr : &found->second;
}

/** Names of all options. */
std::vector<std::string> CommandLine::names() const {
  std::vector<std::string> names;
  for (const auto& [key, option] : options_)
    if (key.size() > 1) names.push_back(option.name);  // else a short one
  return names;
}

/** Brings every option into the form --declared-name=value, which leaves nothing for Boost to guess.
 * \param unnamed receives the other arguments */
std::vector<std::string> CommandLine::spelledOut(const std::vector<std::string>& arguments,
                                                 std::vector<std::string>& unnamed) const {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument == "--") {
      unnamed.insert(unnamed.end(), arguments.begin() + static_cast<std::ptrdiff_t>(i) + 1, arguments.end());
      break;
    }
    if (!asksForOption(argument)) {
      unnamed.push_back(argument);
      continue;
    }
    const auto equals = argument.find('=');
    const std::string given_name = argument.substr(0, equals);
    const Option* option = find(given_name.substr(given_name.compare(0, 2, "--") == 0 ? 2 : 1));
    if (!option) {
      const std::string word = given_name.substr(given_name.find_first_not_of('-'));
      throw UsageError(
          fmt::format("unrecognised option '{}'{}", given_name, didYouMean(word, names(), "--")));
    }

    std::string spelled = "--" + option->name;
    const bool has_next = i + 1 < arguments.size() && !asksForOption(arguments[i + 1]);
    if (equals != std::string::npos)
      spelled += argument.substr(equals);
    else if (has_next && (option->needs == Needs::Value ||
                          (option->needs == Needs::Either && isTruthValue(arguments[i + 1]))))
      spelled += "=" + arguments[++i];
    else if (option->needs == Needs::Either)
      spelled += "=true";
    else if (option->needs == Needs::Value)
      throw UsageError(fmt::format("the value of option '{}' is missing", given_name));
    if (option->needs != Needs::Nothing && spelled.back() == '=')
      throw UsageError(fmt::format("the value of option '{}' is empty", given_name));
    out.push_back(spelled);
  }
  return out;
}

/** Each argument gets its value, and a list all that the others leave. */
void CommandLine::assign(const std::vector<std::string>& unnamed) const {
  std::size_t next = 0, required = 0;
  for (const Argument& argument : arguments_) {
    if (argument.required && ++required > unnamed.size()) throw UsageError(argument.word + " is missing");
  }
  std::size_t spare = unnamed.size() - required;
  for (const Argument& argument : arguments_) {
    if (!argument.required && spare == 0) continue;
    if (!argument.required) --spare;
    if (argument.value) *argument.value = unnamed[next++];
    if (!argument.values) continue;
    for (std::size_t n = 1 + std::exchange(spare, 0); n > 0; --n) argument.values->push_back(unnamed[next++]);
  }
  if (spare > 0) throw UsageError("too many arguments");
}

/** Throws UsageError if an argument is at the place of another, such as a recording where a map belongs. */
void CommandLine::requireKinds() const {
  std::vector<std::string> facts;  // "walk is a recording", "walk.flmap is a map", ...
  const auto add = [&facts](const std::string& word, const std::vector<std::string>& paths) {
    for (const std::string& path : paths)
      if (!path.empty() && isMisplaced(word, path)) facts.push_back(path + " is " + kindOf(path));
  };
  for (const Argument& argument : arguments_)
    add(argument.word, argument.values ? *argument.values : std::vector<std::string>{*argument.value});
  for (const auto& option : declared_->common.options()) {
    const std::string word = option->semantic()->name();
    if (!isMap(word) || !declared_->values.count(option->long_name())) continue;
    const boost::any& value = declared_->values[option->long_name()].value();
    if (const auto* path = boost::any_cast<std::string>(&value)) add(word, {*path});
    if (const auto* paths = boost::any_cast<std::vector<std::string>>(&value)) add(word, *paths);
  }
  if (!facts.empty())
    throw UsageError(fmt::format("{}; {} {}", fmt::join(facts, " and "),
                                 facts.size() > 1 ? "the order is" : "expected", synopsis_));
}

/** The lines of a parameter file as arguments. */
std::vector<std::string> CommandLine::parametersIn(std::string_view content, const std::string& path,
                                                   Unknown unknown) const {
  std::vector<std::string> arguments;
  std::string prefix;
  int number = 0;
  for (const std::string_view whole : text::lines(content)) {
    ++number;
    const std::string line = trimmed(withoutComment(std::string(whole)));
    if (line.empty()) continue;
    const auto fail = [&](const std::string& cause) {
      throw UsageError(fmt::format("{}: line {}: {}", path, number, cause));
    };
    if (line.front() == '[' && line.back() == ']') {
      prefix = trimmed(line.substr(1, line.size() - 2));
      if (!prefix.empty()) prefix += ".";
      continue;
    }
    const auto equals = line.find('=');
    if (equals == std::string::npos) fail("expected name = value or [group]");
    const std::string name = prefix + trimmed(line.substr(0, equals));
    const Option* option = find(name);
    if (!option && unknown == Unknown::skipped) continue;
    if (!option || !option->in_files)
      fail(fmt::format("unknown parameter '{}'{}", name, didYouMean(name, names())));
    const std::string value = trimmed(line.substr(equals + 1));
    if (value.empty()) fail(name + " has no value");
    if (option->needs != Needs::Nothing)
      arguments.push_back(fmt::format("--{}={}", option->name, value));
    else if (!isTruthValue(value))
      fail(name + " is either true or false");
    else if (value == "1" || value == "true" || value == "yes" || value == "on")
      arguments.push_back("--" + option->name);
  }
  return arguments;
}

/** Values that are stored already are kept. */
void CommandLine::storeFrom(const std::string& path, const std::vector<std::string>& arguments) try {
  store(arguments);
} catch (const po::error& e) {
  throw UsageError(fmt::format("{}: {}", path, e.what()));
}

void CommandLine::store(const std::vector<std::string>& arguments) {
  using namespace po::command_line_style;
  for (const std::string& argument : arguments)  // Boost would replace such a value without end
    if (argument.find("%value%") != std::string::npos)
      throw po::error(fmt::format("'{}' cannot be an argument", argument));
  Options all;
  all.add(declared_->common).add(declared_->rare).add(declared_->general);
  for (const Declared::Group& group : declared_->groups) all.add(*group.options);
  po::store(po::command_line_parser(arguments).options(all).style(allow_long | long_allow_adjacent).run(),
            declared_->values);
}

bool CommandLine::parse(const std::vector<std::string>& arguments, std::ostream& out) try {
  std::vector<std::string> unnamed;
  store(spelledOut(arguments, unnamed));
  if (declared_->values["help-all"].as<bool>()) return printHelp(out, true), false;
  if (declared_->values["help"].as<bool>()) return printHelp(out, false), false;
  if (declared_->values["version"].as<bool>()) return out << versionText() << "\n", false;
  if (declared_->values.count("params")) {
    const std::string path = declared_->values["params"].as<std::string>();
    std::string content;
    try {
      content = readText(path);
    } catch (const IoError& e) {
      throw UsageError(fmt::format("{}: cannot be read: {}", path, e.cause()));
    }
    storeFrom(path, parametersIn(content, path, Unknown::refused));
  }
  if (declared_->values.count("preset")) {
    const std::string name = declared_->values["preset"].as<std::string>();
    storeFrom("preset " + name, parametersIn(presetText(name), name, Unknown::skipped));
  }
  assign(unnamed);
  po::notify(declared_->values);
  requireKinds();
  for (const auto& check : checks_) check();
  return true;
} catch (const po::error& e) {
  throw UsageError(e.what());
} catch (const std::invalid_argument& e) {  // thrown by checkRanges()
  throw UsageError(e.what());
}

bool CommandLine::has(const std::string& name) const { return find(name) != nullptr; }

bool CommandLine::given(const std::string& name) const {
  const Option* option = find(name);
  return option && declared_->values.count(option->name) && !declared_->values[option->name].defaulted();
}

void CommandLine::printHelp(std::ostream& out, bool all) const {
  out << "Usage: " << tool_ << " " << synopsis_ << "\n\n" << wrapped(about_) << "\n";
  if (!declared_->common.options().empty()) out << declared_->common << "\n";
  for (const Declared::Group& group : declared_->groups)
    if (group.shown == Shown::in_help) out << *group.options << "\n";
  if (all)
    out << declared_->general;
  else
    out << wrapped("Options of all tools: -h, --help; --help-all, with the parameters of the algorithms; "
                   "--version; --params FILE, a file of options; --threads N, 0 = all cores; -q, --quiet: no "
                   "progress and no remarks.");
  if (all && !declared_->rare.options().empty()) out << "\n" << declared_->rare;
  std::ostringstream parameters;
  for (const bool for_users : {true, false})
    for (const Declared::Group& group : declared_->groups)
      if (all && group.shown == Shown::in_help_all && (group.title == kUsersTitle) == for_users)
        parameters << "\n" << *group.options;
  out << parameters.str();
  if (parameters.str().find("[nats]") != std::string::npos) out << "\n" << wrapped(kNats);
  std::size_t width = 0;
  for (const auto& [arguments, what] : examples_) width = std::max(width, arguments.size());
  if (!examples_.empty()) out << "\nExamples:\n";
  for (const auto& [arguments, what] : examples_)
    out << fmt::format("  {} {:{}}  # {}\n", tool_, arguments, width, what);
}

}  // namespace facetloc
