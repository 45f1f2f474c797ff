// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <array>
#include <limits>
#include <vector>

namespace facetloc::internal {

/** \brief The most useful planes of a view, property by property, for many of them at once are compared. */
struct PlaneColumns {
  static constexpr int kMost = 24;  ///< whole vectors (lanes.h)
  using Column = std::array<float, kMost>;

  /** \brief Segments that are not finite are left out. */
  explicit PlaneColumns(const View& view);

  int size = 0;
  // Where there is no plane all is zero: no normal is near that.
  Column nx{}, ny{}, nz{};  ///< unit normals, away from the camera
  Column cx{}, cy{}, cz{};  ///< centroids [m]
  Column offset{};          ///< distance from the camera [m]
  Column radius{};          ///< half the length of a rectangle of that extent [m]
  Column weight{};          ///< square root of the support

  Eigen::Vector3f normal(int i) const { return {nx[i], ny[i], nz[i]}; }
  Eigen::Vector3f centroid(int i) const { return {cx[i], cy[i], cz[i]}; }
};

/** \brief How one view may be laid over another. */
struct Overlay {
  float score = std::numeric_limits<float>::lowest();  ///< lowest if nothing can be laid over anything
  Eigen::Isometry3f T_m_c = Eigen::Isometry3f::Identity();

  bool exists() const { return score > std::numeric_limits<float>::lowest(); }
};

/** \brief A quick look whether two views of a camera in any attitude may show the same place (METHOD 2.7):
 * about a hundredth of the work of a registration.
 *
 * Three planes of the scene whose normals span space, laid over three of the model that meet at the same
 * angles, are a pose; where no three do, two are, with the least move along the line in which they meet. The
 * score of a pose is the share of the scene's planes, by the root of their support, that lie on a
 * plane of the model, less a penalty for its distance from the prior. Never changes; thread-safe. */
class PlaneTripletMatcher {
public:
  /** \param prior of T_m_c, about the identity and equal in all directions
   * \param tilt_std for two views that are level, with y downwards, how far a pose may tilt one against the
   * other, standard deviation [rad]; 0 = they are in any attitude */
  PlaneTripletMatcher(const View& scene, const PoseWithCovariance& prior, double tilt_std = 0);

  /** \brief False if no two planes of the scene are far enough from parallel. */
  bool isUseful() const { return !seeds_.empty(); }
  Overlay on(const PlaneColumns& model) const;

private:
  /** \brief Planes of the scene that are laid over others. */
  struct Seed {
    std::array<int, 3> planes;  // the first two are the nearest to a right angle
    int size;                   // 2 or 3
    float worth;
  };
  void findTriples(std::vector<Seed>& seeds) const;
  void findPairs(std::vector<Seed>& seeds) const;
  void keepDifferent(std::vector<Seed> seeds);
  void lay(const Seed& seed, const PlaneColumns& model, Overlay& best) const;
  void judge(const Seed& seed, const std::array<int, 3>& over, const Eigen::Matrix3f& R,
             const PlaneColumns& model, Overlay& best) const;

  PlaneColumns scene_;
  float rotation_std_, translation_std_;
  float tilt_std_;  // 0: not level
  float total_weight_ = 0;
  std::vector<Seed> seeds_;
};

}  // namespace facetloc::internal
