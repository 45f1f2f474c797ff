// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/free_space_violations.h"

#include <facetloc/testing/synthetic_views.h>

#include <gmock/gmock.h>

namespace facetloc {
namespace {

using namespace internal;
using test::lookingAlong, test::viewFrom;

const test::Scene kRoom = test::box({0, 0, 0}, {6, 5, 2.5});
const test::Scene kChest = test::box({2.4, 3.6, 0}, {3.6, 4.4, 1.0});  // its front is in view
const Eigen::Isometry3d kModel = lookingAlong({3, 1.2, 1.2}, {0, 1, -0.2});
const std::vector<Eigen::Isometry3d> kLater = {lookingAlong({2.7, 1.1, 1.2}, {0.05, 1, -0.2}),
                                               lookingAlong({3.3, 1.3, 1.2}, {-0.1, 1, -0.2}),
                                               lookingAlong({3, 0.7, 1.2}, {0, 1, -0.15})};

/** A local model of the room with the chest, and its review by later views of another room. */
class FreeSpaceViolations : public testing::Test {
protected:
  SurfaceReview review(const std::vector<test::Scene>& later, int looks = 2) {
    std::vector<PosedPicture> others;
    views_.clear();
    for (std::size_t i = 0; i < later.size(); ++i)
      views_.push_back(viewFrom(later[i], kLater[i], static_cast<unsigned>(20 + i)));
    for (std::size_t i = 0; i < later.size(); ++i)
      others.push_back({&views_[i].depth, kModel.inverse() * kLater[i]});
    return reviewSurfaces(model_, others, DepthComparison({}), looks);
  }
  /** Is a segment one of the chest's, that is, neither of walls nor of the floor? */
  bool isOfChest(const Segment& segment) const {
    const Eigen::Vector3d p = kModel * segment.t;
    return p.z() > 0.05 && p.y() < 4.6 && p.x() > 2 && p.x() < 4;
  }
  long ofChest(const View& view) const {
    return std::count_if(view.segments.begin(), view.segments.end(),
                         [&](const Segment& s) { return isOfChest(s); });
  }

  View model_ = viewFrom(kRoom + kChest, kModel, 1);
  std::vector<View> views_;
};

TEST_F(FreeSpaceViolations, GoneSurfacesAreRemovedAndNothingElse) {
  ASSERT_GE(ofChest(model_), 1);
  const SurfaceReview gone = review({kRoom, kRoom, kRoom});
  EXPECT_EQ(static_cast<long>(gone.gone_segments.size()), ofChest(model_));
  for (const int k : gone.gone_segments) EXPECT_TRUE(isOfChest(model_.segments[k])) << k;
  EXPECT_GT(gone.goneShare(), 0.02);
  const View left = withoutGone(model_, gone);
  EXPECT_EQ(left.segments.size(), model_.segments.size() - gone.gone_segments.size());
  EXPECT_EQ(ofChest(left), 0);
  // The picture without it is unknown there, and unchanged elsewhere.
  int erased = 0;
  for (std::size_t i = 0; i < left.depth.inverse_depth.size(); ++i) {
    erased += left.depth.inverse_depth[i] == 0 && model_.depth.inverse_depth[i] != 0;
    if (left.depth.inverse_depth[i] != 0) {
      EXPECT_EQ(left.depth.inverse_depth[i], model_.depth.inverse_depth[i]);
    }
  }
  EXPECT_GE(erased, gone.gone_pixels / 2);
  EXPECT_EQ(left.depth.noise.inverse_depth_std, model_.depth.noise.inverse_depth_std);
}

TEST_F(FreeSpaceViolations, UnchangedSurfacesStay) {
  const SurfaceReview same = review({kRoom + kChest, kRoom + kChest, kRoom + kChest});
  EXPECT_TRUE(same.gone_segments.empty());
  EXPECT_LT(same.goneShare(), 0.01);
  EXPECT_GT(same.judged_segments, 2);
}

TEST_F(FreeSpaceViolations, OneLookIsNotEnough) {
  EXPECT_TRUE(review({kRoom}).gone_segments.empty());
  EXPECT_TRUE(review({kRoom, kRoom + kChest, kRoom + kChest}).gone_segments.empty());
  EXPECT_FALSE(review({kRoom}, 1).gone_segments.empty());
}

TEST_F(FreeSpaceViolations, APasserByHidesAndRemovesNothing) {
  const test::Scene person = test::box({2.6, 2.4, 0}, {3.2, 2.8, 1.8});
  const SurfaceReview hidden =
      review({kRoom + kChest + person, kRoom + kChest + person, kRoom + kChest + person});
  EXPECT_TRUE(hidden.gone_segments.empty());
  EXPECT_LT(hidden.goneShare(), 0.01);
}

TEST_F(FreeSpaceViolations, ViewsThatSayNothingChangeNothing) {
  EXPECT_EQ(review({}).judged, 0);
  View bare = model_;
  bare.depth = {};
  EXPECT_EQ(reviewSurfaces(bare, {}, DepthComparison({}), 2).goneShare(), 0);
  EXPECT_EQ(withoutGone(bare, reviewSurfaces(bare, {}, DepthComparison({}), 2)).segments.size(),
            bare.segments.size());
}

}  // namespace
}  // namespace facetloc
