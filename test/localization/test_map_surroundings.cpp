// SPDX-License-Identifier: BSD-3-Clause
#include "belief/map_surroundings.h"

#include <facetloc/registration/pose_prior.h>
#include <facetloc/testing/changed_views.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/random_segments.h>
#include <facetloc/testing/synthetic_views.h>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace facetloc {
namespace {

using namespace internal;
using test::gaussian, test::IsPositiveSemidefinite, test::largeRoom, test::lookingAlong, test::MatrixNear,
    test::PoseNear, test::Rng, test::viewFrom, testing::ElementsAre;

LocalModel modelAt(const Eigen::Isometry3d& T_w_m, unsigned seed) {
  return {"", 0, T_w_m, viewFrom(largeRoom(), T_w_m, seed)};
}

class SurroundingsOfAPose : public testing::Test {
protected:
  SurroundingsOfAPose() {
    map->models.push_back(modelAt(lookingAlong({3, 2.5, 1.2}, {1, 0, -0.2}), 1));
    map->models.push_back(modelAt(lookingAlong({3.5, 2.5, 1.2}, {1, 0.1, -0.2}), 2));
    map->models.push_back(modelAt(lookingAlong({3, 2.5, 1.2}, {-1, 0, -0.2}), 3));  // the other way
    map->models.push_back(modelAt(lookingAlong({3, 2.5, 1.2}, {1, 0, -0.2}), 4));
    map->models.back().T_w_m.reset();  // its pose is unknown
  }
  MapSurroundings surroundings() const { return MapSurroundings(map, DepthComparison({})); }
  static std::vector<int> viewsOf(const LocalMap& found) {
    std::vector<int> views;
    for (const LocalMap::Origin& o : found.origins)
      if (views.empty() || views.back() != o.view) views.push_back(o.view);
    return views;
  }

