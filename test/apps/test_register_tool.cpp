// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"
#include "tools/register_app.h"

#include <facetloc/io/results.h>

#include <gmock/gmock.h>

namespace facetloc {
namespace {

using test::filesOf;
using test::runTool;
using test::ToolRun;
using test::Tools;
using testing::HasSubstr;

TEST_F(Tools, RegisterFindsAnImageInItself) {
  const auto images = filesOf(map_run() + "/depth");
  const ToolRun run = runTool<RegisterApp>({images[0].string(), images[1].string(), "-o", folder_ / "out"});
  EXPECT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.out, HasSubstr(folder_ / "out"));
  const auto rows = readHypotheses(folder_ / "out");
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows[0].frame, images[0].stem().string());
  EXPECT_EQ(rows[0].rank > 0 ? rows[0].model : images[1].stem().string(), images[1].stem().string());
  EXPECT_EQ(runTool<RegisterApp>({images[0].string(), map_run()}).code, kUsage);
  EXPECT_EQ(runTool<RegisterApp>({images[0].string(), folder_ / "nowhere.png"}).code, kFailed);
}

}  // namespace
}  // namespace facetloc
