// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>
#include <facetloc/registration/registration_params.h>

namespace facetloc {

/** \brief Which local models a view is registered with, in which order, and when no more are asked. */
struct ShortlistParams {
  static constexpr const char* kTitle = "Shortlist of local models that a view is registered with";
  int size = 40;
  int examined_models = 200;
  double examined_gap = 20;
  double gap = 1.2;
  int exhaustive_up_to = 5;
  int aligned_models = 3000;
  int first_models = 10;
  double sure_probability = 0.95;
  double start_translation = 0.2;
  int overlaid_size = 200;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("size", p.size, 0, 100000000,
          "Maximum number of local models that a view is registered with; 0 registers with all of them, "
          "which is slower and overlooks nothing.",
          kForUsers);
    visit(
        "examined_models", p.examined_models, 1, 100000000,
        "Number of best aligned local models that are examined by all planes if the first ones leave doubt.");
    visit("examined_gap", p.examined_gap, 0.0, 1e6,
          "Score below the best examined or registered local model at which one is left out [nats].");
    visit("gap", p.gap, 0.0, 1e6,
          "Score of its coarse alignment below the best at which a local model is left out.");
    visit("exhaustive_up_to", p.exhaustive_up_to, 0, 100000000,
          "Number of local models up to which a view is registered with all of them.");
    visit("aligned_models", p.aligned_models, 1, 100000000,
          "Maximum number of local models, chosen by votes and prescore, that a view is coarsely aligned "
          "with.");
    visit("first_models", p.first_models, 1, 100000000,
          "Number of likeliest local models that a view is registered with before any others.");
    visit("sure_probability", p.sure_probability, 0.0, 1.0,
          "Stop after the first batch if its best place has at least this probability.");
    visit("start_translation", p.start_translation, 0.0, 100.0,
          "Position error of a coarse alignment, standard deviation [m]; 0 searches about the prior.");
    visit("overlaid_size", p.overlaid_size, 1, 100000000,
          "With an unknown mounting: maximum number of local models that a view is registered with.",
          kForUsers);
  }
};

/** \brief Parameters of the search of a whole map. A field is known by its path, such as `ekf.iterations`. */
struct GlobalLocalizationParams : RegistrationParams {
  static constexpr const char* kTitle = "Global localization";
  ShortlistParams shortlist;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("prior", p.prior);
    visit("shortlist", p.shortlist);
    ViewRegistrationParams::describe(p, visit);
    describeRanking(p, visit);
  }
  /** \brief Throws std::invalid_argument for a parameter or a constant out of its range. */
  void validate() const { checkRanges(*this), checkRanges(calibration); }
};

/** \brief How the views of a moving camera together tell where it is. */
struct LocalizerParams {
  static constexpr const char* kTitle = "Localization of a moving camera";
  ViewOdometryParams odometry;  ///< odometry by images in quick succession
  double look_distance = 0.15;
  double look_rotation_deg = 5;
  int max_places = 12;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("odometry", p.odometry);
    visit("look_distance", p.look_distance, 0.0, 100.0,
          "Distance travelled after which a view is localized in the map again [m].", kForUsers);
    visit("look_rotation_deg", p.look_rotation_deg, 0.0, 180.0,
          "Rotation after which a view is localized in the map again [deg].", kForUsers);
    visit("max_places", p.max_places, 1, 1000, "Number of possible places of the camera that are kept.");
  }
};

}  // namespace facetloc
