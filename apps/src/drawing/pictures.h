// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/colours.h"
#include "drawing/plan_view.h"

#include <facetloc/features/depth_image.h>
#include <facetloc/features/local_model.h>
#include <facetloc/features/occupancy_grid.h>
#include <facetloc/io/png.h>
#include <facetloc/registration/hypothesis.h>
#include <facetloc/segmentation/view_builder.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief A depth image and its segments. */
struct SeenImage {
  std::string name;
  DepthImage depth;   ///< at the working size
  LabelImage labels;  ///< k = segment k - 1 of the view
  View view;
};

/** \brief Segments an image of the working size. */
inline SeenImage see(const std::string& name, DepthImage depth, ViewBuilder& builder,
                     const std::optional<Gravity>& gravity = {}) {
  SeenImage image{name, std::move(depth), {}, {}};
  image.view = builder.build(image.depth, gravity);
  image.labels = builder.segmentation().labels;
  return image;
}

// Pictures of results, PNG, written atomically; all need an X display (OffscreenDisplay). They
// throw IoError for a file that cannot be written, std::invalid_argument for an image without pixels or with
// labels of another size. The same input gives the same picture.

/** \brief A view that has segments alone, as its camera would see them: the depth of their planes. */
SeenImage seeSegments(const std::string& name, View view);

/** \brief The paper's Fig. 1, in (a) without colour: the surfaces as a lamp at the camera lights them, the
 * depth image, the same with its segments outlined in green, and a 3D model of the dominant segments. */
void drawSegmentation(const std::filesystem::path& path, const SeenImage& image);

/** \brief A run through a floor map. */
struct DrawnRun {
  std::string name;
  std::vector<Eigen::Isometry3d> T_w_c;
  Colour colour = kCurveColours[0];
};
/** \brief Poses that are marked in a floor map, such as failures. */
struct DrawnMarks {
  std::string name;
  std::vector<Eigen::Isometry3d> T_w_c;
  Colour colour = kRed;
};
/** \brief The paper's Fig. 4: the segments of all local models in plan view (upright ones as lines, level
 * ones not), the local models with their headings, their links, runs and marks, a scale bar. Of a map in
 * parts the world, or else the largest part. Models without a pose are left out; throws IoError if none has
 * one. \param grid a plan in the map's x and y, drawn in the place of the segments; may be null */
void drawFloorMap(const std::filesystem::path& path, const Map& map, const std::vector<DrawnRun>& runs,
                  const std::vector<DrawnMarks>& marks = {}, const OccupancyGrid* grid = nullptr);

/** \brief Runs from above, with a scale bar. */
void drawRuns(const std::filesystem::path& path, const PlanView& view, const std::vector<DrawnRun>& runs);

/** \brief An answer to draw, and the truth, where it is known. */
struct DrawnMatch {
  int model = 0;  ///< index of the local model; -1 = there is no answer, only the query is drawn
  Eigen::Isometry3d T_m_c = Eigen::Isometry3d::Identity();
  std::string caption;  ///< such as "rank 1, probability 0.93"
};
/** \brief Which segments agree at a pose: for each scene segment the model segment that fits best, if any
 * passes the gates of the search with as much slack as the score of a hypothesis has; in the order of the
 * scene segments. Several of these may match one model segment. */
std::vector<SegmentPair> matchedSegments(const View& scene, const View& model,
                                         const Eigen::Isometry3d& T_m_c);
/** \brief A query beside the local models it was matched to, one answer per row, matched segments in the same
 * colour; a failure shows rank 1 and the answer that would be right. \param answers at least one */
Raster<std::uint8_t> matchesPicture(const SeenImage& query, const Map& map,
                                    const std::vector<DrawnMatch>& answers);

/** \brief Several pictures in one, reduced, two beside each other, each with its title. */
Raster<std::uint8_t> contactSheet(const std::vector<Raster<std::uint8_t>>& pictures,
                                  const std::vector<std::string>& titles);

/** \brief Throws std::invalid_argument for an image without pixels or with labels of another size. */
void checkDrawable(const SeenImage& image);

}  // namespace facetloc
