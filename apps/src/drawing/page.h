// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/colours.h"

#include <facetloc/io/png.h>

#include <Eigen/Core>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTextProperty.h>

#include <string>
#include <vector>

class vtkImageData;

namespace facetloc {

/** \brief A rectangle of a page, from its top left corner [px]. */
struct Box {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;

  double right() const { return left + width; }
  double bottom() const { return top + height; }
  Eigen::Vector2d centre() const { return {left + width / 2, top + height / 2}; }
};

struct Pen {
  Colour colour;
  double width = 1;  ///< [px]
};

enum class Across { left, centre, right };
struct TextStyle {
  int size = 17;  ///< [px]
  bool bold = false;
  Colour colour = kBlack;
  Across across = Across::left;
};

/** \brief The corners of a regular polygon about the origin, of radius 1. */
std::vector<Eigen::Vector2d> unitCircle(int corners);

/** \brief Sets up texts of VTK, their height centred. */
void apply(const TextStyle& style, int scale, vtkTextProperty* property);

/** \brief Width of a text [px]. */
double textWidth(const std::string& text, const TextStyle& style);

/** \brief A picture, RGB, as VTK has it: its first row is the lowest. */
vtkNew<vtkImageData> toImage(const Raster<std::uint8_t>& rgb);

/** \brief Makes a window invisible, and its rendering the same everywhere. [px] */
void setOffscreen(vtkRenderWindow* window, int width, int height);
/** \brief The content of a window that is rendered, RGB. */
Raster<std::uint8_t> grabbed(vtkRenderWindow* window);

/** \brief A white page of lines, text, pictures and 3D scenes, x to the right and y down [px].
 *
 * Later items cover earlier ones; 3D scenes cover all else. Everything is rendered three
 * times as large and averaged: smooth edges without the help of the graphics driver. Needs a display. */
class Page {
public:
  Page(int width, int height);
  ~Page();

  using Points = std::vector<Eigen::Vector2d>;
  void line(const Points& points, const Pen& pen);
  void polygon(const Points& convex, const Colour& fill);
  void disk(const Eigen::Vector2d& centre, double radius, const Colour& fill);
  /** \brief Text whose height is centred at a place; it begins, is centred or ends there. */
  void text(const Eigen::Vector2d& at, const std::string& words, const TextStyle& style = {});
  void picture(const Box& box, const Raster<std::uint8_t>& rgb);
  void frame(const Box& box, const Pen& pen);
  /** \brief A 3D scene on a white ground; widths of its lines are to be given times kFiner. */
  vtkRenderer* scene(const Box& box);

  Raster<std::uint8_t> render();

  static constexpr int kFiner = 3;

private:
  class Item;

  const int width_;
  const int height_;
  vtkNew<vtkRenderWindow> window_;
  vtkNew<vtkRenderer> ground_;
  Item* item_;  // owned by the scene of ground_
};

}  // namespace facetloc
