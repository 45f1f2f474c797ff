// SPDX-License-Identifier: BSD-3-Clause
// Devices that are missing, come later or send nothing.
#include "live_tool.h"

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

TEST_F(LiveTool, SaysThatADeviceIsMissing) {
  const auto start = Clock::now();
  const ToolRun run = runLive({"--device", "vanished://camera", "--headless"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("facetloc_live: vanished://camera"));
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
  const std::vector<std::string> slow = {"--device", images, "--headless", "--speed", "0.001"};
  std::vector<std::string> arguments = slow;
  arguments.insert(arguments.end(), {"--results", results});
  const ToolRun run = runLive(arguments);
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("no frame for 3 s"));
  EXPECT_THAT(lastLine(run.out), HasSubstr("1 processed"));
  expectWholeResults(results, 1);

  arguments = slow;
  arguments.push_back("--wait");
  LiveProcess patient(arguments);
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

}  // namespace
}  // namespace facetloc::test
