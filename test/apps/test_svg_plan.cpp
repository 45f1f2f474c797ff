// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/pictures.h"
#include "example_scene.h"

#include <facetloc/io/error.h>

#include <gmock/gmock.h>

namespace facetloc {
namespace {

using testing::HasSubstr;
using testing::Not;

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
