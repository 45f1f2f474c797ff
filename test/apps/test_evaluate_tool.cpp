// SPDX-License-Identifier: BSD-3-Clause
#include "cli/findings_file.h"
#include "example_room.h"
#include "golden.h"

#include <facetloc/features/pose.h>
#include <facetloc/io/trajectory.h>

#include <algorithm>

namespace facetloc::test {
namespace {

TEST_F(Tools, EvaluateDistinguishesThePlacesOfBothRuns) {
  const std::string place = fs::path(map_run()).parent_path().string();
  for (const char* run : {"map", "query"})
    ok(runTool<localizeApp>({map(), place + "/" + run, "-o", folder_ / (std::string("results/") + run)}));
  const std::vector<std::string> arguments = {folder_ / "results", place, "--map", map(), "--table-paper"};
  EXPECT_THAT(ok(runTool<evaluateApp>(arguments)).out,
              HasAll("all images", "new", "covered", "Solvable:", "ERRORS BY THE NUMBER OF VISIBLE PLANES",
                     "TIME PER IMAGE"));
  EXPECT_THAT(contentOf(folder_ / "results/evaluation/report.html"),
              HasAll("<title>Localization of " + fs::path(place).filename().string() + "</title>",
                     "TABLE II.", "id=\"plan\"", "Fig. 5"));
  const Raster<std::uint8_t> examples = readRgbPng(folder_ / "results/evaluation/fig5.png");
  EXPECT_GT(examples.height, examples.width / 2) << "four rows of two runs";
  ok(runTool<evaluateApp>(arguments + Arguments{"-o", folder_ / "again"}));
  for (const char* file : {"tables.csv", "frames.csv", "fig6.csv", "errors.csv", "timing_summary.csv"})
    EXPECT_EQ(contentOf(folder_ / "results/evaluation/" + file), contentOf(folder_ / "again/" + file))
        << file;
}

TEST_F(Tools, EvaluateLeavesNothingOfAnEarlierOne) {
  const std::string results = folder_ / "results", evaluation = results + "/evaluation";
  ok(runTool<localizeApp>({map(), query(), "-o", results}));
  fs::create_directories(evaluation + "/failures");
  for (const char* stale : {"/failures/miss_1.5.png", "/failures/1.5.png", "/failures/miss_1.5.txt",
                            "/floor_map.png", "/timing_summary.csv"})
    writeContent(evaluation + stale, "stale");
  fs::remove(results + "/timing.csv");
  ok(runTool<evaluateApp>({results, query()}));
  for (const char* stale : {"/failures/miss_1.5.png", "/floor_map.png", "/timing_summary.csv"})
    EXPECT_FALSE(fs::exists(evaluation + stale)) << stale;
  for (const char* others : {"/failures/1.5.png", "/failures/miss_1.5.txt"})
    EXPECT_TRUE(fs::exists(evaluation + others)) << others;
  EXPECT_TRUE(fs::exists(evaluation + "/report.html"));
}

TEST_F(Tools, EvaluateAlignsResultsOfAnotherWorld) {
  const std::string results = folder_ / "results", moved = folder_ / "moved";
  ok(runTool<localizeApp>({map(), query(), "-o", results}));
  fs::create_directories(moved);
  std::vector<StampedPose> poses = readTrajectory(query() + "/groundtruth.txt").poses();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = expSO3({0.2, -0.4, 2});
  motion.translation() << 30, -20, 5;
  for (StampedPose& pose : poses) pose.T_w_c = motion * pose.T_w_c;
  writeTumTrajectory(moved + "/groundtruth.txt", poses);

  const std::vector<std::string> lost = {results, moved, "--map", map(), "-o", folder_ / "lost"};
  ok(runTool<evaluateApp>(lost));
  const ToolRun run =
      ok(runTool<evaluateApp>({results, moved, "--map", map(), "--align", "-o", folder_ / "found"}));
  EXPECT_THAT(run.out, HasAll("Aligned with the truth: rotated by",
                              "Absolute trajectory error of all sure answers: RMSE"));
  ok(runTool<evaluateApp>({results, query(), "--map", map(), "-o", folder_ / "own"}));
  const auto correct = [&](const std::string& evaluation) {
    for (const std::string& line : linesIn(contentOf(folder_ / evaluation + "/tables.csv")))
      if (line.rfind("beyond,,Rank 1 correct,", 0) == 0)
        return std::stoi(line.substr(line.find(",,", 8) + 2));
    return -1;
  };
  EXPECT_EQ(correct("lost"), 0);
  EXPECT_GT(correct("found"), 0);
  EXPECT_EQ(correct("found"), correct("own"));
}

TEST_F(Tools, EvaluateKnowsErrorsRelativeToLocalModels) {
  const std::string results = folder_ / "results", truth = map_run() + "/groundtruth.txt";
  ok(runTool<localizeApp>({map(), query(), "-o", results}));
  const std::string title = "Sure answers relative to their local models";
  EXPECT_THAT(runTool<evaluateApp>({results, query(), "--map", map()}).out, Not(HasSubstr(title)));
  EXPECT_THAT(runTool<evaluateApp>({results, query(), "--map", map(), "--map-groundtruth", truth}).out,
              HasSubstr(title));
  EXPECT_THAT(runTool<evaluateApp>({results, query(), "--map-groundtruth", truth}).out, HasSubstr(title))
      << "by the names of models, which are stamps";
}

TEST_F(Tools, EvaluateJudgesATrajectory) {
  const std::string truth = map_run() + "/groundtruth.txt", estimate = folder_ / "walk.txt";
  std::vector<StampedPose> poses = readTrajectory(truth).poses();
  const std::size_t all = poses.size();
  for (StampedPose& pose : poses) pose.T_w_c.translation() *= 1.01;
  writeTumTrajectory(estimate, poses);
  ToolRun run = ok(runTool<evaluateApp>({estimate, map_run()}));
  EXPECT_THAT(run.out, HasAll(std::to_string(all) + " poses over", "ABSOLUTE TRAJECTORY ERROR",
                              "position [mm]", "over 1 s [mm]"));
  EXPECT_THAT(lastLine(run.out), HasSubstr(folder_ / "walk_evaluation"));
  for (const char* file : {"/evaluation.txt", "/trajectory_errors.csv", "/trajectory_summary.csv",
                           "/report.html", "/trajectory.png"})
    EXPECT_TRUE(fs::exists(folder_ / "walk_evaluation" + file)) << file;
  const std::string csv = contentOf(folder_ / "walk_evaluation/trajectory_errors.csv");
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), all + 1);

