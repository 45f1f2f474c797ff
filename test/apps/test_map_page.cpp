// SPDX-License-Identifier: BSD-3-Clause
#include "browser.h"
#include "drawing/depth_drawing.h"
#include "drawing/html_text.h"
#include "drawing/map_page.h"
#include "example_scene.h"
#include "golden.h"

#include <facetloc/io/error.h>

#include <json/value.h>

namespace facetloc::test {
namespace {

const Eigen::Isometry3d kRight = ExampleScene::pose(0.2, 0.15, -4), kWrong = ExampleScene::pose(1.6, 0.6, 30);

PageAnswer answered(const std::string& name, AnswerState state, const Eigen::Isometry3d& T_w_c,
                    const Map& map) {
  PageAnswer answer;
  answer.frame = name;
  answer.state = state;
  answer.places.push_back({0, map.models[0].T_w_m->inverse() * T_w_c, T_w_c, 0.95, 0.02, 0.3});
  answer.P_w_c = Matrix6d::Identity() * 1e-2;
  return answer;
}

/** An image where it was taken, one that is elsewhere, and one that is nowhere. */
MapPage examplePage(const Map& map) {
  MapPage page;
  page.title = "Three images";
  page.answers = {answered("first", AnswerState::sure, kRight, map),
                  answered("second", AnswerState::sure, kWrong, map),
                  {}};
  page.answers[1].wrong = true;
  page.answers[1].error_m = 1.47;
  page.answers[1].error_deg = 34;
  page.answers[2].frame = "third";
  page.answers[2].reason = "the view shows no planar segment";
  page.runs.push_back({"true poses", {kRight, ExampleScene::pose(0.6, 0.2, 0)}});
  page.view = [](std::size_t i) -> std::optional<View> {
    if (i > 0) return {};
    return ExampleScene().see("first", kRight).view;
  };
  return page;
}

/** A page of a map that was asked about itself: its first image is sure, and the second is taken for it. */
MapPage pageOfOwnViews() {
  MapPage page;
  page.title = "A map";
  page.own_views.resize(2);
  page.own_views[0].state = AnswerState::sure;
  page.own_views[0].right = true;
  page.own_views[0].probability = 0.97;
  page.own_views[0].nees = 4;
  page.own_views[1].model = 1;
  page.own_views[1].state = AnswerState::doubtful;
  page.own_views[1].probability = 0.7;
  page.own_views[1].mistaken_for = 0;
  page.own_views[1].distance = 0.64;
  return page;
}

/** The page with a script of a visitor at its end; press() clicks on the scene at (x, y) pixels. */
std::string visited(const std::string& page, const std::string& script) {
  const std::string html = contentOf(page), end = "</body>", path = page + ".visited.html";
  const std::string press = "function press(at) { for (const type of ['pointerdown', 'pointerup']) "
                            "document.getElementById('scene').dispatchEvent("
                            "new PointerEvent(type, {clientX: at[0], clientY: at[1], bubbles: true})); }";
  const std::size_t at = html.rfind(end);
  writeContent(path, html.substr(0, at) + "<script>" + press + script + "</script>" + html.substr(at));
  return path;
}

/** A page in a browser; tests skip without one. */
class MapInBrowser : public testing::Test {
protected:
  void SetUp() override {
    if (!browser_.available()) GTEST_SKIP() << "no browser: install chromium";
    try {
      pageFile("three.js");
    } catch (const std::runtime_error& e) {
      GTEST_SKIP() << e.what();
    }
  }
  /** The elements after a visitor's script; nothing may be said on the console. */
  std::string elements(const std::string& script) {
    const ToolRun run = ok(browser_.elementsOf(visited(path_, script)));
    EXPECT_THAT(Browser::consoleOf(run), IsEmpty());
    return run.out.substr(std::min(run.out.size(), run.out.find("<canvas")),
                          run.out.find("<script id=\"data\"") - run.out.find("<canvas"));
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "page.html";
  const Map map_ = ExampleScene().map();
  Browser browser_;
};

TEST(MapPageData, HasFindings) {
  const Map map = ExampleScene().map();
  MapPage page = examplePage(map);
  EXPECT_FALSE(mapPageData(map, page, "page.html").isMember("findings"));
  page.findings = {{"localize.scale", Severity::doubt, "too far", "look at depth_scale"}};
  EXPECT_EQ(mapPageData(map, page, "page.html")["findings"][0].asString(),
            "doubt: too far; look at depth_scale");
}

TEST(MapPageData, HasOwnViews) {
  const Map map = ExampleScene().map();
  const Json::Value models = mapPageData(map, pageOfOwnViews(), "page.html")["models"];
  EXPECT_EQ(models[0]["own"]["verdict"].asString(), "sure");
  EXPECT_TRUE(models[0]["own"]["inside"].asBool());
  EXPECT_FALSE(models[0]["own"].isMember("taken_for"));
  EXPECT_EQ(models[1]["own"]["verdict"].asString(), "wrong");
  EXPECT_EQ(models[1]["own"]["taken_for"].asInt(), 0);
  EXPECT_FALSE(models[2].isMember("own"));
}

TEST_F(MapInBrowser, OwnViewsColourTheLocalModels) {
  writeMapPage(path_, map_, pageOfOwnViews());
  const std::string found = elements("press(facetloc.modelOnScreen(1));");
  EXPECT_THAT(found, HasAll("own images without themselves", "1 sure", "1 wrong", "1 not asked",
                            "<h2>Local model left</h2>", "in the map without it", "0.700", "0.64 m"));
}

TEST_F(MapInBrowser, DrawsEverything) {
  writeMapPage(path_, map_, examplePage(map_));
  const std::string found =
      elements("document.getElementById('fault').textContent = facetloc.triangles() + ' triangles';");
  // Two triangles for each of 3 x 7 rectangles, again two, in two passes, for the backs of 3 x 5 upright
  // ones, 17 for each axis and its name, six for each of 2 cameras that are shown, and two balls.
  EXPECT_THAT(found, HasAll(std::to_string(2 * 21 + 2 * 2 * 15 + 3 * 17 + 6 * 2 + 2 * 2 * 20 * (14 - 1)) +
                                " triangles",
                            "3 local models, 21 segments, 2 links", "1 sure and wrong"));
}

TEST_F(MapInBrowser, AClickAnswers) {
  writeMapPage(path_, map_, examplePage(map_));
  const std::size_t matches = matchedSegments(ExampleScene().see("first", kRight).view, *map_.view(0),
                                              map_.models[0].T_w_m->inverse() * kRight)
                                  .size();
  ASSERT_GT(matches, 3u);
  const std::string first = elements("press(facetloc.answerOnScreen(0));");
  EXPECT_THAT(first, HasAll("<h2>Image first</h2>", "0.20, 0.15, 1.00 m",
                            std::to_string(matches) + " matched segments", "local model start"));
  const std::string second = elements("press(facetloc.answerOnScreen(1));");
  EXPECT_THAT(second, HasAll("<h2>Image second</h2>", "sure, and wrong", "1.47 m, 34.00°"));
  EXPECT_THAT(elements("press([2, 300]);"), Not(HasSubstr("<h2>")));
}

TEST_F(MapInBrowser, TheSliderGoesThroughTime) {
  writeMapPage(path_, map_, examplePage(map_));
  const std::string found = elements("const moment = document.getElementById('moment'); moment.value = '2'; "
                                     "moment.dispatchEvent(new Event('input'));");
  EXPECT_THAT(found, HasAll("<h2>Image third</h2>", "the view shows no planar segment", "3/3 third"));
}

TEST_F(MapInBrowser, NamesAreText) {
  const std::string hostile =
      "</script><img src=x onerror=\"document.title='taken'\"><script>document.title='taken'</script>";
  Map map = map_;
  map.models[0].name = hostile;
  MapPage page = examplePage(map);
  page.title = hostile + "@DATA@";
  page.answers[0].frame = page.answers[0].reason = page.runs[0].name = hostile;
  writeMapPage(path_, map, page);
  const ToolRun run = browser_.elementsOf(visited(path_, "press(facetloc.answerOnScreen(0));"));
  EXPECT_THAT(Browser::consoleOf(run), IsEmpty());
  EXPECT_THAT(run.out,
              HasAll(Not(HasSubstr("<title>taken")), "<title>" + htmlEscaped("</script><img").substr(0, 9),
                     "<h2>Image &lt;/script&gt;&lt;img src=x", Not(HasSubstr("<img"))));
}

TEST_F(MapInBrowser, LooksAsItDid) {
  writeMapPage(path_, map_, examplePage(map_));
  // Words look otherwise where other fonts are installed.
  const std::string hidden =
      "for (const e of document.querySelectorAll('header, footer, #scale')) e.style.visibility = 'hidden';";
  const auto expectLike = [&](const std::string& name, const std::string& script, int width, int height,
                              bool dark) {
    const std::string page = visited(path_, hidden + script);
    const ToolRun run = ok(browser_.photograph(page, folder_ / "page.png", width, height, dark));
    EXPECT_THAT(Browser::consoleOf(run), IsEmpty());
    expectLikeGolden(name, readRgbPng(folder_ / "page.png"));
  };
  expectLike("map_page", "", 1280, 800, false);
  expectLike("map_page_phone", "document.getElementById('layer-points').click();", 390, 700, true);
}

TEST(MapPageData, HasTheMeasuredPoints) {
  const Map map = ExampleScene().map();
  const Json::Value data = mapPageData(map, {}, "page.html");
  const DepthPicture& picture = map.view(0)->depth;
  const Json::Value& points = data["models"][0]["points"];
  ASSERT_FALSE(picture.empty());
  EXPECT_EQ(points["columns"].asInt(), picture.camera.width) << "few enough for all of them";
  EXPECT_DOUBLE_EQ(points["step"].asDouble() * picture.camera.width, 1);
  EXPECT_EQ(points["inverse"].asString(),
            base64({reinterpret_cast<const char*>(picture.inverse_depth.data()),
                    picture.inverse_depth.size() * sizeof(picture.inverse_depth[0])}));
}

TEST(MapPageData, LeavesOutOtherPartsAndSaysSo) {
  Map map = ExampleScene().map();
  map.parts = {"", "shed"};
  map.models[2].part = 1;
  map.links[1].to = 2;
  const Json::Value data = mapPageData(map, {}, "page.html");
  EXPECT_EQ(data["models"].size(), 2u);
  EXPECT_EQ(data["links"].size(), 1u);
  EXPECT_EQ(data["left_out"].asString(), "not shown: 1 local model in other parts or without a pose");
  for (LocalModel& model : map.models) model.T_w_m.reset();
  EXPECT_THROW(mapPageData(map, {}, "page.html"), IoError);
}

TEST(MapPageData, ShowsAnswersOfImagesThatCannotBeRead) {
  const Map map = ExampleScene().map();
  MapPage page = examplePage(map);
  page.view = [](std::size_t) -> std::optional<View> { throw IoError("first.png", "is torn"); };
  const Json::Value data = mapPageData(map, page, "page.html");
  ASSERT_EQ(3u, data["answers"].size());
  EXPECT_FALSE(data["answers"][0].isMember("image"));
  EXPECT_EQ("sure", data["answers"][0]["state"].asString());
}

TEST(MapPageData, PicturesFitHoweverManyImagesThereAre) {
  const Map map = ExampleScene().map();
  const View view = ExampleScene().see("x", kRight).view;
  for (const std::size_t images : {10u, 500u, 4000u}) {
    MapPage page;
    page.answers.assign(images, answered("x", AnswerState::sure, kRight, map));
    page.view = [&](std::size_t) { return std::optional<View>(view); };
    const Json::Value data = mapPageData(map, page, "page.html");
    std::size_t bytes = 0, pictures = 0;
    for (const Json::Value& answer : data["answers"]) {
      bytes += answer["image"].asString().size() + answer["matches"].toStyledString().size() / 4;
      pictures += answer.isMember("image");
    }
    EXPECT_GT(pictures, std::min<std::size_t>(images - 1, 300)) << images;
    EXPECT_LT(bytes, std::size_t{2} << 20) << images;
  }
}

TEST(Thumbnail, IsAJpegOfTheDepth) {
  const View view = ExampleScene().see("x", kRight).view;
  const std::string jpeg = depthThumbnail(view, 160);
  EXPECT_EQ(jpeg.substr(0, 3), "\xff\xd8\xff");
  EXPECT_EQ(jpeg.substr(jpeg.size() - 2), "\xff\xd9");
  EXPECT_LT(depthThumbnail(view, 40).size(), jpeg.size());
  EXPECT_EQ(depthThumbnail(View(), 160), "");
}

}  // namespace
}  // namespace facetloc::test
