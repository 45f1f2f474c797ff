// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_picture.h"

#include "base/text.h"
#include "cli/text.h"
#include "drawing/depth_drawing.h"
#include "drawing/page.h"
#include "live/live_cloud.h"
#include "live/live_plan.h"
#include "live/live_status.h"

#include <vtkActor2D.h>
#include <vtkCamera.h>
#include <vtkImageData.h>
#include <vtkImageMapper.h>
#include <vtkTextActor.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace facetloc {
namespace {

constexpr int kWidth = 1280, kHeight = 720;                                    // size of a screenshot [px]
constexpr double kHeader = 78, kMargin = 10, kCaption = 24, kFooterLine = 22;  // heights [px]
constexpr double kLeftShare = 0.56, kWholeShare = 0.56;  // width of the cloud, height of the whole map
constexpr Colour kFrame = {190, 190, 190}, kPale = {95, 95, 95}, kUntold = {140, 140, 140};

/** A text of one line that is set anew for each picture. */
class Label {
public:
  Label(vtkRenderer* renderer, int size, const Colour& colour, bool bold = false)
      : style_{size, bold, colour} {
    apply(style_, 1, actor_->GetTextProperty());
    renderer->AddActor2D(actor_);
  }

  /** \param at middle of the left (or right) edge, from the top left corner of a window [px]; text wider
   * than the room for it is cut. */
  void show(const std::string& words, const Eigen::Vector2d& at, double room, double window_height,
            Across across = Across::left) {
    actor_->GetTextProperty()->SetJustification(static_cast<int>(across));
    const std::string shown = fitting(words, room);
    actor_->SetInput(shown.c_str());
    actor_->SetPosition(std::round(at.x()), std::round(window_height - at.y()));
    actor_->SetVisibility(!shown.empty());
  }
  void hide() { actor_->VisibilityOff(); }
  void setColour(const Colour& colour) {
    actor_->GetTextProperty()->SetColor(colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0);
  }

private:
  /** As much of a text as there is room for; none if that is not even for dots. */
  std::string fitting(std::string words, double room) const {
    if (words.empty() || textWidth(words, style_) <= room) return words;
    while (!words.empty()) {
      dropLast(words);
      if (textWidth(words + "...", style_) <= room) return words + "...";
    }
    return words;
  }
  /** A character of UTF-8, all of its bytes. */
  static void dropLast(std::string& words) {
    bool continued = true;
    while (!words.empty() && continued) {
      continued = (words.back() & 0xC0) == 0x80;
      words.pop_back();
    }
  }

  TextStyle style_;
  vtkNew<vtkTextActor> actor_;
};

/** A picture, pixel by pixel. */
class Still {
public:
  explicit Still(vtkRenderer* renderer) {
    mapper_->SetColorWindow(255);
    mapper_->SetColorLevel(127.5);
    actor_->SetMapper(mapper_);
    actor_->VisibilityOff();  // there is nothing to see yet
    renderer->AddActor2D(actor_);
  }
  void show(const Raster<std::uint8_t>& rgb, const Box& box, double window_height) {
    mapper_->SetInputData(toImage(resized(rgb, static_cast<int>(box.width), static_cast<int>(box.height))));
    actor_->SetPosition(std::round(box.left), std::round(window_height - box.bottom()));
    actor_->VisibilityOn();
  }
  void hide() { actor_->VisibilityOff(); }

private:
  vtkNew<vtkImageMapper> mapper_;
  vtkNew<vtkActor2D> actor_;
};

/** The largest box of a picture's shape at the top of another box. */
Box fitted(const Box& box, const Intrinsics& camera) {
  const double scale = std::min(box.width / camera.width, box.height / camera.height);
  return {box.left, box.top, std::max(1.0, std::floor(scale * camera.width)),
          std::max(1.0, std::floor(scale * camera.height))};
}

/** Where everything is in a window of a given size [px]. In a small one the map from near gives its place to
 * the others, and in a narrow one the cloud is above the rest. */
struct Layout {
  Box cloud, whole, near, image;  // without their captions, which are above
  double footer_top;

