// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluate_app.h"
#include "example_room.h"
#include "tools/localize_app.h"

#include <gmock/gmock.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using test::contentOf;
using test::runMap;
using test::runTool;
using test::ToolRun;
using test::Tools;
using testing::AllOf;
using testing::HasSubstr;

TEST_F(Tools, EvaluateTellsThePlacesOfBothRuns) {
  const std::string place = fs::path(map_run()).parent_path().string();
  for (const char* run : {"map", "query"})
    ASSERT_EQ(
        runTool<LocalizeApp>({map(), place + "/" + run, "-o", folder_ / (std::string("results/") + run)})
            .code,
        kOk);
  const std::vector<std::string> arguments = {folder_ / "results", place, "--map", map()};
  const ToolRun run = runTool<EvaluateApp>(arguments);
  ASSERT_EQ(run.code, kOk) << run.err;
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("all images"), HasSubstr("new"), HasSubstr("covered"), HasSubstr("Solvable:"),
                    HasSubstr("ERRORS BY THE NUMBER OF VISIBLE PLANES"), HasSubstr("TIME PER IMAGE")));
  EXPECT_THAT(contentOf(folder_ / "results/evaluation/report.html"), HasSubstr("TABLE II."));
  auto again = arguments;
  again.insert(again.end(), {"-o", folder_ / "again"});
  ASSERT_EQ(runTool<EvaluateApp>(again).code, kOk);
  for (const char* file : {"tables.csv", "frames.csv", "fig6.csv", "errors.csv", "timing_summary.csv"})
    EXPECT_EQ(contentOf(folder_ / "results/evaluation/" + file), contentOf(folder_ / "again/" + file))
        << file;
}

TEST_F(Tools, EvaluateLeavesNothingOfAnEarlierOne) {
  const std::string results = folder_ / "results", evaluation = results + "/evaluation";
  ASSERT_EQ(runTool<LocalizeApp>({map(), query(), "-o", results}).code, kOk);
  fs::create_directories(evaluation + "/failures");
  for (const char* stale : {"/failures/miss_1.5.png", "/failures/1.5.png", "/failures/miss_1.5.txt",
                            "/floor_map.png", "/timing_summary.csv"})
    test::writeContent(evaluation + stale, "stale");
  fs::remove(results + "/timing.csv");
  ASSERT_EQ(runTool<EvaluateApp>({results, query()}).code, kOk);
  for (const char* stale : {"/failures/miss_1.5.png", "/floor_map.png", "/timing_summary.csv"})
    EXPECT_FALSE(fs::exists(evaluation + stale)) << stale;
  for (const char* others : {"/failures/1.5.png", "/failures/miss_1.5.txt"})
    EXPECT_TRUE(fs::exists(evaluation + others)) << others;
  EXPECT_TRUE(fs::exists(evaluation + "/report.html"));
}

TEST_F(Tools, EvaluateSaysWhatIsWrongWithItsInput) {
  const std::string results = folder_ / "results";
  ASSERT_EQ(runTool<LocalizeApp>({map(), query(), "-o", results}).code, kOk);
  ASSERT_EQ(runMap({"build", query(), "-o", folder_ / "other.flmap"}).code, kOk);
  ToolRun run = runTool<EvaluateApp>({results, query(), "--map", folder_ / "other.flmap"});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("of another map"));
  EXPECT_FALSE(fs::exists(results + "/evaluation"));

  const std::string hypotheses = contentOf(results + "/hypotheses.csv");
  test::writeContent(results + "/hypotheses.csv", hypotheses.substr(0, hypotheses.find('\n') + 1));
  run = runTool<EvaluateApp>({results, query()});
  EXPECT_EQ(run.code, kFailed);
  EXPECT_THAT(run.err, HasSubstr("has results of no image"));
  EXPECT_EQ(runTool<EvaluateApp>({folder_ / "nowhere", query()}).code, kFailed);
}

}  // namespace
}  // namespace facetloc
