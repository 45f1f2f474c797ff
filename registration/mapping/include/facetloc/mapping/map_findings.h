// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera.h>
#include <facetloc/features/depth_distortion.h>
#include <facetloc/features/depth_image.h>
#include <facetloc/features/finding.h>
#include <facetloc/features/local_model.h>
#include <facetloc/mapping/trajectory_estimation.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

/** \file
 * Results of making a map, beside the map, and the tests that they come from. */

namespace facetloc {

/** \brief How a camera is mounted on a robot, by the floor that its images show. */
struct FoundMounting {
  CameraMounting mounting;
  int models = 0;      ///< local models that show the floor so
  int all_models = 0;  ///< number of models examined

  /** \brief "0.980 m above the floor, 10.0 deg down, by the floor in 140 of 160 local models". */
  std::string toString() const;
};

/** \brief The floor as a camera sees it. */
struct SeenFloor {
  double height = 0;      ///< mean height of the camera above it [m]
  double tilt_deg = 0;    ///< tilt of the optical axis below the horizon
  double roll_deg = 0;    ///< about the optical axis: positive if the camera's right side is lower
  double height_std = 0;  ///< over the views [m]
  int views = 0;          ///< that show it so
  int all_views = 0;      ///< number of views examined
  bool steady = false;    ///< as under a robot; the floor below a camera in the hand comes and goes

  /** \brief The mounting of a robot's camera that sees it so. A roll of less than 2 deg counts as none. */
  CameraMounting mounting() const;
};

/** \brief Looks for the plane below the camera that most local models have in common. Nothing if fewer than
 * 10, or than 30 %, show one. \param map of which segments are read */
std::optional<SeenFloor> findFloor(const Map& map);

/** \brief The mounting found by the floor, where it is the same in most local models although the camera
 * has moved. Nothing for a camera in the hand, whose height and tilt spread, and where the camera has not
 * moved by 2 m, or may not have. A roll of less than 2 deg counts as none. \param map of which
 * segments and poses are read */
std::optional<FoundMounting> findMounting(const Map& map);

/** \brief Bend of surfaces that ought to be flat (mapping/METHOD 2.1). */
struct SurfaceBend {
  double ray_exponent = 0;      ///< depths as read are z times this power of the length of the ray (b_z = 1):
                                ///< 0 for z, 1 for distances along the rays
  double ray_exponent_std = 0;  ///< standard deviation, from the scatter over the images
  double lens = 0;              ///< k1 of a radial lens whose distortion is left in the images
  double lens_std = 0;
  double residual_ratio = 1;  ///< sum of squared residuals without the bend, by that with it
  double flat_share = 0;      ///< expected share of the image that the surface of a pixel covers
};

/** \brief Intrinsics by which the angles between surfaces agree best over the images (METHOD 2.2): with the
 * right ones, the angle between two surfaces is the same from every point of view. */
struct SurfaceAngles {
  std::size_t pairs = 0, images = 0;  ///< pairs of surfaces, each in one image; images that show some
  double fx = 1, fy = 1;              ///< the best ones, by the given ones
  double cx = 0, cy = 0;              ///< the best ones minus the given ones [px]
  double gain = 0;  ///< log likelihood ratio of the best to those as read, give or take the errors of usual
                    ///< calibrations, with an image as one observation, less the cost of unusual
                    ///< cameras [nats]; 0 if the best are within these errors
  double gain_std = 0;  ///< standard deviation, from the scatter over the images

