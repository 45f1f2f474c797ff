// SPDX-License-Identifier: BSD-3-Clause
#include "browser.h"
#include "drawing/html_text.h"
#include "evaluation/evaluation_pictures.h"
#include "evaluation/html_report.h"
#include "evaluation/verdict.h"
#include "example_scene.h"
#include "golden.h"
#include "tool_runner.h"

#include <facetloc/io/error.h>

#include <algorithm>
#include <json/value.h>

namespace facetloc::test {
namespace {

/** A page without its script elements. */
std::string withoutScripts(std::string html) {
  const std::string begin = "<script", end = "</script>";
  for (std::size_t at = html.find(begin); at != std::string::npos; at = html.find(begin))
    html.erase(at, html.find(end, at) + end.size() - at);
  return html;
}

/** The first fault in the nesting of a page's elements; empty for a sound page. */
std::string faultOf(const std::string& page) {
  const std::string html = withoutScripts(page);
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return "a tag without an end";
    const std::string tag = html.substr(at + 1, end - at - 1);
    if (tag.front() == '!' || tag.back() == '/') continue;
    std::string name = tag.substr(0, tag.find(' '));
    if (name.front() != '/') {
      open.push_back(name);
      continue;
    }
    if (open.empty() || open.back() != name.substr(1))
      return "</" + name.substr(1) + "> without its beginning";
    open.pop_back();
  }
  return open.empty() ? "" : "<" + open.back() + "> without its end";
}

std::size_t countOf(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(Html, TextIsEscaped) {
  EXPECT_EQ(htmlEscaped("a < b & \"c\" > d"), "a &lt; b &amp; &quot;c&quot; &gt; d");
  EXPECT_EQ(htmlEscaped("line\nbreak, 2.0°"), "line break, 2.0°");
}

TEST(Html, Base64AsInTheStandard) {  // RFC 4648, section 10
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64(std::string("\xff\x00\xfe", 3)), "/wD+");
}

TEST(Html, APageIsWholeInItself) {
  const TemporaryFolder folder;
  writeContent(folder / "picture.png", "foobar");
  HtmlPage page("A <page>");
  page.heading("First & last");
  page.paragraph("<script>alert(1)</script>");
  TextTable table({"", "n"});
  table.add({"Group"});
  table.add({"  part", "1"});
  page.table("Counts", table);
  page.picture(folder / "picture.png", "A picture");
  page.beginFolded("More & more");
  page.begin("verdict");
  page.paragraph("inside");
  page.end();
  page.end();
  page.link("map.html", "a map");
  const std::string html = page.str();
  EXPECT_EQ(faultOf(html), "");
  EXPECT_THAT(html, HasAll("<title>A &lt;page&gt;</title>", "<th colspan=\"2\">Group</th>",
                           "<td class=\"part\">part</td><td>1</td>", "src=\"data:image/png;base64,Zm9vYmFy\"",
                           "<details><summary>More &amp; more</summary>\n<div class=\"verdict\">",
                           "<a href=\"map.html\">a map</a>", "prefers-color-scheme: dark",
                           Not(HasSubstr("<script")), Not(HasSubstr("://"))));
  EXPECT_THROW(page.picture(folder / "nowhere.png", ""), IoError);
}

FrameEvaluation answered(const std::string& name, double probability, int first_correct) {
  FrameEvaluation f;
  f.name = name;
  f.run = "query";
  f.frame_class = FrameClass::new_image;
  f.covered = true;
  f.solvable = true;
  f.visible_planes = 5;
  f.nearest = NearestModel{"10.0", 0.4, 8};
  f.hypotheses = 3;
  f.probability = probability;
  f.state = probability >= kMinProbability ? AnswerState::sure : AnswerState::doubtful;
  f.first_correct = first_correct;
  f.closest = std::max(first_correct, 1);
  f.best_error = PoseError{first_correct == 1 ? 0.01 : 1.5, 0.5, 0};
  return f;
}

EvaluationReport exampleReport() {
  EvaluationReport report{"results <1>", "place", {}, {}, {}, {}};
  FrameEvaluation none = answered("1004", 0, 0);
  none.hypotheses = none.closest = 0;
  none.best_error.reset();
  none.state = AnswerState::unknown;
  none.reason = "the planes in view leave free: rotation & more";
  report.evaluation.frames = {answered("1001", 0.95, 1), answered("1002", 0.97, 0), answered("1003", 0.4, 2),
                              none};
  report.summaries = summarizeSets(report.evaluation);
  report.timing = {{"1001", 5, 1, 100, 40}, {"1002", 7, 1, 200, 40}};
  return report;
}

using EvaluationHtml = InAFolder;

TEST_F(EvaluationHtml, HasEveryTableOfTheText) {
  const EvaluationReport report = exampleReport();
  writeHtmlReport(folder_ / "", report, {});
  const std::string html = contentOf(folder_ / "report.html");
  EXPECT_EQ(faultOf(html), "");
  EXPECT_THAT(withoutScripts(html), Not(HasSubstr("://")));
  const auto tables = reportTables(report);
  EXPECT_EQ(tables.size(), 8u);
  for (const ReportTable& t : tables) {
    EXPECT_THAT(html, HasSubstr("<caption>" + htmlEscaped(t.title) + "</caption>"));
    for (const auto& row : t.table.rows())
      for (const std::string& cell : row)
        EXPECT_THAT(html,
                    HasSubstr(">" +
                              htmlEscaped(cell.substr(std::min(cell.find_first_not_of(' '), cell.size()))) +
                              "<"));
  }
}

TEST_F(EvaluationHtml, ThePapersFiguresAppearIfAskedForOnly) {
  EvaluationReport report = exampleReport();
  writeHtmlReport(folder_ / "", report, {});
  EXPECT_THAT(contentOf(folder_ / "report.html"),
              HasAll(Not(HasSubstr("<th>paper</th>")), Not(HasSubstr("99 % in the paper")),
                     Not(HasSubstr("TABLE I"))));
  report.beside_paper = true;
  writeHtmlReport(folder_ / "", report, {});
  EXPECT_THAT(contentOf(folder_ / "report.html"),
              HasAll("<caption>TABLE II.", "<th>paper</th>", "99 % in the paper"));
}

TEST_F(EvaluationHtml, BeginsWithTheVerdict) {
  EvaluationReport report = exampleReport();
  report.results = "above/results <1>/";
  ReportFigures figures;
  figures.plan["models"].append(0);
  figures.map_page = true;
  writeHtmlReport(folder_ / "", report, figures);
  const std::string html = contentOf(folder_ / "report.html");
  EXPECT_EQ(faultOf(html), "");
  EXPECT_THAT(html, HasSubstr("<title>Localization of results &lt;1&gt;</title>"));
  EXPECT_THAT(html.substr(0, html.find("<h2>Charts</h2>")), Not(HasSubstr("above")));
  const Verdict verdict = verdictOf(report);
  std::size_t at = 0;
  for (const std::string& sentence : verdict.sentences) {
    EXPECT_GT(html.find(htmlEscaped(sentence)), at);
    at = html.find(htmlEscaped(sentence));
  }
  EXPECT_LT(at, html.find("id=\"plan\""));
  EXPECT_LT(html.find("id=\"plan\""), html.find("<b>50\u00a0%</b>of the images have a sure answer"));
  EXPECT_LT(html.find("href=\"map.html\""), html.find("<h2>Charts</h2>"));
  EXPECT_LT(html.find("<h2>Images that miss</h2>"), html.find("<table"));
}

TEST_F(EvaluationHtml, NamesTheImagesThatMiss) {
  writeHtmlReport(folder_ / "", exampleReport(), {});
  const std::string html = contentOf(folder_ / "report.html");
  EXPECT_THAT(html, HasAll("<caption>Confident and wrong (1)</caption>",
                           "<caption>No correct hypothesis (1)</caption>",
                           "<caption>Correct, but not at rank 1 (1)</caption>", "rotation &amp; more",
                           "correct at rank 2"));
  EXPECT_EQ(countOf(html, "<td>query 1001</td>"), 0u);
  for (const char* name : {"1002", "1003", "1004"})
    EXPECT_EQ(countOf(html, std::string("<td>query ") + name + "</td>"), 1u);
}

std::vector<double> numbers(const Json::Value& row) {
  std::vector<double> values;
  for (const Json::Value& cell : row) values.push_back(cell.asDouble());
  return values;
}

TEST(ChartData, IsThatOfTheAnswers) {
  EvaluationReport report = exampleReport();
  report.evaluation.frames[0].first_correct_error = {0.03, 0.5, 0};
  report.evaluation.frames[2].first_correct_error = {0.01, 1.5, 0};
  for (FrameEvaluation& frame : report.evaluation.frames)
    if (frame.hypotheses > 0) frame.best_error = frame.first_correct_error;
  report.summaries = summarizeSets(report.evaluation);
  report.starts = {{"images", {{0, 2, 0, 0}, {1, 2, 2, 1}}}};
  const Json::Value data = chartData(report);
  // Probabilities 0.95, right, and 0.97, wrong; 0.4, wrong; one image without an answer.
  const Json::Value& bins = data["reliability"]["bins"];
  ASSERT_EQ(bins.size(), 10u);
  EXPECT_THAT(numbers(bins[9]), testing::Pointwise(testing::DoubleNear(1e-12), {0.9, 1.0, 2.0, 0.96, 0.5}));
  EXPECT_THAT(numbers(bins[4]), testing::Pointwise(testing::DoubleNear(1e-12), {0.4, 0.5, 1.0, 0.4, 0.0}));
  EXPECT_NEAR(data["reliability"]["brier"].asDouble(), (0.05 * 0.05 + 0.97 * 0.97 + 0.4 * 0.4) / 3, 1e-12);
  EXPECT_THAT(numbers(data["position"]["sets"][0]["errors"]),
              testing::Pointwise(testing::DoubleNear(1e-9), {10.0, 30.0}));
  EXPECT_NEAR(data["position"]["marks"]["99 %"].asDouble(), 30, 1e-9);
  EXPECT_NEAR(data["position"]["limit"].asDouble(), 200, 1e-9);
  EXPECT_THAT(numbers(data["orientation"]["sets"][0]["errors"]), testing::ElementsAre(0.5, 1.5));
  EXPECT_THAT(numbers(data["planes"][0]), testing::ElementsAre(5, 4, 2, 1));
  EXPECT_THAT(numbers(data["starts"]["images"][1]), testing::ElementsAre(1, 2, 2, 1));
}

TEST(ChartData, IsThatOfATrajectory) {
  TrajectoryErrors errors;
  PosePair pair;
  pair.truth = pair.estimated = Eigen::Isometry3d::Identity();
  pair.truth.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;  // looks along y, upright
  pair.truth.translation() << 1, 2, 3;
  pair.estimated.translation() << 1.5, 2, 3;
  errors.pairs = {pair};
  errors.distance = {7};
  errors.translation = {0.5};
  errors.rotation_deg = {4};
  const Json::Value data = chartData(errors);
  EXPECT_THAT(numbers(data["plan"]["true"][0]), testing::ElementsAre(1, 2));
  EXPECT_THAT(numbers(data["plan"]["estimated"][0]), testing::ElementsAre(1.5, 2));
  EXPECT_THAT(numbers(data["errors"][0]), testing::ElementsAre(7, 500, 4));
}

/** A right answer of exampleReport() at one place, and a wrong one at another. */
Json::Value examplePlan(const Map& map) {
  MapPage page;
  for (const char* frame : {"1001", "1002"}) {
    PageAnswer answer;
    answer.run = "query";
    answer.frame = frame;
    answer.state = AnswerState::sure;
    answer.wrong = !page.answers.empty();
    answer.truth = ExampleScene::pose(static_cast<double>(page.answers.size()), 0, 90);
    page.answers.push_back(answer);
  }
  return planData(map, exampleReport().evaluation, page);
}

TEST(PlanData, HasWallsModelsAndAnswers) {
  Map map = ExampleScene().map();
  const Json::Value data = examplePlan(map);
  EXPECT_GT(data["tall"].size(), 0u);
  EXPECT_EQ(data["tall"].size() % 4, 0u);
  EXPECT_EQ(data["models"].size(), 2 * map.models.size());
  EXPECT_THAT(data["answers"].getMemberNames(), testing::ElementsAre("sure", "sure and wrong"));
  EXPECT_EQ(numbers(data["answers"]["sure and wrong"])[0], 1000);
  for (LocalModel& model : map.models) model.T_w_m.reset();
  EXPECT_THROW(examplePlan(map), IoError);
}

TEST_F(EvaluationHtml, DrawsItsPlanAndChartsInABrowser) {
  EvaluationReport report = exampleReport();
  report.summaries[0].name = "</script><img src=x>";
  writeHtmlReport(folder_ / "", report, {});
  std::string html = contentOf(folder_ / "report.html");
  writeHtmlReport(folder_ / "", report, {});
  EXPECT_EQ(html, contentOf(folder_ / "report.html"));
  if (!hasPageFile("chart.js")) {
    EXPECT_THAT(html, AllOf(HasSubstr("facetloc was built without Chart.js"), Not(HasSubstr("<script"))));
    GTEST_SKIP() << "no Chart.js: install libjs-chart.js";
  }
  ReportFigures figures;
  figures.plan = examplePlan(ExampleScene().map());
  writeHtmlReport(folder_ / "", report, figures);
  html = contentOf(folder_ / "report.html");
  const Browser browser;
  if (!browser.available()) GTEST_SKIP() << "no browser: install chromium";
  // Each canvas must have pixels of the colours of curves, which are not grey.
  html.insert(html.rfind("</body>"),
              "<script>for (const canvas of document.querySelectorAll('canvas')) {"
              "const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);"
              "let n = 0; for (let i = 0; i < data.length; i += 4) n += Math.abs(data[i] - data[i + 2]) > 90 "
              "&& data[i + 3] > 200;"
              "canvas.setAttribute('data-drawn', n > 20 ? 'yes' : 'no'); }</script>");
  writeContent(folder_ / "visited.html", html);
  const ToolRun run = ok(browser.elementsOf(folder_ / "visited.html"));
  EXPECT_THAT(Browser::consoleOf(run), testing::IsEmpty());
  EXPECT_EQ(countOf(run.out, "data-drawn=\"yes\""), 5u);
  EXPECT_EQ(countOf(run.out, "data-drawn=\"no\""), 0u);
  EXPECT_EQ(countOf(run.out, "<circle"), 2u);
  EXPECT_THAT(run.out, HasAll("class=\"wall\" d=\"M", "sure (1)", "sure and wrong (1)", " m</text>",
                              Not(HasSubstr("unknown (")), Not(HasSubstr("<img"))));
}

TEST_F(EvaluationHtml, LooksAsItDid) {
  const Browser browser;
  if (!browser.available() || !hasPageFile("chart.js")) GTEST_SKIP() << "install chromium and libjs-chart.js";
  ReportFigures figures;
  figures.plan = examplePlan(ExampleScene().map());
  writeHtmlReport(folder_ / "", exampleReport(), figures);
  // Plan and curves alone: words look otherwise, and take other space, where other fonts are installed.
  std::string html = contentOf(folder_ / "report.html");
  html.insert(
      html.rfind("</body>"),
      "<script>document.body.replaceChildren(document.querySelector('#plan svg'), "
      "document.getElementById('charts'));"
      "for (const words of document.querySelectorAll('svg text, figcaption')) words.remove();"
      "for (const chart of Object.values(Chart.instances)) {"
      "for (const scale of Object.values(chart.options.scales)) scale.display = false;"
      "chart.options.plugins.legend.display = false; chart.resize(); chart.update('none'); }</script>");
  writeContent(folder_ / "visited.html", html);
  const auto expectLike = [&](const std::string& name, int width, int height, bool dark) {
    ok(browser.photograph(folder_ / "visited.html", folder_ / "page.png", width, height, dark));
    expectLikeGolden(name, readRgbPng(folder_ / "page.png"));
  };
  expectLike("report", 1280, 1320, false);
  expectLike("report_phone", 390, 1400, true);
}

}  // namespace
}  // namespace facetloc::test
