// SPDX-License-Identifier: BSD-3-Clause
// The tools one after the other, as a user runs them, on a small simulated room.
#include "example_room.h"

#include <facetloc/io/results.h>
#include <facetloc/io/segment_file.h>

#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <cmath>

namespace facetloc::test {

ToolRun runMap(const std::vector<std::string>& arguments) {
  return captured([&](const Console& console) { return mapProgram().run(arguments, console); });
}

std::unique_ptr<TemporaryFolder> Tools::room_;

void Tools::SetUpTestSuite() {
  room_ = std::make_unique<TemporaryFolder>();
  ok(runTool<simulateApp>({"room", "-o", *room_ / "", "--seed", "5", "--frames", std::to_string(kFrames),
                           "--width", "320", "--drive.turn_deg", "8"}));
  ok(runMap({"build", map_run(), "-o", map(), "--map.distance", "0.1"}));
}

std::string Tools::withOneCorruptImage() const {
  const std::string folder = folder_.copyOf(query(), "input");
  writeContent(filesOf(folder + "/depth")[4], "no PNG at all");
  return folder;
}

void Tools::giveOtherImages(const std::string& input) {
  const auto names = filesOf(input + "/depth"), images = filesOf(map_run() + "/depth");
  for (std::size_t i = 0; i < names.size(); ++i)
    fs::copy_file(images[i], names[i], fs::copy_options::overwrite_existing);
}

namespace {

TEST_F(Tools, RefuseOptionsThatMakeNoSense) {
  const std::string out = folder_ / "out";
  for (const char* width : {"-5", "1", "39"})
    EXPECT_EQ(runTool<segmentApp>({query(), "-o", out, "--width", width}).code, kUsage) << width;
  ok(runTool<segmentApp>({firstImage(), "-o", out, "--width", "0"}));
  for (const char* tolerance : {"-1", "nan"}) {
    EXPECT_EQ(runMap({"build", query(), "-o", out + ".flmap", "--pose-tolerance", tolerance}).code, kUsage);
    EXPECT_EQ(runTool<evaluateApp>({out, query(), "--pose-tolerance", tolerance}).code, kUsage);
  }
  EXPECT_EQ(runTool<simulateApp>({"room", "-o", folder_ / "x", "--drive", "0.001"}).code, kUsage);
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

TEST_F(Tools, FromMapToEvaluation) {
  const ToolRun info = ok(runMap({"info", map()}));
  EXPECT_THAT(info.out, HasAll("local models", "facetloc 0", Not(HasSubstr("distance = 0.1"))));
  EXPECT_LE(std::count(info.out.begin(), info.out.end(), '\n'), 40) << "one screen";
  EXPECT_THAT(runMap({"info", map(), "--all"}).out, HasSubstr("[map]\n  distance = 0.1"));
  ok(runMap({"check", map()}));

  for (const char* threads : {"1", "2"}) {
    const ToolRun run =
        ok(runTool<localizeApp>({map(), query(), "-o", folder_ / threads, "--threads", threads}));
    EXPECT_THAT(lastLine(run.out), HasAll("12 images", folder_ / threads));
  }
  for (const char* file : {"/hypotheses.csv", "/poses_tum.txt", "/params.ini"}) {
    EXPECT_FALSE(contentOf(folder_ / "1" + file).empty());
    EXPECT_EQ(contentOf(folder_ / "1" + file), contentOf(folder_ / "2" + file)) << file;
  }

  EXPECT_THAT(
      ok(runTool<evaluateApp>({folder_ / "1", query() + "/groundtruth.txt", "--map", map(), "--table-paper"}))
          .out,
      HasAll("TABLE I.", "TABLE II.", "12 (100.00 %)"));
  for (const char* file : {"evaluation.txt", "tables.csv", "frames.csv", "fig6.csv"})
    EXPECT_TRUE(fs::exists(folder_ / "1/evaluation/" + file)) << file;
}

TEST_F(Tools, ATrajectoryThatCannotBeReadStopsOnlyWhoNeedsIt) {
  const std::string input = folder_.copyOf(query(), "input"), path = folder_ / "m.flmap";
  writeContent(input + "/groundtruth.txt", "0.5 left and right\n");
  ok(runTool<localizeApp>({map(), input, "-o", folder_ / "results"}));
  ok(runTool<segmentApp>({input, "-o", folder_ / "out"}));
  ok(runMap({"build", input, "-o", path, "--poses", query() + "/groundtruth.txt"}));
  EXPECT_THAT(runMap({"build", input, "-o", folder_ / "other.flmap"}), fails("groundtruth.txt", "line 1"));
}

TEST_F(Tools, ResultsReplaceNoInputs) {
  const std::string list = folder_ / "images.txt", params = folder_ / "params.ini";
  writeContent(list, firstImage() + "\n");
  writeContent(params, "# mine\nwidth = 320\n");
  const std::string here = folder_ / "";
  const std::string replaced = "the results would replace ";
  EXPECT_THAT(runTool<localizeApp>({map(), list, "-o", here}), refuses(replaced + list));
  EXPECT_THAT(runTool<localizeApp>({map(), firstImage(), "-o", here, "--params", params}),
              refuses(replaced + params));
  EXPECT_THAT(runTool<segmentApp>({list, "-o", here}), refuses(replaced + list));
  EXPECT_THAT(runTool<segmentApp>({firstImage(), "-o", here, "--params", params}),
              refuses(replaced + params));
  EXPECT_EQ(runTool<localizeApp>({map(), firstImage(), "-o", here, "--params", params, "--resume"}).code,
            kFailed);
  EXPECT_EQ(runTool<segmentApp>({firstImage(), "-o", here, "--params", params, "--resume"}).code, kFailed);
  EXPECT_EQ(contentOf(list), firstImage() + "\n");
  EXPECT_EQ(contentOf(params), "# mine\nwidth = 320\n");

  const std::string results = folder_ / "results";
  ok(runTool<localizeApp>({map(), firstImage(), "-o", results}));
  ok(runTool<localizeApp>(
      {map(), firstImage(), "-o", results, "--params", results + "/params.ini", "--resume"}));
}

TEST_F(Tools, RegisterFindsAnImageInItself) {
  const auto images = filesOf(map_run() + "/depth");
  EXPECT_THAT(runTool<registerApp>({images[0].string(), images[1].string(), "-o", images[0].parent_path()}),
              fails("holds other files already"));
  EXPECT_THAT(ok(runTool<registerApp>({images[0].string(), images[1].string(), "-o", folder_ / "out"})).out,
              HasSubstr(folder_ / "out"));
  const auto rows = readHypotheses(folder_ / "out");
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows[0].frame, images[0].stem().string());
  EXPECT_EQ(rows[0].rank > 0 ? rows[0].model : images[1].stem().string(), images[1].stem().string());
  EXPECT_EQ(runTool<registerApp>({images[0].string(), map_run()}).code, kUsage);
  EXPECT_EQ(runTool<registerApp>({images[0].string(), folder_ / "nowhere.png"}).code, kFailed);
}

TEST_F(Tools, RegisterTakesSegmentsAndMovesTheSource) {
  const auto images = filesOf(map_run() + "/depth");
  const std::string source = images[1].string(), target = images[0].string(), found = folder_ / "found";
  ok(runTool<segmentApp>({source, target, "-o", found}));
  const auto segmentsOf = [&](const std::string& image) {
    return found + "/" + std::filesystem::path(image).stem().string() + ".segments.pcd";
  };
  std::vector<std::string> clouds;
  for (const std::string& of_source : {source, segmentsOf(source)})
    for (const std::string& of_target : {target, segmentsOf(target)}) {
      clouds.push_back(folder_ / (std::to_string(clouds.size()) + ".pcd"));
      EXPECT_THAT(ok(runTool<registerApp>({of_source, of_target, "--aligned", clouds.back()})).out,
                  HasSubstr("aligned source in " + clouds.back()));
    }
  // The points of the image and its segments are moved to the same place.
  pcl::PointCloud<pcl::PointXYZ> points;
  ASSERT_EQ(pcl::io::loadPCDFile(clouds[0], points), 0);
  const std::vector<Segment> moved = readSegments(clouds[2]);
  ASSERT_FALSE(moved.empty());
  std::size_t near = 0;
  for (const pcl::PointXYZ& p : points)
    near += std::abs(moved[0].normal().dot(p.getVector3fMap().cast<double>() - moved[0].t)) < 0.03;
  EXPECT_GT(near, static_cast<std::size_t>(moved[0].num_points) / 2);

  EXPECT_THAT(runTool<registerApp>({segmentsOf(source), target, "--aligned", segmentsOf(source)}),
              refuses("would replace"));
  EXPECT_EQ(runTool<registerApp>({source, target, "--aligned", folder_ / "a.txt"}).code, kUsage);
}

}  // namespace
}  // namespace facetloc::test
