// SPDX-License-Identifier: BSD-3-Clause
// What every pcl::Registration of ours promises, tested through pointers to PCL's base class. PCL's own ICP
// runs along as a control wherever it makes the same promise.

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Warray-bounds"  // GCC 12 about Eigen's umeyama inside PCL's ICP
#endif

#include <facetloc/registration/ekf_registration.h>
#include <facetloc/registration/planar_registration.h>
#include <facetloc/testing/organized_clouds.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>
#include <pcl/registration/icp.h>

#include <cmath>
#include <limits>

namespace facetloc {
namespace {

using test::lookingAlong;
using test::PoseNear;

const Eigen::Isometry3d kTargetPose = lookingAlong({1.2, 1, 1.2}, {1, 1, -0.25});
const Eigen::Isometry3d kNearPose = lookingAlong({1.4, 1.2, 1.25}, {1.15, 1, -0.22});
const Eigen::Isometry3d kFarPose = lookingAlong({2.4, 1.0, 1.25}, {0.4, 1, -0.2});  // 1.2 m and 24 deg away

DepthImage imageFrom(const Eigen::Isometry3d& T_w_c, unsigned seed) {
  return test::noisy(test::render(test::largeRoom(), test::smallCamera(), T_w_c).image,
                     SensorNoise{}.inverse_depth_std, seed);
}

struct EkfCase {
  using Point = SegmentFrame;
  static pcl::Registration<Point, Point>::Ptr make() { return pcl::make_shared<EkfRegistration>(); }
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
    return test::organizedCloud<Point>(imageFrom(T_w_c, seed));
  }
  static constexpr double kMetres = 0.02, kDegrees = 0.5;
  static void setNarrowPrior(pcl::Registration<Point, Point>& r, const Matrix6d& P) {
    dynamic_cast<RankedRegistration<Point>&>(r).setPriorCovariance(P);
  }
};

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

// ---- promises that ICP makes as well

template <class Case>
class AnyRegistration : public RegistrationBase<Case> {};
using AnyCases = testing::Types<EkfCase, PlanarCase<pcl::PointXYZ>, IcpCase>;
TYPED_TEST_SUITE(AnyRegistration, AnyCases);

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
      perturbed(far_truth, (Vector6d() << 0.02, -0.02, 0.01, 0.04, 0.02, -0.03).finished())
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

// ---- promises of ours

template <class Case>
class OurRegistration : public RegistrationBase<Case> {
protected:
  using typename RegistrationBase<Case>::Point;
  using typename RegistrationBase<Case>::Points;
  RankedRegistration<Point>& ranked() {
    return dynamic_cast<RankedRegistration<Point>&>(*this->registration);
  }

