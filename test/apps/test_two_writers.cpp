// SPDX-License-Identifier: BSD-3-Clause
// Programs that write to the same place, that are stopped, or whose reader goes away.
#include "example_room.h"
#include "process.h"

#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/testing/places.h>

#include <sys/stat.h>
#include <utility>

namespace facetloc::test {
namespace {

/** A process in the shell's way: "command > file" and the like. */
ToolRun shell(const std::string& command) { return Process({"/bin/sh", "-c", command}).wait(); }

class TwoWriters : public Tools {
protected:
  /** All images of the query, the last but one a pipe whose writer takes its time. */
  std::string slowImages() {
    const std::string input = folder_.copyOf(query(), "input");
    const std::string pipe = filesOf(input + "/depth").rbegin()[1].string();
    fs::remove(pipe);
    EXPECT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    pipe_ = open(pipe.c_str(), O_RDWR | O_CLOEXEC);
    return input;
  }
  ~TwoWriters() override {
    if (pipe_ >= 0) close(pipe_);
  }
  int pipe_ = -1;
};

TEST_F(TwoWriters, OneBuildsAMapAndTheOtherSaysWhoIsInTheWay) {
  const std::string input = slowImages(), path = folder_ / "m.flmap";
  for (const char* flag : {"", "--resume", "--overwrite"}) {
    if (*flag) {
      ok(runMap({"build", query(), "-o", path, "--every", "3", "--overwrite"}));
    }
    const std::string before = contentOf(path);
    std::vector<std::string> build = {kMapTool, "build", input, "-o", path, "--every", "1"};
    if (*flag) build.emplace_back("--overwrite");
    Process first(build);
    // To try the lock would be in the way of the process.
    const std::string held = "FLOCK  ADVISORY  WRITE " + std::to_string(first.id()) + " ";
    ASSERT_TRUE(eventually([&] { return contentOf("/proc/locks").find(held) != std::string::npos; }));
    std::vector<std::string> again = {kMapTool, "build", query(), "-o", path, "--every", "3"};
    if (*flag) again.emplace_back(flag);
    EXPECT_THAT(Process(again).wait(),
                fails("m.flmap: is being written by process " + std::to_string(first.id())));
    if (*flag) {
      EXPECT_EQ(contentOf(path), before);
    }
    first.signal(SIGKILL);
    first.wait();
  }
  ok(runMap({"build", query(), "-o", path, "--every", "3", "--overwrite"}));
  ok(runMap({"check", path}));
  for (const fs::path& file : filesOf(folder_ / ""))
    EXPECT_THAT(file.filename().string(), AnyOf("m.flmap", "input")) << "left behind";
}

TEST_F(TwoWriters, OneLocalizesAndTheOtherSaysWhoIsInTheWay) {
  const std::string input = slowImages(), results = folder_ / "results";
  Process first({kLocalizeTool, map(), input, "-o", results});
  ASSERT_TRUE(eventually([&] { return fs::exists(results + "/images.txt"); }));
  for (const char* flag : {"--quiet", "--resume"}) {
    EXPECT_THAT(Process({kLocalizeTool, map(), query(), "-o", results, flag}).wait(),
                fails("results: is being written by process " + std::to_string(first.id())));
  }
}

TEST_F(TwoWriters, CtrlCSaysHowToGoOn) {
  const std::string input = slowImages(), results = folder_ / "results";
  Process job({kLocalizeTool, map(), input, "-o", results, "--threads", "1"});
  ASSERT_TRUE(eventually([&] {
    return fs::exists(results + "/hypotheses.csv") && readResults(results).size() == kFrames - 2u;
  }));
  job.signal(SIGINT);
  close(std::exchange(pipe_, -1));  // the image ends
  EXPECT_THAT(job.wait(), fails("stopped after ", "--resume goes on"));
  EXPECT_EQ(readResults(results).size(), kFrames - 1u);
}

TEST_F(TwoWriters, APipeWithoutAWriterIsRefusedWithoutWaiting) {
  const std::string pipe = folder_ / "a.flmap";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(Process({kMapTool, "check", pipe}).wait().err, HasSubstr("is a pipe, not a file"));
  const std::string image = folder_ / "1.png";
  fs::rename(pipe, image);
  fs::copy(query() + "/camera.ini", folder_ / "camera.ini");
  EXPECT_THAT(Process({kSegmentTool, image, "-o", folder_ / "out"}).wait(), fails("1.png: is empty"));
}

/** Output would go to the first file that is opened. */
TEST_F(TwoWriters, AClosedOrDesertedOutputEndsNothing) {
  const std::string info = std::string(kMapTool) + " info " + map();
  ok(shell(info + " >&-"));
  ok(shell(info + " >&- 2>&- <&-"));
  EXPECT_EQ(shell("{ " + info + "; echo $? >&2; } | true").err, "0\n");
  if (fs::exists("/dev/full")) {
    EXPECT_EQ(shell(info + " > /dev/full").code, kFailed);
  }
}

TEST_F(TwoWriters, NamesAndTextsOfMapsDoNotCommandTheTerminal) {
  const std::string path = folder_ / "\x1B[2Jm.flmap";
  fs::copy(map(), path);
  MapDatabase::open(path).setMeta("note", "\x1B]0;title\x07");
  const ToolRun info = ok(Process({kMapTool, "info", path}).wait());
  EXPECT_THAT(info.out, HasAll("note: \\x1b]0;title\\x07", "\\x1b[2Jm.flmap", Not(HasSubstr("\x1B"))));
  EXPECT_THAT(Process({kMapTool, "info", path + "x"}).wait().err,
              HasAll("\\x1b[2Jm.flmapx: does not exist", Not(HasSubstr("\x1B"))));
}

}  // namespace
}  // namespace facetloc::test