  /** \brief Are other intrinsics certainly better than those as read? */
  bool contradicts() const;
};

/** \brief Evidence in depth images alone of how they must be read. */
struct GeometryCheck {
  std::size_t images = 0, surfaces = 0;  ///< that were looked at
  SurfaceBend bend;
  std::optional<SurfaceAngles> angles;  ///< nothing if there are too few pairs
  Findings findings;                    ///< the clearest first
};

/** \brief Tests the largest flat surfaces of some images of one camera: whether they are flat as read, as
 * distances along the rays, or behind a lens; and whether the angles between them agree over the images with
 * their intrinsics, or with other ones.
 *
 * A plane stays a plane whatever fx, fy, cx and cy are; these show in the angles between planes only.
 * \param images as they are worked on, valid, of one size; some dozen, from all over a recording */
GeometryCheck checkGeometry(const std::vector<DepthImage>& images, const Camera& camera);

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

/** \brief A motion between two images whose poses are farther from the images than 5 times the deviation of
 * all: one of the two poses may be wrong. */
struct PoseOutlier {
  double stamp_a = 0, stamp_b = 0;           ///< times of the images [s]
  double rotation_deg = 0, translation = 0;  ///< disagreement [deg, m]
};

/** \brief Comparison of poses with the motions that images show. */
struct PoseCheck {
  /** \brief Id of the finding on poses that agree with the images: how accurate they are. */
  static constexpr const char* kAccuracy = "poses.accuracy";

  PoseDisagreement as_given;
  std::string cause;        ///< the fault of the poses that explains it, in words; else empty
  std::string convention;   ///< that explains it, as io's PoseReading takes it ("wxyz,inverse"); else empty
  PoseDisagreement mended;  ///< without that fault
  bool wrong_convention = false;  ///< wrong order of numbers, axes or units, which is more than an inaccuracy
  MotionRatio distances, turns;   ///< ratios for the poses as given
  std::vector<PoseOutlier> outliers;  ///< single motions, and steps of single poses
  double tail = 0;                    ///< share of the motions among them

  /** \brief A sentence without full stop for each ratio that is certainly not 1. */
  std::vector<std::string> ratiosInWords() const;
  /** \brief Are there enough motions to judge by? */
  bool isKnown() const;
  /** \brief No map can be made of such poses: they are known, and in a wrong convention, or have nothing to
   * do with the images. */
  bool isBeyondSense() const;
  /** \brief Do more motions disagree with the images than these alone get wrong, whatever the median says? */
  bool hasTail() const;
  /** \brief The fault of the poses, their accuracy if they agree, or that they could not be checked; then
   * their outliers, with their times. */
  Findings list() const;
};

/** \brief A step of the poses between neighbouring images that the images contradict: the tracking that gave
 * the poses was lost, and has begun anew. */
struct PoseJump {
  std::size_t image = 0;            ///< number of the image after it
  double stamp_a = 0, stamp_b = 0;  ///< times of the images before and after it [s]
  Eigen::Isometry3d by_poses = Eigen::Isometry3d::Identity();  ///< pose of the second camera in the first
  std::optional<Eigen::Isometry3d> by_images;                  ///< unless they show nothing in common
  bool timed = true;                                           ///< both times are measured

  /** \brief Is it certainly faster than robots and people move a camera? The poses begin anew then, in a part
   * of the map of their own. */
  bool isTooFast() const;
  Finding finding() const;
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
  std::vector<PoseJump> jumps;                   ///< the given poses', the largest first
  std::optional<PoseCheck> odometry;             ///< the odometry, against the trajectory from the images
  std::optional<DistortionEstimate> distortion;  ///< removed from all images only if it is reliable()
  std::optional<FoundMounting> mounting;         ///< mounting found for a camera without one
  std::vector<UnreadImage> unread;               ///< sorted as the images
  std::size_t without_segments = 0;              ///< selected images that became no local models
  std::string problem;                           ///< reason for an empty map, in words
  std::size_t images = 0, without_pose = 0;  ///< number of images; of those without one of the given poses

  /** \brief Findings so far about the images, their poses and the trajectory. */
  Findings list() const;
  /** \brief Was none of that many images readable? */
  bool noneRead(std::size_t of_images) const { return of_images > 0 && unread.size() == of_images; }
};

}  // namespace facetloc
