// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace facetloc {

/** \brief Systematic error of a depth camera, constant at each place of its image: a smooth
 * field of inverse depth, on a grid over the image with straight lines between the nodes.
 *
 * Cameras that triangulate have equal errors of disparity, so of inverse depth, at all distances. The field
 * refers to normalised rays, so that it holds for the image at any resolution. */
class DepthDistortion {
public:
  static constexpr int kColumns = 9, kRows = 7, kNodes = kColumns * kRows;
  using Values = std::array<double, kNodes>;  ///< row-major; measured minus true inverse depth [1/m]

  /** \brief The four nodes about a ray, and how much each of them counts; the weights add up to 1. */
  struct Weights {
    std::array<int, 4> node;
    std::array<double, 4> weight;
  };

  /** \brief The normalised rays (b_x, b_y) between those of the first and the last pixel. */
  static Eigen::AlignedBox2d extentOf(const Intrinsics& camera);

  /** \brief None, over the rays between -1 and 1. */
  DepthDistortion() = default;
  /** \param extent of the rays, not empty; outermost nodes lie on its border. Throws std::invalid_argument if
   * a value or the extent is impossible. */
  explicit DepthDistortion(const Eigen::AlignedBox2d& extent, const Values& values = {});

  const Eigen::AlignedBox2d& extent() const { return extent_; }
  const Values& values() const { return values_; }
  /** \brief The ray (b_x, b_y) of a node. */
  Eigen::Vector2d rayOf(int node) const;
  /** \brief Rays outside the extent count as the nearest one inside. */
  Weights weights(const Eigen::Vector2d& ray) const;
  /** \brief Measured minus true inverse depth along a ray [1/m]. */
  double at(const Eigen::Vector2d& ray) const;
  /** \brief Root mean square of the nodes [1/m]. */
  double rms() const;

  /** \brief Could the image be one of this camera, at whatever resolution? */
  bool fits(const Intrinsics& camera) const;

private:
  Eigen::AlignedBox2d extent_{Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1)};
  Values values_{};
};

/** \brief Takes the distortion of a camera out of its images. Keeps its memory from image to image; one per
 * thread. */
class DepthCorrection {
public:
  explicit DepthCorrection(const DepthDistortion& distortion) : distortion_(distortion) {}
  /** \brief The image as the camera would have measured it without distortion, valid until the next call; the
   * image itself if it cannot be of this camera. Pixels for which the field leaves no depth are 0. */
  const DepthImage& operator()(const DepthImage& image);

private:
  DepthDistortion distortion_;
  std::vector<float> error_;  // error of each pixel of the last image's camera [1/m]
  DepthImage corrected_;
};

}  // namespace facetloc