  EXPECT_THAT(runTool<evaluateApp>({estimate, query()}),
              fails("walk.txt", "0 pairs"));  // another run, at other times
  poses.resize(2);
  writeTumTrajectory(estimate, poses);
  EXPECT_THAT(runTool<evaluateApp>({estimate, truth}).err, HasSubstr("2 pairs"));
  poses.push_back(poses.back());
  writeTumTrajectory(estimate, poses);
  EXPECT_THAT(runTool<evaluateApp>({estimate, truth}).err, HasSubstr("two estimated poses have the stamp"));
  writeContent(estimate, "no pose\n");
  EXPECT_THAT(runTool<evaluateApp>({estimate, truth}).err, HasSubstr("line 1"));
}

TEST_F(Tools, EvaluateKnowsWhatIsInDoubt) {
  const std::string results = folder_ / "results", known = folder_ / "known.json";
  ok(runTool<localizeApp>({map(), query(), "-o", results}));
  writeFindings(known, {{"poses.disagree",
                         Severity::doubt,
                         "the poses disagree",
                         "look at them",
                         {{"rotation_deg", 1}, {"translation_m", 0.01}}}});
  writeFindings(results + "/" + kFindingsFile, {{"localize.scale", Severity::doubt, "too far", ""}});
  const auto of_report = HasAll("In doubt: the poses disagree; look at them.", "In doubt: too far.",
                                "Next: Settle first what is in doubt: look at them.");
  const ToolRun run = ok(runTool<evaluateApp>({results, query(), "--known", known, "--known", known}));
  EXPECT_THAT(run.out, AllOf(of_report, HasSubstr("within 0.2 m and orientation within 3 deg")));
  const auto listed = HasSubstr("Findings\n- the poses disagree; look at them\n- too far\n\n");
  EXPECT_THAT(run.out, listed);
  const std::string page = contentOf(results + "/evaluation/report.html");
  EXPECT_THAT(page, AllOf(of_report, HasAll("<h2>Findings</h2>", "<td>the poses disagree</td>")));
  EXPECT_LT(page.find("<h2>Findings</h2>"), page.find("<h2>Charts</h2>"));
  EXPECT_THAT(ok(runTool<evaluateApp>({results, "--known", known})).out, AllOf(of_report, listed))
      << "without a truth";
}

TEST_F(Tools, EvaluateCallsNoMapReadyByItsOwnImages) {
  const std::string results = folder_ / "results";
  ok(runTool<localizeApp>({map(), map_run(), "-o", results}));
  for (const Arguments& truth : {Arguments(), Arguments{map_run()}})
    EXPECT_THAT(ok(runTool<evaluateApp>(Arguments{results} + truth + Arguments{"--map", map()})).out,
                Not(HasSubstr("ready to be used")));
}

TEST_F(Tools, EvaluateNamesFaultsOfItsInput) {
  const std::string results = folder_ / "results";
  ok(runTool<localizeApp>({map(), query(), "-o", results}));
  ok(runMap({"build", query(), "-o", folder_ / "other.flmap"}));
  EXPECT_THAT(runTool<evaluateApp>({results, query(), "--map", folder_ / "other.flmap"}),
              fails("of another map"));
  EXPECT_FALSE(fs::exists(results + "/evaluation"));

  const std::string hypotheses = contentOf(results + "/hypotheses.csv");
  const std::string header = hypotheses.substr(0, hypotheses.find('\n') + 1);
  std::string doubtful = hypotheses;
  for (std::size_t at; (at = doubtful.find(",sure")) != std::string::npos;)
    doubtful.replace(at, 5, ",doubtful");
  writeContent(results + "/hypotheses.csv", doubtful);
  EXPECT_THAT(runTool<evaluateApp>({results, query(), "--align"}), fails("has 0 sure answers"));

  writeContent(results + "/hypotheses.csv", header);
  EXPECT_THAT(runTool<evaluateApp>({results, query()}), fails("contains no results of any image"));
  EXPECT_EQ(runTool<evaluateApp>({folder_ / "nowhere", query()}).code, kFailed);
}

}  // namespace
}  // namespace facetloc::test