  void alignGoodClouds() {
    this->registration->setInputSource(this->source);
    this->registration->setInputTarget(this->target);
    this->registration->align(this->output);
    ASSERT_TRUE(this->registration->hasConverged());
    ASSERT_FALSE(ranked().getHypotheses().empty());
    ASSERT_EQ(ranked().getStatus(), "");
  }
  void expectNoAnswer() {
    EXPECT_FALSE(this->registration->hasConverged());
    EXPECT_EQ(this->registration->getFinalTransformation(), Eigen::Matrix4f::Identity());
    EXPECT_TRUE(ranked().getHypotheses().empty());
    EXPECT_EQ(ranked().getFinalPose().matrix(), Eigen::Matrix4d::Identity());
    EXPECT_TRUE(ranked().getFinalCovariance().isZero());
    EXPECT_NE(ranked().getStatus(), "");
  }
  void expectNoAnswerFor(const typename Points::ConstPtr& bad) {
    alignGoodClouds();
    this->registration->setInputSource(bad);
    this->registration->align(this->output);
    expectNoAnswer();
    alignGoodClouds();
    this->registration->setInputTarget(bad);
    this->registration->align(this->output);
    expectNoAnswer();
    alignGoodClouds();  // and all is well again
  }
};
using OurCases = testing::Types<EkfCase, PlanarCase<pcl::PointXYZ>, PlanarCase<pcl::PointXYZI>,
                                PlanarCase<pcl::PointXYZRGB>, PlanarCase<pcl::PointXYZRGBA>>;
TYPED_TEST_SUITE(OurRegistration, OurCases);

TYPED_TEST(OurRegistration, NeedsNoGuess) {
  this->alignGoodClouds();
  EXPECT_THAT(this->found(*this->registration),
              PoseNear(this->truth, TypeParam::kMetres, TypeParam::kDegrees));
}

TYPED_TEST(OurRegistration, IndicesChooseThePointsOfTheSourceAndOfTheOutput) {
  auto indices = pcl::make_shared<pcl::Indices>();
  for (std::size_t i = 0; i < this->source->size(); ++i)
    if (this->source->size() < 100 || i % 8 != 0) indices->push_back(static_cast<int>(i));
  if (this->source->size() < 100) indices->pop_back();  // the least informative frame
  this->registration->setInputSource(this->source);
  this->registration->setInputTarget(this->target);
  this->registration->setIndices(indices);
  this->registration->align(this->output);
  EXPECT_TRUE(this->registration->hasConverged());
  EXPECT_EQ(this->output.size(), indices->size());
  EXPECT_THAT(this->found(*this->registration),
              PoseNear(this->truth, TypeParam::kMetres, TypeParam::kDegrees));
}

TEST(PlanarRegistration, ACameraThatCannotBeIsToldAsSuch) {
  PlanarRegistration<pcl::PointXYZ> registration;
  registration.setInputSource(PlanarCase<pcl::PointXYZ>::cloudFrom(kTargetPose, 1));
  registration.setInputTarget(PlanarCase<pcl::PointXYZ>::cloudFrom(kTargetPose, 2));
  registration.setIntrinsics(Intrinsics{320, 240, 0, 0, 0, 0});
  pcl::PointCloud<pcl::PointXYZ> output;
  registration.align(output);
  EXPECT_FALSE(registration.hasConverged());
  EXPECT_EQ(registration.getStatus(), "target: the camera that was set is impossible");
}

TEST(PlanarRegistration, IndicesOutsideTheCloudAreToldNotUsed) {
  struct Opened : PlanarRegistration<pcl::PointXYZ> {
    using PlanarRegistration::makeView;
  };
  const auto cloud = PlanarCase<pcl::PointXYZ>::cloudFrom(kTargetPose, 1);
  for (const int bad : {-1, static_cast<int>(cloud->size())}) {
    const pcl::Indices indices{0, bad};
    std::string why;
    EXPECT_TRUE(Opened().makeView(*cloud, &indices, why).segments.empty());
    EXPECT_EQ(why, "the indices do not fit the cloud");
  }
}

TYPED_TEST(OurRegistration, HasTheAnswerInDoublePrecisionWithItsCovariance) {
  this->alignGoodClouds();
  const Eigen::Isometry3d pose = this->ranked().getFinalPose();
  EXPECT_THAT(Eigen::Matrix3d(pose.linear()), test::IsRotation());
  EXPECT_EQ(Eigen::Matrix4f(pose.matrix().template cast<float>()),
            this->registration->getFinalTransformation());
  const Matrix6d P = this->ranked().getFinalCovariance();
  EXPECT_THAT(P, test::IsPositiveSemidefinite(1e-15));
  EXPECT_GT(P.trace(), 0);
  EXPECT_LT(std::sqrt(P.trace()), 0.1);
  double sum = 0, before = std::numeric_limits<double>::infinity();
  for (const Hypothesis& h : this->ranked().getHypotheses()) {
    EXPECT_LE(h.score, before);
    before = h.score;
    sum += h.probability;
  }
  EXPECT_LE(sum, 1);
}

TYPED_TEST(OurRegistration, EmptyAndMissingCloudsLeaveNothingOfTheCallBefore) {
  this->expectNoAnswerFor(nullptr);
  this->expectNoAnswerFor(pcl::make_shared<typename TestFixture::Points>());
}

TYPED_TEST(OurRegistration, CloudsWithoutAValidPointLeaveNothingOfTheCallBefore) {
  auto nan = pcl::make_shared<typename TestFixture::Points>(*this->source);
  for (auto& p : *nan) p.x = p.y = p.z = std::numeric_limits<float>::quiet_NaN();
  this->expectNoAnswerFor(nan);
}

TYPED_TEST(OurRegistration, IndicesWithoutAUsablePointLeaveNothingOfTheCallBefore) {
  this->alignGoodClouds();
  this->registration->setIndices(pcl::make_shared<pcl::Indices>(pcl::Indices{0}));
  this->registration->align(this->output);
  EXPECT_EQ(this->output.size(), 1u);
  this->expectNoAnswer();
}

TYPED_TEST(OurRegistration, IndicesOutsideTheSourceLeaveNothingOfTheCallBefore) {
  const int size = static_cast<int>(this->source->size());
  this->alignGoodClouds();
  for (const int bad : {-1, size, 100000000}) {
    this->registration->setIndices(pcl::make_shared<pcl::Indices>(pcl::Indices{0, bad}));
    this->registration->align(this->output);
    EXPECT_TRUE(this->output.empty());
    this->expectNoAnswer();
    EXPECT_THAT(this->ranked().getStatus(), testing::HasSubstr("the indices do not fit the cloud"));
  }
  // They fitted the cloud before.
  this->registration->setIndices(pcl::make_shared<pcl::Indices>(pcl::Indices{0, size - 1}));
  auto smaller = pcl::make_shared<typename TestFixture::Points>(*this->source);
  smaller->resize(smaller->size() / 2);
  this->registration->setInputSource(smaller);
  this->registration->align(this->output);
  this->expectNoAnswer();
}

TYPED_TEST(OurRegistration, IndicesHoldForEveryCloudThatTheyFit) {
  const auto size = this->source->size();
  const auto chosen = pcl::make_shared<pcl::Indices>();
  for (std::size_t i = 0; i + 1 < size; ++i) chosen->push_back(static_cast<int>(i));
  const auto alignedPoints = [this] {
    this->registration->align(this->output);
    EXPECT_TRUE(this->registration->hasConverged()) << this->ranked().getStatus();
    return this->output.size();
  };
  this->alignGoodClouds();
  this->registration->setIndices(chosen);
  EXPECT_EQ(alignedPoints(), size - 1);
  // A frame without points, or with too few, is no reason to forget them.
  this->registration->setInputSource(pcl::make_shared<typename TestFixture::Points>());
  this->registration->align(this->output);
  this->expectNoAnswer();
  this->registration->setInputSource(this->source);
  EXPECT_EQ(alignedPoints(), size - 1);
  // No indices mean all points, also after wrong ones and for clouds of any size.
  this->registration->setIndices(pcl::make_shared<pcl::Indices>(pcl::Indices{-1}));
  this->registration->setIndices(pcl::IndicesPtr());
  EXPECT_EQ(alignedPoints(), size);
  const auto one = pcl::make_shared<typename TestFixture::Points>(1, 1, this->source->front());
  this->registration->setInputSource(one);
  this->registration->align(this->output);
  EXPECT_THAT(this->ranked().getStatus(), testing::Not(testing::HasSubstr("indices")));
  this->registration->setInputSource(this->source);
  EXPECT_EQ(alignedPoints(), size);
}

TYPED_TEST(OurRegistration, AGuessThatIsNoPoseHasNoAnswerAndMovesNothing) {
  Eigen::Matrix4f mirror = Eigen::Matrix4f::Identity(), scale = mirror, sheared = mirror;
  mirror(0, 0) = -1;
  scale.topLeftCorner<3, 3>() *= 5;
  sheared(3, 0) = 1;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Eigen::Matrix4f& guess : {Eigen::Matrix4f(Eigen::Matrix4f::Constant(nan)),
                                       Eigen::Matrix4f(Eigen::Matrix4f::Zero()), mirror, scale, sheared}) {
    this->alignGoodClouds();
    this->registration->align(this->output, guess);
    this->expectNoAnswer();
    EXPECT_THAT(this->ranked().getStatus(), testing::HasSubstr("no rigid motion"));
    ASSERT_EQ(this->output.size(), this->source->size());
    for (std::size_t i = 0; i < this->output.size(); i += 97) {
      if (!pcl::isXYZFinite((*this->source)[i])) continue;
      EXPECT_EQ(this->output[i].getVector3fMap(), (*this->source)[i].getVector3fMap());
    }
  }
}

