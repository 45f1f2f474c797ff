// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "disparity_image.h"

#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_depth.h>

#include <Eigen/Dense>

#include <cmath>
#include <vector>

namespace facetloc::test {

using namespace internal;

/** \brief An image of the given size with nothing measured. */
inline DisparityImage blankDisparity(int width, int height) {
  DisparityImage image;
  image.camera = {width, height, 0.9 * width + 1, 0.9 * width + 2, 0.5 * width, 0.5 * height};
  image.unit = 0.5 / kKinectGain;
  image.d.assign(static_cast<std::size_t>(width) * height, 0.f);
  return image;
}

/** \brief Independent random values: the worst case of a segmentation. */
inline DisparityImage randomDisparity(int width, int height, double valid_share, unsigned seed) {
  DisparityImage image = blankDisparity(width, height);
  Rng rng(seed);
  for (float& d : image.d)
    if (uniform(rng, 0, 1) < valid_share) d = static_cast<float>(uniform(rng, 100, 1000));
  return image;
}

/** \brief A furnished room with unit white noise, in steps of 1/1024 so that sums with integers are exact. */
inline DisparityImage roomDisparity(const Intrinsics& camera, unsigned seed, double noise = 1) {
  const DepthImage depth = render(furnishedRoom(), camera, lookingAlong({1, 0.5, 1.2}, {0.4, 1, -0.2})).image;
  DisparityImage image;
  toDisparity(depth, 0.5 / kKinectGain, image);
  Rng rng(seed);
  for (float& d : image.d)
    if (d > 0) d = static_cast<float>(std::round((d + noise * gaussian<1>(rng)[0]) * 1024) / 1024);
  return image;
}

/** \brief Sum of the squared residuals of pixels (u, v, d) about their own plane, by dense least squares. */
inline double squaredResiduals(const std::vector<Eigen::Vector3d>& pixels) {
  Eigen::MatrixX3d A(pixels.size(), 3);
  Eigen::VectorXd d(pixels.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    A.row(static_cast<int>(i)) << pixels[i].x(), pixels[i].y(), 1;
    d[static_cast<int>(i)] = pixels[i].z();
  }
  return (A * A.colPivHouseholderQr().solve(d) - d).squaredNorm();
}

}  // namespace facetloc::test
