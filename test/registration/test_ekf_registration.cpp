// SPDX-License-Identifier: BSD-3-Clause
#include "registration_cases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace facetloc {
namespace {

using test::EkfCase;
using test::kNearPose;
using test::kTargetPose;
using test::PoseNear;

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

TEST(EkfRegistration, HasItsName) {
  EXPECT_EQ(EkfRegistration().getClassName(), "EkfRegistration");
  EXPECT_EQ(PlanarRegistration<pcl::PointXYZ>().getClassName(), "PlanarRegistration");
}

}  // namespace
}  // namespace facetloc
