// SPDX-License-Identifier: BSD-3-Clause
#include "opened_map.h"
#include "ranking/global_localization.h"

#include <facetloc/localization/map_localization.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/organized_clouds.h>
#include <facetloc/testing/synthetic_views.h>

#include <gmock/gmock.h>

namespace facetloc {
namespace {

using test::onCircle, testing::HasSubstr;

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

Cloud::Ptr cloudFrom(const Eigen::Isometry3d& T_w_c, unsigned seed) {
  const DepthImage image = test::render(test::largeRoom(), test::smallCamera(), T_w_c, 20).image;
  return test::organizedCloud<pcl::PointXYZ>(test::noisy(image, SensorNoise{}.inverse_depth_std, seed));
}

class MapLocalizationInARoom : public testing::Test {
protected:
  static void SetUpTestSuite() { map = test::openedMap(*test::roomMap()); }
  static void TearDownTestSuite() { map.reset(); }
  void SetUp() override { localization.setMap(map); }
  static inline std::shared_ptr<const Map> map;
  MapLocalization<pcl::PointXYZ> localization;
};

TEST_F(MapLocalizationInARoom, FindsTheCameraOfACloud) {
  int sure = 0;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Isometry3d truth = onCircle(10 + 60 * i, 0.6);
    localization.setInputCloud(cloudFrom(truth, i));
    PoseWithCovariance pose;
    if (!localization.localize(pose)) {
      EXPECT_NE(localization.getReason(), "");
      continue;
    }
    ++sure;
    EXPECT_TRUE(isNear(pose.T, truth, 0.05, 1)) << i;
    EXPECT_GE(localization.getProbability(), 0.9);
    EXPECT_EQ(localization.getState(), AnswerState::sure);
    EXPECT_EQ(localization.getReason(), "");
    EXPECT_EQ(pose.P.llt().info(), Eigen::Success);
    EXPECT_FALSE(localization.getView().segments.empty());
    ASSERT_FALSE(localization.getHypotheses().empty());
    EXPECT_TRUE(localization.getHypotheses()[0].T_w_c->isApprox(pose.T));
  }
  EXPECT_GE(sure, 4);
}

TEST_F(MapLocalizationInARoom, AnswersAsTheCoreDoes) {
  const Eigen::Isometry3d truth = onCircle(100, 0.5);
  const Cloud::Ptr cloud = cloudFrom(truth, 3);
  localization.setInputCloud(cloud);
  Eigen::Isometry3d T;
  localization.localize(T);
  const Localization core = internal::GlobalLocalization(map).localize(localization.getView());
  ASSERT_EQ(localization.getHypotheses().size(), core.hypotheses.size());
  for (std::size_t i = 0; i < core.hypotheses.size(); ++i) {
    EXPECT_EQ(localization.getHypotheses()[i].probability, core.hypotheses[i].probability);
    EXPECT_TRUE(localization.getHypotheses()[i].T_w_c->isApprox(*core.hypotheses[i].T_w_c, 1e-12));
  }
}

TEST_F(MapLocalizationInARoom, CloudsAreOneDriveInSequenceMode) {
  localization.setSequenceMode(true);
  Localizer core(map);
  for (int i = 0; i < 8; ++i) {
    const Eigen::Isometry3d truth = onCircle(10 + 3.6 * i, 0.6);
    const Cloud::Ptr cloud = cloudFrom(truth, i);
    cloud->header.stamp = 1000000 + 100000 * static_cast<std::uint64_t>(i);
    localization.setInputCloud(cloud);
    PoseWithCovariance pose;
    const bool is_sure = localization.localize(pose);
    const Localization answer = core.update(localization.getView(), 1 + 0.1 * i);
    EXPECT_EQ(localization.getState(), answer.state) << i;
    EXPECT_EQ(localization.getHypotheses().size(), answer.hypotheses.size()) << i;
    if (is_sure) {
      EXPECT_TRUE(isNear(pose.T, truth, 0.1, 2)) << i;
    }
    EXPECT_TRUE(is_sure || i < 6) << localization.getReason();
  }
  // A new drive remembers nothing of the last one.
  localization.reset();
  localization.setInputCloud(cloudFrom(onCircle(200, 0.6), 50));
  Eigen::Isometry3d T;
  localization.localize(T);
  const Localization first = Localizer(map).update(localization.getView(), 0);
  EXPECT_EQ(localization.getHypotheses().size(), first.hypotheses.size());
}

PoseWithCovariance guessNear(const Eigen::Isometry3d& T_w_c) {
  PoseWithCovariance guess{Eigen::Translation3d(0.3, -0.2, 0) * T_w_c, Matrix6d::Identity()};
  guess.P.topLeftCorner<3, 3>() *= 30 * kDegree * 30 * kDegree;
  return guess;
}

TEST_F(MapLocalizationInARoom, AGuessIsAPriorAndNoResult) {
  const Eigen::Isometry3d truth = onCircle(70, 0.6);
  localization.setInputCloud(cloudFrom(truth, 1));
  PoseWithCovariance pose = guessNear(truth);
  EXPECT_TRUE(localization.localize(pose, pose)) << localization.getReason();
  EXPECT_TRUE(isNear(pose.T, truth, 0.05, 1)) << "by the cloud, not by the guess";
  EXPECT_EQ(localization.getPart(), "");
  if (localization.localize(pose, guessNear(onCircle(250, 0.6)))) {
    EXPECT_TRUE(isNear(pose.T, truth, 0.05, 1));
  }

  EXPECT_FALSE(localization.localize(pose, PoseWithCovariance()));
  EXPECT_THAT(localization.getReason(), HasSubstr("positive definite"));
  EXPECT_FALSE(localization.localize(pose, guessNear(truth), "attic"));
  EXPECT_THAT(localization.getReason(), HasSubstr("no part 'attic'"));
}

TEST_F(MapLocalizationInARoom, MotionsAreOfTheCameraSinceTheCloudBefore) {
  localization.setSequenceMode(true);
  Localizer core(map);
  const OdometryError error;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Isometry3d before = onCircle(10 + 20 * (i - 1), 0.6), truth = onCircle(10 + 20 * i, 0.6);
    const Eigen::Isometry3d between = onCircle(20 * i, 0.6);
    const Eigen::Isometry3d first = before.inverse() * between, second = between.inverse() * truth;
    localization.addMotion(first);
    localization.addMotion(second);
    const Cloud::Ptr cloud = cloudFrom(truth, static_cast<unsigned>(i));
    cloud->header.stamp = 1000000 * static_cast<std::uint64_t>(i + 1);
    localization.setInputCloud(cloud);
    PoseWithCovariance pose;
    localization.localize(pose);
    const Localization answer =
        core.update(localization.getView(), i + 1,
                    motionByOdometry(first, {}, error) * motionByOdometry(second, {}, error));
    EXPECT_EQ(localization.getState(), answer.state) << i;
    ASSERT_EQ(localization.getHypotheses().size(), answer.hypotheses.size()) << i;
    EXPECT_TRUE(localization.getAnswer().T_before_now.T.isApprox(answer.T_before_now.T, 1e-12)) << i;
  }
}

