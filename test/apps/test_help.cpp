// SPDX-License-Identifier: BSD-3-Clause
#include "tool_runner.h"

#include <algorithm>
#include <map>

namespace facetloc::test {
namespace {

/** The output of each tool for --help or --help-all. */
std::map<std::string, std::string> helpOfAll(const std::string& option) {
  return {{"evaluate", runTool<evaluateApp>({option}).out},
          {"live", runTool<liveApp>({option}).out},
          {"localize", runTool<localizeApp>({option}).out},
          {"map build", runTool<mapBuildApp>({option}).out},
          {"map info", runTool<mapInfoApp>({option}).out},
          {"map merge", runTool<mapMergeApp>({option}).out},
          {"register", runTool<registerApp>({option}).out},
          {"render", runTool<renderApp>({option}).out},
          {"segment", runTool<segmentApp>({option}).out},
          {"simulate", runTool<simulateApp>({option}).out},
          {"map export", runTool<mapExportApp>({option}).out},
          {"check", runTool<checkApp>({option}).out},
          {"map check", runTool<mapCheckApp>({option}).out},
          {"map import", runTool<mapImportApp>({option}).out},
          {"map extend", runTool<mapExtendApp>({option}).out},
          {"map calibrate", runTool<mapCalibrateApp>({option}).out},
          {"map from-model", runTool<mapModelApp>({option}).out},
          {"map densify", runTool<mapDensifyApp>({option}).out},
          {"try", runTool<tryApp>({option}).out},
          {"convert", runTool<convertApp>({option}).out}};
}

TEST(Help, FitsOnAScreen) {
  for (const auto& [tool, help] : helpOfAll("--help")) {
    EXPECT_LE(std::count(help.begin(), help.end(), '\n'), 40) << tool;
    EXPECT_THAT(help, HasAll("--help-all", Not(ContainsRegex("SEQUENCE|FOLDER"))))
        << tool;  // one word for each
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
