// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/localization/tracking_params.h>

namespace facetloc {

/** \brief How the views of a moving camera together tell where it is. */
struct SequenceParams {
  static constexpr const char* kTitle = "Localization by a sequence of views";
  ViewOdometryParams odometry;            ///< of images in quick succession
  double look_distance = 0.15;            ///< motion of the camera between views that are looked at [m]
  double look_rotation_deg = 5;           ///< the same
  double independent_distance = 0.5;      ///< motion after which a view tells as much as a first one [m]
  double independent_rotation_deg = 15;   ///< the same
  int max_places = 12;                    ///< places that are kept
  int kept_looks = 6;                     ///< latest views, by which a new place is judged too
  double most_log_odds = 7;               ///< that any number of views add up to [nats]
  double lookalike_weight = 0.8;          ///< of what the map's look-alikes score, in what a place must score
  double lookalike_share_of_place = 0.5;  ///< in that, of the look-alikes of the place itself
  double max_translation = 0.15;          ///< std of a pose beyond which it is not sure [m]
  double max_rotation_deg = 3;            ///< the same

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("odometry", p.odometry);
    visit("look_distance", p.look_distance, 0.0, 100.0,
          "Way of the camera after which its view is looked for in the map again [m].");
    visit("look_rotation_deg", p.look_rotation_deg, 0.0, 180.0,
          "Rotation of the camera after which its view is looked for in the map again [deg].");
    visit("independent_distance", p.independent_distance, 1e-3, 100.0,
          "Way of the camera after which a view tells nearly as much as a first one [m].");
    visit("independent_rotation_deg", p.independent_rotation_deg, 0.1, 360.0,
          "Rotation of the camera after which a view tells nearly as much as a first one [deg].");
    visit("max_places", p.max_places, 1, 1000, "Number of places where the camera may be that are kept.");
    visit("kept_looks", p.kept_looks, 0, 1000,
          "Number of latest views by which a place is judged that only a later one brings up.");
    visit("most_log_odds", p.most_log_odds, 0.1, 100.0,
          "Log odds that any number of views add up to at most; less forgets faster [nats].");
    visit("lookalike_weight", p.lookalike_weight, 0.0, 1.0,
          "Weight of the scores of wrong places for the map's own views in the score that speaks for a "
          "place; the rest has what wrong places score at least.");
    visit(
        "lookalike_share_of_place", p.lookalike_share_of_place, 0.0, 1.0,
        "Share of what looks like the place itself in the score of look-alikes; the rest has what looks like "
        "the places of the map that have most of it.");
    visit("max_translation", p.max_translation, 1e-3, 100.0,
          "Position uncertainty from which on a place is not sure, standard deviation [m].");
    visit("max_rotation_deg", p.max_rotation_deg, 1e-3, 180.0,
          "Orientation uncertainty from which on a place is not sure, standard deviation [deg].");
  }
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
