// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/app.h>
#include <facetloc/io/error.h>

#include <pcl/console/print.h>

#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <unistd.h>

namespace facetloc {

void Console::note(const std::string& text) const {
  if (!quiet) err << tool << ": " << text << "\n";
}

void Console::error(const std::string& what) const { err << tool << ": " << what << "\n"; }

App::App(std::string name, std::string synopsis, std::string about)
    : name_(std::move(name)), synopsis_(std::move(synopsis)), about_(std::move(about)) {}

int App::run(const std::vector<std::string>& arguments, Console console) {
  console.tool = name_;
  try {
    return parseAndExecute(arguments, console);
  } catch (const UsageError& e) {
    console.error(e.what());
    console.err << "Try '" << name_ << " --help'.\n";
    return kUsage;
  } catch (const std::exception& e) {
    console.error(e.what());
  } catch (...) {
    console.error("failed for an unknown reason");
  }
  return kFailed;
}

int App::parseAndExecute(const std::vector<std::string>& arguments, Console& console) {
  CommandLine line(name_, synopsis_, about_);
  addOptions(line);
  line.addGeneralOptions(threads_, console.quiet);
  if (!line.parse(arguments, console.out)) return kOk;
  const int code = execute(line, console);
  console.out.flush();
  if (!console.out) throw std::runtime_error("the output cannot be written");
  return code;
}

void App::createFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!std::filesystem::is_directory(path))
    throw IoError(path, "cannot be created: " + (error ? error.message() : "it is a file"));
}

Console standardConsole() {
  // What PCL has to say about a bad file comes as an exception, once.
  if (!std::getenv("PCL_VERBOSITY_LEVEL")) pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  return {std::cout, std::cerr, isatty(STDERR_FILENO) == 1, false, {}};
}

int runApp(App& app, int argc, const char* const* argv) {
  return app.run({argv + 1, argv + argc}, standardConsole());
}

std::string versionText() { return "facetloc " FACETLOC_VERSION; }

}  // namespace facetloc
