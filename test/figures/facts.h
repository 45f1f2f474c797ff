// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/local_model.h>

#include <cmath>
#include <json/json.h>

/** \file
 * The contents of the figures of the METHOD documents, computed by the library on simulated views. Numbers
 * are rounded, so that figures do not change with the last digit of a result. */
namespace facetloc::figures {

Json::Value pipelineFacts();  ///< One image in a map of a room: segments, pairs, ranked poses
Json::Value splitFacts();     ///< The squares of a split, and the segments that they become
Json::Value segmentFacts();   ///< A segment frame, its covariance, and the planes that 60 cameras see
Json::Value treeFacts();      ///< All sets of pairs of a corner of three planes
Json::Value verdictFacts();  ///< Pixels that agree, contradict or are occluded at a right and at a wrong pose
Json::Value directionFacts();  ///< Likelihood of a motion along a corridor, with doors and without

/** \brief A number with that many decimals. */
inline double rounded(double value, int decimals = 4) {
  const double scale = std::pow(10.0, decimals), whole = std::round(value * scale) / scale;
  return whole == 0 ? 0 : whole;  // and not -0
}

template <class Vector>
Json::Value numbers(const Vector& vector, int decimals = 4) {
  Json::Value out(Json::arrayValue);
  for (Eigen::Index i = 0; i < vector.size(); ++i) out.append(rounded(vector[i], decimals));
  return out;
}

/** \brief A matrix as an array of its rows. */
template <class Matrix>
Json::Value rows(const Matrix& matrix, int decimals = 9) {
  Json::Value out(Json::arrayValue);
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    out.append(numbers(Eigen::VectorXd(matrix.row(i)), decimals));
  return out;
}

/** \brief Depths of every second pixel [cm], 0 = not measured. */
Json::Value smallDepth(const DepthImage& image);
/** \brief Where the camera of a view sees the outlines of its segments [px]. */
Json::Value outlines(const View& view);
/** \brief Where the camera sees a point [px]. */
Eigen::Vector2d pixelOf(const Intrinsics& camera, const Eigen::Vector3d& point);

}  // namespace facetloc::figures
