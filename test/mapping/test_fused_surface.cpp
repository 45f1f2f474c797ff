// SPDX-License-Identifier: BSD-3-Clause
#include "models/fused_surface.h"

#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace facetloc {
namespace {

using namespace internal;
using test::box, test::lookingAlong, test::Scene;

const Scene kRoom = box({0, 0, 0}, {6, 5, 2.5}), kPillar = box({3.2, 2.2, 0}, {3.8, 2.8, 2.5});

/** The pictures of several cameras, each of its own scene. */
class Pictures {
public:
  void add(const Scene& scene, const Eigen::Isometry3d& T_w_c) {
    views_.push_back(test::viewFrom(scene, T_w_c, static_cast<unsigned>(1 + views_.size())));
    poses_.push_back(T_w_c);
  }
  std::vector<PosedPicture> all() const {
    std::vector<PosedPicture> out;
    for (std::size_t i = 0; i < views_.size(); ++i) out.push_back({&views_[i].depth, poses_[i]});
    return out;
  }

private:
  std::vector<View> views_;
  std::vector<Eigen::Isometry3d> poses_;
};

/** A drive towards +x along y = 1.5, which looks ahead and a little to both sides. */
Pictures driveThrough(const Scene& scene) {
  Pictures drive;
  for (const double x : {0.5, 1.0, 1.5})
    for (const double side : {-0.4, 0.0, 0.4}) drive.add(scene, lookingAlong({x, 1.5, 1.2}, {1, side, -0.2}));
  return drive;
}

/** Differences of a rendered image from the ray caster, in standard deviations of one picture. */
struct Comparison {
  int known = 0, off = 0, nothing_there = 0;
  double mean_square = 0;

  Comparison(const DepthImage& rendered, const DepthImage& truth) {
    for (std::size_t i = 0; i < truth.depth.size(); ++i) {
      if (rendered.depth[i] == 0) continue;
      ++known;
      if (truth.depth[i] == 0) {
        ++nothing_there;
        continue;
      }
      const double e = (1 / rendered.depth[i] - 1 / truth.depth[i]) / SensorNoise{}.inverse_depth_std;
      if (std::abs(e) > 3)
        ++off;
      else
        mean_square += e * e;
    }
    mean_square /= std::max(1, known - off - nothing_there);
  }
};

Comparison compare(const FusedSurface& surface, const Scene& scene, const Eigen::Isometry3d& T_w_c) {
  const DepthImage truth = test::render(scene, test::smallCamera(), T_w_c).image;
  return {surface.renderWithErrors(test::smallCamera(), T_w_c).image, truth};
}

TEST(FusedSurface, ShowsItsSurfacesFromElsewhere) {
  const FusedSurface surface(driveThrough(kRoom + kPillar).all(), 1);
  for (const auto& T :
       {lookingAlong({1.2, 1.9, 1.2}, {1, 0.1, -0.2}), lookingAlong({0.9, 1.1, 1.2}, {1, 0.5, -0.25}),
        lookingAlong({1.6, 1.5, 1.3}, {1, -0.5, -0.1})}) {
    const Comparison found = compare(surface, kRoom + kPillar, T);
    const int all = test::smallCamera().width * test::smallCamera().height;
    EXPECT_GT(found.known, 0.6 * all);
    EXPECT_LT(found.off, 0.03 * found.known) << "only along the edges of the pillar";
    EXPECT_EQ(found.nothing_there, 0);
    EXPECT_LT(found.mean_square, 0.5) << "the mean of many pixels is better than one";
  }
}

TEST(FusedSurface, UnseenSpaceIsUnknown) {
  const FusedSurface surface(driveThrough(kRoom + kPillar).all(), 1);
  const auto known = [&](const Eigen::Isometry3d& T) {
    return surface.renderWithErrors(test::smallCamera(), T).knownShare();
  };
  EXPECT_EQ(known(lookingAlong({1, 1.5, 1.2}, {-1, 0, 0})), 0) << "behind the drive";
  EXPECT_EQ(known(lookingAlong({4.6, 2.5, 1.2}, {-1, 0, 0})), 0) << "from behind the pillar";
  EXPECT_LT(known(lookingAlong({3.0, 4.8, 1.2}, {0.2, -1, 0})), 0.05) << "the walls that the drive passed";
}

/** The far side of a cupboard is unseen: behind it, the wall must not be seen through it. */
TEST(FusedSurface, SurfacesSeenFromTheFrontHideFromBehindAndFromTheSide) {
  const Scene cupboard = box({2.5, 3.0, 0}, {3.5, 3.6, 2.0});
  Pictures front;
  for (const double x : {2.6, 3.0, 3.4}) {
    front.add(kRoom + cupboard, lookingAlong({x, 0.7, 1.2}, {0, 1, -0.1}));
    front.add(kRoom + cupboard, lookingAlong({x - 1.5, 0.7, 1.2}, {0, 1, -0.1}));  // the wall beside it
    front.add(kRoom + cupboard, lookingAlong({x + 1.5, 0.7, 1.2}, {0, 1, -0.1}));
  }
  const FusedSurface surface(front.all(), 1);
  const Comparison side = compare(surface, kRoom + cupboard, lookingAlong({1.0, 2.6, 1.2}, {1, 0.3, -0.1}));
  EXPECT_GT(side.known, 2000);
  EXPECT_LT(side.off, 0.05 * side.known);
}

TEST(FusedSurface, LeavesOutMovedObjects) {
  const Scene person = box({2.6, 1.0, 0}, {3.0, 1.6, 1.8});
  Pictures drive = driveThrough(kRoom);
  drive.add(kRoom + person, lookingAlong({0.8, 1.4, 1.2}, {1, 0, -0.2}));
  const FusedSurface surface(drive.all(), 1);
  EXPECT_GT(surface.contradictedShare(), 0.005);
  EXPECT_LT(surface.contradictedShare(), 0.1);
  const Comparison empty = compare(surface, kRoom, lookingAlong({1, 1.6, 1.2}, {1, 0, -0.2}));
  EXPECT_LT(empty.off, 0.01 * empty.known);
}

/** Two pictures whose poses are 5 cm apart from the truth disagree, and say so. */
TEST(FusedSurface, ReportsHowMuchThePicturesDisagree) {
  const Eigen::Isometry3d T = lookingAlong({2, 2, 1.2}, {1, 0, -0.1});
  Pictures right, wrong;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Isometry3d beside = lookingAlong({2, 1.7 + 0.2 * i, 1.2}, {1, 0, -0.1});
    right.add(kRoom, beside);
    wrong.add(kRoom, beside);
  }
  std::vector<PosedPicture> moved = wrong.all();
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i].T_w_c.translation().x() += i % 2 ? 0.025 : -0.025;
  const double with_right =
      FusedSurface(right.all(), 1).renderWithErrors(test::smallCamera(), T).disagreement;
  const double with_wrong = FusedSurface(moved, 1).renderWithErrors(test::smallCamera(), T).disagreement;
  EXPECT_LT(with_right, 1);
  EXPECT_GT(with_wrong, 1.5 * with_right);
}

