// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/pose.h>

#include <optional>
#include <string>
#include <vector>

/** \file
 * Meta data of a map: its surfaces, its rendered local models, the errors that its views share, and the
 * probability of sure answers. */

namespace facetloc {

/** \brief Key of a map's meta data: "fixed" or "incomplete", as MapSurfaces; without it, surfaces were seen.
 */
constexpr const char* kSurfacesKey = "surfaces";

/** \brief The surfaces that a map holds (localization/METHOD 1.7). */
enum class MapSurfaces {
  seen,        ///< as a camera or scanner saw them: all surfaces of a day, some of which people move
  fixed,       ///< as drawn: the surfaces that stay; people put other things before them
  incomplete,  ///< a part of the surfaces that stay, as the walls of a floor plan; furniture stands before
               ///< them
};

/** \brief The kind of surfaces in a map. */
MapSurfaces surfacesOf(const Map& map);
/** \brief Says so in the meta data of a map. */
void setSurfaces(MapSurfaces surfaces, Map& map);

/** \brief Whether a map lacks surfaces: objects in front of its surfaces, as furniture before a wall,
 * do not contradict it; objects seen through them do (localization/METHOD 1.7). */
inline bool lacksSurfaces(const Map& map) { return surfacesOf(map) == MapSurfaces::incomplete; }

/** \brief Key of a map's meta data: the names of the local models that were rendered from the depth pictures
 * of others (mapping's densify()), one a line. Names that no local model has mean nothing. */
constexpr const char* kRenderedKey = "rendered views";

/** \brief Flags the local models that were rendered: these views show nothing that others have not shown. */
std::vector<char> renderedViews(const Map& map);

/** \brief Key of a map's meta data: its ConsideredErrors, as toText() writes them. */
constexpr const char* kConsideredErrorsKey = "considered errors";

/** \brief Errors of a view in a map that no number of its pixels averages out: those that neighbouring pixels
 * share, those that whole views share, and the errors of the poses of the map's local models. A map learns
 * them from its own overlapping views when it is made (mapping/METHOD 2.3); by default, those of usual depth
 * cameras and poses. */
struct ConsideredErrors {
  double pixels_as_one = 200;            ///< compared pixels with the information of one, positive
  double rotation_std = 0.35 * kDegree;  ///< about each axis [rad], positive
  double translation_std = 0.008;        ///< along each axis [m], positive
  int views = 0;                         ///< that have shown them; 0: the usual ones

  /** \brief "0.12 deg, 5 mm, and 62 pixels as one; from 57 of its views". */
  std::string toString() const;
};

/** \brief For the meta data of a map: one line. Throws std::invalid_argument for impossible numbers. */
std::string toText(const ConsideredErrors& errors);
/** \brief The errors in the meta data of a map; the usual ones if it was not asked. Throws
 * std::invalid_argument for malformed or impossible ones. */
ConsideredErrors consideredErrorsOf(const Map& map);

/** \brief Key of a map's meta data: its SureThreshold, as toText() writes it. */
constexpr const char* kSureKey = "sure";

/** \brief Least probability of sure answers in a map, with a bound on the share of wrong ones among them,
 * as found by SureCalibration (localization/METHOD 1.6). Holds for single images like those that it was
 * found with. */
struct SureThreshold {
  double min_probability = 1;  ///< range (0, 1]
  double alpha = 0;            ///< largest share of wrong answers among the sure ones, in (0, 1)
  double confidence = 0;       ///< with which alpha holds, in (0, 1)
  int images = 0;              ///< that it was found with, each of another view
  int sure = 0;                ///< images with a sure answer at this threshold
  int wrong = 0;               ///< sure answers that are wrong
  std::string source{};        ///< description of the images, on one line

  /** \brief "p >= 0.95: at most 1 % of the sure answers are wrong, with 95 % confidence; 412 of 600 images of
   * walk are sure, 1 of these wrong". */
  std::string toString() const;
};

/** \brief For the meta data of a map: one line. */
std::string toText(const SureThreshold& threshold);
/** \brief The threshold in the meta data of a map; nothing if it was not calibrated. Throws
 * std::invalid_argument for one that is malformed or impossible. */
std::optional<SureThreshold> sureThresholdOf(const Map& map);
/** \brief Least probability of a sure answer in a map, unless the user says otherwise: from its
 * SureThreshold, else kMinProbability. Throws as sureThresholdOf(). */
double minProbabilityOf(const Map& map);

}  // namespace facetloc
