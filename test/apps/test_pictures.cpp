// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/depth_drawing.h"
#include "drawing/offscreen_display.h"
#include "drawing/pictures.h"
#include "evaluation/evaluation_pictures.h"
#include "example_scene.h"
#include "golden.h"
#include "tool_runner.h"

#include <facetloc/io/error.h>
#include <facetloc/testing/changed_views.h>

#include <optional>

namespace facetloc::test {
namespace {

const Eigen::Isometry3d kQueryPose = ExampleScene::pose(0.2, 0.15, -4);

std::vector<Colour> someColours(std::size_t n) {
  std::vector<Colour> colours;
  for (std::size_t k = 0; k < n; ++k) colours.push_back(segmentColour(k).withAlpha(150));
  return colours;
}

TEST(DepthDrawing, DepthBecomesGrey) {
  const DepthImage image{{4, 1, 1, 1, 0, 0}, {1.f, 2.f, 0.f, 3.f}};
  EXPECT_THAT(greyDepth(image).data, ElementsAre(50, 50, 50, 152, 152, 152, 0, 0, 0, 255, 255, 255));
  EXPECT_THAT(greyDepth(image, {10, 20, 7}).data, ElementsAre(10, 10, 10, 15, 15, 15, 7, 7, 7, 20, 20, 20));
}

TEST(DepthDrawing, AlphaMixesColours) {
  Raster<std::uint8_t> picture{3, 1, 3, {100, 100, 100, 100, 100, 100, 100, 100, 100}};
  paintSegments(picture, {3, 1, {0, 1, 2}}, {{200, 0, 100, 255}, {200, 0, 100, 51}});
  EXPECT_THAT(picture.data, ElementsAre(100, 100, 100, 200, 0, 100, 120, 80, 100));
}

TEST(DepthDrawing, OutlineIsGolden) {
  const SeenImage image = ExampleScene().see("x", kQueryPose);
  expectGolden("outline", overlay(image.depth, image.labels));
}

TEST(DepthDrawing, SegmentsOfAViewAreGolden) {
  const View view = ExampleScene().see("x", kQueryPose).view;
  Raster<std::uint8_t> picture = greyDepth(depthOf(view));
  paintSegments(picture, seenSegments(view), someColours(view.segments.size()));
  expectGolden("seen_segments", picture);
}

TEST(DepthDrawing, SegmentsAreSeenWhereTheyAre) {
  const SeenImage image = ExampleScene().see("x", kQueryPose);
  const LabelImage labels = seenSegments(image.view);
  ASSERT_EQ(labels.width, 80);
  int agree = 0;
  for (int v = 0; v < labels.height; ++v)
    for (int u = 0; u < labels.width; ++u)
      agree += labels.label[static_cast<std::size_t>(v) * 80 + u] ==
               image.labels.label[static_cast<std::size_t>(2 * v) * 160 + 2 * u];
  EXPECT_GT(agree, 0.95 * 80 * 60);
}

TEST(DepthDrawing, WithoutDepthTheNearestSegmentIsSeen) {
  SeenImage image = ExampleScene().see("x", kQueryPose);
  const LabelImage with_depth = seenSegments(image.view);
  image.view.depth = {};
  const LabelImage labels = seenSegments(image.view);
  int differ = 0;
  for (std::size_t i = 0; i < labels.label.size(); ++i) differ += labels.label[i] != with_depth.label[i];
  EXPECT_LT(differ, 0.05 * static_cast<double>(labels.label.size()));
}

TEST(DepthDrawing, Averages) {
  const Raster<std::uint8_t> picture{5, 2, 1, {0, 10, 100, 200, 9, 20, 30, 100, 201, 9}};
  EXPECT_THAT(averaged(picture, 2).data, ElementsAre(15, 150));
}

TEST(MatchedSegments, AreTheSameSurfacesAtTheTruePose) {
  const Map map = ExampleScene().map();
  const View query = ExampleScene().see("x", kQueryPose).view;
  const auto pairs = matchedSegments(query, *map.view(1), map.models[1].T_w_m->inverse() * kQueryPose);
  ASSERT_EQ(pairs.size(), query.segments.size());
  for (const SegmentPair& pair : pairs) EXPECT_EQ(pair.scene, pair.model);
}

TEST(MatchedSegments, AreFewAtAWrongPose) {
  const Map map = ExampleScene().map();
  const View query = ExampleScene().see("x", kQueryPose).view;
  const Eigen::Isometry3d wrong = ExampleScene::pose(0.6, 0.4, 20);
  EXPECT_LE(matchedSegments(query, *map.view(0), map.models[0].T_w_m->inverse() * wrong).size(), 2u);
  EXPECT_TRUE(matchedSegments(View(), *map.view(0), wrong).empty());
}

TEST(Failures, AreWrongOrMissingAnswers) {
  const Map map = ExampleScene().map();
  Evaluation evaluation;
  const auto add = [&](const std::string& name, int hypotheses, int first_correct,
                       double probability) -> FrameEvaluation& {
    FrameEvaluation frame;
    frame.name = name;
    frame.T_w_c = kQueryPose;
    frame.hypotheses = hypotheses;
    frame.first_correct = first_correct;
    frame.probability = probability;
    frame.nearest = NearestModel{"left", 0.4, 12};
    if (hypotheses > 0) frame.best_error = PoseError();
    evaluation.frames.push_back(frame);
    return evaluation.frames.back();
  };
  add("right", 3, 1, 0.9);
  add("missing", 0, 0, 0).reason = "two planes only";
  add("second", 3, 2, 0.4);
  add("wrong", 2, 0, 0.7);
  add("nowhere", 2, 0, 0.3).unmapped = true;
  std::vector<RunResults> runs(1);
  for (const FrameEvaluation& frame : evaluation.frames) {
    ResultRow row;
    row.frame = frame.name;
    row.rank = frame.hypotheses > 0 ? 1 : 0;
    row.model = frame.hypotheses > 0 ? "right" : "";
    runs[0].rows.push_back(row);
  }

  const auto failures = findFailures(evaluation, runs, map);
  ASSERT_EQ(failures.size(), 3u);
  EXPECT_EQ(failures[0].frame, "wrong");
  EXPECT_EQ(failures[1].frame, "second");
  EXPECT_EQ(failures[2].frame, "missing");
  EXPECT_EQ(failures[2].answers[0].model, -1);
  EXPECT_THAT(failures[2].answers[0].caption, HasSubstr("two planes only"));
  EXPECT_EQ(failures[0].answers[0].model, 2);
  EXPECT_EQ(failures[0].answers[1].model, 1);
  EXPECT_TRUE((*map.models[1].T_w_m * failures[0].answers[1].T_m_c).isApprox(kQueryPose, 1e-12));
  runs[0].rows[3].model = "of another map";
  EXPECT_THROW(findFailures(evaluation, runs, map), std::runtime_error);
}

TEST(Failures, OfRunsWithTheSameNamesAreDistinguished) {
  const Map map = ExampleScene().map();
  Evaluation evaluation;
  std::vector<RunResults> runs;
  for (const std::string name : {"left", "right"}) {
    FrameEvaluation frame;
    frame.run = name;
    frame.name = "1.0";
    frame.hypotheses = 1;
    evaluation.frames.push_back(frame);
    ResultRow row;
    row.frame = "1.0";
    row.rank = 1;
    row.model = name;
    runs.push_back({name, {row}, {}});
  }
  const auto failures = findFailures(evaluation, runs, map);
  ASSERT_EQ(failures.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(failures[i].run, runs[i].name);
    EXPECT_EQ(map.models.at(failures[i].answers.at(0).model).name, runs[i].name);
  }
}

/** Pictures that VTK renders. */
class Pictures : public testing::Test {
protected:
  static void SetUpTestSuite() { display_ = std::make_unique<OffscreenDisplay>(); }
  static void TearDownTestSuite() { display_.reset(); }
  void SetUp() override {
    if (!display_->available()) GTEST_SKIP() << display_->problem();
  }

