// SPDX-License-Identifier: BSD-3-Clause
#include "cli/app.h"

#include "batch/batch.h"
#include "batch/ranks.h"
#include "cli/findings_file.h"
#include "cli/progress.h"
#include "cli/text.h"

#include <exception>
#include <fmt/core.h>
#include <sstream>

namespace facetloc {
namespace {

void writeAtOnce(std::ostream& out, const std::string& text) {
  out.write(text.data(), static_cast<std::streamsize>(text.size())).flush();
}

}  // namespace

void Console::print(const std::string& text) const { writeAtOnce(out, text); }

void Console::note(const std::string& text) const {
  if (!quiet && !text.empty()) error(text);
}

void Console::find(const Finding& finding) const {
  keep(finding);
  if (finding.severity == Severity::note)
    note(finding.text());
  else if (Ranks::here().isFirst())
    error(finding.text());
}

void Console::keep(const Finding& finding) const {
  if (findings) findings->push_back(finding);
  if (publish) publish(finding);
}

void Console::error(const std::string& what) const {
  writeAtOnce(err, fmt::format("{}: {}\n", tool, printable(what)));
}

void Console::show(const std::string& line) const { writeAtOnce(err, "\r\033[K" + line); }

App::App(std::string name, std::string synopsis, std::string about)
    : name_(std::move(name)), synopsis_(std::move(synopsis)), about_(std::move(about)) {}

int App::run(const std::vector<std::string>& arguments, Console console) {
  console.tool = name_;
  int code = kFailed;
  std::string what = "failed for an unknown reason";
  try {
    Ranks::join();
    code = runInJob(arguments, console);
    Ranks::here().leave();
    return code;
  } catch (const RankFailed& e) {
    code = e.code;
    what = e.what();
    console.tool += fmt::format(" (rank {})", e.rank);
  } catch (const UsageError& e) {
    code = kUsage;
    what = fmt::format("{}\nTry '{} --help'.", e.what(), name_);
  } catch (const std::exception& e) {
    what = e.what();
  } catch (...) {
  }
  if (!Ranks::here().isFirst()) Ranks::here().fail(code, what);
  console.error(what);
  Ranks::here().abort(code);
  return code;
}

int App::threads() const { return threads_ > 0 ? threads_ : Ranks::here().threads(); }

int App::runInJob(const std::vector<std::string>& arguments, Console& console) {
  if (Ranks::here().isFirst()) return parseAndExecute(arguments, console);
  std::ostringstream nowhere;
  Console silent{nowhere, console.err, false, true, console.tool};
  parseAndExecute(arguments, silent);
  return kOk;
}

/** A person at a terminal sees after a second that work goes on, whatever it is; after Ctrl-C in a tool that
 * can go on, how. */
int App::executeWatched(const CommandLine& line, const Console& console) try {
  if (!console.terminal || console.quiet || console.watched || showsWork()) return execute(line, console);
  const Heartbeat heartbeat(console, name_);
  return execute(line, heartbeat.console());
} catch (const Stopped& e) {
  if (!line.has("resume")) throw;
  throw std::runtime_error(fmt::format("{}; the same command with --resume goes on from there", e.what()));
}

int App::parseAndExecute(const std::vector<std::string>& arguments, Console& console) {
  CommandLine line(name_, synopsis_, about_);
  addOptions(line);
  line.addGeneralOptions(threads_, console.quiet, findings_);
  int code = kOk;
  Findings found;
  if (!console.findings) console.findings = &found;
  if (line.parse(arguments, console.out)) {
    if (Ranks::here().size() > 1 && !dealsOut())
      throw UsageError("works in one process like this: start it without mpirun");
    console.quiet = console.quiet || !Ranks::here().isFirst();
    const auto write = [&] {
      if (!findings_.empty() && Ranks::here().isFirst()) writeFindings(findings_, *console.findings);
    };
    try {
      code = executeWatched(line, console);
    } catch (...) {
      write();
      throw;
    }
    write();
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