  const Eigen::Isometry3d pose = lookingAlong({3.1, 2.5, 1.2}, {1, 0.02, -0.2});
  const View view = viewFrom(largeRoom(), pose, 9);
  std::shared_ptr<Map> map = std::make_shared<Map>();
};

TEST_F(SurroundingsOfAPose, AreTheNearestModels) {
  const MapSurroundings all = surroundings();
  const LocalMap found = all.around(view, 0, pose, 5);
  EXPECT_THAT(viewsOf(found), ElementsAre(0, 1));
  EXPECT_EQ(found.pictures.size(), 2u);
  EXPECT_THAT(viewsOf(all.around(view, 0, pose, 1)), ElementsAre(0));
  Eigen::Isometry3d far = pose;
  far.translation().x() += 100;
  EXPECT_TRUE(all.around(view, 0, far, 5).segments.empty());
}

TEST_F(SurroundingsOfAPose, WithoutDepthAreTheNearest) {
  test::changeViews(*map, [](View& changed) { changed.depth = {}; });
  const LocalMap found = surroundings().around(view, 0, pose, 1);
  EXPECT_THAT(viewsOf(found), ElementsAre(0));
  EXPECT_TRUE(found.pictures.empty());
}

TEST_F(SurroundingsOfAPose, AModelBehindAWallGivesNoPicture) {
  // The same pose, but the surfaces of that model are nearer than all that the view sees.
  map->models[0].setView(viewFrom(test::box({2.5, 2, 0}, {3.9, 3, 2.5}), *map->models[0].T_w_m, 5));
  const LocalMap found = surroundings().around(view, 0, pose, 5);
  ASSERT_EQ(found.pictures.size(), 1u);
  EXPECT_EQ(found.pictures[0].picture, &map->view(1)->depth);
  EXPECT_EQ(viewsOf(found).front(), 1);
}

TEST_F(SurroundingsOfAPose, HaveTheirSegmentsInTheWorld) {
  const LocalMap found = surroundings().around(view, 0, pose, 5);
  ASSERT_EQ(found.segments.size(), map->view(0)->segments.size() + map->view(1)->segments.size());
  ASSERT_EQ(found.origins.size(), found.segments.size());
  for (std::size_t i = 0; i < found.segments.size(); ++i) {
    const LocalModel& m = map->models[found.origins[i].view];
    const Segment& s = map->view(found.origins[i].view)->segments[found.origins[i].segment];
    EXPECT_LT((*m.T_w_m * s.t - found.segments[i].t).norm(), 1e-12);
    EXPECT_LT((m.T_w_m->linear() * s.R - found.segments[i].R).norm(), 1e-12);
  }
}

TEST_F(SurroundingsOfAPose, StandOnTheFloorOfTheNearestRobots) {
  const Eigen::Matrix3d covariance = floorCovariance({});
  EXPECT_FALSE(surroundings().floorNear(0, pose, 2, covariance));  // no mounting, no robot
  map->camera.mounting = CameraMounting{1.2, 0};
  map->models.resize(2);
  const auto standing = [](double x, double floor) {
    return Eigen::Translation3d(x, 0, floor) * CameraMounting{1.2, 0}.T_b_c();
  };
  map->models[0].T_w_m = standing(0, 0.1);
  map->models[1].T_w_m = standing(5, 0.3);
  const auto height = [&](double x, int n) {
    const FloorPlane floor = *surroundings().floorNear(0, standing(x, 0.1 + 0.04 * x), n, covariance);
    const Eigen::Vector3d normal = floor.T_w_f.linear().col(2);
    const Eigen::Vector3d to_plane = floor.T_w_f.translation() - Eigen::Vector3d(x, 0, 0);
    return normal.dot(to_plane) / normal.z();
  };
  EXPECT_NEAR(height(1, 1), 0.1, 1e-9);
  EXPECT_NEAR(height(4, 1), 0.3, 1e-9);
  const double between = height(4, 2);
  EXPECT_GT(between, 0.2);
  EXPECT_LT(between, 0.3);
  EXPECT_EQ(height(4, 9), between);
  // Robots on the storey above, and on a stage, have another floor.
  for (const auto& [x, floor] : {std::pair(3.9, 3.3), std::pair(4.1, 3.3), std::pair(4.2, 0.8)}) {
    map->models.push_back(map->models[0]);
    map->models.back().T_w_m = standing(x, floor);
  }
  EXPECT_NEAR(height(4, 9), between, 1e-9);
  EXPECT_FALSE(surroundings().floorNear(0, standing(4, 2), 2, covariance));
  for (LocalModel& m : map->models) m.T_w_m.reset();
  EXPECT_FALSE(surroundings().floorNear(0, standing(0, 0), 2, covariance));
}

TEST(MapSurroundings, OfAnEmptyMapAreEmpty) {
  const MapSurroundings none(std::make_shared<Map>(), DepthComparison({}));
  EXPECT_TRUE(none.around({}, 0, Eigen::Isometry3d::Identity(), 5).segments.empty());
}

const CameraMounting kMounting{1.2, 15};

/** A camera whose robot stands at (x, y, z) with that (roll, pitch, heading) [rad]. */
Eigen::Isometry3d standing(const Eigen::Vector3d& place, const Eigen::Vector3d& angles) {
  return Eigen::Translation3d(place) *
         Eigen::Isometry3d(expSO3({0, 0, angles.z()}) * expSO3({angles.x(), angles.y(), 0})) *
         kMounting.T_b_c();
}

/** Roll, pitch and height of that camera's robot on the floor z = 0, without any approximation but small
 * tilts.
 */
Eigen::Vector3d ofTheRobot(const Eigen::Isometry3d& T_w_c) {
  const Eigen::Isometry3d T_w_b = T_w_c * kMounting.T_b_c().inverse();
  const Eigen::Vector3d x = T_w_b.linear().col(0), y = T_w_b.linear().col(1);
  return {y.z(), -x.z(), T_w_b.translation().z()};
}

const Eigen::Matrix3d kCovariance = floorCovariance({});

TEST(FloorUpdate, OneRobotFixesItsFloor) {
  const FloorPlane floor =
      floorUnder({standing({1, 2, 0.3}, {0, 0, 1})}, kMounting, kCovariance, {1, 2, 1.5});
  EXPECT_THAT(floor.T_w_f.linear().col(2), MatrixNear(Eigen::Vector3d(0, 0, 1), 1e-12));
  EXPECT_NEAR(floor.T_w_f.translation().z(), 0.3, 1e-12);
  // As well as its wheels do, about whatever axes: the sum of the variances of the slopes is the tilts'.
  const auto slopes = [](const Eigen::Matrix3d& C) { return C(0, 0) + C(1, 1); };
  EXPECT_NEAR(slopes(floor.covariance), slopes(kCovariance), 1e-9);
}

TEST(FloorUpdate, TiltedRobotsFixASlopeByTheirPositions) {
  // On a floor that rises by 2 cm a metre, each tilted by another bump of its own.
  Rng rng(5);
  std::vector<Eigen::Isometry3d> cameras;
  const Eigen::LLT<Eigen::Matrix3d> bump(kCovariance);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d g = gaussian<3>(rng), b = bump.matrixL() * gaussian<3>(rng);
    const Eigen::Vector3d place(2 * g.x(), 2 * g.y(), 0);
    cameras.push_back(Eigen::AngleAxisd(-0.02, Eigen::Vector3d::UnitY()) *
                      standing({place.x(), place.y(), b.z()}, {b.x(), b.y(), g.z()}));
  }
  const FloorPlane floor = floorUnder(cameras, kMounting, kCovariance, Eigen::Vector3d::Zero());
  const Eigen::Vector3d normal = floor.T_w_f.linear().col(2);
  EXPECT_NEAR(normal.x() / normal.z(), -0.02, 0.002);  // one robot's tilt has 0.02
  EXPECT_NEAR(normal.y() / normal.z(), 0, 0.002);
  EXPECT_NEAR(normal.dot(floor.T_w_f.translation()), 0, 0.003);
}

