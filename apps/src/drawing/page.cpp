// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/page.h"

#include "drawing/depth_drawing.h"

#include <vtkBrush.h>
#include <vtkContext2D.h>
#include <vtkContextActor.h>
#include <vtkContextItem.h>
#include <vtkContextScene.h>
#include <vtkImageData.h>
#include <vtkObjectFactory.h>
#include <vtkPen.h>
#include <vtkStdString.h>
#include <vtkTextRenderer.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace facetloc {
namespace {

/** x, y, x, y, ... in VTK's pixels, which are finer and counted from below. */
std::vector<float> toDevice(const Page::Points& points, int height) {
  std::vector<float> xy;
  for (const Eigen::Vector2d& p : points) {
    xy.push_back(static_cast<float>(Page::kFiner * p.x()));
    xy.push_back(static_cast<float>(Page::kFiner * (height - p.y())));
  }
  return xy;
}

static_assert(static_cast<int>(Across::left) == VTK_TEXT_LEFT &&
              static_cast<int>(Across::centre) == VTK_TEXT_CENTERED &&
              static_cast<int>(Across::right) == VTK_TEXT_RIGHT);

}  // namespace

void apply(const TextStyle& style, int scale, vtkTextProperty* property) {
  property->SetFontFamilyToArial();
  property->SetFontSize(style.size * scale);
  property->SetBold(style.bold);
  property->SetColor(style.colour.red / 255.0, style.colour.green / 255.0, style.colour.blue / 255.0);
  property->SetJustification(static_cast<int>(style.across));
  property->SetVerticalJustificationToCentered();
}

std::vector<Eigen::Vector2d> unitCircle(int corners) {
  constexpr double kTurn = 2 * 3.14159265358979323846;
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < corners; ++i)
    points.emplace_back(std::cos(kTurn * i / corners), std::sin(kTurn * i / corners));
  return points;
}

double textWidth(const std::string& text, const TextStyle& style) {
  constexpr int kDotsPerInch = 72;  // a point is a pixel
  vtkNew<vtkTextProperty> property;
  apply(style, Page::kFiner, property);
  std::array<int, 4> box = {};
  vtkTextRenderer::GetInstance()->GetBoundingBox(property, vtkStdString(text), box.data(), kDotsPerInch);
  return static_cast<double>(box[1] - box[0] + 1) / Page::kFiner;
}

vtkNew<vtkImageData> toImage(const Raster<std::uint8_t>& rgb) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(rgb.width, rgb.height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const std::size_t row = 3 * static_cast<std::size_t>(rgb.width);
  for (int v = 0; v < rgb.height; ++v)
    std::copy_n(&rgb.data[row * v], row,
                static_cast<std::uint8_t*>(image->GetScalarPointer(0, rgb.height - 1 - v, 0)));
  return image;
}

void setOffscreen(vtkRenderWindow* window, int width, int height) {
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(0);  // the same picture on every machine
  window->SetSize(width, height);
}

Raster<std::uint8_t> grabbed(vtkRenderWindow* window) {
  vtkNew<vtkWindowToImageFilter> filter;
  filter->SetInput(window);
  filter->SetInputBufferTypeToRGB();
  filter->ReadFrontBufferOff();
  filter->ShouldRerenderOff();
  filter->Update();
  vtkImageData* image = filter->GetOutput();
  Raster<std::uint8_t> picture{image->GetDimensions()[0], image->GetDimensions()[1], 3, {}};
  const std::size_t row = 3 * static_cast<std::size_t>(picture.width);
  picture.data.resize(row * picture.height);
  for (int v = 0; v < picture.height; ++v) {  // VTK's first row is the lowest
    const auto* from =
        static_cast<const std::uint8_t*>(image->GetScalarPointer(0, picture.height - 1 - v, 0));
    std::copy(from, from + row, picture.data.begin() + static_cast<std::ptrdiff_t>(row * v));
  }
  return picture;
}

