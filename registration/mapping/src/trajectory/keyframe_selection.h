// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "motion/step_prior.h"
#include "motion/view_odometry.h"
#include "trajectory/trajectory_graph.h"

#include <deque>

namespace facetloc::internal {

/** \brief Image rhythm and speed of a camera, learned from its images so far. */
class CameraSpeed {
public:
  /** \brief Takes the time between two images [s]. */
  void addInterval(double dt);
  /** \brief Takes a motion that images have shown, and its duration [s]. */
  void addMotion(const Eigen::Isometry3d& T_before_after, double duration);

  /** \brief True for an interval that breaks the rhythm and takes the camera farther than consecutive images
   * can be expected to overlap. */
  bool isGap(double dt) const;
  /** \brief Upper bound of the distance that the camera covers in some time [m]. */
  double farthest(double duration) const;

private:
  std::deque<double> intervals_;  // latest ones
  double fastest_ = 0.25;         // [m/s]; slow walking pace until motions are known
  double fastest_turn_ = 0.25;    // [rad/s]
};

/** \brief Follows a camera from image to image, and decides which images become keyframes. */
class KeyframeSelection {
public:
  struct Image {
    double stamp;  // [s]
    int keyframe;
    Eigen::Isometry3d T_k_c;  // pose in its keyframe
  };
  using SharedView = std::shared_ptr<const View>;

  explicit KeyframeSelection(const MappingParams& params);
  void setEndless(bool endless) { endless_ = endless; }
  void interrupt() { interrupted_ = !images_.empty(); }
  /** \brief Takes the next image. \param given motion of the camera since the image before, by another
   * odometry \return true if it has become a keyframe of the graph. */
  bool add(const SharedView& view, double stamp, const std::optional<Eigen::Isometry3d>& given,
           TrajectoryGraph& graph);

  const std::vector<Image>& images() const { return images_; }
  const CameraSpeed& speed() const { return speed_; }
  /** \brief The keyframe that the latest image is attached to, and its position relative to that one. */
  int current() const { return current_; }
  const RelativePosition& position() const { return since_; }

private:
  RelativePosition stepBy(const ViewMotion& seen, double dt, const std::optional<Eigen::Isometry3d>& given,
                          const TrajectoryGraph& graph) const;
  void learnVelocity(const SharedView& before, const Eigen::Isometry3d& T_k_before, double dt,
                     const TrajectoryGraph& graph);
  RelativePosition place(const View& view, const RelativePosition& thought,
                         const TrajectoryGraph& graph) const;
  void compareWithKeyframe(const SharedView& view, const RelativePosition& step, TrajectoryGraph& graph);
  void addImage(double stamp, const Eigen::Isometry3d& T_k_c, const TrajectoryGraph& graph);
  bool beginAgain(const SharedView& view, double stamp, TrajectoryGraph& graph);
  bool attach(const SharedView& view, const RelativePosition& at, TrajectoryGraph& graph);
  bool attachToKnown(const View& view, const RelativePosition& at, const TrajectoryGraph& graph);
  void attachTo(int keyframe, const PoseWithCovariance& T_k_c);

  MappingParams params_;
  ViewOdometry odometry_;
  ViewPlacing placing_;
  CameraSpeed speed_;
  VelocityPrior velocity_;
  bool endless_ = false, interrupted_ = false;
  int run_ = 0;
  std::vector<Image> images_;
  int current_ = 0;         // keyframe that the latest image is attached to
  RelativePosition since_;  // relative to that keyframe
  SharedView latest_;
};

}  // namespace facetloc::internal
