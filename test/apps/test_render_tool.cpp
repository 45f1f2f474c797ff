// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/html_text.h"
#include "drawing/offscreen_display.h"
#include "example_room.h"

namespace facetloc::test {
namespace {

TEST_F(Tools, RenderDrawsEachKindOfInput) {
  if (const OffscreenDisplay display; !display.available()) GTEST_SKIP() << display.problem();
  const auto draws = [&](const Arguments& arguments, const std::string& output) {
    const ToolRun run = ok(runTool<renderApp>(arguments + Arguments{"-o", output}));
    EXPECT_THAT(lastLine(run.out), HasSubstr(output));
    return fs::exists(output);
  };
  EXPECT_TRUE(draws({firstImage()}, folder_ / "image.png"));
  EXPECT_TRUE(draws({firstImage(), "--map", map(), "--max-hypotheses", "2"}, folder_ / "answers.png"));
  EXPECT_TRUE(draws({map(), "--trajectory", query()}, folder_ / "map.png"));
  const std::string name = fs::path(firstImage()).stem().string();
  EXPECT_TRUE(draws({query(), "--frame", name}, folder_ / "again.png"));
  EXPECT_EQ(contentOf(folder_ / "image.png"), contentOf(folder_ / "again.png"));
  EXPECT_TRUE(draws({firstImage()}, folder_ / "alone"));
  EXPECT_EQ(filesOf(folder_ / "alone"), std::vector<fs::path>{folder_ / ("alone/" + name + ".png")});
  EXPECT_TRUE(draws({query()}, folder_ / "all"));
  EXPECT_EQ(filesOf(folder_ / "all").size(), static_cast<std::size_t>(kFrames));

  ok(runTool<localizeApp>({map(), query(), "-o", folder_ / "results"}));
  EXPECT_TRUE(draws({folder_ / "results", "--map", map(), "--sequence", query(),
                     "--evaluation.max_translation", "0", "--most", "2"},
                    folder_ / "failures"));
  EXPECT_EQ(filesOf(folder_ / "failures").size(), 3u);  // and failures.png
}

TEST_F(Tools, RenderDrawsFilesOfSegments) {
  if (const OffscreenDisplay display; !display.available()) GTEST_SKIP() << display.problem();
  ok(runTool<segmentApp>({firstImage(), "-o", folder_ / "found"}));
  const std::string segments =
      folder_ / ("found/" + fs::path(firstImage()).stem().string() + ".segments.pcd");
  for (const std::vector<std::string>& with : {std::vector<std::string>{}, {"--map", map()}}) {
    ok(runTool<renderApp>(Arguments{segments, "-o", folder_ / "picture.png"} + with));
    EXPECT_TRUE(fs::remove(folder_ / "picture.png"));
  }
}

TEST_F(Tools, RenderDrawsABeliefAsItNarrows) {
  if (const OffscreenDisplay display; !display.available()) GTEST_SKIP() << display.problem();
  const std::string results = folder_ / "results", picture = folder_ / "strip.png";
  ok(runTool<localizeApp>({map(), query(), "-o", results, "--sequence"}));
  EXPECT_THAT(ok(runTool<renderApp>({results, "--map", map(), "--sequence", query(), "-o", picture})).out,
              HasSubstr("of " + std::to_string(kFrames) + " images"));
  EXPECT_TRUE(fs::exists(picture));
  EXPECT_EQ(runTool<renderApp>({results, "-o", picture}).code, kUsage);
}

TEST_F(Tools, RenderWritesPagesForBrowsers) {
  const std::string results = folder_ / "results", page = folder_ / "page.html";
  ok(runTool<localizeApp>({map(), query(), "-o", results, "--sequence"}));
  const auto written = [&](const Arguments& arguments) {
    ok(runTool<renderApp>(arguments + Arguments{"-o", page}));
    return contentOf(page);
  };
  try {
    pageFile("three.js");
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(runTool<renderApp>({map(), "-o", page}).err, HasSubstr("libjs-three"));
    GTEST_SKIP() << e.what();
  }
  EXPECT_THAT(written({map(), "--trajectory", query()}), HasSubstr("\"name\":\"trajectory\""));
  EXPECT_THAT(written({map(), "--self"}), HasSubstr("\"verdict\":"));
  EXPECT_EQ(runTool<renderApp>({results, "--map", map(), "--self", "-o", page}).code, kUsage);
  const std::string alone = written({results, "--map", map()});
  EXPECT_THAT(alone, HasAll("\"state\":\"sure\"", Not(HasSubstr("\"truth\":"))));
  const std::string whole = written({results, "--map", map(), "--sequence", query()});
  EXPECT_THAT(whole, HasAll("\"truth\":", "\"matches\":"));
  EXPECT_LT(whole.size(), std::size_t{3} << 20);
  EXPECT_EQ(whole, written({results, "--map", map(), "--sequence", query()})) << "the same bytes";
  EXPECT_EQ(runTool<renderApp>({results, "-o", page}).code, kUsage);
  EXPECT_EQ(runTool<renderApp>({firstImage(), "-o", page}).code, kUsage);
  writeContent(page, "mine");
  EXPECT_THAT(runTool<renderApp>({map(), "-o", page}), refuses("would overwrite " + page));
  ok(runTool<renderApp>({map(), "-o", page, "--overwrite"}));
}

TEST_F(Tools, RenderNamesMissingInputs) {
  if (const OffscreenDisplay display; !display.available()) GTEST_SKIP() << display.problem();
  EXPECT_EQ(runTool<renderApp>({firstImage()}).code, kUsage);
  EXPECT_EQ(runTool<renderApp>({firstImage(), "-o", firstImage()}).code, kUsage);
  EXPECT_EQ(runTool<renderApp>({map(), "-o", map()}).code, kUsage);
  EXPECT_EQ(runTool<renderApp>({query(), "-o", query() + "/depth"}).code, kUsage);
  EXPECT_EQ(runTool<renderApp>({query(), "-o", folder_ / "several.png"}).code, kUsage);
  EXPECT_EQ(runTool<renderApp>({firstImage(), "-o", folder_ / "image.jpg"}).code, kUsage);
  EXPECT_EQ(runTool<renderApp>({query(), "--frame", "nowhere", "-o", folder_ / "x.png"}).code, kUsage);
  EXPECT_THAT(runTool<renderApp>({folder_ / "nowhere.png", "-o", folder_ / "x.png"}),
              fails("nowhere.png: does not exist"));
  ok(runTool<localizeApp>({map(), firstImage(), "-o", folder_ / "results"}));
  EXPECT_EQ(runTool<renderApp>({folder_ / "results", "-o", folder_ / "x"}).code, kUsage);
}

TEST_F(Tools, RenderOverwritesNothingButPictures) {
  if (const OffscreenDisplay display; !display.available()) GTEST_SKIP() << display.problem();
  const std::string input = folder_.copyOf(query(), "input"), results = folder_ / "results";
  fs::copy_file(map(), folder_ / "m.flmap");
  ok(runTool<localizeApp>({map(), query(), "-o", results}));
  const auto images = filesOf(input + "/depth");
  const auto refused = [](const std::vector<std::string>& arguments) {
    return runTool<renderApp>(arguments).code == kUsage;
  };
  for (const std::string& output :
       {images[1].string(), folder_ / "m.flmap", filesOf(input + "/labels")[0].string()})
    EXPECT_TRUE(refused({images[0].string(), "-o", output})) << output;
  EXPECT_TRUE(refused({map(), "-o", folder_ / "m.flmap"}));
  EXPECT_TRUE(refused({input, "-o", input + "/labels"}));
  const std::vector<std::string> failures = {
      results, "--map", map(), "--sequence", input, "--evaluation.max_translation", "0"};
  for (const char* folder : {"/depth", "/labels"}) {
    EXPECT_TRUE(refused(failures + Arguments{"-o", input + folder})) << folder;
  }
  for (const fs::path& image : images)
    EXPECT_EQ(contentOf(image), contentOf(query() + "/depth/" + image.filename().string()));
  EXPECT_EQ(contentOf(folder_ / "m.flmap"), contentOf(map()));
  EXPECT_EQ(filesOf(input + "/depth").size(), images.size());
}

}  // namespace
}  // namespace facetloc::test
