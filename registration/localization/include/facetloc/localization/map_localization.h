// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/organized_cloud.h>
#include <facetloc/localization/localizer.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/segmentation/view_builder.h>

#include <pcl/pcl_base.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Finds the camera of an organized cloud in a map: global localization as a PCL class.
 *
 *     facetloc::MapLocalization<pcl::PointXYZRGBA> localization;
 *     localization.setMap(std::make_shared<const facetloc::Map>(facetloc::openMap("office.flmap")));
 *     localization.setInputCloud(cloud);  // NaN is normal
 *     facetloc::PoseWithCovariance pose;  // the camera in the world
 *     if (localization.localize(pose)) use(pose.T, pose.P);
 *     else std::cout << localization.getReason();
 *
 * The cloud is in the optical frame of its camera (x right, y down, z forward); indices choose some of its
 * points. In sequence mode the clouds are those of one drive, and each is localized by all earlier ones as
 * well. */
template <typename PointT>
class MapLocalization : public pcl::PCLBase<PointT> {
public:
  using Ptr = pcl::shared_ptr<MapLocalization<PointT>>;
  using ConstPtr = pcl::shared_ptr<const MapLocalization<PointT>>;

  /** \brief The map, whose views may stay in its file; null takes it away. */
  void setMap(std::shared_ptr<const Map> map);
  /** \brief The camera of the clouds: noise, mounting and range; without intrinsics these are recovered from
   * the points. Nothing is known of it unless set; of the camera that made the map it is Map::camera. */
  void setCamera(const Camera& camera) { camera_ = camera, builder_.reset(); }
  const Camera& getCamera() const { return camera_; }
  /** \brief Throw std::invalid_argument for a parameter out of its range. */
  /// @{
  void setViewParams(const ViewParams& params) { view_params_ = checked(params), builder_.reset(); }
  void setLocalizationParams(const GlobalLocalizationParams& params) { params_ = checked(params), reset(); }
  void setLocalizerParams(const LocalizerParams& params) { localizer_params_ = checked(params), reset(); }
  /// @}
  /** \brief Width that clouds are subsampled to before segmentation [px]; 0 = full size. 320 unless set. */
  void setWorkingWidth(int width) { working_width_ = width, builder_.reset(); }
  /** \brief OpenMP threads; 1 unless set, 0 = all cores. */
  void setNumberOfThreads(int n);
  /** \brief Least probability of a pose that is sure; unless set, as the map was calibrated
   * (SureThreshold), else 0.9. Throws std::invalid_argument outside of (0, 1]. */
  void setMinProbability(double p);

  /** \brief Is each cloud one of a drive? The time of a cloud is its header's stamp [us]; a cloud without one
   * comes 1/30 s after the one before. */
  void setSequenceMode(bool on) { is_sequence_ = on, reset(); }
  /** \brief Begins a new drive. */
  void reset();

  /** \name Knowledge beside the cloud. */
  /// @{
  /** \brief Adds, in sequence mode, the camera's motion since the cloud before, or since the latest call, of
   * which several add up. One that is not finite makes the motion to the next cloud unknown.
   * \param T_before_now as an odometry measures it, of the camera; its covariance follows from
   * setOdometryError() and the mounting of the camera */
  void addMotion(const Eigen::Isometry3d& T_before_now);
  /** \brief The same with the covariance of the motion, as PoseWithCovariance has it. */
  void addMotion(const PoseWithCovariance& T_before_now);
  /** \brief How well an odometry measures motions. Throws std::invalid_argument for a parameter out of its
   * range. */
  void setOdometryError(const OdometryError& error) { odometry_error_ = checked(error); }
  /** \brief Gravity in the optical frame of the next cloud; nothing where it is unknown. Holds until it is
   * set anew. */
  void setGravity(const std::optional<Gravity>& gravity) { gravity_ = gravity; }
  /// @}

  /** \brief Localizes the input cloud. \param pose T_w_c with its covariance, order (phi, t), left and
   * decoupled: of the first hypothesis, be it sure or not; the identity and zeros without a hypothesis. It is
   * in the frame of getPart(): where that is not empty, of a part of the map that nothing ties to the world,
   * or of a map without a world; where the map places no local models, of the first hypothesis' one. \return
   * is it sure? Otherwise getReason() says why not. Never throws for the content of a cloud. */
  bool localize(PoseWithCovariance& pose);
  /** \brief Localizes with a guess, as in pcl::Registration::align(): a prior that decides among places that
   * look the same, and no result. In sequence mode, the drive begins anew there. \param guess T_w_c in the
   * frame of the part, with its covariance; positive definite, or getReason() says so \param part of the map
   * by its name; empty: the world */
  bool localize(PoseWithCovariance& pose, const PoseWithCovariance& guess, const std::string& part = {});
  /** \brief The pose alone. */
  bool localize(Eigen::Isometry3d& T_w_c);

  /** \name Of the latest cloud. */
  /// @{
  /** \brief All places where it may be, most probable first. */
  const std::vector<Hypothesis>& getHypotheses() const { return answer_.hypotheses; }
  /** \brief Probability of the first one; 0 without a hypothesis. */
  double getProbability() const {
    return answer_.hypotheses.empty() ? 0 : answer_.hypotheses.front().probability;
  }
  /** \brief Part of the map in whose frame the pose is; empty: the world, or there is no hypothesis. */
  std::string getPart() const;
  AnswerState getState() const { return answer_.state; }
  /** \brief Why it is not sure; empty if it is. */
  const std::string& getReason() const { return answer_.reason; }
  /** \brief All of it. */
  const Localization& getAnswer() const { return answer_; }
  /** \brief Its planes. */
  const View& getView() const { return view_; }
  /// @}

private:
  using pcl::PCLBase<PointT>::indices_;
  using pcl::PCLBase<PointT>::input_;
  using pcl::PCLBase<PointT>::use_indices_;

  bool see(std::string& why_not);
  Localizer& localizer();
  Localization answer(const std::optional<PoseWithCovariance>& guess, const std::string& part);
  bool localizeNear(const std::optional<PoseWithCovariance>& guess, const std::string& part,
                    PoseWithCovariance& pose);
  double nextStamp();

  std::shared_ptr<const Map> map_;
  Camera camera_;
  ViewParams view_params_;
  GlobalLocalizationParams params_;
  LocalizerParams localizer_params_;
  int working_width_ = kWorkingWidth;
  int threads_ = 1;
  std::optional<double> min_probability_;  // none = the map's
  bool is_sequence_ = false;

  // Made when they are first needed, and anew when something is set.
  std::optional<ViewBuilder> builder_;
  std::optional<Localizer> localizer_;
  std::optional<double> latest_stamp_;
  std::optional<PoseWithCovariance> motion_;  // since the cloud before
  bool is_motion_lost_ = false;
  std::optional<Gravity> gravity_;
  OdometryError odometry_error_;

  View view_;
  Localization answer_;
};

}  // namespace facetloc

#include <facetloc/localization/impl/map_localization.hpp>

extern template class facetloc::MapLocalization<pcl::PointXYZ>;
extern template class facetloc::MapLocalization<pcl::PointXYZI>;
extern template class facetloc::MapLocalization<pcl::PointXYZRGB>;
extern template class facetloc::MapLocalization<pcl::PointXYZRGBA>;