TYPED_TEST(OurRegistration, FitnessOfCloudsWithHolesOrOfNoneIsNoCrash) {
  const auto withHoles = [](const auto& cloud) {
    auto holes = pcl::make_shared<typename TestFixture::Points>(*cloud);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (std::size_t i = 9; i < holes->size(); i += 10) (*holes)[i].x = (*holes)[i].y = (*holes)[i].z = nan;
    holes->is_dense = false;
    return holes;
  };
  const auto searched = withHoles(this->target);
  this->registration->setInputSource(withHoles(this->source));
  this->registration->setInputTarget(searched);
  this->registration->align(this->output);
  ASSERT_TRUE(this->registration->hasConverged());
  EXPECT_LT(this->registration->getFitnessScore(), 1);
  const auto tree = this->registration->getSearchMethodTarget();
  EXPECT_EQ(tree->getInputCloud(), searched);
  pcl::Indices neighbours;
  std::vector<float> squared_distances;
  EXPECT_EQ(tree->nearestKSearch(1, 1, neighbours, squared_distances), 1);
  this->registration->setInputSource(nullptr);
  this->registration->align(this->output);
  EXPECT_TRUE(this->output.empty());
  EXPECT_EQ(this->registration->getFitnessScore(), std::numeric_limits<double>::max());
  auto nothing = pcl::make_shared<typename TestFixture::Points>(*this->target);
  for (auto& p : *nothing) p.x = p.y = p.z = std::numeric_limits<float>::quiet_NaN();
  nothing->is_dense = false;
  this->registration->setInputSource(this->source);
  this->registration->setInputTarget(nothing);
  this->registration->align(this->output);
  EXPECT_EQ(this->registration->getFitnessScore(), std::numeric_limits<double>::max());
}

