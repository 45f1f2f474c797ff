// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/output_folder.h"
#include "tool_runner.h"

#include <facetloc/io/error.h>
#include <facetloc/io/png.h>

namespace facetloc::test {
namespace {

using OutputFolder = InAFolder;

TEST_F(OutputFolder, IsTheToolsOwnOrFree) {
  const std::string folder = folder_ / "new/results";
  const auto claim = [&](bool overwrite = false) {
    return messageOf<IoError>([&] { claimFolder(folder, {"a.csv", "b.csv"}, overwrite, nullptr); });
  };
  EXPECT_EQ(claim(), "") << "it is created";
  EXPECT_TRUE(fs::is_directory(folder));
  fs::create_directories(folder + "/sub");
  writeContent(folder + "/sub/notes.txt", "mine");
  writeContent(folder + "/.hidden", "mine");
  EXPECT_EQ(claim(), "") << "hidden files and subfolders do not count";

  writeContent(folder + "/notes.txt", "mine");
  writeContent(folder + "/z.txt", "mine");
  for (const char* words : {"new/results", "notes.txt", "--overwrite"})
    EXPECT_THAT(claim(), HasSubstr(words));
  EXPECT_EQ(claim(true), "");
  writeContent(folder + "/b.csv", "");
  EXPECT_EQ(claim(), "") << "one file of its own is enough";
  EXPECT_EQ(contentOf(folder + "/notes.txt"), "mine");
}

TEST_F(OutputFolder, OfPicturesHoldsNothingElse) {
  const std::string folder = folder_ / "pictures";
  const auto claim = [&](bool overwrite = false) {
    return messageOf<IoError>([&] { claimPictureFolder(folder, overwrite); });
  };
  EXPECT_EQ(claim(), "");
  writePng(folder + "/a.png", Raster<std::uint8_t>{2, 1, 1, {0, 255}});
  EXPECT_EQ(claim(), "") << "drawn before";
  writePng(folder + "/depth.png", Raster<std::uint16_t>{2, 1, 1, {0, 1000}});
  EXPECT_THAT(claim(), HasSubstr("depth.png"));
  EXPECT_EQ(claim(true), "");
}

}  // namespace
}  // namespace facetloc::test