  /** Half the size: small files, and no trifles. */
  Raster<std::uint8_t> written() const { return averaged(readRgbPng(path_), 2); }
  std::vector<DrawnMatch> answers() const {
    return {{1, map_.models[1].T_w_m->inverse() * kQueryPose, "rank 1, probability 0.93"},
            {-1, Eigen::Isometry3d::Identity(), "no hypothesis"}};
  }
  std::vector<DrawnRun> runs() const {
    DrawnRun run;
    run.name = "run";
    for (int i = 0; i < 12; ++i) run.T_w_c.push_back(ExampleScene::pose(0.12 * i, 0.4 - 0.01 * i * i, 0));
    return {run};
  }
  std::vector<DrawnMarks> marks() const { return {{"failures", {ExampleScene::pose(1, 0, 0)}}}; }

  const ExampleScene scene_;
  const Map map_ = scene_.map();
  const SeenImage query_ = scene_.see("query", kQueryPose);
  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "picture.png";

private:
  static std::unique_ptr<OffscreenDisplay> display_;
};
std::unique_ptr<OffscreenDisplay> Pictures::display_;

TEST_F(Pictures, SegmentationIsGolden) {
  drawSegmentation(path_, query_);
  expectLikeGolden("segmentation", written());
}

TEST_F(Pictures, FloorMapIsGolden) {
  drawFloorMap(path_, map_, runs(), marks());
  expectLikeGolden("floor_map", written());
}

TEST_F(Pictures, MatchesAreGolden) {
  expectLikeGolden("matches", averaged(matchesPicture(query_, map_, answers()), 2));
}

TEST_F(Pictures, BeliefsAreGolden) {
  const auto placeAt = [](double x, double probability, double std) {
    return PagePlace{-1, Eigen::Isometry3d::Identity(), ExampleScene::pose(x, 0, 0.3), probability, std};
  };
  std::vector<PageAnswer> answers(3);
  answers[0].places = {placeAt(0, 0.4, 0.2), placeAt(1, 0.3, 0.3)};
  answers[0].truth = ExampleScene::pose(1, 0, 0.3);
  answers[1].places = {placeAt(1, 0.95, 0.02)};
  answers[1].state = AnswerState::sure;
  const std::vector<std::string> titles = {"image 1: doubtful", "image 2: sure", "image 3: unknown"};
  drawBeliefs(path_, map_, answers, titles);
  expectLikeGolden("beliefs", written());
  const std::string first = contentOf(path_);
  drawBeliefs(path_, map_, answers, titles);
  EXPECT_EQ(first, contentOf(path_));
  EXPECT_THROW(drawBeliefs(path_, map_, {}, {}), std::invalid_argument);
  EXPECT_THROW(drawBeliefs(path_, Map(), answers, titles), IoError);
}

TEST_F(Pictures, APlanIsDrawnForTheSegments) {
  OccupancyGrid grid = OccupancyGrid::filled(60, 40, 0.1, {-10, -10}, OccupancyGrid::kFree);
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < 15; ++column) {
      grid.cells[grid.index(column, row)] = OccupancyGrid::kOccupied;
      grid.cells[grid.index(grid.width - 1 - column, row)] = OccupancyGrid::kUnknown;
    }
  drawFloorMap(path_, map_, {}, {}, &grid);
  const Raster<std::uint8_t> picture = written();
  const auto pixelsOf = [&](std::uint8_t grey) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < picture.data.size(); i += 3)
      n +=
          std::all_of(picture.data.data() + i, picture.data.data() + i + 3, [&](int c) { return c == grey; });
    return static_cast<double>(n);
  };
  EXPECT_GT(pixelsOf(60), 1000);
  EXPECT_NEAR(pixelsOf(232) / pixelsOf(60), 1, 0.05) << "as many unknown cells as occupied ones";
}