TEST(FloorUpdate, TheFloorsErrorsMatchItsCovariance) {
  Rng rng(6);
  const Eigen::LLT<Eigen::Matrix3d> bump(kCovariance);
  double sum = 0;
  constexpr int kTrials = 400;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<Eigen::Isometry3d> cameras;
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d g = gaussian<3>(rng), b = bump.matrixL() * gaussian<3>(rng);
      cameras.push_back(standing({0.1 * g.x(), 0.1 * g.y(), b.z()}, {b.x(), b.y(), 3 * g.z()}));
    }
    const FloorPlane floor = floorUnder(cameras, kMounting, kCovariance, Eigen::Vector3d(0, 0, 1.2));
    // The true floor, z = 0, as a plane over the one that was found.
    const Eigen::Vector3d up = floor.T_w_f.linear().transpose() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d e(-up.x() / up.z(), -up.y() / up.z(), -floor.T_w_f.translation().z() / up.z());
    sum += e.dot(floor.covariance.ldlt().solve(e));
  }
  EXPECT_NEAR(sum / kTrials, 3, 0.4);  // chi-squared of three: standard deviation of the mean 0.12
}

TEST(FloorUpdate, APoseThatIsNotKnownOtherwiseIsPutOnTheFloor) {
  PoseWithCovariance camera{standing({1, 2, 0.05}, {0.02, -0.03, 0.7}), 100 * Matrix6d::Identity()};
  const Eigen::Matrix3d covariance = 1e-8 * Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) {  // linear in small angles only
    camera = updatedByFloor(camera, kMounting, {}, covariance);
    camera.P = 100 * Matrix6d::Identity();
  }
  EXPECT_THAT(ofTheRobot(camera.T), MatrixNear(Eigen::Vector3d::Zero().eval(), 1e-6));
}