  Layout(double width, double height, std::size_t footer_lines, bool with_plan) {
    constexpr double kSmall = 900, kNarrow = 620;  // widths [px]
    footer_top = height - kFooterLine * static_cast<double>(footer_lines);
    const double top = kHeader + kCaption, bottom = std::max(top + 1, footer_top - kMargin);
    if (width < kNarrow) {
      stack(width, top, bottom);
      return;
    }
    const double room = bottom - top - kCaption;
    const double upper = std::floor(with_plan ? kWholeShare * room : (room - kMargin) / 2);
    const double column = std::round(with_plan ? kLeftShare * width : width - kMargin - upper * 4 / 3);
    const double column_width = width - kMargin - column;
    cloud = {kMargin, top, column - 2 * kMargin, bottom - top};
    whole = {column, top, column_width, upper};
    const double lower = whole.bottom() + kMargin + kCaption;
    near = {column, lower, with_plan && width >= kSmall ? std::round(0.43 * column_width) : 0,
            bottom - lower};
    const double left = near.width > 0 ? near.right() + kMargin : column;
    image = {left, lower, width - kMargin - left, bottom - lower};
  }

private:
  void stack(double width, double top, double bottom) {
    const double inside = width - 2 * kMargin, middle = std::round(top + 0.55 * (bottom - top));
    cloud = {kMargin, top, inside, std::max(1.0, middle - top)};
    const double lower = middle + kMargin + kCaption, half = std::round((inside - kMargin) / 2);
    whole = {kMargin, lower, half, std::max(1.0, bottom - lower)};
    image = {whole.right() + kMargin, lower, half, whole.height};
  }
};

}  // namespace

class LivePicture::Scene {
public:
  Scene(vtkRenderWindow* window, std::shared_ptr<const Map> map) : window_(window) {
    window_->SetNumberOfLayers(2);
    ground_->SetBackground(1, 1, 1);
    ground_->AddActor(decoration_.actor());
    window_->AddRenderer(ground_);
    window_->AddRenderer(cloud_.ground());
    window_->AddRenderer(cloud_.overlay());
    setMap(std::move(map));
  }

  void choose(const Eigen::Vector2d& at) {
    const auto panel = looks_.panelAt(at);
    chosen_point_.reset();
    if (!panel) return chosen_model_.reset();
    const Box& box = looks_.box(*panel);
    if (*panel == LiveLooks::Panel::cloud)
      chosen_point_ = {(at.x() - box.left) / box.width, (at.y() - box.top) / box.height};
    else if (plan_)
      chosen_model_ = plan_->modelAt(*panel, {at.x(), height_ - at.y()});
  }

  void show(const LiveResult& result, const std::vector<std::string>& footer) {
    if (result.mapped && result.mapped->map != map_) setMap(result.mapped->map);
    const int* size = window_->GetSize();
    width_ = size[0], height_ = size[1];
    vtkCamera* camera = ground_->GetActiveCamera();
    camera->ParallelProjectionOn();
    camera->SetParallelScale(height_ / 2);
    camera->SetPosition(width_ / 2, height_ / 2, 1);
    camera->SetFocalPoint(width_ / 2, height_ / 2, 0);
    camera->SetClippingRange(0.1, 10);

    const Layout layout(width_, height_, footer.size(), plan_ != nullptr);
    looks_.setBoxes(layout.cloud, plan_ ? layout.whole : Box(), plan_ ? layout.near : Box());
    const LiveColours colours(result, map_.get());
    showHeader(result, colours.matched);
    showCloud(result, colours, layout);
    if (plan_) showPlan(result, layout);
    showImage(result, layout);
    decoration_.show();
    showFooter(footer, layout.footer_top);
    window_->Render();
  }

