// SPDX-License-Identifier: BSD-3-Clause
#include "cli/progress.h"

#include <facetloc/testing/matchers.h>

#include <chrono>
#include <sstream>
#include <thread>

namespace facetloc::test {
namespace {

/** Standard error of work that prints, then is silent for a while, then prints again. */
std::string said(bool terminal, bool quiet, std::chrono::milliseconds silence) {
  std::ostringstream out, err;
  const Console console{out, err, terminal, quiet, "tool"};
  {
    const Heartbeat heartbeat(console, "2/4 build");
    const Console inside = heartbeat.console(out);
    inside.error("begins");
    std::this_thread::sleep_for(silence);
    inside.error("ends");
  }
  return err.str();
}

TEST(Heartbeat, SaysHowLongItHasTakenOnATerminal) {
  EXPECT_THAT(said(true, false, std::chrono::milliseconds(1600)),
              ContainsRegex("^tool: begins\n\r[^\n]*2/4 build: 1 s\r[^\n]*tool: ends\n$"));
}

TEST(Heartbeat, IsDotsElsewhere) {
  EXPECT_EQ(said(false, false, std::chrono::milliseconds(2600)), "tool: begins\n.\ntool: ends\n");
}

TEST(Heartbeat, SaysNothingOfWorkThatSpeaksOrIsQuiet) {
  EXPECT_EQ(said(true, false, std::chrono::milliseconds(0)), "tool: begins\ntool: ends\n");
  EXPECT_EQ(said(true, true, std::chrono::milliseconds(1300)), "tool: begins\ntool: ends\n");
}

/** A tool that is silent for a while, and then prints its result. */
class SlowApp : public App {
public:
  explicit SlowApp(bool shows_work) : App("slow", "", "Waits."), shows_work_(shows_work) {}

private:
  void addOptions(CommandLine&) override {}
  bool showsWork() const override { return shows_work_; }
  int execute(const CommandLine&, const Console& console) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(1300));
    console.print("result\n");
    return kOk;
  }

  bool shows_work_;
};

std::string errorsOfSlowApp(bool terminal, const std::vector<std::string>& arguments,
                            bool shows_work = false) {
  std::ostringstream out, err;
  EXPECT_EQ(SlowApp(shows_work).run(arguments, {out, err, terminal, false, ""}), kOk);
  EXPECT_EQ(out.str(), "result\n");
  return err.str();
}

TEST(Heartbeat, EveryToolHasOneOnATerminal) {
  EXPECT_THAT(errorsOfSlowApp(true, {}), ContainsRegex("^\r[^\n]*slow: 1 s\r[^\n]*$"));
  EXPECT_EQ(errorsOfSlowApp(false, {}), "");
  EXPECT_EQ(errorsOfSlowApp(true, {"--quiet"}), "");
  EXPECT_EQ(errorsOfSlowApp(true, {}, true), "");
}

}  // namespace
}  // namespace facetloc::test
