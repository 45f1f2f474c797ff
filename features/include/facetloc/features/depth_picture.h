// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief The small depth picture that a view keeps for dense checks (METHOD 4.3).
 *
 * Inverse depth at half the working resolution, in steps of kQuantum, with the smallest and largest value of
 * each 3x3 neighbourhood (5x5 px of the working image), which tolerates silhouettes and lateral errors. 0 =
 * unknown. */
struct DepthPicture {
  static constexpr double kQuantum =
      1.0 / 16384;  ///< [1/m]: 0.02 disparity units of a Kinect; reaches to 0.25 m

  /** \brief Smallest and largest inverse depth of a neighbourhood [kQuantum], 0 if all of it is unknown. */
  struct Extremes {
    std::uint16_t lowest = 0, highest = 0;
    bool operator==(const Extremes& o) const { return lowest == o.lowest && highest == o.highest; }
  };

  Intrinsics camera;                         ///< intrinsics of the picture itself
  std::vector<std::uint16_t> inverse_depth;  ///< [kQuantum], row-major
  std::vector<Extremes> extremes;            ///< over 3x3 known neighbours; derived
  DepthNoise noise;                          ///< random error of its depths

  bool empty() const { return inverse_depth.empty(); }
  /** \brief Picture of a depth image at working resolution; empty for an empty image. */
  static DepthPicture fromDepth(const DepthImage& image);
  /** \brief The same, in the memory that this picture has. */
  void assign(const DepthImage& image);
  /** \brief Picture from stored values; extremes are derived. Throws std::invalid_argument if the size is
   * wrong. */
  static DepthPicture fromStored(const Intrinsics& camera, std::vector<std::uint16_t> inverse_depth);

private:
  void deriveExtremes();
};

/** \brief A depth picture and where its camera was. */
struct PosedPicture {
  const DepthPicture* picture;
  Eigen::Isometry3d T_w_c;
};

/** \brief Root mean square of the noise of two pictures, term by term: the standard deviation of differences
 * of their inverse depths. */
inline DepthNoise commonNoise(const DepthPicture& a, const DepthPicture& b) {
  const auto common = [&](double DepthNoise::*part) {
    const double of_a = a.noise.*part, of_b = b.noise.*part;
    return std::sqrt((of_a * of_a + of_b * of_b) / 2);
  };
  DepthNoise noise;
  noise.inverse_depth_std = common(&DepthNoise::inverse_depth_std);
  noise.depth_std = common(&DepthNoise::depth_std);
  noise.depth_std_slope = common(&DepthNoise::depth_std_slope);
  return noise;
}

}  // namespace facetloc