TYPED_TEST(OurRegistration, ParametersOutOfTheirRangeAreRefused) {
  GlobalLocalizationParams params;
  params.ranking.evidence_models = -1;
  EXPECT_THROW(this->ranked().setRegistrationParams(params), std::invalid_argument);
}

TYPED_TEST(OurRegistration, ForgetsItsAnswerAsSoonAsACloudChanges) {
  this->alignGoodClouds();
  this->registration->setInputSource(this->source);
  this->expectNoAnswer();
  this->alignGoodClouds();
  this->registration->setInputTarget(this->target);
  this->expectNoAnswer();
}

TYPED_TEST(OurRegistration, CallsBeforeAnyCloudAreNoCrash) {
  this->registration->align(this->output);
  this->expectNoAnswer();
  this->registration->setInputSource(this->source);
  this->registration->align(this->output);
  this->expectNoAnswer();
}

TYPED_TEST(OurRegistration, APriorThatExcludesTheTruthHasNoAnswer) {
  this->registration->setInputSource(this->source);
  this->registration->setInputTarget(this->target);
  Matrix6d P = 1e-6 * Matrix6d::Identity();
  this->ranked().setPriorCovariance(P);
  EXPECT_EQ(this->ranked().getPriorCovariance(), P);
  this->registration->align(this->output);
  this->expectNoAnswer();
}

TEST(PlanarRegistration, TurnsTheNormalsOfTheSource) {
  const auto cloudWithNormals = [](const Eigen::Isometry3d& T_w_c, unsigned seed) {
    const auto points = PlanarCase<pcl::PointXYZ>::cloudFrom(T_w_c, seed);
    auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointNormal>>();
    pcl::copyPointCloud(*points, *cloud);
    for (auto& p : *cloud) p.normal_x = 0, p.normal_y = 0, p.normal_z = -1;
    return cloud;
  };
  PlanarRegistration<pcl::PointNormal> registration;
  registration.setInputSource(cloudWithNormals(kNearPose, 2));
  registration.setInputTarget(cloudWithNormals(kTargetPose, 1));
  pcl::PointCloud<pcl::PointNormal> aligned;
  registration.align(aligned);
  ASSERT_TRUE(registration.hasConverged());
  const Eigen::Vector3d turned = -registration.getFinalPose().linear().col(2);
  EXPECT_LT((aligned[0].getNormalVector3fMap().cast<double>() - turned).norm(), 1e-6);
}

