// SPDX-License-Identifier: BSD-3-Clause
#include "registration_cases.h"

#include <facetloc/registration/segment_matching.h>

#include <gmock/gmock.h>
#include <pcl/registration/correspondence_estimation.h>
#include <pcl/registration/correspondence_rejection.h>

#include <limits>
#include <set>
#include <utility>

namespace facetloc {
namespace {

using test::EkfCase, test::kNearPose, test::kTargetPose, test::PoseNear;

TEST(EkfRegistration, OutputFramesAreTurnedAsWellAsMoved) {
  EkfRegistration registration;
  const auto source = EkfCase::cloudFrom(kNearPose, 2), target = EkfCase::cloudFrom(kTargetPose, 1);
  registration.setInputSource(source);
  registration.setInputTarget(target);
  pcl::PointCloud<SegmentFrame> output;
  registration.align(output);
  ASSERT_NE(registration.getState(), AnswerState::unknown);
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
  ASSERT_NE(registration.getState(), AnswerState::unknown);
  EXPECT_THAT(registration.getFinalPose(), PoseNear(kTargetPose.inverse() * kNearPose, 0.02, 0.5));
  EXPECT_EQ(output.size(), source->size());
}

// Keeps the pairs of a list, and looks at the points that PCL's protocol hands over.
class ChosenPairs : public pcl::registration::CorrespondenceRejector {
public:
  using Ptr = pcl::shared_ptr<ChosenPairs>;
  ChosenPairs() { rejection_name_ = "ChosenPairs"; }
  void getRemainingCorrespondences(const pcl::Correspondences& all, pcl::Correspondences& left) override {
    left.clear();
    for (const pcl::Correspondence& c : all)
      if (keep.count({c.index_query, c.index_match})) left.push_back(c);
    given = all;
  }
  bool requiresSourcePoints() const override { return true; }
  void setSourcePoints(pcl::PCLPointCloud2::ConstPtr cloud) override {
    pcl::fromPCLPointCloud2(*cloud, source_points);
  }
  bool requiresTargetNormals() const override { return true; }
  void setTargetNormals(pcl::PCLPointCloud2::ConstPtr cloud) override {
    pcl::fromPCLPointCloud2(*cloud, target_normals);
  }

