// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_picture.h"

#include "base/text.h"
#include "drawing/depth_drawing.h"
#include "drawing/page.h"
#include "drawing/vtk_picture.h"
#include "live/live_cloud.h"
#include "live/live_plan.h"
#include "shared/text.h"

#include <vtkActor2D.h>
#include <vtkCamera.h>
#include <vtkImageData.h>
#include <vtkImageMapper.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace facetloc {
namespace {

constexpr int kWidth = 1280, kHeight = 720;                                    // of a screenshot [px]
constexpr double kHeader = 78, kMargin = 10, kCaption = 24, kFooterLine = 22;  // heights [px]
constexpr double kLeftShare = 0.56, kWholeShare = 0.56;  // of the cloud; of the whole map in its column
constexpr Colour kFrame = {190, 190, 190}, kPale = {95, 95, 95};

/** A text of one line that is set anew for each picture. */
class Label {
public:
  Label(vtkRenderer* renderer, int size, const Colour& colour, bool bold = false)
      : style_{size, bold, colour} {
    vtkTextProperty* property = actor_->GetTextProperty();
    property->SetFontFamilyToArial();
    property->SetFontSize(size);
    property->SetBold(bold);
    property->SetColor(colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0);
    property->SetVerticalJustificationToCentered();
    renderer->AddActor2D(actor_);
  }

  /** \param at middle of the left (or right) edge, from the top left corner of a window [px]; what is wider
   * than the room for it is cut. */
  void show(const std::string& words, const Eigen::Vector2d& at, double room, double window_height,
            Across across = Across::left) {
    actor_->GetTextProperty()->SetJustification(static_cast<int>(across));
    actor_->SetInput(fitting(words, room).c_str());
    actor_->SetPosition(std::round(at.x()), std::round(window_height - at.y()));
    actor_->SetVisibility(!words.empty());
  }
  void hide() { actor_->VisibilityOff(); }

private:
  std::string fitting(std::string words, double room) const {
    if (words.empty() || textWidth(words, style_) <= room) return words;
    while (!words.empty() && textWidth(words + "...", style_) > room) words.pop_back();
    while (!words.empty() && (words.back() & 0xC0) == 0x80) words.pop_back();  // no half characters
    return words + "...";
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
    const int width = static_cast<int>(box.width), height = static_cast<int>(box.height);
    const Raster<std::uint8_t> picture = resized(rgb, width, height);
    vtkNew<vtkImageData> image;
    image->SetDimensions(width, height, 1);
    image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
    const std::size_t row = 3 * static_cast<std::size_t>(width);
    for (int v = 0; v < height; ++v)
      std::copy_n(&picture.data[row * v], row,
                  static_cast<std::uint8_t*>(image->GetScalarPointer(0, height - 1 - v, 0)));
    mapper_->SetInputData(image);
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
  return {box.left, box.top, std::floor(scale * camera.width), std::floor(scale * camera.height)};
}

/** Where everything is in a window of a given size [px]. */
struct Layout {
  Box cloud, whole, near, image;  // without their captions, which are above
  double footer_top;