TEST(FusedSurface, OfNoPicturesIsEmpty) {
  const FusedSurface surface({}, 1);
  EXPECT_EQ(surface.renderWithErrors(test::smallCamera(), Eigen::Isometry3d::Identity()).knownShare(), 0);
}

TEST(SeenSpace, IsKnownUpToSurfacesAndFreeInFrontOfThem) {
  const Pictures drive = driveThrough(kRoom + kPillar);
  const SeenSpace space(drive.all());
  EXPECT_TRUE(space.isFree({2.5, 1.8, 1.2}));
  EXPECT_TRUE(space.isKnown({2.5, 1.8, 1.2}));
  EXPECT_FALSE(space.isFree({3.3, 2.5, 1.2})) << "in the pillar";
  EXPECT_FALSE(space.isKnown({5.0, 3.2, 1.2})) << "in its shadow";
  EXPECT_FALSE(space.isKnown({7, 2, 1.2})) << "outside of the room";
  EXPECT_FALSE(space.isKnown({-100, 1e9, std::nan("")}));
  EXPECT_TRUE(space.isFreeBetween({1.5, 1.5, 1.2}, {2.8, 1.6, 1.2}));
  EXPECT_FALSE(space.isFreeBetween({2.5, 2.5, 1.2}, {4.5, 2.5, 1.2})) << "through the pillar";
  EXPECT_FALSE(space.isKnownBetween({2.5, 2.2, 1.2}, {5.0, 3.2, 1.2}));
}

TEST(SurfacePatches, ArePlanesAndEndAtSilhouettes) {
  const Eigen::Isometry3d T = lookingAlong({1, 1.5, 1.2}, {1, 0.3, -0.2});
  const Scene scene = kRoom + kPillar;
  const View view = test::viewFrom(scene, T, 3);
  const SurfacePatches patches = patchesOf({&view.depth, T}, {});
  int known = 0, off = 0;
  for (int v = 0; v < patches.camera.height; ++v)
    for (int u = 0; u < patches.camera.width; ++u) {
      const auto& m = patches.at(u, v);
      if (m.isZero(0)) continue;
      ++known;
      // The plane that the pixel lies on is one of the scene's: its normal is an axis of the world.
      const Eigen::Vector3d normal = (T.linear() * m.cast<double>()).normalized();
      off += normal.cwiseAbs().maxCoeff() < std::cos(20 * kDegree);
    }
  EXPECT_GT(known, 0.8 * patches.camera.width * patches.camera.height);
  EXPECT_LT(off, 0.05 * known);
  std::vector<char> all(view.depth.inverse_depth.size(), 1);
  const SurfacePatches nothing = patchesOf({&view.depth, T}, all);
  EXPECT_TRUE(nothing.box.isEmpty());
}

}  // namespace
}  // namespace facetloc
