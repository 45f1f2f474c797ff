// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/offscreen_display.h"
#include "drawing/page.h"
#include "example_scene.h"
#include "golden.h"
#include "live/live_picture.h"
#include "live/live_results.h"
#include "live/live_window.h"
#include "tool_runner.h"

#include <vtkNew.h>
#include <vtkRenderWindow.h>

namespace facetloc::test {
namespace {

const Eigen::Isometry3d kPose = ExampleScene::pose(0.2, 0.15, -4);

/** A frame of the example, tracked in its map. */
LiveResult exampleResult(TrackingState state) {
  LiveResult result;
  result.number = 7;
  result.stamp = 12.5;
  result.image = ExampleScene().see("12.500000", kPose);
  Localization answer;
  answer.tracking = state;
  if (state == TrackingState::localized || state == TrackingState::tracking) answer.state = AnswerState::sure;
  if (state == TrackingState::degenerate) answer.reason = "nothing in view fixes translation along x";
  if (state != TrackingState::searching && state != TrackingState::lost) {
    answer.T_w_c.emplace();
    answer.T_w_c->T = kPose;
    answer.T_w_c->P.diagonal() << 1e-6, 1e-6, 1e-6, 4e-4, 1e-4, 1e-4;
    Hypothesis match;
    match.model = 1;
    match.T_m_c.T = ExampleScene::pose(0.4, 0.5, 8).inverse() * kPose;
    match.T_m_c.P = answer.T_w_c->P;
    match.T_w_c = kPose;
    match.probability = 0.97;
    match.pairs = {{0, 0, 1}};
    answer.hypotheses = {match};
  }
  result.answer = answer;
  for (int i = 0; i < 5; ++i) result.trajectory.add({0.05 * i, 0.03 * i, 1});
  return result;
}

std::shared_ptr<const Map> exampleMap() { return std::make_shared<const Map>(ExampleScene().map()); }

int pixelsOf(const Raster<std::uint8_t>& picture, const Colour& c) {
  int n = 0;
  for (std::size_t i = 0; i < picture.data.size(); i += 3)
    n += picture.data[i] == c.red && picture.data[i + 1] == c.green && picture.data[i + 2] == c.blue;
  return n;
}

class LivePictureTest : public testing::Test {
protected:
  void SetUp() override {
    if (!display_.available()) GTEST_SKIP() << display_.problem();
  }
  const OffscreenDisplay display_;
};

TEST_F(LivePictureTest, ShowsTheState) {
  LiveScreenshot screenshot(exampleMap());
  for (const TrackingState state :
       {TrackingState::searching, TrackingState::localized, TrackingState::tracking,
        TrackingState::degenerate, TrackingState::lost}) {
    const LiveResult result = exampleResult(state);
    const Raster<std::uint8_t> picture = screenshot.draw(result);
    EXPECT_EQ(picture.width, 1280);
    EXPECT_EQ(picture.height, 720);
    EXPECT_GT(pixelsOf(picture, stateColour(result)), 1000) << stateName(state);
  }
}

TEST_F(LivePictureTest, IsTheSameForTheSameFrameWhateverWasDrawnBefore) {
  const LiveResult result = exampleResult(TrackingState::tracking);
  LiveScreenshot first(exampleMap());
  const Raster<std::uint8_t> expected = first.draw(result);
  LiveScreenshot second(exampleMap());
  second.draw(exampleResult(TrackingState::lost));
  LiveResult later = result;  // times are no part of the picture
  later.number = 100;
  later.age_ms = later.segment_ms = 50;
  later.received = later.dropped = 1000;
  EXPECT_TRUE(second.draw(later).data == expected.data);
  expectLikeGolden("live", expected);

  const LiveResult lost = exampleResult(TrackingState::lost);
  EXPECT_TRUE(LiveScreenshot(exampleMap()).draw(lost).data == second.draw(lost).data);
}

TEST_F(LivePictureTest, DrawsWithoutAMapAndWithoutAnything) {
  LiveResult result = exampleResult(TrackingState::searching);
  result.answer.reset();
  LiveScreenshot screenshot(nullptr);
  expectLikeGolden("live_segmenting", screenshot.draw(result));

  LiveResult blind;
  blind.image.depth.camera = {160, 120, 140, 140, 79.5, 59.5};
  blind.image.depth.depth.assign(160 * 120, 0.f);
  blind.image.labels = {160, 120, std::vector<std::uint16_t>(160 * 120, 0)};
  EXPECT_NO_THROW(screenshot.draw(blind));
  EXPECT_NO_THROW(screenshot.draw(LiveResult()));
}

TEST_F(LivePictureTest, DrawsAMapWithoutPoses) {
  Map map = ExampleScene().map();
  for (LocalModel& model : map.models) model.T_w_m.reset();
  LiveScreenshot screenshot(std::make_shared<const Map>(map));
  LiveResult result = exampleResult(TrackingState::tracking);
  result.answer->T_w_c.reset();
  EXPECT_GT(pixelsOf(screenshot.draw(result), stateColour(result)), 1000);
}

/** A picture that somebody looks at, of any size. */
class WatchedPicture {
public:
  WatchedPicture(int width, int height, std::shared_ptr<const Map> map) : picture(window_, std::move(map)) {
    setOffscreen(window_, width, height);
  }
  Raster<std::uint8_t> show(const LiveResult& result) {
    picture.show(result);
    return grabbed(window_);
  }

private:
  vtkNew<vtkRenderWindow> window_;

public:
  LivePicture picture;
};

/** The box of the pixels in which two pictures differ. */
Eigen::AlignedBox2i changesOf(const Raster<std::uint8_t>& a, const Raster<std::uint8_t>& b) {
  Eigen::AlignedBox2i box;
  for (int v = 0; v < a.height; ++v)
    for (int u = 0; u < a.width; ++u)
      if (pixelDifference(a, u, v, b, u, v) > 0) box.extend(Eigen::Vector2i(u, v));
  return box;
}

TEST_F(LivePictureTest, TurnsMovesAndZoomsThePanelUnderTheMouse) {
  const LiveResult result = exampleResult(TrackingState::tracking);
  WatchedPicture watched(1280, 720, exampleMap());
  const Raster<std::uint8_t> before = watched.show(result);
  LiveLooks& looks = watched.picture.looks();
  const auto changes = [&] { return changesOf(before, watched.show(result)); };
  const auto expectIn = [&](LiveLooks::Panel panel) {
    const Eigen::AlignedBox2i box = changes();
    ASSERT_FALSE(box.isEmpty());
    for (const auto corner : {Eigen::AlignedBox2i::BottomLeft, Eigen::AlignedBox2i::TopRight})
      EXPECT_EQ(looks.panelAt(box.corner(corner).cast<double>()), panel);
    looks.reset();
    EXPECT_TRUE(changes().isEmpty());
  };
  looks.drag({300, 400}, {300, 400}, {380, 420}, LiveLooks::Drag::turn);
  expectIn(LiveLooks::Panel::cloud);
  looks.zoom({300, 400}, 1.5);
  expectIn(LiveLooks::Panel::cloud);
  looks.drag({1000, 250}, {1000, 250}, {1040, 270}, LiveLooks::Drag::turn);
  expectIn(LiveLooks::Panel::whole);
  looks.zoom({800, 600}, 1.5);
  expectIn(LiveLooks::Panel::near);
  looks.zoom({5, 5}, 2);  // the header
  EXPECT_TRUE(changes().isEmpty());
}

TEST_F(LivePictureTest, AClickDescribesTheItem) {
  const LiveResult result = exampleResult(TrackingState::tracking);
  WatchedPicture watched(1280, 720, exampleMap());
  const Raster<std::uint8_t> before = watched.show(result);
  const Box cloud = watched.picture.looks().box(LiveLooks::Panel::cloud);
  watched.picture.choose(cloud.centre());
  const Eigen::AlignedBox2i changes = changesOf(before, watched.show(result));
  ASSERT_FALSE(changes.isEmpty());
  EXPECT_LT(changes.min().y(), cloud.top) << "the caption";
  EXPECT_GT(changes.max().y(), cloud.top) << "the outline";
  EXPECT_LT(changes.max().x(), cloud.right() + 1);
  watched.picture.choose({2, 2});
  EXPECT_TRUE(changesOf(before, watched.show(result)).isEmpty());
}

TEST_F(LivePictureTest, PosesThatAreNotSureAreGrey) {
  constexpr Colour kUntold = {140, 140, 140};
  LiveScreenshot screenshot(exampleMap());
  const auto grey = [&](TrackingState state) {
    return pixelsOf(screenshot.draw(exampleResult(state)), kUntold);
  };
  EXPECT_GT(grey(TrackingState::degenerate), grey(TrackingState::tracking) + 100)
      << "of the depth image both";
}

TEST_F(LivePictureTest, FitsSmallWindows) {
  const LiveResult result = exampleResult(TrackingState::tracking);
  for (const auto& [width, height] : {std::pair(800, 480), {480, 640}, {320, 240}, {90, 60}}) {
    WatchedPicture watched(width, height, exampleMap());
    const Raster<std::uint8_t> picture = watched.show(result);
    EXPECT_EQ(picture.width, width);
    if (height < 400) continue;
    const Box cloud = watched.picture.looks().box(LiveLooks::Panel::cloud);
    EXPECT_GT(cloud.width, 0.4 * width);
    EXPECT_GT(cloud.height, 0.3 * height);
    EXPECT_GT(watched.picture.looks().box(LiveLooks::Panel::whole).width, 180);
  }
}

TEST(LiveLooks, ZoomKeepsThePlaceUnderTheMouse) {
  LiveLooks looks;
  looks.setBoxes({0, 0, 400, 200}, {400, 0, 200, 200}, {});
  const Eigen::Vector2d at(560, 40), centre(500, 100);
  looks.drag(at, at, {570, 60}, LiveLooks::Drag::move);
  // The place shown at a pixel, in heights of the panel from its centre before any change.
  const auto shownAt = [&](const Eigen::Vector2d& pixel) {
    const PanelLook& look = looks[LiveLooks::Panel::whole];
    const Eigen::Vector2d offset = (pixel - centre) / 200;
    return Eigen::Vector2d((Eigen::Vector2d(offset.x(), -offset.y()) - look.shift) / look.zoom);
  };
  EXPECT_NEAR((shownAt({570, 60}) - Eigen::Vector2d(0.3, 0.3)).norm(), 0, 1e-12) << "moved with the mouse";
  const Eigen::Vector2d before = shownAt(at);
  for (const double factor : {1.2, 3.0, 0.1, 1e9}) {
    looks.zoom(at, factor);
    EXPECT_NEAR((shownAt(at) - before).norm(), 0, 1e-9) << factor;
  }
  EXPECT_LE(looks[LiveLooks::Panel::whole].zoom, 100);
  EXPECT_FALSE(looks.panelAt({700, 50}));
}

TEST_F(LivePictureTest, WindowReportsItsUsersCommands) {
  LiveWindow window("test", exampleMap());
  window.show(exampleResult(TrackingState::tracking), {"30.0 frames/s"});
  EXPECT_THAT(window.commands(), IsEmpty());
  for (const char* key : {"s", "x", "r", "space", "p", "l", "q"}) window.press(key);
  EXPECT_THAT(window.commands(), ElementsAre(LiveCommand::screenshot, LiveCommand::record, LiveCommand::pause,
                                             LiveCommand::pause, LiveCommand::relocalize, LiveCommand::quit));
  EXPECT_THAT(window.commands(), IsEmpty());
}

TEST(LiveKeys, AreAllExplained) {
  for (const char* key : {"s", "r", "p", "l", "q"}) {
    EXPECT_TRUE(commandOf(key)) << key;
    EXPECT_THAT(keysText(), HasSubstr(std::string(key) + " "));
  }
  EXPECT_FALSE(commandOf("Shift_L"));
}

TEST(LiveResults, GiveAPoseWhereItIsCertain) {
  const TemporaryFolder folder;
  const std::string path = folder / "results";
  LiveResults results(path, "width = 320\n");
  EXPECT_TRUE(readHypotheses(path).empty()) << "there from the begin";
  for (const TrackingState state :
       {TrackingState::searching, TrackingState::localized, TrackingState::tracking,
        TrackingState::degenerate, TrackingState::lost}) {
    const LiveResult result = exampleResult(state);
    results.append(result, frameResult(result, exampleMap().get(), kMinProbability));
  }
  const auto rows = readHypotheses(path);  // while it is being written
  ASSERT_EQ(rows.size(), 5u);
  const std::vector<int> ranks = {0, 1, 1, 0, 0};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(rows[i].rank, ranks[i]) << i;
  EXPECT_EQ(rows[1].model, "left");
  ASSERT_TRUE(rows[1].T_w_c);
  EXPECT_LT((rows[1].T_w_c->translation() - kPose.translation()).norm(), 1e-6);
  EXPECT_THAT(rows[3].reason, HasSubstr("cannot tell: nothing in view fixes"));
  EXPECT_THAT(contentOf(path + "/states.csv"), HasSubstr("12.500000,12.500000,tracking,,0,0,0.000\n"));
}

TEST(LiveResults, GiveAPoseThatIsCarriedOnWhereTheMapShowsNothing) {
  const TemporaryFolder folder;
  LiveResult result = exampleResult(TrackingState::tracking);
  result.answer->hypotheses.front().pairs.clear();
  LiveResults(folder / "results", "")
      .append(result, frameResult(result, exampleMap().get(), kMinProbability));
  const auto rows = readHypotheses(folder / "results");
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].rank, 1);
  const std::shared_ptr<const Map> map = exampleMap();
  const LocalModel& latest = map->models[result.answer->hypotheses.front().model];
  EXPECT_EQ(rows[0].model, latest.name);
  EXPECT_THAT(rows[0].reason, HasSubstr("carried on"));
  ASSERT_TRUE(rows[0].T_w_c);
  EXPECT_TRUE(rows[0].T_w_c->isApprox(kPose, 1e-6));
  EXPECT_TRUE((*latest.T_w_m * rows[0].T_m_c).isApprox(kPose, 1e-6));
  EXPECT_NEAR(rows[0].sd_trans_m, 0.02, 1e-9);
}

}  // namespace
}  // namespace facetloc::test
