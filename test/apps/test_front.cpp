// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"
#include "process.h"

#include <facetloc/testing/places.h>

namespace facetloc::test {
namespace {

const fs::path kTools = fs::path(kMapTool).parent_path();

ToolRun front(const std::vector<std::string>& arguments) {
  return captured([&](const Console& console) { return frontProgram(kTools).run(arguments, console); });
}

TEST(Front, ListsAllCommands) {
  const ToolRun run = ok(front({}));
  for (const Command& command : frontProgram(kTools).commands) {
    EXPECT_THAT(run.out, HasSubstr("\n  " + command.name + " "));
    if (command.name != "try") {
      EXPECT_EQ(access((kTools / ("facetloc_" + command.name)).c_str(), X_OK), 0) << command.name;
    }
  }
  EXPECT_EQ(front({"--help"}).out, run.out);
  EXPECT_THAT(front({"--version"}).out, StartsWith("facetloc "));
  EXPECT_THAT(front({"fly"}), refuses("unknown command 'fly'", "Commands:"));
  EXPECT_EQ(front({"help"}).out, run.out);
  EXPECT_THAT(front({"help", "try"}).out, StartsWith("Usage: facetloc try "));
  EXPECT_THAT(front({"lokalize"}).err, HasSubstr("did you mean 'localize'?"));
}

TEST(Front, BecomesTheToolThatIsNamed) {
  const std::string facetloc = (kTools / "facetloc").string();
  EXPECT_THAT(Process({facetloc, "map", "info", "nowhere.flmap"}).wait(),
              fails("facetloc_map", "nowhere.flmap"));
  EXPECT_EQ(Process({facetloc, "localize", "--no-such-option"}).wait().code, kUsage);
  EXPECT_THAT(Process({facetloc, "help", "map", "build"}).wait().out, HasSubstr("Usage: facetloc_map build"));
  EXPECT_THAT(Process({facetloc, "render", "--help"}).wait().out, HasSubstr("Usage: facetloc_render"));
}

TEST_F(Tools, TryMakesAReportOfTwoRecordings) {
  const std::string folder = folder_ / "tried";
  const ToolRun run = ok(runTool<tryApp>({map_run(), query(), "-o", folder}));
  for (const char* stage : {"1/5 check", "2/5 check_later", "3/5 build", "4/5 localize", "5/5 evaluate"})
    EXPECT_THAT(run.out, HasSubstr(stage));
  EXPECT_THAT(run.out, HasSubstr("\nNext: "));
  EXPECT_EQ(lastLine(run.out), "report in " + folder + "/report.html");
  EXPECT_THAT(contentOf(folder + "/report.html"), HasAll("of these are right", "Next: "));
  std::vector<std::string> on_top;
  for (const fs::path& path : filesOf(folder)) on_top.push_back(path.filename());
  EXPECT_THAT(on_top, testing::ElementsAre("details", "map.flmap", "map.html", "report.html"));
  for (const char* file : {"results/hypotheses.csv", "check.txt", "check_later.json", "build.txt",
                           "localize.txt", "evaluate.txt", "tables.csv"})
    EXPECT_TRUE(fs::exists(folder + "/details/" + file)) << file;
  const ToolRun again = ok(runTool<tryApp>({map_run(), query(), "-o", folder}));
  EXPECT_THAT(again.err, HasSubstr("the files of an earlier run in " + folder + " are replaced"));
}

TEST_F(Tools, TryNeedsNoTruth) {
  const std::string folder = folder_ / "tried", blind = folder_ / "blind";
  fs::copy(query(), blind, fs::copy_options::recursive);
  fs::remove(blind + "/groundtruth.txt");
  ok(runTool<tryApp>({map_run(), blind, "-o", folder}));
  const std::string report = contentOf(folder + "/report.html");
  EXPECT_THAT(report, HasAll("have a sure answer", "id=\"plan\"", Not(HasSubstr("TABLE"))));
  EXPECT_FALSE(fs::exists(folder + "/details/tables.csv"));
}

TEST_F(Tools, TryStopsWhereSomethingIsWrong) {
  EXPECT_THAT(runTool<tryApp>({folder_ / "nowhere"}), fails("nowhere: does not exist"));
  EXPECT_EQ(runTool<tryApp>({}).code, kUsage);
  EXPECT_THAT(runTool<tryApp>({map_run(), "-o", folder_ / "tried", "--depth-scale", "200000"}),
              fails("stopped at check"));
  EXPECT_FALSE(fs::exists(folder_ / "tried/map.flmap"));

  const std::string later = folder_.copyOf(query(), "later");
  std::string camera = contentOf(later + "/camera.ini");
  const std::string key = "depth_scale=";
  camera.insert(camera.find(key) + key.size(), "20");
  writeContent(later + "/camera.ini", camera);
  EXPECT_THAT(runTool<tryApp>({map_run(), later, "-o", folder_ / "tried"}), fails("stopped at check_later"));
}

}  // namespace
}  // namespace facetloc::test
