// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_picture.h>
#include <facetloc/features/params.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace facetloc {

/** \brief How depth pictures are compared (METHOD_MEASURED 11.4 (5)). */
struct DepthConsistencyParams {
  double absolute_error = 3.0;   ///< of a predicted inverse depth [noise std]
  double relative_error = 0.01;  ///< of a predicted inverse depth
  double gate = 3.0;             ///< times the error: beyond it, pixels do not agree
  double max_depth = 6.0;        ///< farther pixels are not compared [m]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& field) {
    field("depth_absolute_error", p.absolute_error, 0.01, 1e3,
          "Error of a predicted inverse depth [noise standard deviations].");
    field("depth_relative_error", p.relative_error, 0.0, 1.0, "Relative error of a predicted inverse depth.");
    field("depth_gate", p.gate, 0.1, 100.0,
          "Pixels whose inverse depths differ by more than this many errors do not agree.");
    field("depth_max", p.max_depth, 0.1, 1e3, "Pixels farther than this are not compared [m].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief Result of moving the pixels of one picture into another. */
struct DepthAgreement {
  int agree = 0;
  int contradict = 0;     ///< predicted nearer than measured: the other camera looked through it
  int occluded = 0;       ///< predicted farther: behind what the other camera saw
  double likelihood = 0;  ///< sum of bounded Gaussian log likelihoods of the error [nats]

  DepthAgreement& operator+=(const DepthAgreement& o) {
    agree += o.agree, contradict += o.contradict, occluded += o.occluded, likelihood += o.likelihood;
    return *this;
  }
  int judged() const { return agree + contradict + occluded; }
  int net() const { return agree - 5 * contradict; }  ///< METHOD_MEASURED 10.5
};

enum class DepthVerdict : signed char { outside, agree, contradict, occluded };
using DepthVerdicts = std::vector<DepthVerdict>;

/** \brief Compares pictures; noise_std is the sensor's noise of inverse depth [1/m]. */
class DepthComparison {
public:
  DepthComparison(const DepthConsistencyParams& params, double noise_std);

  /** \brief Moves every pixel on a grid of so many columns from a into b. Nothing is counted where b is
   * unknown. */
  DepthAgreement compare(const DepthPicture& a, const DepthPicture& b, const Eigen::Isometry3d& T_b_a,
                         int columns) const;
  /** \brief Both directions. */
  DepthAgreement compareBoth(const DepthPicture& a, const DepthPicture& b, const Eigen::Isometry3d& T_b_a,
                             int columns) const;
  /** \brief Error of a predicted inverse depth [1/m]. */
  double error(double predicted) const { return absolute_error_ + params_.relative_error * predicted; }
  /** \brief Largest difference from a predicted inverse depth that still counts as agreement [1/m]. */
  double tolerance(double predicted) const { return params_.gate * error(predicted); }

  double gate() const { return params_.gate; }
  double absoluteError() const { return absolute_error_; }
  double relativeError() const { return params_.relative_error; }
  double farthest() const { return 1 / params_.max_depth; }  ///< smallest inverse depth compared [1/m]

private:
  DepthConsistencyParams params_;
  double absolute_error_;  // [1/m]
};

/** \brief The verdicts of picture b on the pixels of picture a, seen from T_b_a. Both must outlive it. */
class DepthJudge {
public:
  DepthJudge(const DepthComparison& comparison, const DepthPicture& a, const DepthPicture& b,
             const Eigen::Isometry3d& T_b_a);

  DepthVerdict operator()(int u, int v) const;
  /** \brief Of the pixels step / 2, step / 2 + step, ... of row v. Adds to likelihood, if given, the bounded
   * log likelihoods of their errors [nats]. */
  void row(int v, int step, DepthVerdicts& out, double* likelihood = nullptr) const;

  /** \brief Where the pixels of a appear in b, in numbers: R ray(u, v) = across u + down v + origin. */
  struct Geometry {
    float across[3], down[3], origin[3], t[3];
    float fx, fy, cx, cy;  // of b, moved by half a pixel
    int width, height;
    const std::uint16_t *lowest, *highest;
    float farthest, absolute_error, relative_error, unit_error, gate;
  };

private:
  const DepthPicture& a_;
  Geometry g_;
};

constexpr int kFineColumns = 40;    ///< an 8 px grid at 320x240
constexpr int kCoarseColumns = 20;  ///< a 16 px grid at 320x240

/** \brief Spacing of a grid of so many columns in a picture. */
inline int gridStep(const DepthPicture& p, int columns) { return std::max(1, p.camera.width / columns); }

/** \brief Number of the points step / 2, step / 2 + step, ... of a grid in a row or column of that size. */
inline int gridPoints(int size, int step) { return size > step / 2 ? (size - step / 2 - 1) / step + 1 : 0; }

}  // namespace facetloc