TEST_F(MapLocalizationInARoom, ItKnowsItsPartInAMapWithoutAWorld) {
  const auto in_part = std::make_shared<Map>(*map);
  in_part->parts = {"attic"};
  const Eigen::Isometry3d truth = onCircle(130, 0.6);
  MapLocalization<pcl::PointXYZ> in_world;
  in_world.setMap(map);
  localization.setMap(in_part);
  PoseWithCovariance pose, there;
  in_world.setInputCloud(cloudFrom(truth, 2));
  localization.setInputCloud(cloudFrom(truth, 2));
  const bool is_sure = in_world.localize(pose);
  EXPECT_EQ(localization.localize(there), is_sure) << localization.getReason();
  EXPECT_EQ(localization.getPart(), "attic");
  EXPECT_TRUE(there.T.isApprox(pose.T, 1e-12));
  EXPECT_TRUE(localization.localize(there, guessNear(truth), "attic")) << localization.getReason();
  EXPECT_FALSE(localization.localize(there, guessNear(truth))) << "its parts are not the world";
}

TEST_F(MapLocalizationInARoom, CloudsWithoutStampsFollowEachOther) {
  localization.setSequenceMode(true);
  bool is_sure = false;
  for (int i = 0; i < 8; ++i) {
    localization.setInputCloud(cloudFrom(onCircle(10 + 1.2 * i, 0.6), i));
    Eigen::Isometry3d T;
    is_sure = localization.localize(T);
    EXPECT_THAT(localization.getReason(), testing::Not(HasSubstr("back"))) << "a stamp that goes back";
  }
  EXPECT_TRUE(is_sure) << localization.getReason();
}

