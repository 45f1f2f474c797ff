// SPDX-License-Identifier: BSD-3-Clause
#include "cli/text.h"
#include "drawing/depth_drawing.h"
#include "drawing/page.h"
#include "drawing/pictures.h"
#include "drawing/plan_view.h"
#include "drawing/segment_scene.h"

#include <facetloc/registration/registration_params.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>

namespace facetloc {

namespace {

constexpr double kPanelWidth = 480;  // [px]
constexpr double kMargin = 16, kGap = 12, kTitle = 28;

const TextStyle kCentred = {17, false, kBlack, Across::centre};

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
  checkDrawable(image);
  const double height = kPanelWidth * image.depth.camera.height / image.depth.camera.width;
  Page page(static_cast<int>(2 * kMargin + 2 * kPanelWidth + kGap),
            static_cast<int>(2 * kMargin + 2 * (height + kTitle) + kGap));
  const auto panel = [&](int column, int row, const std::string& title) {
    const Box box = {kMargin + column * (kPanelWidth + kGap), kMargin + row * (height + kTitle + kGap),
                     kPanelWidth, height};
    page.text({box.centre().x(), box.bottom() + kTitle / 2 + 3}, title, kCentred);
    return box;
  };
  page.picture(panel(0, 0, "(a) " + image.name + ", its surfaces lit from the camera"),
               litDepth(image.depth));
  page.picture(panel(1, 0, "(b) depth image"), greyDepth(image.depth));
  page.picture(panel(0, 1, "(c) " + counted(image.view.segments.size(), "planar surface segment")),
               overlay(image.depth, image.labels));
  const Box box = panel(1, 1, "(d) 3D model of the dominant segments");
  if (image.view.segments.empty())
    page.text(box.centre(), "no segments", kCentred);
  else
    drawModel3d(page, box, image.view);
  page.frame(box, {{190, 190, 190}, 1});
  writePng(path, page.render());
}

}  // namespace facetloc