TEST_F(Pictures, AMissingElementIsNoticed) {
  if (updatesGolden()) GTEST_SKIP();
  const Raster<std::uint8_t> golden = readRgbPng(goldenPath("floor_map"));
  const auto lacks = [&](const Map& map, const std::vector<DrawnRun>& runs) {
    drawFloorMap(path_, map, runs, marks());
    return strangePixels(golden, written());
  };
  Map unlinked = map_;
  unlinked.links.pop_back();
  EXPECT_GT(lacks(unlinked, runs()), 4);
  auto recoloured = runs();
  recoloured[0].colour = {200, 40, 40};
  EXPECT_GT(lacks(map_, recoloured), 4);
  EXPECT_EQ(lacks(map_, runs()), 0);
}

TEST_F(Pictures, AreTheSameEachTime) {
  const auto twice = [&](const auto& draw) {
    draw(path_);
    const std::string first = contentOf(path_);
    draw(path_);
    return !first.empty() && first == contentOf(path_);
  };
  EXPECT_TRUE(twice([&](const auto& path) { drawSegmentation(path, query_); }));
  EXPECT_TRUE(twice([&](const auto& path) { drawFloorMap(path, map_, runs(), marks()); }));
  EXPECT_TRUE(twice([&](const auto& path) { writePng(path, matchesPicture(query_, map_, answers())); }));
}

