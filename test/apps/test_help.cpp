// SPDX-License-Identifier: BSD-3-Clause
#include "cli/presets.h"
#include "evaluation/evaluate_app.h"
#include "live/live_app.h"
#include "tool_runner.h"
#include "tools/check_app.h"
#include "tools/convert_app.h"
#include "tools/localize_app.h"
#include "tools/map_apps.h"
#include "tools/map_calibrate_app.h"
#include "tools/map_densify_app.h"
#include "tools/map_extend_app.h"
#include "tools/map_model_app.h"
#include "tools/register_app.h"
#include "tools/render_app.h"
#include "tools/segment_app.h"
#include "tools/simulate_app.h"
#include "tools/try_app.h"

#include <algorithm>
#include <map>

namespace facetloc::test {
namespace {

/** The output of each tool for --help or --help-all. */
std::map<std::string, std::string> helpOfAll(const std::string& option) {
  return {{"evaluate", runTool<EvaluateApp>({option}).out},
          {"live", runTool<LiveApp>({option}).out},
          {"localize", runTool<LocalizeApp>({option}).out},
          {"map build", runTool<MapBuildApp>({option}).out},
          {"map info", runTool<MapInfoApp>({option}).out},
          {"map merge", runTool<MapMergeApp>({option}).out},
          {"register", runTool<RegisterApp>({option}).out},
          {"render", runTool<RenderApp>({option}).out},
          {"segment", runTool<SegmentApp>({option}).out},
          {"simulate", runTool<SimulateApp>({option}).out},
          {"map export", runTool<MapExportApp>({option}).out},
          {"check", runTool<CheckApp>({option}).out},
          {"map check", runTool<MapCheckApp>({option}).out},
          {"map import", runTool<MapImportApp>({option}).out},
          {"map extend", runTool<MapExtendApp>({option}).out},
          {"map calibrate", runTool<MapCalibrateApp>({option}).out},
          {"map from-model", runTool<MapModelApp>({option}).out},
          {"map densify", runTool<MapDensifyApp>({option}).out},
          {"try", runTool<TryApp>({option}).out},
          {"convert", runTool<ConvertApp>({option}).out}};
}

TEST(Help, FitsOnAScreen) {
  for (const auto& [tool, help] : helpOfAll("--help")) {
    EXPECT_LE(std::count(help.begin(), help.end(), '\n'), 40) << tool;
    EXPECT_THAT(help, HasSubstr("--help-all")) << tool;
    // It ends with two examples, calls of the tool itself.
    const std::size_t examples = help.find("\nExamples:\n");
    ASSERT_NE(examples, std::string::npos) << tool;
    EXPECT_THAT(help.substr(examples),
                testing::MatchesRegex("\nExamples:\n(  facetloc[^\n]*  # [^\n]+\n){2}"))
        << tool;
  }
}

// Sentences that begin like these are understood with their neighbour only.
TEST(Help, EachOptionIsUnderstoodAlone) {
  for (const auto& [tool, help] : helpOfAll("--help-all"))
    for (const char* words :
         {"The same", "the same of", " ... ", "Like ", "see above", "next two options", "  Of "})
      EXPECT_THAT(help.substr(std::min(help.size(), help.find("Options:"))), Not(HasSubstr(words))) << tool;
}

TEST(Help, UnitsOfScoresAreExplained) {
  int explained = 0;
  for (const auto& [tool, help] : helpOfAll("--help-all")) {
    const bool has_nats = help.find("[nats]") != std::string::npos;
    EXPECT_EQ(help.find("in nats: each nat multiplies") != std::string::npos, has_nats) << tool;
    explained += has_nats;
  }
  EXPECT_GT(explained, 0);
}

/** A preset's parameter that no tool has would be left out silently. */
TEST(Help, PresetsSetExistingParameters) {
  std::string all;
  for (const auto& [tool, help] : helpOfAll("--help-all")) all += help;
  for (const std::string& preset : presetNames()) {
    std::istringstream lines(presetText(preset));
    std::string group;
    for (std::string line; std::getline(lines, line);) {
      line = line.substr(0, line.find('#'));
      if (line.find('[') != std::string::npos) group = line.substr(1, line.find(']') - 1) + ".";
      const auto equals = line.find(" =");
      if (equals == std::string::npos) continue;
      EXPECT_THAT(all, HasSubstr("--" + group + line.substr(0, equals) + " ")) << preset;
    }
  }
}

}  // namespace
}  // namespace facetloc::test
