// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/depth_drawing.h"
#include "drawing/page.h"
#include "drawing/vtk_picture.h"

#include <vtkActor2D.h>
#include <vtkImageData.h>
#include <vtkImageMapper.h>
#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <cmath>
#include <string>

namespace facetloc {

/** \brief A text of one line that is set anew for each picture. */
class Label {
public:
  Label(vtkRenderer* renderer, int size, const Colour& colour, bool bold = false)
      : style_{size, bold, colour} {
    vtkTextProperty* property = actor_->GetTextProperty();
    property->SetFontFamilyToArial();
    property->SetFontSize(size);
    property->SetBold(bold);
    setColour(colour);
    property->SetVerticalJustificationToCentered();
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

/** \brief A picture, pixel by pixel. */
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

}  // namespace facetloc