  Layout(double width, double height, std::size_t footer_lines, bool with_plan) {
    footer_top = height - kFooterLine * static_cast<double>(footer_lines);
    const double top = kHeader + kCaption, bottom = footer_top - kMargin, room = bottom - top - kCaption;
    const double upper = std::floor(with_plan ? kWholeShare * room : (room - kMargin) / 2);
    const double column = std::round(with_plan ? kLeftShare * width : width - kMargin - upper * 4 / 3);
    const double column_width = width - kMargin - column;
    cloud = {kMargin, top, column - 2 * kMargin, bottom - top};
    whole = {column, top, column_width, upper};
    const double lower = whole.bottom() + kMargin + kCaption;
    near = {column, lower, with_plan ? std::round(0.43 * column_width) : 0, bottom - lower};
    const double left = with_plan ? near.right() + kMargin : column;
    image = {left, lower, width - kMargin - left, bottom - lower};
  }
};

/** "x 1.20  y -3.41  z 0.98 m". */
std::string positionText(const Eigen::Vector3d& p) {
  return fmt::format("x {}   y {}   z {} m", text::decimals(p.x(), 2), text::decimals(p.y(), 2),
                     text::decimals(p.z(), 2));
}

std::string seenText(const SeenImage& image) {
  const auto& labels = image.labels.label;
  const auto labelled = labels.size() - std::count(labels.begin(), labels.end(), 0);
  const auto measured = std::count_if(image.depth.depth.begin(), image.depth.depth.end(), isMeasured);
  return fmt::format("{} on {:.0f} % of the measured pixels",
                     counted(image.view.segments.size(), "planar segment"),
                     measured ? 100.0 * labelled / measured : 0.0);
}

/** "± 12 mm, 0.30°": the largest standard deviations over directions. */
std::string accuracyText(const Matrix6d& P) {
  return fmt::format("± {:.0f} mm, {:.2f}°", 1000 * largestTranslationStd(P),
                     largestRotationStd(P) / kDegree);
}

/** What a position in a part of the map begins with; nothing in the world. */
std::string partText(const Map& map, int part) {
  const auto i = static_cast<std::size_t>(part);
  return i < map.parts.size() && !map.parts[i].empty() ? fmt::format("in part {}:  ", map.parts[i]) : "";
}

std::string poseText(const LiveResult& result, const Map* map, const LivePlan* plan, std::size_t matched) {
  if (!map) return seenText(result.image);
  const Hypothesis* match = result.match();
  const PoseWithCovariance* pose = result.pose();
  if (!pose && !match) return "no pose; " + seenText(result.image);
  const std::string model = match ? map->models.at(match->model).name : "";
  std::string words =
      pose ? partText(*map, result.part()) + positionText(pose->T.translation())
           : fmt::format("in local model {}:  {}", model, positionText(match->T_m_c.T.translation()));
  if (pose && plan) words += fmt::format("   heading {}°", text::decimals(plan->heading(pose->T), 1));
  words += "   " + accuracyText(pose ? pose->P : match->T_m_c.P);
  if (match)
    words += fmt::format("   {} of {} in local model {}", matched,
                         counted(result.image.view.segments.size(), "segment"), model);
  return words;
}

}  // namespace

class LivePicture::Scene {
public:
  Scene(vtkRenderWindow* window, std::shared_ptr<const Map> map);
  void show(const LiveResult& result, const std::vector<std::string>& footer);

private:
  void place(vtkRenderer* renderer, const Box& box);
  void caption(Label& label, const std::string& words, const Box& box);
  void showHeader(const LiveResult& result, std::size_t matched);
  void showPlan(const LiveResult& result, const Layout& layout);
  void setMap(std::shared_ptr<const Map> map);
  void showImage(const LiveResult& result, const Layout& layout);
  void addFrame(const Box& box, double inset = 0);
  Eigen::Vector3d onGround(double x, double y) const { return {x, height_ - y, 0}; }