TEST_F(Pictures, AViewWithoutSegmentsIsDrawn) {
  SeenImage empty = query_;
  empty.depth.depth.assign(empty.depth.depth.size(), 0.f);
  empty.labels.label.assign(empty.labels.label.size(), 0);
  empty.view = View();
  empty.view.intrinsics = empty.depth.camera;
  drawSegmentation(path_, empty);
  EXPECT_GT(written().width, 0);
  EXPECT_GT(matchesPicture(empty, map_, answers()).width, 0);
}

TEST_F(Pictures, AModelWithoutDepthIsDrawn) {
  Map map = map_;
  const Raster<std::uint8_t> with_depth = matchesPicture(query_, map, answers());
  changeView(map, 1, [](View& view) { view.depth = {}; });
  const Raster<std::uint8_t> without = matchesPicture(query_, map, answers());
  EXPECT_EQ(without.width, with_depth.width);
  EXPECT_GT(strangePixels(with_depth, without), 100);  // its segments stand before an empty ground
}

TEST_F(Pictures, AMapNeedsPoses) {
  Map map = map_;
  map.models[0].T_w_m.reset();
  drawFloorMap(path_, map, {});
  for (LocalModel& model : map.models) model.T_w_m.reset();
  EXPECT_THROW(drawFloorMap(path_, map, {}), IoError);
  EXPECT_THROW(drawFloorMap(path_, Map(), {}), IoError);
}

TEST_F(Pictures, AnImageNeedsPixels) {
  SeenImage image = query_;
  image.labels = {};
  EXPECT_THROW(drawSegmentation(path_, image), std::invalid_argument);
  EXPECT_THROW(drawSegmentation(path_, SeenImage()), std::invalid_argument);
  EXPECT_THROW(matchesPicture(SeenImage(), map_, answers()), std::invalid_argument);
}

TEST_F(Pictures, AFileThatCannotBeWrittenIsAnError) {
  EXPECT_THROW(drawFloorMap(folder_ / "nowhere/picture.png", map_, {}), IoError);
}

/** Sets a variable of the environment for the life of the object. */
class Environment {
public:
  Environment(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    value ? setenv(name, value, 1) : unsetenv(name);
  }
  ~Environment() { before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST(OffscreenDisplay, LeavesTheEnvironmentAsItWas) {
  const Environment display("DISPLAY", ":9999");  // no server there
  {
    const OffscreenDisplay offscreen;
    if (!offscreen.available()) GTEST_SKIP() << offscreen.problem();
    EXPECT_STRNE(std::getenv("DISPLAY"), ":9999");
  }
  EXPECT_STREQ(std::getenv("DISPLAY"), ":9999");
}

TEST(OffscreenDisplay, NamesTheCauseOfFailure) {
  const Environment display("DISPLAY", nullptr), path("PATH", "/nonexistent");
  const OffscreenDisplay offscreen;
  EXPECT_FALSE(offscreen.available());
  EXPECT_THAT(offscreen.problem(), HasSubstr("xvfb"));
}

TEST(Runs, LookTheSameEachTime) {
  const Environment display("DISPLAY", nullptr);
  const OffscreenDisplay offscreen;
  if (!offscreen.available()) GTEST_SKIP() << offscreen.problem();
  const TemporaryFolder folder;
  const Eigen::Isometry3d start = Eigen::Isometry3d::Identity(), end(Eigen::Translation3d(2, 1, 0));
  const PlanView above(Eigen::Vector3d::UnitZ());
  drawRuns(folder / "a.png", above, {{"walk", {start, end}}, {"nothing", {}}});
  drawRuns(folder / "b.png", above, {{"walk", {start, end}}, {"nothing", {}}});
  const std::string a = contentOf(folder / "a.png");
  EXPECT_EQ(a.substr(1, 3), "PNG");
  EXPECT_EQ(a, contentOf(folder / "b.png"));
}

}  // namespace
}  // namespace facetloc::test
