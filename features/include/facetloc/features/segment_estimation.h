// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/params.h>
#include <facetloc/features/segment.h>

#include <memory>
#include <vector>

namespace facetloc {

/** \brief Errors of a segment beyond those of its plane fit, fitted together (METHOD 7.3). */
struct SegmentErrors {
  double edge_factor = 0.15;     ///< kappa_u of the term for uncertain outlines
  double slope_floor_deg = 0.1;  ///< s_0: smallest slope uncertainty, standard deviation
  double offset_floor = 0.002;   ///< r_0: smallest offset uncertainty, standard deviation [m]
};

/** \brief Which regions of a labelled depth image become segments, and how uncertain they are (METHOD 7,
 * 8). */
struct SegmentEstimationParams {
  static constexpr const char* kTitle = "Segments and their uncertainty";
  double min_support = 150;  ///< [px at 320x240], scaled with the image area; ViewBuilder takes the labels'
  double max_depth = 7.5;
  bool paper_uncertainty = false;
  SegmentErrors errors;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("max_depth", p.max_depth, 0.1, 1e3,
          "Distance of its nearest end beyond which a segment is left out [m].", kForUsers);
    visit("paper_uncertainty", p.paper_uncertainty, false, true,
          "Uncertainty of a segment by the paper's eqs. (4)-(5) instead of the covariance of its plane fit.");
  }
};

/** \brief Sigma_q by the paper's eqs. (4)-(5) with factor kappa_u on sigma_r; diagonal. */
Eigen::Matrix3d paperCovariance(const Eigen::Vector3d& normal, const Eigen::Vector3d& centroid,
                                const Eigen::Vector2d& lambda, const Intrinsics& camera, double kappa_u,
                                const SensorNoise& noise);

/** \brief Sigma_q = J_q (Sigma_m) J_q^T with J_q of METHOD 7.3: first-order covariance of q by the one of m,
 * for a segment with axes R, centroid t and plane distance rho. */
Eigen::Matrix3d slopeOffsetCovariance(const Eigen::Matrix3d& R, const Eigen::Vector3d& t, double rho,
                                      const Eigen::Matrix3d& Sigma_m);

/** \brief A region that is no segment. */
struct LeftOutRegion {
  int label = 0;
  const char* reason = "";  ///< such as "is seen edge-on"
};

/** \brief Estimates the segments of a labelled depth image. Keeps its buffers between images; use one per
 * thread. */
class SegmentEstimation {
public:
  explicit SegmentEstimation(const SegmentEstimationParams& params = {});
  ~SegmentEstimation();
  SegmentEstimation(const SegmentEstimation&);
  SegmentEstimation& operator=(const SegmentEstimation&);

  /** \param image depth at working size, \param labels of the same size,
   * \param noise of the sensor, of which that at the depth of a segment counts; if the image is noisier, then
   * already scaledTo() the noise of the image.
   * \param segments receives the segments, sorted by information content (METHOD 9). Labels that fail a
   * test of the parameters are left out; an empty or all-invalid image gives an empty list.
   * \param kept receives the label of each of them. \param left_out receives, if given, the other labels of
   * the image and why. Throws std::invalid_argument if the sizes differ. */
  void estimate(const DepthImage& image, const LabelImage& labels, const SensorNoise& noise,
                std::vector<Segment>& segments, std::vector<int>& kept,
                std::vector<LeftOutRegion>* left_out = nullptr);

private:
  struct Buffers;
  SegmentEstimationParams params_;
  std::unique_ptr<Buffers> buffers_;
};

/** \brief The same once. \param kept receives, if given, the label of each returned segment. */
std::vector<Segment> estimateSegments(const DepthImage& image, const LabelImage& labels,
                                      const SensorNoise& noise, const SegmentEstimationParams& params,
                                      std::vector<int>* kept = nullptr,
                                      std::vector<LeftOutRegion>* left_out = nullptr);

/** \brief Order of segments by the share of information that each provides about translation along its normal
 * (METHOD 9, the ranking of the paper's reference [14]); ties by index. */
std::vector<int> rankByInformation(const std::vector<Segment>& segments);

}  // namespace facetloc
