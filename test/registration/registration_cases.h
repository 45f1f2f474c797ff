// SPDX-License-Identifier: BSD-3-Clause
// The common part of the tests of our pcl::Registration classes.
#pragma once

#include <facetloc/registration/ekf_registration.h>
#include <facetloc/registration/planar_registration.h>
#include <facetloc/testing/organized_clouds.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

namespace facetloc::test {

inline const Eigen::Isometry3d kTargetPose = lookingAlong({1.2, 1, 1.2}, {1, 1, -0.25});
inline const Eigen::Isometry3d kNearPose = lookingAlong({1.4, 1.2, 1.25}, {1.15, 1, -0.22});
inline const Eigen::Isometry3d kFarPose =
    lookingAlong({2.4, 1.0, 1.25}, {0.4, 1, -0.2});  // 1.2 m and 24 deg away

inline DepthImage imageFrom(const Eigen::Isometry3d& T_w_c, unsigned seed) {
  return noisy(render(largeRoom(), smallCamera(), T_w_c).image, SensorNoise{}.inverse_depth_std, seed);
}

struct EkfCase {
  using Point = SegmentFrame;
  /** A few bare planes fit by chance more often than nine times out of ten would allow. */
  static pcl::Registration<Point, Point>::Ptr make() {
    const auto registration = pcl::make_shared<EkfRegistration>();
    registration->setMinProbability(0.8);
    return registration;
  }
  static pcl::PointCloud<Point>::Ptr cloudFrom(const Eigen::Isometry3d& T_w_c, unsigned seed) {
    return pcl::make_shared<pcl::PointCloud<Point>>(
        toCloud(ViewBuilder().build(imageFrom(T_w_c, seed)).segments));
  }
  static constexpr double kMetres = 0.02, kDegrees = 0.5;
  static void setNarrowPrior(pcl::Registration<Point, Point>& r, const Matrix6d& P) {
    dynamic_cast<RankedRegistration<Point>&>(r).setPriorCovariance(P);
  }
};

template <typename PointT>
struct PlanarCase {
  using Point = PointT;
  static typename pcl::Registration<Point, Point>::Ptr make() {
    return pcl::make_shared<PlanarRegistration<Point>>();
  }
  static typename pcl::PointCloud<Point>::Ptr cloudFrom(const Eigen::Isometry3d& T_w_c, unsigned seed) {
    return organizedCloud<Point>(imageFrom(T_w_c, seed));
  }
  static constexpr double kMetres = 0.02, kDegrees = 0.5;
  static void setNarrowPrior(pcl::Registration<Point, Point>& r, const Matrix6d& P) {
    dynamic_cast<RankedRegistration<Point>&>(r).setPriorCovariance(P);
  }
};

template <class Case>
class RegistrationBase : public testing::Test {
protected:
  using Point = typename Case::Point;
  using Points = pcl::PointCloud<Point>;
  using Registration = pcl::Registration<Point, Point>;

  static Eigen::Isometry3d found(Registration& r) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.matrix() = r.getFinalTransformation().template cast<double>();
    T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
    return T;
  }
  static typename Points::Ptr cloudFrom(const Eigen::Isometry3d& T_w_c, unsigned seed) {
    return Case::cloudFrom(T_w_c, seed);
  }

  const Eigen::Isometry3d truth = kTargetPose.inverse() * kNearPose;
  static typename Points::Ptr commonTarget() {
    static const typename Points::Ptr cloud = cloudFrom(kTargetPose, 1);
    return cloud;
  }
  static typename Points::Ptr commonSource() {
    static const typename Points::Ptr cloud = cloudFrom(kNearPose, 2);
    return cloud;
  }
  const typename Points::ConstPtr target = commonTarget(), source = commonSource();
  const typename Registration::Ptr registration = Case::make();
  Points output;
};

}  // namespace facetloc::test
