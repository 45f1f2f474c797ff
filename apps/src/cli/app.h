// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/command_line.h"

#include <facetloc/features/finding.h>

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Exit codes of the tools. */
enum ExitCode { kOk = 0, kFailed = 1, kUsage = 2 };

/** \brief Where a tool writes: results and their place to out, everything else to err. Each text is written
 * at once, so that it stays whole where other threads and processes write to the same place. */
struct Console {
  std::ostream& out;
  std::ostream& err;
  bool terminal = false;  ///< err is watched by a person, so that a progress line makes sense
  bool quiet = false;     ///< no progress and no remarks
  std::string tool;
  bool watched = false;                           ///< a Heartbeat shows that work goes on
  Findings* findings = nullptr;                   ///< the tool's list, which outlives this
  std::function<void(const Finding&)> publish{};  ///< receives each finding as it is kept; may be empty

  /** \brief Results on out. */
  void print(const std::string& text) const;
  /** \brief A remark on err, unless it is empty or quiet. */
  void note(const std::string& text) const;
  /** \brief Keeps a finding in the list, and remarks it on err; notes not if quiet. */
  void find(const Finding& finding) const;
  /** \brief Keeps it, for who shows it. */
  void keep(const Finding& finding) const;
  /** \brief Writes "facetloc_x: MESSAGE" to err, also if quiet. */
  void error(const std::string& what) const;
  /** \brief A line on err in the place of the one that was shown before; empty = none. */
  void show(const std::string& line) const;
};

/** \brief A command-line tool as a class, so that tests can run it.
 *
 * Every tool has --help, --version, --params, --threads and --quiet. Whatever is thrown becomes a message on
 * err and an exit code here, and nowhere else.
 *
 * Tools that deal out their work run in several processes if mpirun starts them: all execute() up to
 * SharedBatch::helped(), the first one alone goes on from there and has a console.out, remarks and an exit
 * code of its own. A process that throws ends the job, and the first one says why. */
class App {
public:
  virtual ~App() = default;
  /** \brief Runs the tool. The arguments are those of main without the program's name. Never throws. */
  int run(const std::vector<std::string>& arguments, Console console);

protected:
  App(std::string name, std::string synopsis, std::string about);

  virtual void addOptions(CommandLine& line) = 0;
  /** \brief Does the work; the last line on console.out says where the results are. */
  virtual int execute(const CommandLine& line, const Console& console) = 0;
  /** \brief Is the work, with the options that were given, a SharedBatch, for one or several processes? */
  virtual bool dealsOut() const { return false; }
  /** \brief Does the tool itself show that work goes on? Otherwise a Heartbeat does, on a terminal. */
  virtual bool showsWork() const { return false; }

  /** \brief As given, or else this process's share of the machine; 0 = all cores. */
  int threads() const;

private:
  int runInJob(const std::vector<std::string>& arguments, Console& console);
  int parseAndExecute(const std::vector<std::string>& arguments, Console& console);
  int executeWatched(const CommandLine& line, const Console& console);

  std::string name_;
  std::string synopsis_;
  std::string about_;
  std::string findings_;  // file
  int threads_ = 0;
};

/** \brief The body of a main(): runs the tool on the standard streams. */
int runApp(App& app, int argc, const char* const* argv);
/** \brief The standard streams of a program, for its main(). Output is made printable(), a closed stream
 * takes everything, and a reader that goes away ends nothing. */
Console standardConsole();

/** \brief "facetloc 1.2.3". */
std::string versionText();

}  // namespace facetloc
