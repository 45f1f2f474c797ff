// SPDX-License-Identifier: BSD-3-Clause
// The end of a run of the live tool, and its files.
#include "live_tool.h"

#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

TEST_F(LiveTool, EndsAfterTheGivenFrames) {
  const std::string results = folder_ / "results";
  ok(runLive({"--device", sequence(), "--headless", "--results", results, "--max-frames", "5", "--repeat"}));
  EXPECT_EQ(readHypotheses(results).size(), 5u);
}

TEST_F(LiveTool, EndsAfterTheGivenTime) {
  const auto start = Clock::now();
  ok(runLive({"--device", sequence(), "--headless", "--duration", "0.5", "--repeat"}));
  EXPECT_GE(Clock::now() - start, 500ms);
}

TEST_F(LiveTool, CtrlCEndsInPeaceAndLosesNothing) {
  for (const int number : {SIGINT, SIGTERM}) {
    const std::string results = folder_ / std::to_string(number);
    LiveProcess process(
        {"--device", sequence(), "--map", map(), "--headless", "--repeat", "--results", results});
    ASSERT_TRUE(eventually([&] { return linesOf(results + "/states.csv").size() > 5; }));
    process.signal(number);
    const ToolRun run = ok(process.wait());
    EXPECT_THAT(lastLine(run.out), HasSubstr("processed"));
    expectWholeResults(results, 5);
  }
}

TEST_F(LiveTool, AKilledRunHasLostNothing) {
  const std::string results = folder_ / "results";
  LiveProcess process(
      {"--device", sequence(), "--map", map(), "--headless", "--repeat", "--results", results});
  ASSERT_TRUE(eventually([&] { return linesOf(results + "/states.csv").size() > 5; }));
  process.signal(SIGKILL);
  EXPECT_EQ(process.wait().code, 128 + SIGKILL);
  EXPECT_GE(readHypotheses(results).size(), 5u);
  EXPECT_NO_THROW(readTrajectory(results + "/poses_tum.txt"));
}

}  // namespace
}  // namespace facetloc::test
