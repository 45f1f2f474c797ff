// SPDX-License-Identifier: BSD-3-Clause
// Promises of every pcl::Registration, tested through pointers to PCL's base class. PCL's own ICP runs
// along as a control.

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Warray-bounds"  // GCC 12 about Eigen's umeyama inside PCL's ICP
#endif

#include "registration_cases.h"

#include <gmock/gmock.h>
#include <pcl/registration/icp.h>

#include <cmath>

namespace facetloc {
namespace {

using test::EkfCase, test::imageFrom, test::kFarPose, test::kTargetPose, test::PlanarCase, test::PoseNear,
    test::RegistrationBase;

struct IcpCase {
  using Point = pcl::PointXYZ;
  static pcl::Registration<Point, Point>::Ptr make() {
    auto icp = pcl::make_shared<pcl::IterativeClosestPoint<Point, Point>>();
    icp->setMaxCorrespondenceDistance(0.2);
    icp->setMaximumIterations(40);
    return icp;
  }
  static pcl::PointCloud<Point>::Ptr cloudFrom(const Eigen::Isometry3d& T_w_c, unsigned seed) {
    auto cloud = pcl::make_shared<pcl::PointCloud<Point>>();
    const DepthImage image = imageFrom(T_w_c, seed);
    for (int v = 0; v < image.camera.height; v += 6)
      for (int u = 0; u < image.camera.width; u += 6)
        if (image.at(u, v) > 0) {
          const Eigen::Vector3d p = double(image.at(u, v)) * image.camera.ray(u, v);
          cloud->emplace_back(float(p.x()), float(p.y()), float(p.z()));
        }
    return cloud;
  }
  static constexpr double kMetres = 0.1, kDegrees = 3;  // ICP slides where the views differ
  static void setNarrowPrior(pcl::Registration<Point, Point>&, const Matrix6d&) {}
};

template <class Case>
class AnyRegistration : public RegistrationBase<Case> {};
using AnyCases = testing::Types<EkfCase, PlanarCase<pcl::PointXYZ>, IcpCase>;
TYPED_TEST_SUITE(AnyRegistration, AnyCases, );  // the comma for -Wpedantic of Clang

TYPED_TEST(AnyRegistration, FindsThePoseOfTheSourceInTheTarget) {
  this->registration->setInputSource(this->source);
  this->registration->setInputTarget(this->target);
  const Eigen::Matrix4f guess = this->truth.matrix().template cast<float>();
  this->registration->align(this->output, guess);
  EXPECT_TRUE(this->registration->hasConverged());
  EXPECT_THAT(this->found(*this->registration),
              PoseNear(this->truth, TypeParam::kMetres, TypeParam::kDegrees));
}

TYPED_TEST(AnyRegistration, AGuessLeadsWhereTheIdentityDoesNot) {
  const Eigen::Isometry3d far_truth = kTargetPose.inverse() * kFarPose;
  Matrix6d narrow = Matrix6d::Zero();
  narrow.diagonal() << Eigen::Vector3d::Constant(std::pow(4 * kDegree, 2)), Eigen::Vector3d::Constant(0.01);
  TypeParam::setNarrowPrior(*this->registration, narrow);
  this->registration->setInputSource(this->cloudFrom(kFarPose, 3));
  this->registration->setInputTarget(this->target);
  this->registration->align(this->output);
  EXPECT_THAT(this->found(*this->registration), testing::Not(PoseNear(far_truth, 0.2, 5.0)));
  const Eigen::Matrix4f guess =
      boxplus(far_truth, (Vector6d() << 0.02, -0.02, 0.01, 0.04, 0.02, -0.03).finished())
          .matrix()
          .cast<float>();
  this->registration->align(this->output, guess);
  EXPECT_TRUE(this->registration->hasConverged());
  EXPECT_THAT(this->found(*this->registration), PoseNear(far_truth, TypeParam::kMetres, TypeParam::kDegrees));
}

TYPED_TEST(AnyRegistration, TheOutputIsTheTransformedSource) {
  this->registration->setInputSource(this->source);
  this->registration->setInputTarget(this->target);
  this->registration->align(this->output);
  ASSERT_TRUE(this->registration->hasConverged());
  ASSERT_EQ(this->output.size(), this->source->size());
  EXPECT_EQ(this->output.width, this->source->width);
  EXPECT_EQ(this->output.height, this->source->height);
  const Eigen::Isometry3f T(this->registration->getFinalTransformation());
  for (std::size_t i = 0; i < this->output.size(); ++i) {
    const auto& p = (*this->source)[i];
    if (!std::isfinite(p.x)) continue;
    EXPECT_LT((this->output[i].getVector3fMap() - T * p.getVector3fMap()).norm(), 1e-4);
  }
}

TYPED_TEST(AnyRegistration, ASecondCallDoesNotDependOnTheFirst) {
  this->registration->setInputSource(this->source);
  this->registration->setInputTarget(this->target);
  this->registration->align(this->output);
  const Eigen::Matrix4f once = this->registration->getFinalTransformation();
  this->registration->align(this->output);
  EXPECT_EQ(this->registration->getFinalTransformation(), once);
  this->registration->setInputSource(this->cloudFrom(kFarPose, 3));
  this->registration->align(this->output);
  this->registration->setInputSource(this->source);
  this->registration->align(this->output);
  EXPECT_EQ(this->registration->getFinalTransformation(), once);
}

TYPED_TEST(AnyRegistration, SwappedCloudsGiveTheInversePose) {
  this->registration->setInputSource(this->source);
  this->registration->setInputTarget(this->target);
  this->registration->align(this->output, this->truth.matrix().template cast<float>());
  const Eigen::Isometry3d there = this->found(*this->registration);
  this->registration->setInputSource(this->target);
  this->registration->setInputTarget(this->source);
  this->registration->align(this->output, this->truth.inverse().matrix().template cast<float>());
  ASSERT_TRUE(this->registration->hasConverged());
  EXPECT_THAT(this->found(*this->registration).inverse(),
              PoseNear(there, 2 * TypeParam::kMetres, 2 * TypeParam::kDegrees));
}

TYPED_TEST(AnyRegistration, FitnessScoreIsThereForTheAsking) {
  this->registration->setInputSource(this->source);
  this->registration->setInputTarget(this->target);
  this->registration->align(this->output);
  const double good = this->registration->getFitnessScore();
  EXPECT_GE(good, 0);
  EXPECT_TRUE(std::isfinite(good));
  this->registration->setInputTarget(this->source);  // the tree behind it follows the target
  this->registration->setInputSource(this->source);
  this->registration->align(this->output);
  EXPECT_LT(this->registration->getFitnessScore(), 1e-3);
}

}  // namespace
}  // namespace facetloc
