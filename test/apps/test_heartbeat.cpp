// SPDX-License-Identifier: BSD-3-Clause
#include "base/heartbeat.h"

#include <gmock/gmock.h>

#include <chrono>
#include <sstream>
#include <thread>

namespace facetloc {
namespace {

using testing::ContainsRegex;

/** What is on standard error after work that says something, then nothing for a while, then something. */
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

}  // namespace
}  // namespace facetloc