  LiveLooks& looks() { return looks_; }

private:
  void setMap(std::shared_ptr<const Map> map) {
    map_ = std::move(map);
    if (plan_) {
      window_->RemoveRenderer(plan_->whole());
      window_->RemoveRenderer(plan_->near());
    }
    plan_.reset();
    chosen_model_.reset();
    if (!map_) return;
    plan_ = std::make_unique<LivePlan>(map_);
    if (plan_->empty()) {
      plan_.reset();
      return;
    }
    window_->AddRenderer(plan_->whole());
    window_->AddRenderer(plan_->near());
  }

  void place(vtkRenderer* renderer, const Box& box) {
    renderer->SetViewport(box.left / width_, 1 - box.bottom() / height_, box.right() / width_,
                          1 - box.top / height_);
  }

  void addFrame(const Box& box) {
    const double l = box.left - 1, r = box.right() + 1, t = box.top - 1, b = box.bottom() + 1;
    decoration_.line({onGround(l, t), onGround(r, t), onGround(r, b), onGround(l, b)}, kFrame, true);
  }

  void caption(Label& label, const std::string& words, const Box& box) {
    label.show(words, {box.left, box.top - kCaption / 2 - 1}, box.width, height_);
  }

  /** The state as a badge, why it is so, and the pose. */
  void showHeader(const LiveResult& result, std::size_t matched) {
    const std::string state = result.state();
    const double badge = textWidth(state, {22, true}) + 28, top = 8, bottom = 42;
    decoration_.polygon({onGround(kMargin, top), onGround(kMargin + badge, top),
                         onGround(kMargin + badge, bottom), onGround(kMargin, bottom)},
                        stateColour(result));
    const double line = (top + bottom) / 2;
    state_.show(state, {kMargin + 14, line}, badge, height_);
    const std::string number = "frame " + result.image.name;
    const double number_width = textWidth(number, {15, false}) + kMargin;
    frame_.show(number, {width_ - kMargin, line}, width_, height_, Across::right);
    const double left = kMargin + badge + 14;
    reason_.show(result.remark(), {left, line}, width_ - left - number_width - kMargin, height_);
    pose_.setColour(result.pose() && !result.isLocalized() ? kUntold : kBlack);
    const auto heading =
        plan_ && result.pose() ? std::optional(plan_->heading(result.pose()->T)) : std::nullopt;
    pose_.show(poseText(result, map_.get(), heading, matched), {kMargin, 60}, width_ - 2 * kMargin, height_);
  }

  void showPlan(const LiveResult& result, const Layout& layout) {
    using Panel = LiveLooks::Panel;
    place(plan_->whole(), layout.whole);
    place(plan_->near(), layout.near);
    plan_->near()->SetDraw(layout.near.width > 0);
    plan_->show(result, {{layout.whole.width, layout.whole.height},
                         {layout.near.width, layout.near.height},
                         looks_[Panel::whole],
                         looks_[Panel::near],
                         chosen_model_});
    addFrame(layout.whole);
    caption(whole_caption_,
            chosen_model_ ? modelText(*map_, *chosen_model_)
                          : "map from above: " + counted(map_->models.size(), "local model"),
            layout.whole);
    if (layout.near.width <= 0) return near_caption_.hide();
    addFrame(layout.near);
    caption(near_caption_,
            fmt::format("grid of {:.9g} m{}", plan_->nearGrid(), result.pose() ? "; ellipse: 2 std" : ""),
            layout.near);
  }

  /** A click is where it is: the segment that is there now. */
  std::optional<Eigen::Vector2d> chosenPixel() const {
    if (!chosen_point_) return {};
    const Box& box = looks_.box(LiveLooks::Panel::cloud);
    return Eigen::Vector2d(box.left + chosen_point_->x() * box.width,
                           height_ - box.top - chosen_point_->y() * box.height);
  }

