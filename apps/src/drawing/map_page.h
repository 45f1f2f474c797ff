// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/pictures.h"

#include <facetloc/features/answer_state.h>
#include <facetloc/features/finding.h>
#include <facetloc/mapping/map_session.h>

#include <functional>
#include <json/forwards.h>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A place where an image may have been taken. */
struct PagePlace {
  int model = -1;  ///< index of the local model that it was found by; -1 = not known
  Eigen::Isometry3d T_m_c = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_w_c = Eigen::Isometry3d::Identity();
  double probability = 0;
  double sd_trans_m = 0;  ///< largest standard deviation of the position [m]
  double sd_rot_deg = 0;  ///< largest standard deviation of the orientation [deg]
};

/** \brief The answer to an image. */
struct PageAnswer {
  std::string run;  ///< may be empty
  std::string frame;
  AnswerState state = AnswerState::unknown;
  bool wrong = false;             ///< sure, and not where the image was taken
  std::string reason;             ///< why there is no place, or a remark
  std::vector<PagePlace> places;  ///< places in the part of the map that is drawn, most probable first
  std::optional<Matrix6d> P_w_c;  ///< covariance of the first place
  std::optional<ViewShares> shares;
  std::optional<Eigen::Isometry3d> truth;
  std::optional<double> error_m, error_deg;  ///< difference of the first place from the truth
  bool relative = false;                     ///< ... in its local model
};

/** \brief A film strip of answers over the places of a map as they narrow, a plan view for each image, PNG,
 * atomically: places as disks, the larger the more probable, with headings and rings of two standard
 * deviations; a bar for the probability of each and of that the map does not hold the place; the truth as a
 * cross. Needs an X display (OffscreenDisplay). Throws IoError if no local model of the map has a pose or the
 * file cannot be written, std::invalid_argument without images. \param titles one for each */
void drawBeliefs(const std::filesystem::path& path, const Map& map, const std::vector<PageAnswer>& answers,
                 const std::vector<std::string>& titles);

/** \brief A map, and the answers and paths shown in it. Poses are in the part of the map that is drawn: the
 * world, or else the largest part. */
struct MapPage {
  std::string title;
  std::vector<DrawnRun> runs;
  std::vector<PageAnswer> answers;     ///< Sorted by time.
  Findings findings;                   ///< about the recordings and their localization
  std::vector<OwnView> own_views;      ///< answers for the map's own images, which colour its local models
  std::vector<SurfaceChange> changes;  ///< surfaces that are gone or new
  /** \brief The view of an answer's image, to show it and its matched local model; may be empty, and return
   * nothing or throw IoError for an image that cannot be read, which has no picture then. */
  std::function<std::optional<View>(std::size_t answer)> view;
};

/** \brief Largest number of links that a page shows without being asked. */
constexpr int kMostLinks = 30;

/** \brief Writes a page for browsers, one file that needs no network, atomically: the segments of all local
 * models as polygons coloured by direction, the local models, links, runs, and answers with 95 % ellipsoids,
 * and changed surfaces, to turn, zoom and click, over a grid of the floor; segments far from nearly all
 * others, backs of walls and answers that are not sure are light. Names are text there, whatever is in them.
 * Pictures and matches share about 1 MB: where images are many, pictures are smaller, then fewer; so are the
 * measured points that a click shows, of which there are 131 072 at most; of more than 40 000 segments the
 * largest are drawn. Throws IoError if no local model of the map has a pose, or the page cannot be written;
 * std::runtime_error if facetloc was built without three.js. */
void writeMapPage(const std::filesystem::path& path, const Map& map, const MapPage& page);
/** \brief Its data, for apps/pages/map.js. Throws IoError, with the name of the page that was to be, if no
 * local model of the map has a pose. */
Json::Value mapPageData(const Map& map, const MapPage& page, const std::filesystem::path& path);

}  // namespace facetloc
