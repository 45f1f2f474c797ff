// SPDX-License-Identifier: BSD-3-Clause
// Devices that are missing, come later or send nothing; the end of a run, and its files.
#include "live_tool.h"

#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

TEST_F(LiveTool, SaysThatADeviceIsMissing) {
  const auto start = Clock::now();
  EXPECT_THAT(runLive({"--device", "vanished://camera", "--headless"}),
              fails("facetloc_live: vanished://camera"));
  EXPECT_LT(Clock::now() - start, kPatience / 2);
  EXPECT_THAT(runLive({"--device", folder_ / "nothing.oni", "--headless"}), fails("nothing.oni"));
  EXPECT_THAT(runLive({"--device", "runs/mistyped", "--headless"}), fails("runs/mistyped: does not exist"));
}

TEST_F(LiveTool, WaitsForADeviceUntilStopped) {
  LiveProcess process({"--device", folder_ / "later.oni", "--headless", "--wait"});
  ASSERT_TRUE(eventually([&] { return process.err().find("waiting for it") != std::string::npos; }));
  std::this_thread::sleep_for(2500ms);  // it looks again, and says nothing
  process.signal(SIGINT);
  const ToolRun run = ok(process.wait());
  EXPECT_EQ(run.err.find("waiting"), run.err.rfind("waiting")) << run.err;
}

TEST_F(LiveTool, WaitsForADeviceForALimitedTime) {
  const auto start = Clock::now();
  ok(runLive({"--device", folder_ / "never.oni", "--headless", "--wait", "--duration", "1.5"}));
  EXPECT_GE(Clock::now() - start, 1500ms);
}

TEST_F(LiveTool, SaysThatNoFrameComes) {
  const std::string images = writePclzf(3), results = folder_ / "results";
  const Arguments slow = {"--device", images, "--headless", "--speed", "0.001"};
  const ToolRun run = runLive(slow + Arguments{"--results", results});
  EXPECT_THAT(run, fails("no frame for 3 s"));
  EXPECT_THAT(lastLine(run.out), HasSubstr("1 processed"));
  expectWholeResults(results, 1);

  LiveProcess patient(slow + Arguments{"--wait"});
  ASSERT_TRUE(eventually([&] { return patient.err().find("waiting for it") != std::string::npos; }));
  patient.signal(SIGINT);
  ok(patient.wait());
}

TEST_F(LiveTool, FindsADeviceThatComesLater) {
  const std::string folder = folder_ / "camera.oni";
  LiveProcess process({"--device", folder, "--headless", "--wait"});
  ASSERT_TRUE(eventually([&] { return process.err().find("waiting for it") != std::string::npos; }));
  // A recording in the place where it is waited for.
  ok(runLive({"--device", sequence(), "--headless", "--record", folder_ / "new.oni", "--max-frames", "3"}));
  fs::rename(folder_ / "new.oni", folder);
  const ToolRun run = ok(process.wait());
  EXPECT_THAT(lastLine(run.out), HasSubstr("segmenting 100.0 %"));
}

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
