// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/params.h>
#include <facetloc/features/segment.h>

#include <memory>
#include <vector>

namespace facetloc {

/** \brief Which regions of a labelled depth image become segments, and how uncertain they are (METHOD 3.3,
 * 4). */
struct SegmentEstimationParams {
  double min_support = 150;   ///< [px at 320x240], scaled with the image area
  double max_depth = 7.5;     ///< nearest end of the segment's ellipse [m]
  double min_width = 0.03;    ///< smallest sqrt(lambda_2) [m], unless it is wide compared with the noise
  double min_width_px = 2.0;  ///< smallest sqrt(lambda_2), as if it faced the camera [px at the working size]
  double min_incidence = 0.1;     ///< smallest |cosine| between normal and ray at the centroid
  double trim = 3.0;              ///< residual beyond which a pixel leaves the fit [noise std]
  bool faithful = false;          ///< the paper's eqs. (4)-(5) instead of METHOD_MEASURED 4.3
  double faithful_factor = 0.25;  ///< kappa_u on sigma_r of eq. (4), 1 = literal
  double edge_factor = 0.15;      ///< kappa_u of the added term of METHOD_MEASURED 4.3
  double slope_floor_deg = 0.1;   ///< s_0
  double offset_floor = 0.002;    ///< r_0 [m]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("min_support", p.min_support, 3.0, 1e6,
          "Smallest support of a segment [px at 320x240, scaled with the image area].");
    field("max_depth", p.max_depth, 0.1, 1e3, "Segments whose nearest end is farther are dropped [m].");
    field("min_width", p.min_width, 0.0, 10.0,
          "Smallest standard deviation of the support along its minor axis [m]; less if that is five times "
          "the depth noise.");
    field("min_width_px", p.min_width_px, 0.0, 100.0,
          "The same in pixels of the image, as if the segment faced the camera [px].");
    field("min_incidence", p.min_incidence, 0.0, 1.0,
          "Smallest cosine between normal and viewing ray at the centroid.");
    field("trim", p.trim, 1.0, 100.0,
          "Residual beyond which a pixel leaves the plane fit [noise standard deviations].");
    field("faithful", p.faithful, false, true,
          "Uncertainty by the paper's eqs. (4)-(5) instead of the full covariance.");
    field("faithful_factor", p.faithful_factor, 0.01, 10.0,
          "Factor on sigma_r of eq. (4); 1 is the paper's.");
    field("edge_factor", p.edge_factor, 0.0, 10.0, "Factor on sigma_r in the term for uncertain outlines.");
    field("slope_floor_deg", p.slope_floor_deg, 0.0, 10.0,
          "Floor of the slope uncertainty, standard deviation [deg].");
    field("offset_floor", p.offset_floor, 0.0, 1.0,
          "Floor of the offset uncertainty, standard deviation [m].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Sigma_q by the paper's eqs. (4)-(5) with factor kappa_u on sigma_r; diagonal. */
Eigen::Matrix3d faithfulCovariance(const Eigen::Vector3d& normal, const Eigen::Vector3d& centroid,
                                   const Eigen::Vector2d& lambda, const Intrinsics& camera, double kappa_u,
                                   const SensorNoise& noise);

/** \brief Sigma_q = J_q (Sigma_m) J_q^T with J_q of METHOD (4.2): first-order covariance of q from that of m,
 * for a segment with axes R, centroid t and plane distance rho. */
Eigen::Matrix3d slopeOffsetCovariance(const Eigen::Matrix3d& R, const Eigen::Vector3d& t, double rho,
                                      const Eigen::Matrix3d& Sigma_m);

/** \brief Estimates the segments of a labelled depth image. Keeps its buffers between images; use one per
 * thread. */
class SegmentEstimation {
public:
  explicit SegmentEstimation(const SegmentEstimationParams& params = {});
  ~SegmentEstimation();
  SegmentEstimation(const SegmentEstimation&);
  SegmentEstimation& operator=(const SegmentEstimation&);

  /** \param image depth at working size, \param labels of the same size,
   * \param noise of the sensor; noise.inverse_depth_std should already be that of the image if it is noisier.
   * \param segments receives the segments, sorted by information content (METHOD 10.1). Labels that fail a
   * test of the parameters are left out; an empty or all-invalid image gives an empty list.
   * \param kept receives the label of each of them. Throws std::invalid_argument if the sizes differ. */
  void estimate(const DepthImage& image, const LabelImage& labels, const SensorNoise& noise,
                std::vector<Segment>& segments, std::vector<int>& kept);

private:
  struct Buffers;
  SegmentEstimationParams params_;
  std::unique_ptr<Buffers> buffers_;
};

/** \brief The same once. \param kept receives, if given, the label of each returned segment. */
std::vector<Segment> estimateSegments(const DepthImage& image, const LabelImage& labels,
                                      const SensorNoise& noise, const SegmentEstimationParams& params,
                                      std::vector<int>* kept = nullptr);

/** \brief Order of segments by the share of information that each provides about translation along its normal
 * (METHOD 10.1, the ranking of the paper's reference [14]); ties by index. */
std::vector<int> rankByInformation(const std::vector<Segment>& segments);

}  // namespace facetloc
