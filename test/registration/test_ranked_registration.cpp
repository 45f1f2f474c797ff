// SPDX-License-Identifier: BSD-3-Clause
// Promises of our pcl::Registration classes beyond PCL's, tested through pointers to PCL's base class.
#include "registration_cases.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

using test::EkfCase, test::PlanarCase, test::PoseNear, test::RegistrationBase;

template <class Case>
class OurRegistration : public RegistrationBase<Case> {
protected:
  using typename RegistrationBase<Case>::Point;
  using typename RegistrationBase<Case>::Points;
  RankedRegistration<Point>& ranked() {
    return dynamic_cast<RankedRegistration<Point>&>(*this->registration);
  }

  void setGoodClouds() {
    this->registration->setInputSource(this->source);
    this->registration->setInputTarget(this->target);
  }
  void alignGoodClouds() {
    setGoodClouds();
    this->registration->align(this->output);
    ASSERT_TRUE(this->registration->hasConverged());
    ASSERT_FALSE(ranked().getHypotheses().empty());
    ASSERT_EQ(ranked().getReason(), "");
  }
  void expectNoAnswer() {
    EXPECT_FALSE(this->registration->hasConverged());
    EXPECT_EQ(this->registration->getFinalTransformation(), Eigen::Matrix4f::Identity());
    EXPECT_TRUE(ranked().getHypotheses().empty());
    EXPECT_EQ(ranked().getFinalPose().matrix(), Eigen::Matrix4d::Identity());
    EXPECT_TRUE(ranked().getFinalCovariance().isZero());
    EXPECT_NE(ranked().getReason(), "");
  }
  void expectFound() {
    EXPECT_THAT(this->found(*this->registration), PoseNear(this->truth, Case::kMetres, Case::kDegrees));
  }
  void expectNoAnswerNow() {
    this->registration->align(this->output);
    expectNoAnswer();
  }
  void expectNoAnswerFor(const typename Points::ConstPtr& bad) {
    alignGoodClouds();
    this->registration->setInputSource(bad);
    expectNoAnswerNow();
    alignGoodClouds();
    this->registration->setInputTarget(bad);
    expectNoAnswerNow();
    alignGoodClouds();  // and all is well again
  }
};
using OurCases = testing::Types<EkfCase, PlanarCase<pcl::PointXYZ>, PlanarCase<pcl::PointXYZI>,
                                PlanarCase<pcl::PointXYZRGB>, PlanarCase<pcl::PointXYZRGBA>>;
TYPED_TEST_SUITE(OurRegistration, OurCases, );  // the comma for -Wpedantic of Clang

TYPED_TEST(OurRegistration, NeedsNoGuess) {
  this->alignGoodClouds();
  this->expectFound();
}

TYPED_TEST(OurRegistration, IndicesChooseThePointsOfTheSourceAndOfTheOutput) {
  auto indices = pcl::make_shared<pcl::Indices>();
  for (std::size_t i = 0; i < this->source->size(); ++i)
    if (this->source->size() < 100 || i % 8 != 0) indices->push_back(static_cast<int>(i));
  if (this->source->size() < 100) indices->pop_back();  // the least informative frame
  this->setGoodClouds();
  this->registration->setIndices(indices);
  this->registration->align(this->output);
  EXPECT_TRUE(this->registration->hasConverged());
  EXPECT_EQ(this->output.size(), indices->size());
  this->expectFound();
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
    EXPECT_THAT(this->ranked().getReason(), testing::HasSubstr("the indices do not fit the cloud"));
  }
  // They fitted the cloud before.
  this->registration->setIndices(pcl::make_shared<pcl::Indices>(pcl::Indices{0, size - 1}));
  auto smaller = pcl::make_shared<typename TestFixture::Points>(*this->source);
  smaller->resize(smaller->size() / 2);
  this->registration->setInputSource(smaller);
  this->expectNoAnswerNow();
}

