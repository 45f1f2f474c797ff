// SPDX-License-Identifier: BSD-3-Clause
#include "cli/text.h"
#include "drawing/depth_drawing.h"
#include "drawing/page.h"
#include "drawing/pictures.h"
#include "drawing/plan_view.h"
#include "drawing/segment_scene.h"

#include <facetloc/registration/registration_params.h>

#include <algorithm>
#include <fmt/format.h>

namespace facetloc {
namespace {

constexpr double kPanelWidth = 480;  // [px]
constexpr double kMargin = 16, kGap = 12;
constexpr double kCaption = 32, kTitle = 24;  // heights [px]
constexpr GreyScale kPale = {110, 245, 60};
constexpr Colour kUnmatched = {130, 130, 130};

/** The matches of one answer, numbered from 0 by model segment, in the order of the query's segments. */
struct Numbering {
  std::vector<int> of_query;  // indexed by segment; -1 = unmatched
  std::vector<int> of_model;
  int size = 0;

  Numbering(const View& query, const View& model, const std::vector<SegmentPair>& pairs)
      : of_query(query.segments.size(), -1), of_model(model.segments.size(), -1) {
    for (const SegmentPair& pair : pairs) {
      if (of_model[pair.model] < 0) of_model[pair.model] = size++;
      of_query[pair.scene] = of_model[pair.model];
    }
  }
};

/** One side of a match: a picture, the segments in it, and their numbers. */
struct Side {
  DepthImage depth;
  LabelImage labels;
  const std::vector<int>& numbers;  // indexed by segment
};

Raster<std::uint8_t> paintedSide(const Side& side) {
  std::vector<Colour> fills, outlines;
  for (const int number : side.numbers) {
    fills.push_back(number < 0 ? kUnmatched.withAlpha(70) : segmentColour(number).withAlpha(150));
    outlines.push_back(number < 0 ? kBlack.withAlpha(60) : kBlack.withAlpha(190));
  }
  Raster<std::uint8_t> picture = greyDepth(side.depth, kPale);
  paintSegments(picture, side.labels, fills);
  paintBorders(picture, side.labels, outlines);
  return picture;
}

/** The pixel of each segment that lies deepest inside of it, so that a number there is not on an edge: by
 * the distance to its border along rows and columns. Negative for segments of no pixels. */
std::vector<Eigen::Vector2i> innermostPixels(const LabelImage& labels, std::size_t segments) {
  const int w = labels.width, h = labels.height;
  std::vector<int> depth(labels.label.size(), 0);  // distance to the border in rows and columns, two passes
  const auto at = [&](int u, int v) { return static_cast<std::size_t>(v) * w + u; };
  const auto lower = [&](int u, int v, int du, int dv) {
    const int x = u + du, y = v + dv;
    const bool inside =
        x >= 0 && y >= 0 && x < w && y < h && labels.label[at(x, y)] == labels.label[at(u, v)];
    depth[at(u, v)] = std::min(depth[at(u, v)], inside ? depth[at(x, y)] + 1 : 1);
  };
  for (int v = 0; v < h; ++v)
    for (int u = 0; u < w; ++u) depth[at(u, v)] = w + h, lower(u, v, -1, 0), lower(u, v, 0, -1);
  for (int v = h - 1; v >= 0; --v)
    for (int u = w - 1; u >= 0; --u) lower(u, v, 1, 0), lower(u, v, 0, 1);

  std::vector<Eigen::Vector2i> best(segments, {-1, -1});
  std::vector<int> deepest(segments + 1, 0);
  for (int v = 0; v < h; ++v)
    for (int u = 0; u < w; ++u) {
      const std::size_t label = labels.label[at(u, v)];
      if (label == 0 || label > segments || depth[at(u, v)] <= deepest[label]) continue;
      deepest[label] = depth[at(u, v)];
      best[label - 1] = {u, v};
    }
  return best;
}

/** The number of each match in the middle of its largest segment. */
void drawNumbers(Page& page, const Box& box, const Side& side) {
  const auto pixels = innermostPixels(side.labels, side.numbers.size());
  const Eigen::Vector2d scale(box.width / side.labels.width, box.height / side.labels.height);
  for (std::size_t k = 0; k < side.numbers.size(); ++k) {
    if (side.numbers[k] < 0 || pixels[k].x() < 0) continue;
    const Eigen::Vector2d inside = scale.cwiseProduct(pixels[k].cast<double>() + Eigen::Vector2d(0.5, 0.5));
    const Eigen::Vector2d at = Eigen::Vector2d(box.left, box.top) + inside;
    constexpr double kRadius = 9;
    page.disk(at, kRadius, kWhite.withAlpha(220));
    page.text(at, std::to_string(side.numbers[k] + 1), {13, false, kBlack, Across::centre});
  }
}

void drawSide(Page& page, const Box& box, const Side& side) {
  page.picture(box, paintedSide(side));
  drawNumbers(page, box, side);
}

SegmentLook modelLook(int number) {
  constexpr Colour kPaleGrey = {222, 222, 222};
  if (number < 0) return {kPaleGrey, kUnmatched, Page::kFiner * 0.5};
  const Colour colour = segmentColour(number);
  return {mixed(colour, kWhite, 0.45), mixed(colour, kWhite, 0.2), Page::kFiner * 0.7};
}

SegmentLook queryLook(int number) {
  if (number < 0) return {{}, {110, 110, 110}, Page::kFiner * 0.8};
  return {{}, mixed(segmentColour(number), kBlack, 0.35), Page::kFiner * 2.2};
}

/** Both sets of segments in space, in the frame of the model, from behind and above its camera. */
void drawFit(Page& page, const Box& box, const View& query, const View& model, const Numbering& numbers,
             const Eigen::Isometry3d& T_m_c, const std::optional<CameraMounting>& mounting) {
  constexpr double kCameraSize = 0.25;  // [m]
  SegmentScene scene(page.scene(box));
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  for (std::size_t k = 0; k < model.segments.size(); ++k)
    scene.add(model.segments[k], identity, modelLook(numbers.of_model[k]));
  for (std::size_t k = 0; k < query.segments.size(); ++k)
    scene.add(query.segments[k], T_m_c, queryLook(numbers.of_query[k]));
  scene.addCamera(model.intrinsics, identity, kCameraSize, {105, 105, 105}, Page::kFiner * 1.5);
  scene.addCamera(query.intrinsics, T_m_c, kCameraSize, kBlack, Page::kFiner * 1.5);
  const Eigen::Vector3d up = upInView(model, mounting);
  scene.lookAlong(fromBehindAndAbove(up), up);
}

/** The largest box of a picture's shape in the middle of another box. */
Box fitted(const Box& box, const Intrinsics& camera) {
  const double scale = std::min(box.width / camera.width, box.height / camera.height);
  const double width = scale * camera.width, height = scale * camera.height;
  return {box.left + (box.width - width) / 2, box.top + (box.height - height) / 2, width, height};
}

/** The three panels of a row, below their titles. */
class Row {
public:
  Row(Page& page, double top, double panel_height) : page_(page), top_(top), height_(panel_height) {}