  std::set<std::pair<int, int>> keep;
  pcl::Correspondences given;
  pcl::PointCloud<SegmentFrame> source_points, target_normals;

protected:
  void applyRejection(pcl::Correspondences& left) override {
    getRemainingCorrespondences(*input_correspondences_, left);
  }
};

class ChosenCorrespondences : public testing::Test {
protected:
  ChosenCorrespondences() {
    registration.setMinProbability(0.8);
    registration.setInputSource(source);
    registration.setInputTarget(target);
  }
  // The pairs of the answer, as indices of the clouds, which are sorted by information.
  std::set<std::pair<int, int>> pairsOfTheAnswer() const {
    std::set<std::pair<int, int>> pairs;
    for (const SegmentPair& p : registration.getHypotheses().front().pairs) pairs.insert({p.scene, p.model});
    return pairs;
  }
  const Eigen::Isometry3d truth = kTargetPose.inverse() * kNearPose;
  const pcl::PointCloud<SegmentFrame>::Ptr source = EkfCase::cloudFrom(kNearPose, 2),
                                           target = EkfCase::cloudFrom(kTargetPose, 1);
  EkfRegistration registration;
  pcl::PointCloud<SegmentFrame> output;
};

TEST_F(ChosenCorrespondences, OurMatchingGivesTheAnswerThatThereIsWithoutIt) {
  registration.align(output);
  ASSERT_TRUE(registration.hasConverged());
  const Eigen::Isometry3d without = registration.getFinalPose();
  registration.setCorrespondenceEstimation(pcl::make_shared<SegmentMatching>());
  registration.align(output);
  ASSERT_TRUE(registration.hasConverged());
  EXPECT_THAT(registration.getFinalPose(), PoseNear(without, 1e-6, 1e-4));
}

TEST_F(ChosenCorrespondences, RejectedPairsTakeNoPart) {
  registration.align(output);
  const auto all = pairsOfTheAnswer();
  ASSERT_GT(all.size(), 5u);
  const auto rejector = pcl::make_shared<ChosenPairs>();
  for (auto it = all.begin(); rejector->keep.size() < all.size() - 2; ++it) rejector->keep.insert(*it);
  registration.addCorrespondenceRejector(rejector);
  registration.align(output);
  ASSERT_NE(registration.getState(), AnswerState::unknown);
  EXPECT_THAT(registration.getFinalPose(), PoseNear(truth, 0.02, 0.5));
  EXPECT_EQ(pairsOfTheAnswer(), rejector->keep);
  EXPECT_GT(rejector->given.size(), all.size());  // many for each frame
  EXPECT_EQ(rejector->source_points.size(), source->size());
  ASSERT_EQ(rejector->target_normals.size(), target->size());
  EXPECT_EQ(rejector->target_normals[0].normal(), target->front().normal());
}

TEST_F(ChosenCorrespondences, WithoutAnyPairThereIsNoAnswer) {
  registration.addCorrespondenceRejector(pcl::make_shared<ChosenPairs>());
  registration.align(output);
  EXPECT_FALSE(registration.hasConverged());
  EXPECT_THAT(registration.getReason(), testing::HasSubstr("no correspondence"));
  registration.clearCorrespondenceRejectors();
  registration.align(output);
  EXPECT_TRUE(registration.hasConverged());
}

TEST_F(ChosenCorrespondences, EstimationsOfPclGetTheSourceWhereTheGuessPutsIt) {
  using Nearest = pcl::registration::CorrespondenceEstimation<SegmentFrame, SegmentFrame>;
  registration.setCorrespondenceEstimation(pcl::make_shared<Nearest>());
  registration.align(output, truth.matrix().cast<float>());
  ASSERT_NE(registration.getState(), AnswerState::unknown);
  EXPECT_THAT(registration.getFinalPose(), PoseNear(truth, 0.05, 1));
  Nearest nearest;
  nearest.setInputSource(pcl::make_shared<pcl::PointCloud<SegmentFrame>>(transformed(*source, truth)));
  nearest.setInputTarget(target);
  pcl::Correspondences found;
  nearest.determineCorrespondences(found);
  std::set<std::pair<int, int>> chosen;
  for (const pcl::Correspondence& c : found) chosen.insert({c.index_query, c.index_match});
  for (const auto& pair : pairsOfTheAnswer()) EXPECT_TRUE(chosen.count(pair));
}

// An estimation must never name frames that do not exist.
TEST_F(ChosenCorrespondences, PairsBeyondTheCloudsDoNotCount) {
  struct Wild : pcl::registration::CorrespondenceEstimationBase<SegmentFrame, SegmentFrame> {
    void determineCorrespondences(pcl::Correspondences& c, double) override {
      for (const auto& [a, b] : {std::pair{-1, 0}, {0, -1}, {0, 1 << 30}, {1 << 30, 0}})
        c.emplace_back(a, b, 0.f);
    }
    void determineReciprocalCorrespondences(pcl::Correspondences&, double) override {}
    Ptr clone() const override { return pcl::make_shared<Wild>(); }
  };
  registration.setCorrespondenceEstimation(pcl::make_shared<Wild>());
  registration.align(output);
  EXPECT_FALSE(registration.hasConverged());
  EXPECT_THAT(registration.getReason(), testing::HasSubstr("no correspondence"));
}

TEST(EkfRegistration, HasItsName) {
  EXPECT_EQ(EkfRegistration().getClassName(), "EkfRegistration");
  EXPECT_EQ(PlanarRegistration<pcl::PointXYZ>().getClassName(), "PlanarRegistration");
}

}  // namespace
}  // namespace facetloc
