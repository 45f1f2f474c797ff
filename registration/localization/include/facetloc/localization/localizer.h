// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/registration/hypothesis.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A view of a drive, as Localizer::update() took it, and its answer. */
struct DriveView {
  View view;
  double stamp = 0;                          ///< [s]
  std::optional<PoseWithCovariance> motion;  ///< as it was given, T_before_now
  Localization answer;                       ///< the views up to this one decide
};

/** \brief The same map for joined() views: each local model is joined with those whose surfaces the other
 * cameras would see from there, when it is first asked for. \param sides T_v_c of the other cameras */
std::shared_ptr<const Map> mapForRig(std::shared_ptr<const Map> map, std::vector<Eigen::Isometry3d> sides);

/** \brief Localizes a camera in a map: from one view, or from all views of a moving camera so far, where
 * later views may resolve the ambiguity of one, such as one of a bare wall.
 *
 *     facetloc::Localizer localizer(map);
 *     for (...) {
 *       const facetloc::Localization answer = localizer.update(builder.build(image), stamp);
 *       if (answer.state == facetloc::AnswerState::sure) use(*answer.T_w_c);
 *     }
 *
 * Holds a belief: places with covariances and odds, and that the camera is nowhere in the map. It moves with
 * the camera, by the views themselves and by an odometry if there is one, and every view that is new enough
 * is compared with each of its places and registered near them, where it may fit better (METHOD 3.5). As
 * long as no place is sure, such views are searched in the whole map. Between them, a place that holds nearly
 * all of the belief is followed by the planes and pixels around it, and a robot by its floor (METHOD 3.1). A
 * view that is sure on its own, of the first place, makes the answer sure. A view that fixes no pose still
 * excludes places; views that repeat the same add nothing. Its size does not grow
 * with time. Same views, stamps and odometry, same answers, for any number of threads. */
class Localizer {
public:
  /** \brief Throws std::invalid_argument for a parameter out of its range, and for a SureThreshold of the map
   * that is impossible. */
  explicit Localizer(std::shared_ptr<const Map> map, const LocalizerParams& params = {},
                     const GlobalLocalizationParams& localization = {});
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;
  ~Localizer();

  /** \brief The place of a single view. Remembers nothing; thread-safe. */
  Localization localize(const View& view) const;
  /** \brief The place of a single view with a given approximate pose: a prior that decides among places that
   * look the same. A view that contradicts it is believed more. Throws the exceptions of setPose(), and
   * std::logic_error with score.by_overlap. \param T_w_c in the frame of the part \param part of the map */
  Localization localize(const View& view, const PoseWithCovariance& T_w_c, int part = 0) const;

  /** \brief The turn of the robot, or the metres, that would most likely make an answer sure, by the views
   * that the map expects at its places; where these say nothing, by the view, with a gain of 0 (METHOD 3.7).
   * Remembers nothing; takes about as long as a search, and is not called by the others. \param view of the
   * answer; the mounting of its camera makes the turn one of the robot, else it is one of the camera about
   * gravity, or about the vertical axis of its image \param answer of localize(), or the latest of update()
   * \return nothing for an answer that is sure, has not searched the map, or has no probabilities */
  std::optional<NextLook> nextLook(const View& view, const Localization& answer) const;

  /** \brief Takes the next view of a moving camera. Any view and any stamp [s] have an answer. A stamp that
   * goes back starts anew, and so does a view that has nothing in common with the one before, unless an
   * odometry tells how the camera has come there and the map does not deny it.
   * \param motion of the camera since the view before, T_before_now, with its covariance: of a robot's
   * wheels, for instance (motionByOdometry()); one that is not finite is none
   * Throws std::logic_error with score.by_overlap, whose scores have no probabilities. */
  Localization update(View view, double stamp, const std::optional<PoseWithCovariance>& motion = {});
  /** \brief The same for a depth image with its intrinsics; of several pixels one, to be about 320 wide. */
  Localization update(const DepthImage& image, double stamp,
                      const std::optional<PoseWithCovariance>& motion = {});
  /** \brief The places of all views of a drive by all of them, later ones included (METHOD 3.6), in their
   * order. Takes as long as the drive did, and remembers nothing. \param drive its views as update() of an
   * object with this map and these parameters took them \param done is called after each view, and may throw
   */
  std::vector<Localization> smoothed(const std::vector<DriveView>& drive,
                                     const std::function<void()>& done = {}) const;
  /** \brief Forgets all views. */
  void reset();
  /** \brief Forgets all views, and takes it that the camera is about there now, at the view that comes next:
   * where it is put in the morning, or was before a restart. Views that deny it are believed more. A
   * standard deviation above 60 deg about the z axis leaves the heading open: all are equally likely. Throws
   * std::invalid_argument for a covariance that is not positive definite, and for a part that is not in the
   * map. \param T_w_c in the frame of the part \param part of the map */
  void setPose(const PoseWithCovariance& T_w_c, int part = 0);

  /** \brief The camera of clouds and depth images: noise, mounting and range; without intrinsics they are
   * recovered from the points of a cloud. By default nothing is known of it. */
  void setCamera(const Camera& camera);
  const Camera& camera() const;
  /** \brief Least probability of a first place that is sure; by default the one that the map was calibrated
   * for (SureThreshold), else kMinProbability. Throws std::invalid_argument outside of (0, 1]. */
  void setMinProbability(double p);
  /** \brief OpenMP threads; 1 by default, 0 = all cores. */
  void setNumberOfThreads(int n);

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/** \brief The probability that the view is of each of several maps (joinMaps()), by name; empty for one map.
 */
std::map<std::string, double> probabilitiesOfMaps(const Localization& answer, const Map& map);

}  // namespace facetloc