  static double height(double panel_height) { return kCaption + kTitle + panel_height + kMargin; }

  void caption(const std::string& words) { page_.text({kMargin, top_ + kCaption / 2}, words, {20, true}); }
  /** Writes a panel's title. \return where its content belongs. */
  Box panel(int column, const std::string& title) {
    const double left = kMargin + column * (kPanelWidth + kGap);
    page_.text({left, top_ + kCaption + kTitle / 2}, title);
    return {left, top_ + kCaption + kTitle, kPanelWidth, height_};
  }

private:
  Page& page_;
  const double top_;
  const double height_;
};

std::string matchedOf(const std::vector<int>& numbers) {
  const auto matched = std::count_if(numbers.begin(), numbers.end(), [](int n) { return n >= 0; });
  return fmt::format("{} of {} matched", matched, counted(numbers.size(), "segment"));
}

void drawAnswer(Page& page, Row& row, const SeenImage& query, const Map& map, int model,
                const Eigen::Isometry3d& T_m_c) {
  const std::shared_ptr<const View> view = map.view(model);
  const Numbering numbers(query.view, *view, matchedSegments(query.view, *view, T_m_c));
  const Side query_side{query.depth, query.labels, numbers.of_query};
  const Side model_side{depthOf(*view), seenSegments(*view), numbers.of_model};
  const Box left = row.panel(0, fmt::format("query {}: {}", query.name, matchedOf(numbers.of_query)));
  drawSide(page, fitted(left, query.depth.camera), query_side);
  const Box middle =
      row.panel(1, fmt::format("local model {}: {}", map.models[model].name, matchedOf(numbers.of_model)));
  drawSide(page, fitted(middle, model_side.depth.camera), model_side);
  const Box right = row.panel(2, "both aligned: local model filled, query outlined");
  drawFit(page, right, query.view, *view, numbers, T_m_c, map.camera.mounting);
  page.frame(right, {kUnmatched, 1});
}

void drawQueryAlone(Page& page, Row& row, const SeenImage& query) {
  const std::vector<int> numbers(query.view.segments.size(), -1);
  const Box left = row.panel(0, fmt::format("query {}: {}", query.name, counted(numbers.size(), "segment")));
  drawSide(page, fitted(left, query.depth.camera), {query.depth, query.labels, numbers});
}

void drawModel3d(Page& page, const Box& box, const View& view) {
  SegmentScene scene(page.scene(box));
  const std::size_t n = std::min<std::size_t>(view.segments.size(), MatchingParams().max_segments);
  for (std::size_t k = 0; k < n; ++k) {
    const Colour colour = segmentColour(k);
    scene.add(view.segments[k], Eigen::Isometry3d::Identity(),
              {mixed(colour, kWhite, 0.25), mixed(colour, kBlack, 0.3), Page::kFiner * 1.2});
  }
  const Eigen::Vector3d up = upInView(view, {});
  scene.lookAlong(fromBehindAndAbove(up), up);
}

}  // namespace

void drawSegmentation(const std::filesystem::path& path, const SeenImage& image) {
  constexpr double kTitleBelow = 28;  // height of a title below its panel [px]
  const TextStyle centred = {17, false, kBlack, Across::centre};
  checkDrawable(image);
  const double height = kPanelWidth * image.depth.camera.height / image.depth.camera.width;
  Page page(static_cast<int>(2 * kMargin + 2 * kPanelWidth + kGap),
            static_cast<int>(2 * kMargin + 2 * (height + kTitleBelow) + kGap));
  const auto panel = [&](int column, int row, const std::string& title) {
    const Box box = {kMargin + column * (kPanelWidth + kGap), kMargin + row * (height + kTitleBelow + kGap),
                     kPanelWidth, height};
    page.text({box.centre().x(), box.bottom() + kTitleBelow / 2 + 3}, title, centred);
    return box;
  };
  page.picture(panel(0, 0, "(a) " + image.name + ", its surfaces lit from the camera"),
               litDepth(image.depth));
  page.picture(panel(1, 0, "(b) depth image"), greyDepth(image.depth));
  page.picture(panel(0, 1, "(c) " + counted(image.view.segments.size(), "planar surface segment")),
               overlay(image.depth, image.labels));
  const Box box = panel(1, 1, "(d) 3D model of the dominant segments");
  if (image.view.segments.empty())
    page.text(box.centre(), "no segments", centred);
  else
    drawModel3d(page, box, image.view);
  page.frame(box, {{190, 190, 190}, 1});
  writePng(path, page.render());
}

Raster<std::uint8_t> matchesPicture(const SeenImage& query, const Map& map,
                                    const std::vector<DrawnMatch>& answers) {
  checkDrawable(query);
  const double panel_height = kPanelWidth * query.depth.camera.height / query.depth.camera.width;
  const double rows = Row::height(panel_height) * static_cast<double>(answers.size());
  Page page(static_cast<int>(2 * kMargin + 3 * kPanelWidth + 2 * kGap), static_cast<int>(rows));
  double top = 0;
  for (const DrawnMatch& answer : answers) {
    Row row(page, top, panel_height);
    row.caption(answer.caption);
    if (answer.model < 0)
      drawQueryAlone(page, row, query);
    else
      drawAnswer(page, row, query, map, answer.model, answer.T_m_c);
    top += Row::height(panel_height);
  }
  return page.render();
}

Raster<std::uint8_t> contactSheet(const std::vector<Raster<std::uint8_t>>& pictures,
                                  const std::vector<std::string>& titles) {
  constexpr double kWidth = 800, kBetween = 20, kHeading = 28;  // [px]
  constexpr int kColumns = 2;
  double cell = 0;
  for (const auto& picture : pictures)
    cell = std::max(cell, kWidth * picture.height / picture.width + kHeading + kBetween);
  const int n = static_cast<int>(pictures.size()), columns = std::min(n, kColumns);
  const int rows = (n + kColumns - 1) / kColumns;
  Page page(static_cast<int>(columns * (kWidth + kBetween) + kBetween),
            static_cast<int>(rows * cell + kBetween));
  for (int i = 0; i < n; ++i) {
    const double left = kBetween + (i % kColumns) * (kWidth + kBetween),
                 top = kBetween / 2 + (i / kColumns) * cell;
    page.text({left, top + kHeading / 2}, titles[i], {17, true});
    const Box box = {left, top + kHeading, kWidth, kWidth * pictures[i].height / pictures[i].width};
    page.picture(box, pictures[i]);
    page.frame(box, {{190, 190, 190}, 1});
  }
  return page.render();
}

}  // namespace facetloc
