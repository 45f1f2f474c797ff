// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"
#include "process.h"
#include "tools/front.h"
#include "tools/try_app.h"

#include <facetloc/testing/places.h>

#include <gmock/gmock.h>

#include <cstdlib>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using test::captured;
using test::contentOf;
using test::lastLine;
using test::runTool;
using test::ToolRun;
using test::Tools;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const fs::path kTools = fs::path(test::kMapTool).parent_path();

ToolRun front(const std::vector<std::string>& arguments) {
  return captured([&](const Console& console) { return runFront(arguments, console, kTools); });
}

TEST(Front, ListsAllCommands) {
  const ToolRun run = front({});
  EXPECT_EQ(run.code, kOk);
  for (const FrontCommand& command : frontCommands()) {
    EXPECT_THAT(run.out, HasSubstr("\n  " + command.name + " "));
    if (command.name != "try") {
      EXPECT_EQ(access((kTools / ("facetloc_" + command.name)).c_str(), X_OK), 0) << command.name;
    }
  }
  EXPECT_EQ(front({"--help"}).out, run.out);
  EXPECT_THAT(front({"--version"}).out, testing::StartsWith("facetloc "));
  const ToolRun unknown = front({"fly"});
  EXPECT_EQ(unknown.code, kUsage);
  EXPECT_THAT(unknown.err, AllOf(HasSubstr("unknown command 'fly'"), HasSubstr("Commands:")));
  EXPECT_THAT(front({"lokalize"}).err, HasSubstr("did you mean 'localize'?"));
}

TEST(Front, BecomesTheToolThatIsNamed) {
  const std::string facetloc = (kTools / "facetloc").string();
  const ToolRun run = test::Process({facetloc, "map", "info", "nowhere.flmap"}).wait();
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, AllOf(HasSubstr("facetloc_map"), HasSubstr("nowhere.flmap")));
  EXPECT_EQ(test::Process({facetloc, "localize", "--no-such-option"}).wait().code, kUsage);
  EXPECT_THAT(test::Process({facetloc, "render", "--help"}).wait().out, HasSubstr("Usage: facetloc_render"));
}

TEST_F(Tools, TryMakesAReportOfTwoRecordings) {
  const std::string folder = folder_ / "tried";
  const ToolRun run = runTool<TryApp>({map_run(), query(), "-o", folder});
  ASSERT_EQ(run.code, kOk) << run.err << run.out;
  for (const char* stage : {"1/4 check", "2/4 build", "3/4 localize", "4/4 evaluate"})
    EXPECT_THAT(run.out, HasSubstr(stage));
  EXPECT_EQ(lastLine(run.out), "report in " + folder + "/report.html");
  EXPECT_THAT(contentOf(folder + "/report.html"),
              AllOf(HasSubstr("of these are right"), HasSubstr("Next: ")));
  for (const char* file :
       {"map.flmap", "results/hypotheses.csv", "check.txt", "build.txt", "localize.txt", "evaluate.txt"})
    EXPECT_TRUE(fs::exists(folder + "/" + file)) << file;
  EXPECT_EQ(runTool<TryApp>({map_run(), query(), "-o", folder}).code, kOk) << "again, in the same folder";
}

TEST_F(Tools, TryNeedsNoTruth) {
  const std::string folder = folder_ / "tried", blind = folder_ / "blind";
  fs::copy(query(), blind, fs::copy_options::recursive);
  fs::remove(blind + "/groundtruth.txt");
  const ToolRun run = runTool<TryApp>({map_run(), blind, "-o", folder});
  ASSERT_EQ(run.code, kOk) << run.err << run.out;
  const std::string report = contentOf(folder + "/report.html");
  EXPECT_THAT(report,
              AllOf(HasSubstr("have a sure answer"), HasSubstr("class=\"plan\""), Not(HasSubstr("TABLE"))));
  EXPECT_FALSE(fs::exists(folder + "/tables.csv"));
}

TEST_F(Tools, TryStopsWhereSomethingIsWrong) {
  const ToolRun nowhere = runTool<TryApp>({folder_ / "nowhere"});
  EXPECT_EQ(nowhere.code, kFailed);
  EXPECT_THAT(nowhere.err, HasSubstr("nowhere: does not exist"));
  EXPECT_EQ(runTool<TryApp>({}).code, kUsage);
  const ToolRun scaled = runTool<TryApp>({map_run(), "-o", folder_ / "tried", "--depth-scale", "200000"});
  EXPECT_EQ(scaled.code, kFailed);
  EXPECT_THAT(scaled.err, HasSubstr("stopped at check"));
  EXPECT_FALSE(fs::exists(folder_ / "tried/map.flmap"));
}

}  // namespace
}  // namespace facetloc
