// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "process.h"

namespace facetloc::test {

/** \brief A browser without a window, with its own profile; empty path if none is installed. */
class Browser {
public:
  Browser() {
    const char* folders = std::getenv("PATH");
    std::istringstream list(folders ? folders : "");
    for (std::string folder; std::getline(list, folder, ':');)
      for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
        if (path_.empty() && std::filesystem::exists(folder + "/" + name)) path_ = folder + "/" + name;
  }
  bool available() const { return !path_.empty(); }

  /** \brief The page's elements as they are a few seconds of its time after loading. */
  ToolRun elementsOf(const std::string& page) const { return run({"--dump-dom"}, page); }
  /** \brief Writes a picture of the page to a PNG file, as one sees it who prefers dark pages or light ones.
   */
  ToolRun photograph(const std::string& page, const std::string& png, int width, int height,
                     bool dark = false) const {
    return run({"--screenshot=" + png,
                "--window-size=" + std::to_string(width) + "," + std::to_string(height),
                "--blink-settings=preferredColorScheme=" + std::to_string(dark ? 0 : 1)},
               page);
  }
  /** \brief The lines that a page has written to the browser's console. */
  static std::vector<std::string> consoleOf(const ToolRun& run) {
    std::vector<std::string> lines;
    std::istringstream text(run.err);
    for (std::string line; std::getline(text, line);)
      if (line.find("CONSOLE") != std::string::npos) lines.push_back(line);
    return lines;
  }

private:
  ToolRun run(const std::vector<std::string>& options, const std::string& page) const {
    std::vector<std::string> command = {path_,
                                        "--headless",
                                        "--no-sandbox",
                                        "--use-angle=swiftshader",
                                        "--enable-unsafe-swiftshader",
                                        "--hide-scrollbars",
                                        "--force-device-scale-factor=1",
                                        "--virtual-time-budget=4000",
                                        "--enable-logging=stderr",
                                        "--v=0",
                                        "--user-data-dir=" + (profile_ / "")};
    command.insert(command.end(), options.begin(), options.end());
    command.push_back("file://" + page);
    return Process(command).wait();
  }

  std::string path_;
  TemporaryFolder profile_;
};

}  // namespace facetloc::test