  vtkRenderWindow* window_;
  std::shared_ptr<const Map> map_;
  double width_ = 0, height_ = 0;  // [px]
  vtkNew<vtkRenderer> ground_;     // in pixels, y up
  LiveCloud cloud_;
  std::unique_ptr<LivePlan> plan_;  // if there is a map with poses
  Shapes decoration_{1};
  Label state_, reason_, pose_, frame_, cloud_caption_, whole_caption_, near_caption_, image_caption_;
  Still image_, depth_;
  std::vector<std::unique_ptr<Label>> footer_;
};

LivePicture::Scene::Scene(vtkRenderWindow* window, std::shared_ptr<const Map> map)
    : window_(window),
      state_(ground_, 22, kWhite, true),
      reason_(ground_, 17, kBlack),
      pose_(ground_, 17, kBlack),
      frame_(ground_, 15, kPale),
      cloud_caption_(ground_, 15, kPale),
      whole_caption_(ground_, 15, kPale),
      near_caption_(ground_, 15, kPale),
      image_caption_(ground_, 15, kPale),
      image_(ground_),
      depth_(ground_) {
  window_->SetNumberOfLayers(2);
  ground_->SetBackground(1, 1, 1);
  ground_->AddActor(decoration_.actor());
  window_->AddRenderer(ground_);
  window_->AddRenderer(cloud_.ground());
  window_->AddRenderer(cloud_.overlay());
  setMap(std::move(map));
}

void LivePicture::Scene::setMap(std::shared_ptr<const Map> map) {
  map_ = std::move(map);
  if (plan_) {
    window_->RemoveRenderer(plan_->whole());
    window_->RemoveRenderer(plan_->near());
  }
  plan_.reset();
  if (!map_) return;
  plan_ = std::make_unique<LivePlan>(map_);
  if (plan_->empty()) {
    plan_.reset();
    return;
  }
  window_->AddRenderer(plan_->whole());
  window_->AddRenderer(plan_->near());
}

void LivePicture::Scene::place(vtkRenderer* renderer, const Box& box) {
  renderer->SetViewport(box.left / width_, 1 - box.bottom() / height_, box.right() / width_,
                        1 - box.top / height_);
}

void LivePicture::Scene::addFrame(const Box& box, double inset) {
  const double l = box.left - 1 + inset, r = box.right() + 1 - inset, t = box.top - 1 + inset,
               b = box.bottom() + 1 - inset;
  decoration_.line({onGround(l, t), onGround(r, t), onGround(r, b), onGround(l, b)}, kFrame, true);
}

void LivePicture::Scene::caption(Label& label, const std::string& words, const Box& box) {
  label.show(words, {box.left, box.top - kCaption / 2 - 1}, box.width, height_);
}

/** The state as a badge, why it is so, and the pose. */
void LivePicture::Scene::showHeader(const LiveResult& result, std::size_t matched) {
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
  pose_.show(poseText(result, map_.get(), plan_.get(), matched), {kMargin, 60}, width_ - 2 * kMargin,
             height_);
}

void LivePicture::Scene::showPlan(const LiveResult& result, const Layout& layout) {
  plan_->show(result, {layout.whole.width, layout.whole.height}, {layout.near.width, layout.near.height});
  place(plan_->whole(), layout.whole);
  place(plan_->near(), layout.near);
  addFrame(layout.whole), addFrame(layout.near);
  caption(whole_caption_, "map from above: " + counted(map_->models.size(), "local model"), layout.whole);
  const double factor = plan_->magnification();
  const std::string enlarged = factor > 1 ? fmt::format(", × {:.9g}", factor) : "";
  const std::string ellipse = "; ellipse: 2 std" + enlarged;
  caption(near_caption_, "from near" + (result.pose() ? ellipse : ""), layout.near);
}

void LivePicture::Scene::showImage(const LiveResult& result, const Layout& layout) {
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

void LivePicture::Scene::show(const LiveResult& result, const std::vector<std::string>& footer) {
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
  const LiveColours colours(result, map_.get());
  showHeader(result, colours.matched);
  place(cloud_.ground(), layout.cloud);
  place(cloud_.overlay(), layout.cloud);
  cloud_.show(result, colours, map_.get());
  addFrame(layout.cloud);
  caption(cloud_caption_,
          "cloud by segment; axes: x, y, normal; ellipses: 2 std of the normals, × 10" +
              std::string(result.match() ? "; thick: local model" : ""),
          layout.cloud);
  if (plan_) showPlan(result, layout);
  showImage(result, layout);
  decoration_.show();
  for (std::size_t i = 0; i < std::max(footer.size(), footer_.size()); ++i) {
    if (i == footer_.size()) footer_.push_back(std::make_unique<Label>(ground_, 15, kPale));
    if (i < footer.size())
      footer_[i]->show(footer[i], {kMargin, layout.footer_top + (static_cast<double>(i) + 0.4) * kFooterLine},
                       width_ - 2 * kMargin, height_);
    else
      footer_[i]->hide();
  }
  window_->Render();
}

LivePicture::LivePicture(vtkRenderWindow* window, std::shared_ptr<const Map> map)
    : scene_(std::make_unique<Scene>(window, std::move(map))) {}

LivePicture::~LivePicture() = default;

void LivePicture::show(const LiveResult& result, const std::vector<std::string>& footer) {
  scene_->show(result, footer);
}

struct LiveScreenshot::Window {
  explicit Window(std::shared_ptr<const Map> map) : picture(window, std::move(map)) {
    setOffscreen(window, kWidth, kHeight);
    window->Render();  // takes its time, which would be missing when frames come
  }
  vtkNew<vtkRenderWindow> window;
  LivePicture picture;
};

LiveScreenshot::LiveScreenshot(std::shared_ptr<const Map> map)
    : window_(std::make_unique<Window>(std::move(map))) {}

LiveScreenshot::~LiveScreenshot() = default;

Raster<std::uint8_t> LiveScreenshot::draw(const LiveResult& result) {
  window_->picture.show(result);
  return grabbed(window_->window);
}

}  // namespace facetloc