TYPED_TEST(OurRegistration, IndicesHoldForEveryCloudThatTheyFit) {
  const auto size = this->source->size();
  const auto chosen = pcl::make_shared<pcl::Indices>();
  for (std::size_t i = 0; i + 1 < size; ++i) chosen->push_back(static_cast<int>(i));
  const auto alignedPoints = [this] {
    this->registration->align(this->output);
    EXPECT_TRUE(this->registration->hasConverged()) << this->ranked().getReason();
    return this->output.size();
  };
  this->alignGoodClouds();
  this->registration->setIndices(chosen);
  EXPECT_EQ(alignedPoints(), size - 1);
  // A frame without points, or with too few, is no reason to forget them.
  this->registration->setInputSource(pcl::make_shared<typename TestFixture::Points>());
  this->expectNoAnswerNow();
  this->registration->setInputSource(this->source);
  EXPECT_EQ(alignedPoints(), size - 1);
  // No indices mean all points, also after wrong ones and for clouds of any size.
  this->registration->setIndices(pcl::make_shared<pcl::Indices>(pcl::Indices{-1}));
  this->registration->setIndices(pcl::IndicesPtr());
  EXPECT_EQ(alignedPoints(), size);
  const auto one = pcl::make_shared<typename TestFixture::Points>(1, 1, this->source->front());
  this->registration->setInputSource(one);
  this->registration->align(this->output);
  EXPECT_THAT(this->ranked().getReason(), testing::Not(testing::HasSubstr("indices")));
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
    EXPECT_THAT(this->ranked().getReason(), testing::HasSubstr("no rigid motion"));
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

TYPED_TEST(OurRegistration, FitnessOfASampleIsThatOfAllPoints) {
  this->alignGoodClouds();
  const double of_sample = this->ranked().getFitnessScore(), of_all = this->registration->getFitnessScore();
  EXPECT_NEAR(of_sample, of_all, 0.05 * of_all);
  constexpr double kNear = 1e-4;  // [m^2]
  const double near = this->registration->getFitnessScore(kNear);
  EXPECT_LT(near, kNear);
  EXPECT_NEAR(this->ranked().getFitnessScore(kNear), near, 0.05 * near);
}

TYPED_TEST(OurRegistration, MaxCorrespondenceDistanceIsThatOfThePlanes) {
  const Eigen::Matrix4f guess = this->truth.matrix().template cast<float>();
  this->alignGoodClouds();
  this->registration->setMaxCorrespondenceDistance(0.1);
  this->registration->align(this->output, guess);
  ASSERT_TRUE(this->registration->hasConverged());
  this->expectFound();
  this->registration->setMaxCorrespondenceDistance(1e-9);
  this->registration->align(this->output, guess);
  this->expectNoAnswer();
  EXPECT_THAT(this->ranked().getReason(), testing::HasSubstr("no correspondence"));
}

TYPED_TEST(OurRegistration, SettersWithoutEffectAreSaidOnce) {
  const auto timesSaid = [this] {
    testing::internal::CaptureStderr();
    this->alignGoodClouds();
    this->registration->align(this->output);
    const std::string said = testing::internal::GetCapturedStderr();
    return std::pair(said.find("no effect") != std::string::npos,
                     said.find("no effect") != said.rfind("no effect"));
  };
  EXPECT_EQ(timesSaid(), std::pair(false, false));
  this->registration->setMaximumIterations(50);
  EXPECT_EQ(timesSaid(), std::pair(true, false));
  EXPECT_EQ(timesSaid(), std::pair(false, false));
}

TEST(PlanarRegistration, ACopyAnswersTheSame) {
  using Case = PlanarCase<pcl::PointXYZ>;
  PlanarRegistration<pcl::PointXYZ> registration;
  registration.setInputTarget(Case::cloudFrom(test::kTargetPose, 1));
  registration.setInputSource(Case::cloudFrom(test::kNearPose, 2));
  pcl::PointCloud<pcl::PointXYZ> output;
  registration.align(output);
  PlanarRegistration<pcl::PointXYZ> copy = registration;
  EXPECT_EQ(copy.getFinalPose().matrix(), registration.getFinalPose().matrix());
  copy.align(output);
  EXPECT_EQ(copy.getFinalPose().matrix(), registration.getFinalPose().matrix());
}

TEST(PlanarRegistration, ReadsItsTargetOnceForManySources) {
  struct Counting : PlanarRegistration<pcl::PointXYZ> {
    View makeView(const pcl::PointCloud<pcl::PointXYZ>& cloud, const pcl::Indices* indices,
                  std::string& why_empty) override {
      ++views;
      return PlanarRegistration::makeView(cloud, indices, why_empty);
    }
    int views = 0;
  } registration;
  using Case = PlanarCase<pcl::PointXYZ>;
  const auto target = Case::cloudFrom(test::kTargetPose, 1);
  const pcl::PointCloud<pcl::PointXYZ>::Ptr sources[] = {Case::cloudFrom(test::kNearPose, 2),
                                                         Case::cloudFrom(test::kFarPose, 3)};
  registration.setInputTarget(target);
  pcl::PointCloud<pcl::PointXYZ> output;
  for (const auto& source : sources) {
    registration.setInputSource(source);
    registration.align(output);
    PlanarRegistration<pcl::PointXYZ> fresh;
    fresh.setInputTarget(target);
    fresh.setInputSource(source);
    fresh.align(output);
    EXPECT_EQ(registration.getFinalPose().matrix(), fresh.getFinalPose().matrix());
  }
  EXPECT_EQ(registration.views, 3);
  const auto viewsOfAlign = [&] {
    const int before = registration.views;
    registration.align(output);
    return registration.views - before;
  };
  EXPECT_EQ(viewsOfAlign(), 1);
  registration.setWorkingWidth(0);
  EXPECT_EQ(viewsOfAlign(), 2);
  registration.setCamera(registration.getCamera());
  EXPECT_EQ(viewsOfAlign(), 2);
  registration.setViewParams(registration.getViewParams());
  EXPECT_EQ(viewsOfAlign(), 2);
  registration.setRegistrationParams(registration.getRegistrationParams());
  EXPECT_EQ(viewsOfAlign(), 2);
  registration.setInputTarget(target);
  EXPECT_EQ(viewsOfAlign(), 2);
}

TYPED_TEST(OurRegistration, ParametersOutOfTheirRangeAreRefused) {
  RegistrationParams params;
  params.evidence.hypotheses = -1;
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
  this->expectNoAnswerNow();
  this->registration->setInputSource(this->source);
  this->expectNoAnswerNow();
}

TYPED_TEST(OurRegistration, APriorThatExcludesTheTruthHasNoAnswer) {
  this->setGoodClouds();
  Matrix6d P = 1e-6 * Matrix6d::Identity();
  this->ranked().setPriorCovariance(P);
  EXPECT_EQ(this->ranked().getPriorCovariance(), P);
  this->expectNoAnswerNow();
}

}  // namespace
}  // namespace facetloc