// ---- what is particular

TEST(EkfRegistration, OutputFramesAreTurnedAsWellAsMoved) {
  EkfRegistration registration;
  const auto source = EkfCase::cloudFrom(kNearPose, 2), target = EkfCase::cloudFrom(kTargetPose, 1);
  registration.setInputSource(source);
  registration.setInputTarget(target);
  pcl::PointCloud<SegmentFrame> output;
  registration.align(output);
  ASSERT_TRUE(registration.hasConverged());
  ASSERT_EQ(output.size(), source->size());
  for (std::size_t i = 0; i < output.size(); ++i) {
    const SegmentFrame want = transformed((*source)[i], registration.getFinalPose());
    EXPECT_LT((output[i].getVector3fMap() - want.getVector3fMap()).norm(), 1e-5);
    EXPECT_LT((output[i].normal() - want.normal()).norm(), 1e-5);
    EXPECT_EQ(output[i].num_points, (*source)[i].num_points);
    for (int k = 0; k < 6; ++k) EXPECT_EQ(output[i].sigma_q[k], (*source)[i].sigma_q[k]);
  }
}

TEST(EkfRegistration, InvalidFramesAmongGoodOnesAreLeftOut) {
  EkfRegistration registration;
  const auto source = EkfCase::cloudFrom(kNearPose, 2), target = EkfCase::cloudFrom(kTargetPose, 1);
  source->push_back(SegmentFrame{});
  source->push_back((*source)[0]);
  source->back().sigma_q[0] = std::numeric_limits<float>::quiet_NaN();
  target->insert(target->begin(), SegmentFrame{});
  registration.setInputSource(source);
  registration.setInputTarget(target);
  pcl::PointCloud<SegmentFrame> output;
  registration.align(output);
  ASSERT_TRUE(registration.hasConverged());
  EXPECT_THAT(registration.getFinalPose(), PoseNear(kTargetPose.inverse() * kNearPose, 0.02, 0.5));
  EXPECT_EQ(output.size(), source->size());
}

TEST(EkfRegistration, HasItsName) {
  EXPECT_EQ(EkfRegistration().getClassName(), "EkfRegistration");
  EXPECT_EQ(PlanarRegistration<pcl::PointXYZ>().getClassName(), "PlanarRegistration");
}

TEST(PlanarRegistration, UnorganizedCloudsHaveNoAnswer) {
  using Case = PlanarCase<pcl::PointXYZ>;
  PlanarRegistration<pcl::PointXYZ> registration;
  auto unorganized = Case::cloudFrom(kNearPose, 2);
  unorganized->width *= unorganized->height;
  unorganized->height = 1;
  const auto target = Case::cloudFrom(kTargetPose, 1);
  pcl::PointCloud<pcl::PointXYZ> output;
  registration.setInputSource(unorganized);
  registration.setInputTarget(target);
  registration.align(output);
  EXPECT_FALSE(registration.hasConverged());
  EXPECT_NE(registration.getStatus(), "");
  registration.setInputSource(target);
  registration.setInputTarget(unorganized);
  registration.align(output);
  EXPECT_FALSE(registration.hasConverged());
  EXPECT_NE(registration.getStatus(), "");
}

TEST(PlanarRegistration, WorkingWidthIsAChoice) {
  using Case = PlanarCase<pcl::PointXYZ>;
  PlanarRegistration<pcl::PointXYZ> registration;
  registration.setInputSource(Case::cloudFrom(kNearPose, 2));
  registration.setInputTarget(Case::cloudFrom(kTargetPose, 1));
  registration.setIntrinsics(test::smallCamera());
  pcl::PointCloud<pcl::PointXYZ> output;
  for (const int width : {160, 0}) {
    registration.setWorkingWidth(width);
    registration.align(output);
    ASSERT_TRUE(registration.hasConverged()) << width;
    EXPECT_THAT(registration.getFinalPose(), PoseNear(kTargetPose.inverse() * kNearPose, 0.05, 0.8)) << width;
  }
}

}  // namespace
}  // namespace facetloc