TEST(FloorUpdate, IsTheInformationFilterOfTheNumericJacobian) {
  Rng rng(3);
  const Eigen::Matrix3d covariance = floorCovariance({});
  for (int trial = 0; trial < 20; ++trial) {
    const Vector6d g = gaussian<6>(rng);
    PoseWithCovariance prior;
    prior.T = standing({g[0], g[1], 0.004 * g[2]}, {0.004 * g[3], 0.004 * g[4], g[5]});
    Matrix6d L = Matrix6d::Zero();
    for (int i = 0; i < 6; ++i) L.col(i) = 0.03 * gaussian<6>(rng);
    prior.P = L * L.transpose() + 1e-6 * Matrix6d::Identity();

    constexpr double kStep = 1e-6;
    Eigen::Matrix<double, 3, 6> H;
    for (int i = 0; i < 6; ++i)
      H.col(i) = (ofTheRobot(boxplus(prior.T, kStep * Vector6d::Unit(i))) -
                  ofTheRobot(boxplus(prior.T, -kStep * Vector6d::Unit(i)))) /
                 (2 * kStep);
    FloorPlane floor;
    floor.covariance = 1e-4 * Eigen::Vector3d(1, 2, 3).asDiagonal();
    floor.covariance(0, 2) = floor.covariance(2, 0) = 1e-4;
    Eigen::Matrix3d by_floor;
    for (int i = 0; i < 3; ++i) {
      const auto on = [&](double step) {
        const Eigen::Vector3d e = step * Eigen::Vector3d::Unit(i), normal(-e.x(), -e.y(), 1);
        Eigen::Isometry3d T = Eigen::Translation3d(0, 0, e.z()) *
                              Eigen::Isometry3d(rotationBetween(Eigen::Vector3d::UnitZ(), normal));
        return ofTheRobot(T.inverse() * prior.T);
      };
      by_floor.col(i) = (on(kStep) - on(-kStep)) / (2 * kStep);
    }
    constexpr double kRepeated = 3;
    const Eigen::Matrix3d R = kRepeated * (covariance + by_floor * floor.covariance * by_floor.transpose());
    const Matrix6d P = (prior.P.inverse() + H.transpose() * R.inverse() * H).inverse();
    const Vector6d step = -P * H.transpose() * R.inverse() * ofTheRobot(prior.T);

    const PoseWithCovariance found = updatedByFloor(prior, kMounting, floor, covariance, kRepeated);
    EXPECT_THAT(found.P, MatrixNear(P, 1e-6 * P.norm())) << trial;
    EXPECT_THAT(found.P, IsPositiveSemidefinite(1e-12)) << trial;
    EXPECT_THAT(boxminus(found.T, prior.T), MatrixNear(step, 1e-6)) << trial;
  }
}

TEST(FloorUpdate, DoesNotDependOnTheAxesOfTheWorld) {
  const PoseWithCovariance camera{standing({1, 2, 0.004}, {0.01, -0.02, 0.7}), 1e-3 * Matrix6d::Identity()};
  const std::vector<Eigen::Isometry3d> mapped{standing({0, 0, 0}, {0.02, 0.01, 0}),
                                              standing({3, 0.5, 0.03}, {-0.01, 0.03, 1})};
  const PoseWithCovariance there = updatedByFloor(
      camera, kMounting, floorUnder(mapped, kMounting, kCovariance, camera.T.translation()), kCovariance);
  // The last one points down, as for flight and ships.
  for (const Eigen::Vector3d& turned :
       {Eigen::Vector3d(1, -0.5, 2), Eigen::Vector3d(EIGEN_PI, 0, 0), Eigen::Vector3d(3.13, 0.02, 0)}) {
    const Eigen::Isometry3d T_v_w = Eigen::Translation3d(3, -1, 4) * Eigen::Isometry3d(expSO3(turned));
    Matrix6d turn = Matrix6d::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = T_v_w.linear();
    std::vector<Eigen::Isometry3d> of_v;
    for (const Eigen::Isometry3d& T : mapped) of_v.push_back(T_v_w * T);
    const FloorPlane floor = floorUnder(of_v, kMounting, kCovariance, T_v_w * camera.T.translation());
    const PoseWithCovariance here =
        updatedByFloor({T_v_w * camera.T, turn * camera.P * turn.transpose()}, kMounting, floor, kCovariance);
    EXPECT_THAT(here.T, PoseNear(T_v_w * there.T, 1e-5, 1e-3));
    EXPECT_THAT(here.P, MatrixNear(Matrix6d(turn * there.P * turn.transpose()), 1e-7));
  }
}

}  // namespace
}  // namespace facetloc
