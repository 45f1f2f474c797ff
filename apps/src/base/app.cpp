// SPDX-License-Identifier: BSD-3-Clause
#include "base/app.h"

#include "base/batch.h"
#include "base/text.h"

#include <chrono>
#include <exception>
#include <sstream>
#include <thread>

namespace facetloc {
namespace {

constexpr auto kWordOfTheFirst = std::chrono::seconds(1);  // that other ranks leave it

}  // namespace

void Console::note(const std::string& text) const {
  if (!quiet) err << tool << ": " << printable(text) << "\n";
}

void Console::error(const std::string& what) const { err << tool << ": " << printable(what) << "\n"; }

App::App(std::string name, std::string synopsis, std::string about)
    : name_(std::move(name)), synopsis_(std::move(synopsis)), about_(std::move(about)) {}

int App::run(const std::vector<std::string>& arguments, Console console) {
  console.tool = name_;
  int code = kFailed;
  std::string what = "failed for an unknown reason";
  try {
    ranks_ = Ranks::join();
    code = runOnRank(arguments, console);
    ranks_.leave();
    return code;
  } catch (const UsageError& e) {
    code = kUsage;
    what = std::string(e.what()) + "\nTry '" + name_ + " --help'.";
  } catch (const std::exception& e) {
    what = e.what();
  } catch (...) {
  }
  if (!ranks_.isFirst()) {
    std::this_thread::sleep_for(kWordOfTheFirst);  // if it fails alike, it tells it and ends us
    console.tool += " (rank " + std::to_string(ranks_.rank()) + ")";
  }
  console.error(what);
  console.err.flush();
  ranks_.abort(code);
  return code;
}

int App::runOnRank(const std::vector<std::string>& arguments, Console& console) {
  if (ranks_.size() > 1 && !dealsOut()) throw UsageError("works in one process: start it without mpirun");
  if (ranks_.isFirst()) return parseAndExecute(arguments, console);
  std::ostringstream nowhere;
  Console silent{nowhere, console.err, false, true, console.tool};
  parseAndExecute(arguments, silent);
  return kOk;
}

/** Ctrl-C in a tool that can go on: the message says how. */
int App::executeUntilStopped(const CommandLine& line, const Console& console) try {
  return execute(line, console);
} catch (const Stopped& e) {
  if (!line.has("resume")) throw;
  throw std::runtime_error(std::string(e.what()) + "; the same command with --resume goes on from there");
}

int App::parseAndExecute(const std::vector<std::string>& arguments, Console& console) {
  CommandLine line(name_, synopsis_, about_);
  addOptions(line);
  line.addGeneralOptions(threads_, console.quiet);
  int code = kOk;
  if (line.parse(arguments, console.out)) {
    console.quiet = console.quiet || !ranks_.isFirst();
    code = executeUntilStopped(line, console);
  }
  console.out.flush();
  if (!console.out) throw std::runtime_error("the output cannot be written");
  return code;
}

int runApp(App& app, int argc, const char* const* argv) {
  return app.run({argv + 1, argv + argc}, standardConsole());
}

std::string versionText() { return "facetloc " FACETLOC_VERSION; }

}  // namespace facetloc
