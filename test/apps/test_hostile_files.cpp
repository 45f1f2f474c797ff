// SPDX-License-Identifier: BSD-3-Clause
// Files that were made to harm: each is refused in words that name it, in little time and memory.
#include "process.h"

#include <facetloc/testing/places.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <string>
#include <sys/resource.h>
#include <vector>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using test::Process;
using test::ToolRun;
using testing::HasSubstr;

struct Hostile {
  const char* file;
  const char* fault;
};

void PrintTo(const Hostile& h, std::ostream* out) { *out << h.file; }

fs::path pathOf(const Hostile& hostile) { return dataFolder("hostile") / hostile.file; }

/** The largest of all children so far; children of a test have it from its own pages to begin with. */
long peakOfChildren() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  return used.ru_maxrss;  // [kB]
}

class HostileFiles : public testing::TestWithParam<Hostile> {
protected:
  void SetUp() override {
    path_ = pathOf(GetParam());
    if (!fs::exists(path_)) GTEST_SKIP() << "no data at " << path_ << "; see FACETLOC_DATA";
  }
  void expectRefused(const std::vector<std::string>& command, const std::string& said) const {
    constexpr long kMostMemory = 1000000;  // [kB]
    const ToolRun run = Process(command).wait();
    EXPECT_EQ(run.code, 1) << run.out << run.err;
    EXPECT_THAT(run.out + run.err, HasSubstr(said));
    EXPECT_THAT(run.out + run.err, HasSubstr(GetParam().file));
    EXPECT_LT(peakOfChildren(), kMostMemory);
  }
  fs::path path_;
};

using HostileMaps = HostileFiles;

TEST_P(HostileMaps, AreRefused) {
  expectRefused({kMapTool, "check", path_}, GetParam().fault);
  const test::TemporaryFolder folder;
  test::writeContent(
      folder / "camera.ini",
      "width = 320\nheight = 240\nfx = 262.5\nfy = 262.5\ncx = 159.5\ncy = 119.5\ndepth_scale = 5000\n");
  fs::create_directories(folder / "depth");
  test::writeContent(folder / "depth/0.png", "never read");
  expectRefused({kLocalizeTool, path_, folder / "", "-o", folder / "results"}, GetParam().fault);
}

INSTANTIATE_TEST_SUITE_P(, HostileMaps,
                         testing::Values(Hostile{"index_nan_heading.flmap", "its place index"},
                                         Hostile{"index_flann_terminate.flmap", "its place index"},
                                         Hostile{"picture_bomb.flmap", "its depth picture"},
                                         Hostile{"meta_view.flmap", "it holds a view, meta"}));

using HostilePclzf = HostileFiles;

TEST_P(HostilePclzf, IsRefused) {
  expectRefused({kLiveTool, "--device", path_, "--headless"}, GetParam().fault);
}

INSTANTIATE_TEST_SUITE_P(, HostilePclzf,
                         testing::Values(Hostile{"pclzf_odd_names", "its name tells no time"},
                                         Hostile{"pclzf_width_bit", "its size of 1073742464x480 pixels"}));

}  // namespace
}  // namespace facetloc
