// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_distortion.h>
#include <facetloc/mapping/found_mounting.h>
#include <facetloc/mapping/geometry_check.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

/** \file
 * Results of making a map, beside the map. */

namespace facetloc {

/** \brief Differences between motions by poses and motions by images: medians. */
struct PoseDisagreement {
  double rotation_deg = 0;
  double translation = 0;   ///< [m]
  std::size_t motions = 0;  ///< motions whose poses are known

  /** \brief "0.78 deg, 18 mm, median of 61 motions". */
  std::string toString() const;
};

/** \brief Length of motions by images, relative to those by poses. */
struct MotionRatio {
  double ratio = 1;
  double lowest = 1, highest = 1;  ///< the ratio if all errors are those of the poses, or of the images
  double std = 0;                  ///< standard deviation, from the scatter over the motions
  double angle_deg = 0;            ///< between the directions of both: mean
  double angle_std_deg = 0;
  std::size_t motions = 0;  ///< 0: nothing is known

  /** \brief Is it certainly another one than 1, whoever errs? */
  bool differs() const;
  /** \brief The least share by which one source of motion exceeds the other; 0 unless it differs(). */
  double difference() const;
  /** \brief angle_deg, if it is certainly not 0; else 0. */
  double certainAngleDeg() const;
};

/** \brief Comparison of poses with the motions that images show. */
struct PoseCheck {
  PoseDisagreement as_given;
  std::string cause;        ///< the fault of the poses that explains it, in words; else empty
  std::string convention;   ///< that explains it, as io's PoseReading takes it ("wxyz,inverse"); else empty
  PoseDisagreement mended;  ///< without that fault
  bool wrong_convention = false;  ///< wrong order of numbers, axes or units, which is more than an inaccuracy
  MotionRatio distances, turns;   ///< ratios for the poses as given

  /** \brief A sentence without full stop for each ratio that is certainly not 1. */
  std::vector<std::string> ratiosInWords() const;
  /** \brief Are there enough motions to judge by? */
  bool isKnown() const;
  /** \brief No map can be made of such poses: they are known, and in a wrong convention, or have nothing to
   * do with the images. */
  bool isBeyondSense() const;
};

/** \brief Accuracy of the poses of pictures, relative to others nearby: standard deviations. */
struct PoseAccuracy {
  double rotation_std;     ///< about each axis [rad]
  double translation_std;  ///< along each axis [m]
};

/** \brief Distortion of a camera, estimated from pictures with poses. */
struct DistortionEstimate {
  DepthDistortion distortion;
  PoseAccuracy poses;  ///< as estimated from the pictures

  /** \brief Are the poses good enough? A distortion of one disparity unit of a Kinect tilts a wall at 3 m by
   * about half a degree. Poses that are worse than that, or that were themselves found with the distorted
   * images, cannot tell one from the other. */
  bool reliable() const;
};

/** \brief An image that was left out, since reading it threw an exception. */
struct UnreadImage {
  std::size_t image = 0;  ///< its number
  std::string cause;      ///< the message of the exception
};

/** \brief Findings of MapMaking and MapSession beside their map. */
struct MapFindings {
  std::optional<CameraTrajectory> trajectory;    ///< estimated from images without poses
  std::size_t without_odometry = 0;              ///< images outside the time of the odometry
  std::optional<GeometryCheck> geometry;         ///< the images themselves, as far as they were checked
  std::optional<PoseCheck> poses;                ///< the given poses, as far as they were checked
  std::optional<PoseCheck> odometry;             ///< the odometry, against the trajectory from the images
  std::optional<DistortionEstimate> distortion;  ///< removed from all images only if it is reliable()
  std::optional<FoundMounting> mounting;         ///< mounting found for a camera without one
  std::vector<UnreadImage> unread;               ///< sorted as the images
  std::size_t without_segments = 0;              ///< selected images that became no local models
  std::string problem;                           ///< reason for an empty map, in words

  /** \brief Was none of that many images readable? */
  bool noneRead(std::size_t images) const { return images > 0 && unread.size() == images; }
};

}  // namespace facetloc
