// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/depth_consistency.h"

#include <facetloc/features/local_model.h>
#include <facetloc/features/pose.h>

#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief How well the pictures of a view fit others whose poses are known, as a function of its pose: minus
 * the cost that a pose has a minimum of (METHOD 11.4). All pictures must outlive it. */
class DepthFit {
public:
  DepthFit(const DepthPicture& scene, std::vector<PosedPicture> pictures, const DepthComparison& comparison)
      : scenes_{{&scene, std::nullopt, std::move(pictures)}}, comparison_(comparison) {}

  /** \brief Adds another picture of the view, and those near it. */
  void add(const SidePicture& side, std::vector<PosedPicture> pictures) {
    scenes_.push_back({side.picture.get(), side.T_v_c, std::move(pictures)});
  }
  /** \brief Number of pictures of the view. */
  std::size_t size() const { return scenes_.size(); }

  /** \brief All pixels of the scene in the others and of the others in the scene. */
  DepthAgreement compare(const Eigen::Isometry3d& T_w_c, int columns) const;
  /** \brief Log likelihood of the pixels relative to an exact fit [nats], of all pictures of which enough
   * pixels are compared; nothing if none is. */
  std::optional<double> operator()(const Eigen::Isometry3d& T_w_c, int columns) const;

private:
  struct Scene {
    const DepthPicture* picture;
    std::optional<Eigen::Isometry3d> T_v_c;  // the view's own frame if empty
    std::vector<PosedPicture> others;
  };
  DepthAgreement compare(const Scene& scene, const Eigen::Isometry3d& T_w_v, int columns) const;

  std::vector<Scene> scenes_;
  const DepthComparison& comparison_;
};

/** \brief Number of independent measurements that the pixels of two pictures are worth. */
constexpr double kIndependentPixels = 240;

/** \brief Log likelihood of compared pixels relative to an exact fit [nats], where they are enough. */
std::optional<double> logLikelihood(const DepthAgreement& seen, int columns);

/** \brief Information of a pose without any prior, and its share of the stated information. */
struct ShownInformation {
  Matrix6d information, share;
};

/** \brief The information of a registered pose by the cost itself (METHOD 11.4). Derivatives of
 * edges and of noise feign information that the cost does not show some pixels away from its minimum; and
 * where derivatives show none, steps of the surface may. Along each principal motion, except those known to
 * millimetres, the information becomes the one of the cost.
 * \param stated information of the pose T_w_c, without any prior; all of it if nothing can be compared */
ShownInformation shownInformation(const Matrix6d& stated, const Eigen::Isometry3d& T_w_c, const DepthFit& fit,
                                  int columns);

/** \brief A registered pose with the covariance that the cost shows; where it shows less than the
 * derivatives, the pose goes back towards the prior. \param found pose and covariance by derivatives, with
 * the prior \param prior positive definite */
PoseWithCovariance asShown(const PoseWithCovariance& found, const PoseWithCovariance& prior,
                           const DepthFit& fit, int columns);

}  // namespace facetloc::internal
