// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/moved_pixels.h"

#include <facetloc/features/depth_picture.h>
#include <facetloc/registration/calibration.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace facetloc::internal {

/** \brief Result of moving the pixels of one picture into another. */
struct DepthAgreement {
  int agree = 0;
  int contradict = 0;     ///< predicted nearer than measured: the other camera looked through it
  int occluded = 0;       ///< predicted farther: behind the surface that the other camera saw
  double likelihood = 0;  ///< sum of bounded Gaussian log likelihoods of the error [nats]
  double misfit = 0;      ///< drop of the log likelihood from an exact fit of each pixel [nats]

  DepthAgreement& operator+=(const DepthAgreement& o) {
    agree += o.agree, contradict += o.contradict, occluded += o.occluded;
    likelihood += o.likelihood, misfit += o.misfit;
    return *this;
  }
  int judged() const { return agree + contradict + occluded; }
  int net() const { return agree - 5 * contradict; }  ///< METHOD 9
};

enum class DepthLabel : signed char { outside, agree, contradict, occluded };
using DepthLabels = std::vector<DepthLabel>;

/** \brief Error model of the difference of two inverse depths. */
struct DepthErrors {
  double absolute = 0;  ///< error of a predicted inverse depth that is the same at all distances [1/m]
  double relative = 0;  ///< error that grows with the predicted inverse depth, as a share of it
  double squared = 0;   ///< error that grows with the square of the predicted inverse depth [m]
  double gate = 0;      ///< largest difference that still counts as agreement [errors]

  /** \brief Error of a predicted inverse depth [1/m]. */
  double of(double predicted) const {
    return absolute + relative * predicted + squared * predicted * predicted;
  }
  /** \brief Largest difference from a predicted inverse depth that still counts as agreement [1/m]. */
  double tolerance(double predicted) const { return gate * of(predicted); }
};

/** \brief How depth is compared at a pose that all pixels have refined. */
inline DepthCalibration refinedErrors(const Calibration& calibration) {
  DepthCalibration depth = calibration.depth;
  depth.absolute_error = calibration.refined_depth.absolute_error;
  depth.relative_error = calibration.refined_depth.relative_error;
  return depth;
}

/** \brief Compares pictures, each by the noise that it was seen with. */
class DepthComparison {
public:
  explicit DepthComparison(const DepthCalibration& calibration) : calibration_(calibration) {}

  /** \brief Moves every pixel on a grid with this number of columns from a into b. Nothing is counted where b
   * is unknown. */
  DepthAgreement compare(const DepthPicture& a, const DepthPicture& b, const Eigen::Isometry3d& T_b_a,
                         int columns) const;
  /** \brief Both directions. */
  DepthAgreement compareBoth(const DepthPicture& a, const DepthPicture& b, const Eigen::Isometry3d& T_b_a,
                             int columns) const;
  /** \brief The verdicts alone, without likelihood and misfit, in half the time. */
  DepthAgreement count(const DepthPicture& a, const DepthPicture& b, const Eigen::Isometry3d& T_b_a,
                       int columns) const;
  DepthErrors errorsBetween(const DepthPicture& a, const DepthPicture& b) const {
    // The noise of depths is a polynomial in inverse depth r: s_2 + s_1 r + s_0 r^2 (features/METHOD 2.2).
    const DepthNoise noise = commonNoise(a, b);
    const double factor = calibration_.absolute_error;
    return {factor * noise.inverse_depth_std, calibration_.relative_error + factor * noise.depth_std_slope,
            factor * noise.depth_std, calibration_.gate};
  }
  /** \brief Number of the pixels of a grid that are near enough to be compared. */
  int pixelsInReach(const DepthPicture& picture, int columns) const;
  double farthest() const { return 1 / calibration_.max_depth; }  ///< smallest inverse depth compared [1/m]

private:
  DepthCalibration calibration_;
};

/** \brief The verdicts of picture b on the pixels of picture a, seen from T_b_a. Both must outlive it. */
class DepthComparator {
public:
  DepthComparator(const DepthComparison& comparison, const DepthPicture& a, const DepthPicture& b,
                  const Eigen::Isometry3d& T_b_a);

  DepthLabel operator()(int u, int v) const;
  /** \brief Labels the pixels step / 2, step / 2 + step, ... of row v. */
  void row(int v, int step, DepthLabels& out) const;
  /** \brief Counts the verdicts on these pixels. */
  void count(int v, int step, DepthAgreement& sum) const;
  /** \brief The same, and adds the bounded log likelihoods of their errors and the misfit. */
  void add(int v, int step, DepthAgreement& sum) const;

  /** \brief Where the pixels of a appear in b, in numbers. */
  struct Geometry {
    TurnedRays rays;
    float t[3];
    float fx, fy, cx, cy;  // intrinsics of b, moved by half a pixel
    int width, height;
    const DepthPicture::Extremes* extremes;
    float farthest, absolute_error, relative_error, squared_error, unit_error, gate;
  };

private:
  const std::uint16_t* pixels(int v) const;

  const DepthPicture& a_;
  Geometry g_;
};

constexpr int kFineColumns = 40;    ///< an 8 px grid at 320x240
constexpr int kCoarseColumns = 20;  ///< a 16 px grid at 320x240

/** \brief Spacing of a grid with this number of columns in a picture. */
inline int gridStep(const DepthPicture& p, int columns) { return std::max(1, p.camera.width / columns); }

/** \brief Number of the points step / 2, step / 2 + step, ... of a grid in a row or column of that size. */
inline int gridPoints(int size, int step) { return size > step / 2 ? (size - step / 2 - 1) / step + 1 : 0; }

}  // namespace facetloc::internal
