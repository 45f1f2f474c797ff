// SPDX-License-Identifier: BSD-3-Clause
#include "pcl/segment_frames.h"
#include "registration_cases.h"

#include <facetloc/features/segment_estimation.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/random_segments.h>

#include <gmock/gmock.h>
#include <pcl/common/io.h>
#include <pcl/registration/correspondence_rejection_distance.h>

#include <limits>
#include <string>

namespace facetloc {
namespace {

using test::kNearPose, test::kTargetPose, test::PlanarCase, test::PoseNear;

Camera cameraOf(const Intrinsics& intrinsics) {
  Camera camera;
  camera.intrinsics = intrinsics;
  return camera;
}

TEST(PlanarRegistration, AnImpossibleCameraIsReported) {
  PlanarRegistration<pcl::PointXYZ> registration;
  registration.setInputSource(PlanarCase<pcl::PointXYZ>::cloudFrom(kTargetPose, 1));
  registration.setInputTarget(PlanarCase<pcl::PointXYZ>::cloudFrom(kTargetPose, 2));
  registration.setCamera(cameraOf(Intrinsics{320, 240, 0, 0, 0, 0}));
  pcl::PointCloud<pcl::PointXYZ> output;
  registration.align(output);
  EXPECT_FALSE(registration.hasConverged());
  EXPECT_EQ(registration.getReason(), "target: the camera that was set is impossible");
}

TEST(PlanarRegistration, IndicesOutsideTheCloudAreReportedAndIgnored) {
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
  EXPECT_NE(registration.getReason(), "");
  registration.setInputSource(target);
  registration.setInputTarget(unorganized);
  registration.align(output);
  EXPECT_FALSE(registration.hasConverged());
  EXPECT_NE(registration.getReason(), "");
}

TEST(PlanarRegistration, WorkingWidthIsAChoice) {
  using Case = PlanarCase<pcl::PointXYZ>;
  PlanarRegistration<pcl::PointXYZ> registration;
  registration.setInputSource(Case::cloudFrom(kNearPose, 2));
  registration.setInputTarget(Case::cloudFrom(kTargetPose, 1));
  registration.setCamera(cameraOf(test::smallCamera()));
  pcl::PointCloud<pcl::PointXYZ> output;
  for (const int width : {160, 0}) {
    registration.setWorkingWidth(width);
    registration.align(output);
    ASSERT_TRUE(registration.hasConverged()) << width;
    EXPECT_THAT(registration.getFinalPose(), PoseNear(kTargetPose.inverse() * kNearPose, 0.05, 0.8)) << width;
  }
}

/** A base pointer has no getReason(). */
TEST(PlanarRegistration, HasConvergedIfItIsSure) {
  using Case = PlanarCase<pcl::PointXYZ>;
  const auto registration = pcl::make_shared<PlanarRegistration<pcl::PointXYZ>>();
  const pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>::Ptr base = registration;
  base->setInputSource(Case::cloudFrom(kNearPose, 2));
  base->setInputTarget(Case::cloudFrom(kTargetPose, 1));
  pcl::PointCloud<pcl::PointXYZ> output;
  const auto printedByAlign = [&] {
    testing::internal::CaptureStderr();
    base->align(output);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(printedByAlign(), "");
  EXPECT_TRUE(base->hasConverged());
  EXPECT_EQ(registration->getState(), AnswerState::sure);
  const double probability = registration->getProbability();
  EXPECT_GE(probability, registration->getMinProbability());
  EXPECT_LT(probability, 1);

  registration->setMinProbability((1 + probability) / 2);
  EXPECT_THAT(printedByAlign(), testing::HasSubstr("PlanarRegistration::align] doubtful"));
  EXPECT_FALSE(base->hasConverged());
  EXPECT_THAT(registration->getFinalPose(), PoseNear(kTargetPose.inverse() * kNearPose, 0.02, 0.5))
      << "a guess is better than none";

  base->setInputTarget(pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>());
  EXPECT_THAT(printedByAlign(), testing::HasSubstr("PlanarRegistration::align] "));
  EXPECT_EQ(registration->getState(), AnswerState::unknown);
  EXPECT_EQ(registration->getProbability(), 0);
  EXPECT_THROW(registration->setMinProbability(0), std::invalid_argument);
  EXPECT_THROW(registration->setMinProbability(1.01), std::invalid_argument);
}

// A filtered cloud has an answer with the camera that saw it.
TEST(PlanarRegistration, FilteredCloudsAreRegisteredByTheirCamera) {
  const auto filtered = [](const Eigen::Isometry3d& T_w_c, unsigned seed) {
    const auto cloud = test::organizedCloud<pcl::PointXYZ>(test::imageFrom(T_w_c, seed));
    auto left = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
    for (const pcl::PointXYZ& p : *cloud)
      if (pcl::isXYZFinite(p)) left->push_back(p);
    return left;
  };
  PlanarRegistration<pcl::PointXYZ> registration;
  Camera camera;
  camera.intrinsics = test::smallCamera();
  registration.setCamera(camera);
  registration.setInputSource(filtered(test::kNearPose, 2));
  registration.setInputTarget(filtered(test::kTargetPose, 1));
  pcl::PointCloud<pcl::PointXYZ> aligned;
  registration.align(aligned);
  ASSERT_TRUE(registration.hasConverged()) << registration.getReason();
  const Eigen::Isometry3d truth = test::kTargetPose.inverse() * test::kNearPose;
  EXPECT_LT((registration.getFinalPose().translation() - truth.translation()).norm(), 0.02);
}

// The picture of a camera that is turned by a quarter about its optical axis.
pcl::PointCloud<pcl::PointXYZ>::Ptr rolled(const pcl::PointCloud<pcl::PointXYZ>& cloud) {
  auto turned = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>(cloud.height, cloud.width);
  for (std::uint32_t v = 0; v < cloud.height; ++v)
    for (std::uint32_t u = 0; u < cloud.width; ++u) {
      const pcl::PointXYZ& p = cloud(u, v);
      (*turned)(cloud.height - 1 - v, u) = {-p.y, p.x, p.z};
    }
  return turned;
}

TEST(PlanarRegistration, CloudsOfATurnedCameraAreRegistered) {
  const auto source = PlanarCase<pcl::PointXYZ>::cloudFrom(kNearPose, 2);
  PlanarRegistration<pcl::PointXYZ> registration;
  registration.setInputSource(rolled(*source));
  registration.setInputTarget(PlanarCase<pcl::PointXYZ>::cloudFrom(kTargetPose, 1));
  pcl::PointCloud<pcl::PointXYZ> aligned;
  registration.align(aligned);
  ASSERT_TRUE(registration.hasConverged()) << registration.getReason();
  const Eigen::Isometry3d quarter(Eigen::AngleAxisd(-EIGEN_PI / 2, Eigen::Vector3d::UnitZ()));
  const Eigen::Isometry3d error =
      registration.getFinalPose().inverse() * kTargetPose.inverse() * kNearPose * quarter;
  EXPECT_LT(error.translation().norm(), 0.02);
  EXPECT_LT(rotationAngle(error.linear()), 1 * kDegree);

  registration.setPriorCovariance(posePrior({}));  // states that the camera is not turned
  registration.align(aligned);
  EXPECT_FALSE(registration.hasConverged());
}

TEST(PlanarRegistration, RejectorsOfCorrespondencesAreRefused) {
  PlanarRegistration<pcl::PointXYZ> registration;
  registration.setInputSource(PlanarCase<pcl::PointXYZ>::cloudFrom(kNearPose, 2));
  registration.setInputTarget(PlanarCase<pcl::PointXYZ>::cloudFrom(kTargetPose, 1));
  registration.addCorrespondenceRejector(
      pcl::make_shared<pcl::registration::CorrespondenceRejectorDistance>());
  pcl::PointCloud<pcl::PointXYZ> aligned;
  registration.align(aligned);
  EXPECT_FALSE(registration.hasConverged());
  EXPECT_THAT(registration.getReason(), testing::HasSubstr("use EkfRegistration"));
}

TEST(PlanarRegistration, ALongMaxCorrespondenceDistanceChangesNothing) {
  PlanarRegistration<pcl::PointXYZ> registration;
  registration.setInputSource(PlanarCase<pcl::PointXYZ>::cloudFrom(kNearPose, 2));
  registration.setInputTarget(PlanarCase<pcl::PointXYZ>::cloudFrom(kTargetPose, 1));
  pcl::PointCloud<pcl::PointXYZ> aligned;
  registration.align(aligned);
  const Eigen::Matrix4f before = registration.getFinalTransformation();
  ASSERT_TRUE(registration.hasConverged());
  registration.setMaxCorrespondenceDistance(100);
  registration.align(aligned);
  EXPECT_TRUE(registration.hasConverged());
  EXPECT_EQ(registration.getFinalTransformation(), before);
}

using namespace internal;
using test::Rng, testing::IsEmpty, testing::UnorderedElementsAre;

pcl::PointCloud<SegmentFrame> randomFrames(int n) {
  Rng rng(1);
  pcl::PointCloud<SegmentFrame> cloud;
  for (int i = 0; i < n; ++i) cloud.push_back(toSegmentFrame(test::randomSegment(rng)));
  return cloud;
}

TEST(SegmentFrames, ComeInTheOrderOfInformationWithTheirIndex) {
  const pcl::PointCloud<SegmentFrame> cloud = randomFrames(20);
  const RankedFrames ranked = rankedSegments(cloud, nullptr);
  ASSERT_EQ(ranked.segments.size(), 20u);
  ASSERT_EQ(ranked.index.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(ranked.segments[i].num_points, cloud[ranked.index[i]].num_points);
    EXPECT_EQ(rankByInformation(ranked.segments)[i], static_cast<int>(i));
  }
}

TEST(SegmentFrames, InvalidFramesAreLeftOut) {
  pcl::PointCloud<SegmentFrame> cloud = randomFrames(5);
  cloud[1].x = std::numeric_limits<float>::quiet_NaN();
  cloud[3] = SegmentFrame{};
  EXPECT_THAT(rankedSegments(cloud, nullptr).index, UnorderedElementsAre(0, 2, 4));
}

TEST(SegmentFrames, IndicesChooseAndThoseOutsideTheCloudAreIgnored) {
  const pcl::PointCloud<SegmentFrame> cloud = randomFrames(5);
  const pcl::Indices some{4, -1, 2, 5, 1000000};
  EXPECT_THAT(rankedSegments(cloud, &some).index, UnorderedElementsAre(2, 4));
  const pcl::Indices none;
  EXPECT_THAT(rankedSegments(cloud, &none).index, IsEmpty());
  EXPECT_THAT(rankedSegments({}, nullptr).segments, IsEmpty());
}

}  // namespace
}  // namespace facetloc