  void showCloud(const LiveResult& result, const LiveColours& colours, const Layout& layout) {
    place(cloud_.ground(), layout.cloud);
    place(cloud_.overlay(), layout.cloud);
    const auto chosen =
        cloud_.show(result, colours, map_.get(), looks_[LiveLooks::Panel::cloud], chosenPixel());
    addFrame(layout.cloud);
    caption(cloud_caption_,
            chosen ? segmentText(result.image.view, *chosen)
                   : fmt::format(
                         "cloud by segment; axes: x, y, normal; ellipses: 2 std of the normals, × {:.9g}{}",
                         cloud_.magnification(), result.match() ? "; thick: local model" : ""),
            layout.cloud);
  }

  void showFooter(const std::vector<std::string>& footer, double top) {
    for (std::size_t i = 0; i < std::max(footer.size(), footer_.size()); ++i) {
      if (i == footer_.size()) footer_.push_back(std::make_unique<Label>(ground_, 15, kPale));
      if (i < footer.size())
        footer_[i]->show(footer[i], {kMargin, top + (static_cast<double>(i) + 0.4) * kFooterLine},
                         width_ - 2 * kMargin, height_);
      else
        footer_[i]->hide();
    }
  }

  void showImage(const LiveResult& result, const Layout& layout) {
    const SeenImage& image = result.image;
    if (!image.depth.valid()) {
      image_.hide(), depth_.hide();
      return;
    }
    const Box box = fitted(layout.image, image.depth.camera);
    image_.show(overlay(image.depth, image.labels), box, height_);
    caption(image_caption_, counted(image.view.segments.size(), "segment") + " in the depth image", box);
    if (plan_) return;
    const Box upper = fitted(layout.whole, image.depth.camera);
    depth_.show(greyDepth(image.depth), upper, height_);
    caption(whole_caption_, "depth image, darker = closer", upper);
  }

  Eigen::Vector3d onGround(double x, double y) const { return {x, height_ - y, 0}; }

  vtkRenderWindow* window_;
  std::shared_ptr<const Map> map_;
  double width_ = 0, height_ = 0;  // [px]
  vtkNew<vtkRenderer> ground_;     // coordinates in pixels, y up
  LiveCloud cloud_;
  std::unique_ptr<LivePlan> plan_;  // if there is a map with poses
  LiveLooks looks_;
  std::optional<Eigen::Vector2d> chosen_point_;  // place in the cloud's panel, as shares of its size
  std::optional<int> chosen_model_;
  Shapes decoration_{1};
  Label state_{ground_, 22, kWhite, true}, reason_{ground_, 17, kBlack}, pose_{ground_, 17, kBlack},
      frame_{ground_, 15, kPale}, cloud_caption_{ground_, 15, kPale}, whole_caption_{ground_, 15, kPale},
      near_caption_{ground_, 15, kPale}, image_caption_{ground_, 15, kPale};
  Still image_{ground_}, depth_{ground_};
  std::vector<std::unique_ptr<Label>> footer_;
};

LivePicture::LivePicture(vtkRenderWindow* window, std::shared_ptr<const Map> map)
    : scene_(std::make_unique<Scene>(window, std::move(map))) {}

LivePicture::~LivePicture() = default;

void LivePicture::show(const LiveResult& result, const std::vector<std::string>& footer) {
  scene_->show(result, footer);
}

LiveLooks& LivePicture::looks() { return scene_->looks(); }

void LivePicture::choose(const Eigen::Vector2d& at) { scene_->choose(at); }

LiveScreenshot::LiveScreenshot(std::shared_ptr<const Map> map) : picture_(window_, std::move(map)) {
  setOffscreen(window_, kWidth, kHeight);
  window_->Render();  // takes its time, which would be missing when frames come
}

Raster<std::uint8_t> LiveScreenshot::draw(const LiveResult& result) {
  picture_.show(result);
  return grabbed(window_);
}

}  // namespace facetloc
