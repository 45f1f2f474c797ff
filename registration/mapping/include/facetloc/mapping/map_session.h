// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/localization/global_localization.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <functional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief How a later session is found in a map, and when the map changes. */
struct MapSessionParams {
  static constexpr const char* kTitle = "A later session in a map";
  int min_agreeing = 3;
  double known_share = 0.8;
  double changed_share = 0.3;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("min_agreeing", p.min_agreeing, 1, 1000,
          "Number of sure images that must agree on where a session is in the map.", kForUsers);
    visit("known_share", p.known_share, 0.0, 1.0,
          "Share of an image's depth pixels that local models must confirm, or it becomes a local model.");
    visit("changed_share", p.changed_share, 0.0, 1.0,
          "Share of a local model's depth pixels beyond which it is replaced as a whole if they are gone.",
          kForUsers);
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Where something with coordinates of its own is in a map. */
struct SessionPlace {
  std::size_t asked = 0;     ///< images that were looked for in the map
  std::size_t sure = 0;      ///< of these, images with a sure answer
  std::size_t agreeing = 0;  ///< of these, images that agree on one place
  /// of each keyframe in the map; nothing where it is not known to 0.1 m and 2 deg
  std::vector<std::optional<Eigen::Isometry3d>> T_w_k;
  std::vector<bool> confirmed;  ///< of each keyframe: its own sure answer, or a pose that was given, says so

  bool found() const { return agreeing > 0; }
  /** \brief "12 of 80 images are sure, 9 of them agree". */
  std::string inWords() const;
};

/** \brief Finds a trajectory in a map: its keyframes are localized, of the sure answers the largest set is
 * taken in which all agree on one place, and the trajectory is bent to them in a pose graph, in which the map
 * stays as it is (METHOD 14.5). The same for any number of threads. */
SessionPlace placeInMap(const GlobalLocalization& localization, const CameraTrajectory& trajectory,
                        const MapSessionParams& params, int threads = 1,
                        const std::function<void()>& progress = {});

/** \brief The same for a trajectory whose shape is known, such as another map's: it moves as a whole. Where
 * the two agree within the tolerance as they are, it stays where it is.
 * \param accuracy of its poses, relative to each other */
SessionPlace placeRigidly(const GlobalLocalization& localization, const CameraTrajectory& trajectory,
                          const MapBuilderParams& accuracy, const MapSessionParams& params, int threads = 1,
                          const std::function<void()>& progress = {});

/** \brief An image of a session that has its place in the map. */
struct SessionImage {
  std::string name;
  double stamp = 0;  ///< [s]
  std::shared_ptr<const View> view;
  Eigen::Isometry3d T_w_c = Eigen::Isometry3d::Identity();
  bool confirmed = true;  ///< otherwise it must agree with the map around it almost everywhere to count
};

/** \brief What a session has changed in a map. Local models by their names. */
struct MapChanges {
  struct Replacement {
    std::string old_model, new_model;
  };
  std::vector<std::string> added;
  std::vector<Replacement> replaced;
  std::vector<std::string> retired;  ///< without a view of their place that could replace them
  std::vector<std::string> edited;   ///< which have lost surfaces, and stay
  std::size_t seen = 0;              ///< local models that the session has seen again
  std::size_t surfaces = 0;          ///< segments of local models that are gone
  std::size_t of_surfaces = 0;       ///< of all segments that the session has looked at
  std::vector<Eigen::Isometry3d> T_w_new, T_w_old,
      T_w_edited;  ///< of local models that have come, have gone, are edited

  bool any() const { return !(added.empty() && replaced.empty() && retired.empty() && edited.empty()); }
};

/** \brief Brings a map up to date: surfaces that several images of a session have looked through retire,
 * local models that have lost much are replaced, and places that no local model shows become new ones
 * (METHOD 14.6).
 *
 * The map is to hold its views (readMap()) and their poses. Its ambiguity is unknown afterwards if anything
 * has changed. The same for any number of threads. */
MapChanges updateMap(Map& map, const std::vector<SessionImage>& session, const MapBuilderParams& builder,
                     const MapSessionParams& params, int threads = 1);

}  // namespace facetloc
