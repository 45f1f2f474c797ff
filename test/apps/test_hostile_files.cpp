// SPDX-License-Identifier: BSD-3-Clause
// Files that were made to harm: each is refused in words that name it, in little time and memory.
#include "../io/sql.h"
#include "example_scene.h"
#include "process.h"

#include <facetloc/io/map_database.h>
#include <facetloc/localization/place_index.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/testing/places.h>

#include <algorithm>
#include <ostream>
#include <sys/resource.h>
#include <utility>

namespace facetloc::test {
namespace {

/** The largest of all children so far; children of a test have it from its own pages to begin with. */
long peakOfChildren() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  return used.ru_maxrss;  // [kB]
}

constexpr long kMostMemory = 1000000;  // [kB]

void expectRefused(const std::vector<std::string>& command, const std::string& file,
                   const std::string& fault) {
  const ToolRun run = Process(command).wait();
  EXPECT_EQ(run.code, 1) << run.out << run.err;
  EXPECT_THAT(run.out + run.err, HasAll(fault, file));
  EXPECT_LT(peakOfChildren(), kMostMemory);
}

/** A view of a corner of a room, so often that the views stay in the file. */
Map largeMap() {
  constexpr int kModels = 401;
  Map map;
  map.camera.mounting = CameraMounting{1.0, 8};
  const Eigen::Isometry3d T_w_m = ExampleScene::pose(0, 0, 0);
  View view = ViewBuilder(Camera()).build(ExampleScene().see("corner", T_w_m).depth);
  view.camera = nullptr;
  map.models.assign(kModels, {"", 0, T_w_m, std::move(view)});
  for (int i = 0; i < kModels; ++i) map.models[i].name = std::to_string(i);
  return map;
}

/** A place index whose first place lies nowhere. */
std::string indexOfNoNumbers(const Map& map) {
  std::ostringstream out;
  PlaceIndex(map).write(out);
  std::string bytes = out.str();
  const std::string format = "facetloc place index 1.0";
  // Behind the format: number of models, checksum of names, mounting, covariance, number of places.
  const std::size_t place = bytes.find(format) + format.size() + 8 + 4 + 6 * 8 + 9 * 8 + 8;
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(place), 11 * sizeof(float), '\xFF');
  return bytes;
}

struct HostileMap {
  const char* name;
  const char* damage;  // nothing: to its place index
  const char* fault;
};

void PrintTo(const HostileMap& h, std::ostream* out) { *out << h.name; }

class HostileMaps : public testing::TestWithParam<HostileMap> {
protected:
  void SetUp() override {
    const Map map = largeMap();
    writeMap(path_, map);
    if (GetParam().damage)
      vandalize(path_, GetParam().damage);
    else
      MapDatabase::open(path_).setPlaceIndex([&](std::ostream& out) { out << indexOfNoNumbers(map); });
  }
  TemporaryFolder folder_;
  fs::path path_ = folder_ / "hostile.flmap";
};

TEST_P(HostileMaps, AreRefused) {
  expectRefused({kMapTool, "check", path_}, "hostile.flmap", GetParam().fault);
  writeContent(
      folder_ / "camera.ini",
      "width = 320\nheight = 240\nfx = 262.5\nfy = 262.5\ncx = 159.5\ncy = 119.5\ndepth_scale = 5000\n");
  fs::create_directories(folder_ / "depth");
  writeContent(folder_ / "depth/0.png", "never read");
  expectRefused({kLocalizeTool, path_, folder_ / "", "-o", folder_ / "results"}, "hostile.flmap",
                GetParam().fault);
}

INSTANTIATE_TEST_SUITE_P(
    , HostileMaps,
    testing::Values(HostileMap{"index", nullptr, "its place index"},
                    HostileMap{"bomb",
                               "UPDATE depth_picture SET width = 4096, height = 4096, data = zeroblob(32623)",
                               "its depth picture"},
                    HostileMap{"view",
                               "ALTER TABLE meta RENAME TO m; CREATE VIEW meta AS SELECT key, value FROM m",
                               "it holds a view, meta"},
                    HostileMap{"unreleased", "PRAGMA user_version = 1002", "unreleased version"}));

// The other image of the folder is played.
TEST(HostilePclzf, IsSkippedAndNamed) {
  const std::string folder = dataFolder("hostile") / "pclzf_width_bit";
  if (!fs::exists(folder)) GTEST_SKIP() << "no data at " << folder << "; see FACETLOC_DATA";
  const ToolRun run = ok(Process({kLiveTool, "--device", folder, "--headless"}).wait());
  EXPECT_THAT(run.err, HasAll("pclzf_width_bit", "its size of 1073742464x480 pixels is impossible"));
  EXPECT_LT(peakOfChildren(), kMostMemory);
}

}  // namespace
}  // namespace facetloc::test