/** All that is drawn in two dimensions, in its order. */
class Page::Item : public vtkContextItem {
public:
  static Item* New() { VTK_STANDARD_NEW_BODY(Item); }
  vtkTypeMacro(Item, vtkContextItem)

      bool Paint(vtkContext2D* painter) override {
    for (const auto& draw : drawings) draw(*painter);
    return true;
  }
  std::vector<std::function<void(vtkContext2D&)>> drawings;
};

Page::Page(int width, int height) : width_(width), height_(height) {
  setOffscreen(window_, kFiner * width, kFiner * height);
  window_->SetNumberOfLayers(2);
  ground_->SetBackground(1, 1, 1);
  window_->AddRenderer(ground_);
  vtkNew<vtkContextActor> actor;
  vtkNew<Item> item;
  actor->GetScene()->AddItem(item);
  actor->GetScene()->SetRenderer(ground_);
  ground_->AddActor(actor);
  item_ = item;
}

Page::~Page() = default;

void Page::line(const Points& points, const Pen& pen) {
  if (points.size() < 2) return;
  item_->drawings.push_back([pen, xy = toDevice(points, height_)](vtkContext2D& painter) mutable {
    painter.GetPen()->SetLineType(vtkPen::SOLID_LINE);
    painter.GetPen()->SetColor(pen.colour.red, pen.colour.green, pen.colour.blue, pen.colour.alpha);
    painter.GetPen()->SetWidth(static_cast<float>(kFiner * pen.width));
    painter.DrawPoly(xy.data(), static_cast<int>(xy.size() / 2));
  });
}

void Page::polygon(const Points& convex, const Colour& fill) {
  item_->drawings.push_back([fill, xy = toDevice(convex, height_)](vtkContext2D& painter) mutable {
    painter.GetPen()->SetLineType(vtkPen::NO_PEN);
    painter.GetBrush()->SetColor(fill.red, fill.green, fill.blue, fill.alpha);
    painter.DrawPolygon(xy.data(), static_cast<int>(xy.size() / 2));
  });
}

void Page::disk(const Eigen::Vector2d& centre, double radius, const Colour& fill) {
  Points points = unitCircle(32);
  for (Eigen::Vector2d& p : points) p = centre + radius * p;
  polygon(points, fill);
}

void Page::text(const Eigen::Vector2d& at, const std::string& words, const TextStyle& style) {
  item_->drawings.push_back([=, xy = toDevice({at}, height_)](vtkContext2D& painter) {
    apply(style, kFiner, painter.GetTextProp());
    painter.DrawString(xy[0], xy[1], words.c_str());
  });
}

void Page::picture(const Box& box, const Raster<std::uint8_t>& rgb) {
  const int width = static_cast<int>(std::lround(kFiner * box.width));
  const int height = static_cast<int>(std::lround(kFiner * box.height));
  const std::vector<float> xy = toDevice({{box.left, box.bottom()}}, height_);
  item_->drawings.push_back([xy, enlarged = resized(rgb, width, height)](vtkContext2D& painter) {
    painter.DrawImage(std::round(xy[0]), std::round(xy[1]), toImage(enlarged));
  });
}

void Page::frame(const Box& box, const Pen& pen) {
  const Eigen::Vector2d first(box.left, box.top), third(box.right(), box.bottom());
  line({first, {third.x(), first.y()}, third, {first.x(), third.y()}, first}, pen);
}

vtkRenderer* Page::scene(const Box& box) {
  vtkNew<vtkRenderer> renderer;
  renderer->SetLayer(1);
  renderer->SetViewport(box.left / width_, 1 - box.bottom() / height_, box.right() / width_,
                        1 - box.top / height_);
  window_->AddRenderer(renderer);
  return renderer;
}

Raster<std::uint8_t> Page::render() {
  window_->Render();
  return averaged(grabbed(window_), kFiner);
}

}  // namespace facetloc
