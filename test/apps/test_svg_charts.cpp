// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/svg_charts.h"
#include "drawing/svg_plan.h"
#include "example_scene.h"

#include <facetloc/io/error.h>

#include <gmock/gmock.h>

namespace facetloc {
namespace {

using testing::HasSubstr;
using testing::Not;

Panel exampleChart() {
  Panel panel;
  panel.title = "A <chart>";
  panel.x_title = "x";
  panel.y_title = "y";
  panel.x_max = 10;
  Curve curve;
  curve.label = "a & b";
  curve.x = {0, 5, 10, 20};
  curve.y = {0, 0.5, 1, 2};
  panel.curves = {curve};
  return panel;
}

TEST(SvgChart, DrawsWhereValuesAre) {
  const std::string svg = svgChart(exampleChart());
  // The plot is 376 x 248 px from (52, 10); beyond the axes is at their ends.
  EXPECT_THAT(svg, HasSubstr("M52.0 258.0L240.0 134.0L428.0 10.0L428.0 10.0"));
  EXPECT_THAT(svg, HasSubstr("A &lt;chart&gt;"));
  EXPECT_THAT(svg, HasSubstr("a &amp; b"));
  for (const char* tick : {">0<", ">0.2<", ">1<", ">2<", ">10<"}) EXPECT_THAT(svg, HasSubstr(tick));
  EXPECT_THAT(svg, Not(HasSubstr(">-0<")));
}

TEST(SvgChart, LogarithmicAxesHaveRoundTicks) {
  Panel panel = exampleChart();
  panel.logarithmic_x = true;
  panel.x_min = 1;
  panel.x_max = 100;
  panel.curves[0].x = {1, 10};
  panel.curves[0].y = {0, 1};
  const std::string svg = svgChart(panel);
  EXPECT_THAT(svg, HasSubstr("M52.0 258.0L240.0 10.0"));
  for (const char* tick : {">1<", ">5<", ">20<", ">100<"}) EXPECT_THAT(svg, HasSubstr(tick));
}

TEST(SvgFloorMap, HasWallsAnswersAndAScale) {
  const Map map = test::ExampleScene().map();
  const std::vector<DrawnMarks> marks = {
      {"sure", {test::ExampleScene::pose(0, 0, 0), test::ExampleScene::pose(1, 0, 90)}, kRed},
      {"unknown", {}, kBlack}};
  const std::string svg =
      svgFloorMap(map, {{"<run>", {test::ExampleScene::pose(0, 0, 0)}}}, marks, "caption");
  EXPECT_THAT(svg, HasSubstr("class=\"wall\""));
  EXPECT_THAT(svg, HasSubstr("sure (2)"));
  EXPECT_THAT(svg, Not(HasSubstr("unknown")));
  EXPECT_THAT(svg, HasSubstr("&lt;run&gt;"));
  EXPECT_THAT(svg, HasSubstr(" m</text>"));
  std::size_t disks = 0;
  for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1))
    ++disks;
  EXPECT_EQ(disks, 2u);
  Map nowhere = map;
  for (LocalModel& model : nowhere.models) model.T_w_m.reset();
  EXPECT_THROW(svgFloorMap(nowhere, {}, {}, ""), IoError);
}

}  // namespace
}  // namespace facetloc
