// SPDX-License-Identifier: BSD-3-Clause
//
// README's library example, as it stands there, beside the tool.
#include "example_room.h"
#include "tools/localize_app.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/registration/global_localization.h>
#include <facetloc/segmentation/view_builder.h>

#include <gmock/gmock.h>

#include <iostream>
#include <memory>
#include <sstream>

namespace facetloc::test {
namespace {

namespace fs = std::filesystem;

void exampleOfReadme(){
#include "readme_example.inc"
}

/** What the example prints in a folder. */
std::string printedIn(const std::string& folder) {
  const fs::path before = fs::current_path();
  std::ostringstream out;
  std::streambuf* const console = std::cout.rdbuf(out.rdbuf());
  fs::current_path(folder);
  exampleOfReadme();
  fs::current_path(before);
  std::cout.rdbuf(console);
  return out.str();
}

/** What the results of the tool look like when they are printed so. */
std::string printed(const std::vector<ResultRow>& rows) {
  std::ostringstream out;
  for (const ResultRow& row : rows) {
    if (row.rank == 0) out << row.reason << "\n";
    if (row.rank == 1) out << row.probability << " at " << row.T_w_c->translation().transpose() << "\n";
  }
  return out.str();
}

class Readme : public Tools {
protected:
  /** \param change of the images' camera */
  void expectSameAsTheTool(const std::function<void(Camera&)>& change) {
    fs::copy(map(), folder_ / "office.flmap");
    fs::copy(query(), folder_ / "walk", fs::copy_options::recursive);
    CameraFile file = readCameraFile(folder_ / "walk/camera.ini");
    change(file.camera);
    writeCameraFile(folder_ / "walk/camera.ini", file);
    const ToolRun run =
        runTool<LocalizeApp>({folder_ / "office.flmap", folder_ / "walk", "-o", folder_ / "results"});
    ASSERT_EQ(run.code, kOk) << run.err;
    const std::string by_example = printedIn(folder_ / "."),
                      by_tool = printed(readHypotheses(folder_ / "results"));
    EXPECT_EQ(by_example, by_tool);
    EXPECT_THAT(by_example, testing::HasSubstr(" at "));
  }
};

TEST_F(Readme, TheLibraryAnswersAsTheToolForARobotsCamera) {
  expectSameAsTheTool([](Camera&) {});
}
TEST_F(Readme, TheLibraryAnswersAsTheToolForACameraInTheHand) {
  expectSameAsTheTool([](Camera& camera) { camera.mounting.reset(); });
}
TEST_F(Readme, TheLibraryAnswersAsTheToolForANoisierCamera) {
  expectSameAsTheTool([](Camera& camera) { camera.noise.inverse_depth_std *= 4; });
}

}  // namespace
}  // namespace facetloc::test
