// SPDX-License-Identifier: BSD-3-Clause
// The window of the live tool, its keys, and its pictures.
#include "cli/text.h"
#include "drawing/offscreen_display.h"
#include "keyboard.h"  // the last one, because of the macros of X
#include "live_tool.h"

#include <map>

namespace facetloc::test {
namespace {

using namespace std::chrono_literals;

TEST_F(LiveTool, TheSameFrameGivesTheSamePicture) {
  if (!OffscreenDisplay().available()) GTEST_SKIP() << OffscreenDisplay().problem();
  std::map<std::string, std::string> pictures;  // keyed by name
  int compared = 0;
  for (const char* run_name : {"first", "second"}) {
    const std::string shots = folder_ / run_name;
    const ToolRun run =
        ok(runLive({"--device", sequence(), "--headless", "--screenshots", shots, "--every", "1"}));
    const auto names = namesIn(shots);
    EXPECT_THAT(lastLine(run.out), HasSubstr(counted(names.size(), "screenshot") + " in " + shots));
    for (const std::string& name : names) {
      const std::string bytes = contentOf(shots + "/" + name);
      EXPECT_GT(bytes.size(), 20000u) << "an empty picture is smaller";
      const auto [before, is_new] = pictures.emplace(name, bytes);
      if (is_new) continue;
      EXPECT_TRUE(before->second == bytes) << name;
      ++compared;
    }
  }
  EXPECT_GE(compared, 1);
}

/** They take longer than the frames that are to be drawn, which wait. */
TEST_F(LiveTool, LeavesOutNoScreenshotOfAFile) {
  if (!OffscreenDisplay().available()) GTEST_SKIP() << OffscreenDisplay().problem();
  for (const bool every_frame : {false, true}) {
    const std::string shots = folder_ / (every_frame ? "every" : "some");
    std::vector<std::string> arguments = {"--device", sequence(),      "--headless", "--map",
                                          map(),      "--screenshots", shots,        "--every",
                                          "1",        "--speed",       "4"};
    if (every_frame) arguments.push_back("--every-frame");
    const ToolRun run = ok(runLive(arguments));
    const auto pictures = namesIn(shots).size();
    EXPECT_THAT(lastLine(run.out),
                HasAll(" " + std::to_string(pictures) + " processed", Not(HasSubstr("left out"))));
    if (every_frame) {
      EXPECT_EQ(pictures, 40u);
    }
  }
}

TEST_F(LiveTool, NeedsNoDisplayWithoutPictures) {
  EXPECT_THAT(ok(runLive({"--device", sequence(), "--headless", "--max-frames", "1"})).err, IsEmpty());
}

TEST_F(LiveTool, SaysThatAWindowNeedsADisplay) {
  EXPECT_THAT(runLive({"--device", sequence()}), fails("--headless"));
}

TEST_F(LiveTool, ShowsAWindow) {
  const OffscreenDisplay display;
  if (!display.available()) GTEST_SKIP() << display.problem();
  LiveProcess process({"--device", sequence(), "--map", map(), "--duration", "2"}, std::getenv("DISPLAY"));
  const ToolRun run = ok(process.wait());
  EXPECT_THAT(lastLine(run.out), HasSubstr("tracking"));
}

bool press(KeySym key) { return Keyboard().press(key, "facetloc_live"); }

/** Shows a device in a window, with that working directory, and presses q in the end. \param play gets the
 * process before that. */
template <class Play>
ToolRun runWithKeys(const std::string& device, const std::string& folder, const Play& play) {
  std::vector<std::string> command =
      liveCommand({"--device", device, "--repeat", "--every", "1"}, std::getenv("DISPLAY"));
  command.insert(command.begin() + 1, "--chdir=" + folder);
  Process process(command);
  play(process);
  EXPECT_TRUE(eventually([] { return press(XK_q); }));
  return process.wait();
}

TEST_F(LiveTool, MakesNoScreenshotsButThoseOfTheKey) {
  const OffscreenDisplay display;
  if (!display.available()) GTEST_SKIP() << display.problem();
  ok(runWithKeys(sequence(), folder_ / "", [](const Process& process) {
    ASSERT_TRUE(
        eventually([&] { return press(XK_s) && process.err().find("screenshot") != std::string::npos; }));
    std::this_thread::sleep_for(1s);  // frames without a picture
  }));
  EXPECT_THAT(namesIn(folder_ / ""), AllOf(Not(IsEmpty()), Each(HasSubstr("live_"))));
}

TEST_F(LiveTool, GoesOnAfterAKeyThatCannotBeObeyed) {
  const OffscreenDisplay display;
  if (!display.available()) GTEST_SKIP() << display.problem();
  for (const std::string& name : namesIn(sequence() + "/depth"))
    writeContent(folder_ / ("live_" + name), "none of our pictures");
  EXPECT_THAT(ok(runWithKeys(sequence(), folder_ / "",
                             [](const Process& process) {
                               ASSERT_TRUE(eventually([&] { return press(XK_s) && !process.err().empty(); }));
                             }))
                  .err,
              HasSubstr("would overwrite"));
}

TEST_F(LiveTool, CtrlCDoesNotReachThePrivateDisplay) {
  if (!OffscreenDisplay().available()) GTEST_SKIP() << OffscreenDisplay().problem();
  const std::string shots = folder_ / "shots", results = folder_ / "results";
  LiveProcess process({"--device", sequence(), "--headless", "--repeat", "--screenshots", shots, "--every",
                       "5", "--results", results});
  ASSERT_TRUE(eventually([&] { return fs::exists(shots) && namesIn(shots).size() > 1; }));
  process.signal(SIGINT);
  ok(process.wait());
  for (const std::string& name : namesIn(shots)) EXPECT_THAT(name, Not(HasSubstr("tmp")));
}

}  // namespace
}  // namespace facetloc::test
