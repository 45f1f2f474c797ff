// SPDX-License-Identifier: BSD-3-Clause
// Frames that another program sends: facetloc_live --device -.
#include "live_tool.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/testing/places.h>

#include <json/json.h>

namespace facetloc::test {
namespace {

/** A Python 3 that has these modules; empty if not found. \param modules separated by commas */
std::string pythonWith(const std::string& modules) {
  for (const char* python : {"python3", "/usr/bin/python3"})
    if (Process({"/usr/bin/env", python, "-c", "import " + modules}).wait().code == 0) return python;
  return {};
}

/** Through a shell, as a user types it. */
std::vector<std::string> shell(const std::string& line) { return {"/bin/sh", "-c", line}; }

class LivePipe : public LiveTool {
protected:
  void SetUp() override {
    python_ = pythonWith("numpy, PIL.Image");
    if (python_.empty()) GTEST_SKIP() << "no Python with numpy and PIL";
  }
  std::string replay(const std::string& folder, const char* rate) const {
    return python_ + " " + examples_ + "/replay.py " + folder + " " + rate;
  }
  std::string live(const std::string& options) const {
    return std::string(kLiveTool) + " --device - --headless " + options;
  }

  const std::string examples_ = fs::path(kSupervise).parent_path().string();
  std::string python_;
};

TEST_F(LivePipe, IsTheSameAsTheFolder) {
  const std::string common = " --every-frame --map " + map() + " --results ";
  const std::string by_pipe = folder_ / "pipe", by_folder = folder_ / "folder";
  const ToolRun piped = ok(Process(shell(replay(sequence(), "0") + " | " + live(common + by_pipe))).wait());
  ok(runLive({"--device", sequence(), "--speed", "0", "--headless", "--every-frame", "--map", map(),
              "--results", by_folder}));
  EXPECT_THAT(piped.err + piped.out, HasSubstr("40 frames received, 40 processed, 0 dropped"));
  EXPECT_EQ(contentOf(by_pipe + "/hypotheses.csv"), contentOf(by_folder + "/hypotheses.csv"));
}

TEST_F(LivePipe, MakesAMap) {
  const std::string made = folder_ / "made.flmap";
  const ToolRun run =
      Process(shell(replay(sequence(), "0") + " | " + live("--every-frame --build " + made))).wait();
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_TRUE(fs::exists(made));
}

TEST_F(LivePipe, ATornFrameEndsWithItsNumberAndKeepsEarlierOnes) {
  const std::string results = folder_ / "results", bytes = folder_ / "bytes";
  ASSERT_EQ(Process(shell(replay(sequence(), "0") + " > " + bytes)).wait().code, 0);
  fs::resize_file(bytes, fs::file_size(bytes) - 1000);
  EXPECT_THAT(Process(shell("cat " + bytes + " | " +
                            live("--every-frame --wait --map " + map() + " --results " + results)))
                  .wait(),
              fails("standard input: frame 40: is torn: the pipe ends 1000 bytes before its last"));
  expectWholeResults(results, 39);
}

TEST_F(LivePipe, WithoutFramesOrCameraSaysSo) {
  EXPECT_THAT(Process(shell(": | " + live(""))).wait().err,
              HasSubstr("standard input: ended without a frame"));
  EXPECT_THAT(Process(shell("sleep 8 | " + live(""))).wait().err,
              HasSubstr("standard input: no frame for 3 s"));
  const std::string header = "printf '{\"stamp\":0,\"width\":4,\"height\":3}\\n'";
  const ToolRun run = Process(shell(header + " | " + live(""))).wait();
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(
      run.err,
      HasSubstr("standard input: frame 1: its header cannot be used: nothing is known of the camera"));
}

/** Lines of the robot stand among the frames for which they hold. */
TEST_F(LivePipe, TakesLinesOfTheRobot) {
  const std::string bytes = folder_ / "bytes", all = folder_ / "all";
  ASSERT_EQ(Process(shell(replay(sequence(), "0") + " > " + bytes)).wait().code, 0);
  const std::string pose = R"({"pose":{"T_w_c":{"position":[900,0,0],"quaternion":[0,0,0,1]},"covariance":[)"
                           R"(1e-6,0,0,0,0,0,1e-6,0,0,0,0,1e-6,0,0,0,1e-6,0,0,1e-6,0,1e-6]}})";
  std::ofstream(all, std::ios::binary) << pose << "\n"
                                       << R"({"pose":5})"
                                       << "\n"
                                       << contentOf(bytes);
  const ToolRun run = ok(Process(shell("cat " + all + " | " + live("--every-frame --map " + map()))).wait());
  EXPECT_THAT(run.err + run.out, HasSubstr("standard input: line 2: its pose cannot be used"));
}

/** A process that is killed in the middle of a frame leaves its rest to the next one. */
TEST_F(LivePipe, IsSupervised) {
  setenv("FACETLOC_LIVE", kLiveTool, 1);
  const std::string own = folder_ / "own.flmap";
  fs::copy_file(map(), own);
  Process running(shell(replay(sequence(), "5") + " | " + python_ + " " + kSupervise + " " + own +
                        " --device - --every-frame"));
  ASSERT_TRUE(eventually([&] { return running.out().find(" go ") != std::string::npos; })) << running.err();
  kill(std::stoi(running.out().substr(running.out().find("start ") + 6)), SIGKILL);
  const ToolRun run = ok(running.wait());
  const auto second = run.out.find("start ", run.out.find("start ") + 1);
  ASSERT_NE(second, std::string::npos) << run.out;
  EXPECT_NE(run.out.find(" go ", second), std::string::npos) << run.out << run.err;
}

TEST_F(LivePipe, RawFramesOfAVideoDeviceAreReadAsOne) {
  const std::string raw = folder_ / "walk.z16";
  const DepthSequence images = DepthSequence::open(sequence());
  std::ofstream out(raw, std::ios::binary);
  for (std::size_t i = 0; i < 10; ++i)
    for (const float z : images.load(i).depth) {
      const auto value = static_cast<std::uint16_t>(std::lround(z * images.camera()->depth_scale));
      out.put(static_cast<char>(value & 0xff)).put(static_cast<char>(value >> 8));
    }
  out.close();
  const std::string results = folder_ / "results";
  const ToolRun run = ok(runLive({"--device", raw, "--camera", sequence() + "/camera.ini", "--headless",
                                  "--every-frame", "--map", map(), "--results", results}));
  EXPECT_EQ(readTrajectory(results + "/poses_tum.txt").poses().size(), 10u) << run.out;
}

}  // namespace
}  // namespace facetloc::test
