// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/registration/registration_params.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief How the trajectory of a camera is found from its images alone, and its way back to known places. */
struct MappingParams {
  static constexpr const char* kTitle = "Trajectory of a camera by its images";
  ViewOdometryParams odometry;
  OdometryError odometry_error;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("odometry", p.odometry);
    visit("odometry_error", p.odometry_error);
  }
};

/** \brief An image on a trajectory. */
struct TrajectoryPose {
  double stamp = 0;  ///< [s]
  Eigen::Isometry3d T_w_c = Eigen::Isometry3d::Identity();
  int keyframe = 0;  ///< the latest one, itself or before it
};

/** \brief A view on a trajectory that others are compared with. */
struct Keyframe {
  std::size_t image = 0;  ///< its number among the images
  std::shared_ptr<const View> view;
  PoseWithCovariance T_w_c;  ///< its covariance is relative to the first keyframe of its part
  int part = 0;              ///< number of the first keyframe that motions lead to
};

/** \brief Another motion between two keyframes that their images leave open. */
struct AlternativeMotion {
  PoseWithCovariance T_from_to;
  double log_odds = 0;  ///< against the likeliest motion, at most 0
};

/** \brief A motion between two keyframes by the images or by an odometry. */
struct KeyframeMotion {
  enum class Source {
    odometry,  ///< motion between consecutive images
    overlap,   ///< they show the same, and the trajectory knew that they would
    loop       ///< the trajectory has come back
  };
  int from = 0, to = 0;
  PoseWithCovariance T_from_to;
  Source source = Source::odometry;
  std::vector<AlternativeMotion> others{};
};

/** \brief Overlapping keyframes whose views confirm or contradict the relative pose of a trajectory. */
struct OverlapVerdicts {
  int confirmed = 0;
  int contradicted =
      0;  ///< depth disagrees there, or the views register beyond 1 deg or 0.1 m and their error

  int judged() const { return confirmed + contradicted; }
  double contradictedShare() const { return judged() > 0 ? double(contradicted) / judged() : 0; }
  /** \brief "1.4 % of 624 overlaps of images contradict it by more than 1 deg or 0.1 m". */
  std::string toString() const;
};

/** \brief Where a camera has been. Parts that nothing ties together have worlds of their own. */
struct CameraTrajectory {
  std::vector<TrajectoryPose> images;
  std::vector<Keyframe> keyframes;
  std::vector<KeyframeMotion> motions;  ///< that the poses come from
  OverlapVerdicts overlaps;             ///< comparisons of the keyframes
  int cut_bonds = 0;  ///< bonds between parts that were cut since overlaps contradicted them

  /** \brief Number of the first keyframe of its part. */
  int partOf(const TrajectoryPose& image) const { return keyframes[image.keyframe].part; }
  std::vector<int> parts() const;  ///< numbers of their first keyframes, the largest part first
  int loops() const;               ///< number of motions by which it has come back
  double length() const;           ///< path length [m], without the jumps between parts
  /** \brief Standard deviations of the least known position [m] and rotation [rad] of its keyframes, along
   * their least known axes, relative to the first keyframe of their part. */
  double positionStd() const;
  double rotationStd() const;
};

/** \brief Finds the trajectory of a depth camera, and nothing else is known: from image to image by
 * ViewOdometry, from keyframe to keyframe by planes and pixels from several starts, and back to where it was
 * by loops that confirm each other, all joined in a pose graph (METHOD 1.4).
 *
 *     facetloc::TrajectoryEstimation estimation;
 *     for (...) estimation.add(view, stamp);
 *     estimation.improve();
 *     for (const facetloc::TrajectoryPose& p : estimation.trajectory().images) ...
 *
 * The world of a camera whose mounting is known is its first robot's: x forward, z up, z = 0 on the floor; of
 * any other, its first optical frame. Same views, same trajectory, for any number of threads. */
class TrajectoryEstimation {
public:
  /** \brief Throws std::invalid_argument for a parameter out of its range. */
  explicit TrajectoryEstimation(const MappingParams& params = {});
  TrajectoryEstimation(TrajectoryEstimation&&) noexcept;
  TrajectoryEstimation& operator=(TrajectoryEstimation&&) noexcept;
  ~TrajectoryEstimation();

  /** \brief OpenMP threads; 1 by default, 0 = all cores. */
  void setNumberOfThreads(int n);
  /** \brief For a camera that is on for hours: at a place that has keyframes, the image is attached to one of
   * them instead of becoming another, also after the camera was covered and moved, and of the
   * other images only the latest is kept. Off by default; to be
   * called before the first image. */
  void setEndless(bool endless);
  /** \brief Takes the next image. \param stamp [s]; one that goes back counts as no time passed
   * \param motion of the camera since the image before, by another odometry, if there is one
   * \return true if it has become a keyframe. */
  bool add(View view, double stamp, const std::optional<Eigen::Isometry3d>& motion = {});
  /** \brief Where the latest image is, as known so far. */
  PoseWithCovariance latest() const;
  /** \brief The next image may show any other place: a recording begins again, somebody carries the camera.
   */
  void interrupt();
  int keyframes() const;
  /** \brief Number of the keyframe that the latest image is attached to. */
  int latestKeyframe() const;
  /** \brief Number of the first keyframe of the part that a keyframe belongs to. */
  int part(int keyframe) const;
  /** \brief T_w_c of a keyframe; its covariance is relative to the first one of its part. */
  const PoseWithCovariance& pose(int keyframe) const;

  /** \brief Compares keyframes with earlier ones, closes loops, and optimizes all poses, several times.
   * \param progress if given, is called with the share of the work that is done, from one thread
   * \param first number of the first keyframe that is compared; results for those before stay. */
  void improve(const std::function<void(double)>& progress = {}, int first = 0);
  /** \brief A copy, to be improved by another thread while images are added here. The views are shared. */
  TrajectoryEstimation clone() const;
  /** \brief Takes the poses and motions of the keyframes that a clone has, improved. Those that have been
   * added since move rigidly with the keyframe before them. Throws std::invalid_argument if the clone has
   * more keyframes than this. */
  void adopt(const TrajectoryEstimation& improved);
  CameraTrajectory trajectory() const;

private:
  struct Impl;
  explicit TrajectoryEstimation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace facetloc
