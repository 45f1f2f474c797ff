// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/params.h>

namespace facetloc {

/** \brief When an image becomes a local model: the paper's rule. */
struct MapBuilderParams {
  static constexpr const char* kTitle = "Images that become local models, and their poses";
  double distance = 0.5;
  double rotation_deg = 15;
  double pose_rotation_std_deg = 0.5;
  double pose_translation_std = 0.02;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("distance", p.distance, 0.0, 1e3, "Distance from the latest local model to the next one [m].",
          kForUsers);
    visit("rotation_deg", p.rotation_deg, 0.0, 180.0,
          "Rotation from the latest local model to the next one [deg].", kForUsers);
    visit("pose_rotation_std_deg", p.pose_rotation_std_deg, 1e-6, 180.0,
          "Accuracy of given orientations, standard deviation [deg].", kForUsers);
    visit("pose_translation_std", p.pose_translation_std, 1e-6, 1e3,
          "Accuracy of given positions, standard deviation [m].", kForUsers);
  }
};

/** \brief Chooses the images of a run that become local models: the first one, and every later one that lies
 * at least 0.5 m or 15 deg from the latest local model (paper, section III). */
class MapBuilder {
public:
  explicit MapBuilder(const MapBuilderParams& params = {}) : params_(params) {}

  /** \brief True if an image at this pose becomes a local model; it is then the latest one. */
  bool accept(const Eigen::Isometry3d& T_w_c);
  /** \brief The link from the model before the latest one to the latest, given their indices in the map. */
  Link link(int from, int to, const Eigen::Isometry3d& T_w_from, const Eigen::Isometry3d& T_w_to) const;

private:
  MapBuilderParams params_;
  std::optional<Eigen::Isometry3d> latest_;
};

}  // namespace facetloc