TEST_F(MapLocalizationInARoom, IndicesChooseThePoints) {
  const Cloud::Ptr cloud = cloudFrom(onCircle(100, 0.5), 3);
  localization.setInputCloud(cloud);
  Eigen::Isometry3d T;
  localization.localize(T);
  const std::size_t all = localization.getView().segments.size();
  auto upper = pcl::make_shared<pcl::Indices>();
  for (int i = 0; i < static_cast<int>(cloud->size()) / 3; ++i) upper->push_back(i);
  localization.setIndices(upper);
  localization.localize(T);
  EXPECT_LT(localization.getView().segments.size(), all);
  upper->push_back(static_cast<int>(cloud->size()));
  EXPECT_FALSE(localization.localize(T));
  EXPECT_THAT(localization.getReason(), HasSubstr("indices"));
}

TEST_F(MapLocalizationInARoom, AFailureHasAReasonAndLeavesNoStaleAnswer) {
  localization = MapLocalization<pcl::PointXYZ>();
  Eigen::Isometry3d T = onCircle(1, 1);
  EXPECT_FALSE(localization.localize(T));
  EXPECT_THAT(localization.getReason(), HasSubstr("no map"));
  EXPECT_TRUE(T.isApprox(Eigen::Isometry3d::Identity()));
  localization.setMap(map);
  EXPECT_FALSE(localization.localize(T));
  EXPECT_THAT(localization.getReason(), HasSubstr("no input cloud"));
  localization.setInputCloud(cloudFrom(onCircle(100, 0.5), 3));
  localization.localize(T);
  ASSERT_FALSE(localization.getHypotheses().empty());
  auto scattered = pcl::make_shared<Cloud>();
  scattered->push_back({1, 2, 3});
  for (const bool in_sequence : {false, true}) {
    localization.setSequenceMode(in_sequence);
    localization.setInputCloud(scattered);
    EXPECT_FALSE(localization.localize(T));
    EXPECT_THAT(localization.getReason(), HasSubstr("organized"));
    EXPECT_TRUE(localization.getHypotheses().empty());
    EXPECT_EQ(localization.getProbability(), 0);
    EXPECT_EQ(localization.getState(), AnswerState::unknown);
  }
  localization.setMap(std::make_shared<const Map>());
  localization.setInputCloud(cloudFrom(onCircle(100, 0.5), 3));
  EXPECT_FALSE(localization.localize(T));
  EXPECT_NE(localization.getReason(), "");
  EXPECT_THROW(localization.setMinProbability(0), std::invalid_argument);
  EXPECT_THROW(localization.setMinProbability(1.1), std::invalid_argument);
}

TEST_F(MapLocalizationInARoom, SettersCountFromTheNextCloudOn) {
  localization.setInputCloud(cloudFrom(onCircle(10, 0.6), 0));
  PoseWithCovariance pose;
  localization.localize(pose);
  localization.setMinProbability(1);
  EXPECT_FALSE(localization.localize(pose));
  EXPECT_THAT(localization.getReason(), HasSubstr("doubtful"));
  Camera camera;
  camera.intrinsics = {10, 10, 10, 10, 5, 5};
  localization.setCamera(camera);
  EXPECT_FALSE(localization.localize(pose));
  EXPECT_THAT(localization.getReason(), HasSubstr("size"));
}

}  // namespace
}  // namespace facetloc
