// SPDX-License-Identifier: BSD-3-Clause
#include "box_mesh.h"

#include <facetloc/features/pose.h>
#include <facetloc/mapping/mesh_surface.h>
#include <facetloc/mapping/surface.h>
#include <facetloc/simulation/simulated_place.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace facetloc {
namespace {

using Verdict = SurfaceOrientation::Verdict;

double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kDegree;
}

/** A mesh with all of its points moved by R, and scaled. */
pcl::PolygonMesh transformed(pcl::PolygonMesh mesh, const Eigen::Matrix3d& R, double scale = 1) {
  pcl::PointCloud<pcl::PointXYZ> points;
  pcl::fromPCLPointCloud2(mesh.cloud, points);
  for (pcl::PointXYZ& p : points)
    p.getVector3fMap() = (scale * R * p.getVector3fMap().cast<double>()).cast<float>();
  pcl::toPCLPointCloud2(points, mesh.cloud);
  return mesh;
}

pcl::PolygonMesh placeMesh(const std::string& name, std::uint64_t seed) {
  return meshOf(lastingParts(simulatedPlace(name, seed)));
}

SurfaceOrientation orientationOfMesh(const pcl::PolygonMesh& mesh) {
  return orientationOf(MeshSurface(mesh), 2);
}

Eigen::Matrix3d turn(double deg, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(deg * kDegree, axis.normalized()).toRotationMatrix();
}

/** Places of the simulator of which all have a storey of rooms. */
const std::pair<const char*, std::uint64_t> kPlaces[] = {
    {"office", 11}, {"home", 12}, {"hall", 13}, {"hotel", 14}};

TEST(SurfaceOrientation, OfPlacesAsTheyStandIsNotDoubted) {
  for (const auto& [name, seed] : kPlaces) {
    const SurfaceOrientation found = orientationOfMesh(placeMesh(name, seed));
    EXPECT_EQ(Verdict::plausible, found.judge(Eigen::Vector3d::UnitZ()).verdict) << name;
    EXPECT_EQ(Eigen::Vector3d(Eigen::Vector3d::UnitZ()), found.judge(Eigen::Vector3d::UnitZ()).better);
    ASSERT_TRUE(found.up()) << name;
    EXPECT_LT(angleBetween(*found.up(), Eigen::Vector3d::UnitZ()), 0.2) << name;
  }
}

/** The walls of corridors are larger than their floors. */
TEST(SurfaceOrientation, OfCorridorsIsNotAcross) {
  for (const float width : {1.2f, 1.7f}) {
    const SurfaceOrientation narrow = orientationOfMesh(BoxMesh().add({0, 0, 0}, {20, width, 2.6f}).mesh());
    ASSERT_TRUE(narrow.up()) << width;
    EXPECT_NEAR(1, narrow.up()->z(), 1e-6) << width;
  }
  const SurfaceOrientation wide = orientationOfMesh(BoxMesh().add({0, 0, 0}, {20, 2.1f, 2.6f}).mesh());
  EXPECT_FALSE(wide.up());
  EXPECT_EQ(2u, wide.candidates().size());
  EXPECT_EQ(Verdict::plausible, wide.judge(Eigen::Vector3d::UnitZ()).verdict);
}

TEST(SurfaceOrientation, IsFoundHoweverAPlaceIsTurned) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const auto& [name, seed] : kPlaces) {
    const pcl::PolygonMesh upright = placeMesh(name, seed);
    // One after the other: compilers evaluate arguments in different orders.
    const double z = normal(random), y = normal(random), x = normal(random), degrees = normal(random);
    const Eigen::Matrix3d R = turn(60 + 60 * std::abs(degrees), Eigen::Vector3d(x, y, z));
    const Eigen::Vector3d up = R * Eigen::Vector3d::UnitZ();
    const SurfaceOrientation found = orientationOfMesh(transformed(upright, R));
    ASSERT_TRUE(found.up()) << name;
    EXPECT_LT(std::min(angleBetween(*found.up(), up), angleBetween(*found.up(), -up)), 0.3) << name;
    if (found.isSignKnown()) {
      EXPECT_GT(found.up()->dot(up), 0) << name;
    }

    const SurfaceOrientation on_side =
        orientationOfMesh(transformed(upright, turn(90, Eigen::Vector3d::UnitX())));
    const SurfaceOrientation::Judgement judged = on_side.judge(Eigen::Vector3d::UnitZ());
    EXPECT_EQ(Verdict::other_axis, judged.verdict) << name;
    EXPECT_LT(std::abs(std::abs(judged.better.y()) - 1), 1e-4) << name;
  }
}

/** Homes and hotels have beds and tables that stay. */
TEST(SurfaceOrientation, OfAClosedPlaceUpsideDownIsNoticedByItsFurniture) {
  for (const auto& [name, seed] : {std::pair("home", 8), {"home", 9}, {"hotel", 8}, {"hotel", 9}}) {
    const SurfaceOrientation found =
        orientationOfMesh(transformed(placeMesh(name, seed), turn(180, Eigen::Vector3d::UnitX())));
    EXPECT_EQ(Verdict::upside_down, found.judge(Eigen::Vector3d::UnitZ()).verdict) << name << seed;
    EXPECT_EQ(Verdict::plausible, found.judge(-Eigen::Vector3d::UnitZ()).verdict) << name << seed;
    ASSERT_TRUE(found.up());
    EXPECT_LT(angleBetween(*found.up(), -Eigen::Vector3d::UnitZ()), 0.2) << name << seed;
  }
}

TEST(SurfaceOrientation, OfAnEmptyClosedRoomHasNoSign) {
  const SurfaceOrientation found = orientationOfMesh(BoxMesh().add({0, 0, 0}, {6, 5, 2.5f}).mesh());
  ASSERT_TRUE(found.up());
  EXPECT_FALSE(found.isSignKnown());
  EXPECT_NEAR(1, found.up()->z(), 1e-6);
  EXPECT_EQ(Verdict::plausible, found.judge(-Eigen::Vector3d::UnitZ()).verdict);
  EXPECT_NEAR(2.5, found.judge(Eigen::Vector3d::UnitZ()).clear_height, 1e-3);
}

TEST(SurfaceOrientation, OfOpenRoomsIsByTheCeilingThatTheyLack) {
  const SurfaceOrientation found = orientationOfMesh(twoRooms(false).mesh());
  EXPECT_EQ(Verdict::plausible, found.judge(Eigen::Vector3d::UnitZ()).verdict);
  EXPECT_EQ(Verdict::upside_down, found.judge(-Eigen::Vector3d::UnitZ()).verdict);
}

TEST(SurfaceOrientation, NamesFloorsThatAreNotLevel) {
  const pcl::PolygonMesh home = placeMesh("home", 12);
  for (const double deg : {0.5, 4.0, 10.0}) {
    const Eigen::Matrix3d R = turn(deg, {1, 0.3, 0});
    const SurfaceOrientation::Judgement judged =
        orientationOfMesh(transformed(home, R)).judge(Eigen::Vector3d::UnitZ());
    EXPECT_EQ(deg < 2 ? Verdict::plausible : Verdict::inclined, judged.verdict) << deg;
    if (deg > 2) {
      EXPECT_LT(angleBetween(judged.better, R * Eigen::Vector3d::UnitZ()), 0.2) << deg;
    }
  }
}

TEST(SurfaceOrientation, DoesNotDependOnUnitsOrThreads) {
  const pcl::PolygonMesh home = placeMesh("home", 12);
  const SurfaceOrientation metres = orientationOfMesh(home);
  for (const double scale : {100.0, 1 / 0.0254}) {
    const SurfaceOrientation other = orientationOfMesh(transformed(home, Eigen::Matrix3d::Identity(), scale));
    ASSERT_EQ(metres.axes.size(), other.axes.size());
    EXPECT_NEAR(scale * metres.axes[0].clear_height, other.axes[0].clear_height, 1e-3 * scale);
    EXPECT_LT(angleBetween(metres.candidates().at(0), other.candidates().at(0)), 0.01);
    EXPECT_NEAR(metres.axes[0].support, other.axes[0].support, 0.02);
  }
  const SurfaceOrientation again = orientationOf(MeshSurface(home), 1);
  ASSERT_EQ(metres.axes.size(), again.axes.size());
  for (std::size_t i = 0; i < metres.axes.size(); ++i) {
    EXPECT_EQ(metres.axes[i].direction, again.axes[i].direction);
    EXPECT_EQ(metres.axes[i].support, again.axes[i].support);
  }
}

/** A room with walls of 0.2 m around it, from the origin. */
BoxMesh shell(const Eigen::Vector3f& size, bool ceiling) {
  const float w = 0.2f, x = size.x(), y = size.y(), z = size.z();
  BoxMesh mesh;
  mesh.add({-w, -w, -w}, {x + w, y + w, 0});
  if (ceiling) mesh.add({-w, -w, z}, {x + w, y + w, z + w});
  return mesh.add({-w, -w, 0}, {x + w, 0, z})
      .add({-w, y, 0}, {x + w, y + w, z})
      .add({-w, 0, 0}, {0, y, z})
      .add({x, 0, 0}, {x + w, y, z});
}

/** A narrow room whose furniture hides most of its floor, so that a wall is the largest plane. */
BoxMesh furnishedRoom(bool ceiling) {
  return shell({6, 3, 2.6f}, ceiling)
      .add({0, 0, 0}, {2, 1.6f, 0.5f})
      .add({2.3f, 0, 0}, {4.5f, 0.9f, 0.45f})
      .add({2.5f, 1.3f, 0.4f}, {3.7f, 1.9f, 0.45f})
      .add({4.8f, 0, 0.7f}, {6, 0.7f, 0.75f})
      .add({3, 2.6f, 0}, {5, 3, 0.8f})
      .add({0, 2.4f, 0}, {1.2f, 3, 0.9f})
      .add({4.3f, 1.2f, 0.7f}, {5.7f, 2.1f, 0.75f})
      .add({4.6f, 0.9f, 0}, {5, 1.2f, 0.9f});
}

/** A room under a roof that rises from 1.2 to 3.2 m. */
pcl::PolygonMesh attic() {
  constexpr float w = 0.2f;
  BoxMesh mesh;
  mesh.add({-w, -w, -w}, {5 + w, 4 + w, 0}).add({-w, -w, 0}, {5 + w, 0, 3.2f});
  mesh.add({-w, 4, 0}, {5 + w, 4 + w, 3.2f}).add({-w, 0, 0}, {0, 4, 1.2f}).add({5, 0, 0}, {5 + w, 4, 3.2f});
  mesh.add({0.2f, 0.2f, 0}, {2, 1.6f, 0.5f}).add({3, 3.4f, 0}, {4.4f, 4, 0.75f});
  mesh.add({3, 0, 0.7f}, {4.2f, 0.6f, 0.75f}).add({0, 0, 3.2f}, {5, 4, 3.2f + w});
  pcl::PolygonMesh room = mesh.mesh();
  pcl::PointCloud<pcl::PointXYZ> points;
  pcl::fromPCLPointCloud2(room.cloud, points);
  for (std::size_t i = points.size() - 8; i < points.size(); ++i)  // the last box becomes the roof
    if (points[i].x == 0) points[i].z -= 2;
  pcl::toPCLPointCloud2(points, room.cloud);
  return room;
}

/** The same with the y axis up, as in the files of phones. */
pcl::PolygonMesh withYUp(const pcl::PolygonMesh& mesh) {
  Eigen::Matrix3d R;
  R << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return transformed(mesh, R);
}

TEST(SurfaceOrientation, OfARoomWithALargeWallIsByAllThatIsSeen) {
  for (const auto& [room, name] : {std::pair{furnishedRoom(true).mesh(), "furnished"},
                                   {furnishedRoom(false).mesh(), "furnished, open"},
                                   {attic(), "under a roof"},
                                   {shell({20, 1.5f, 2.6f}, true).mesh(), "corridor"},
                                   {shell({20, 1.5f, 2.6f}, false).mesh(), "corridor, open"}})
    for (const bool is_y_up : {false, true}) {
      SurfaceOrientation found = orientationOfMesh(is_y_up ? withYUp(room) : room);
      const Eigen::Vector3d up = Eigen::Vector3d::Unit(is_y_up ? 1 : 2);
      EXPECT_EQ(Verdict::plausible, found.judge(up).verdict) << name << is_y_up;
      found.usual = up;
      ASSERT_TRUE(found.up()) << name << is_y_up;
      EXPECT_LT(angleBetween(*found.up(), up), 0.5) << name << is_y_up;
      EXPECT_EQ(Verdict::plausible, found.judge(up).verdict) << name << is_y_up;
      found.usual = Eigen::Vector3d::Unit(is_y_up ? 2 : 1);  // a file against the convention
      EXPECT_EQ(Verdict::plausible, found.judge(up).verdict) << name << is_y_up;
    }
}

TEST(SurfaceOrientation, OfABareCorridorIsAskedFor) {
  const pcl::PolygonMesh corridor = shell({30, 2.4f, 3.6f}, true).mesh();  // a wall half again the floor
  for (const bool is_y_up : {false, true}) {
    SurfaceOrientation found = orientationOfMesh(is_y_up ? withYUp(corridor) : corridor);
    const Eigen::Vector3d up = Eigen::Vector3d::Unit(is_y_up ? 1 : 2);
    found.usual = up;
    EXPECT_FALSE(found.up());
    EXPECT_EQ(2u, found.candidates().size());
    EXPECT_EQ(Verdict::plausible, found.judge(up).verdict);
  }
}

TEST(SurfaceOrientation, IsNotDecidedByTheFilesConventionAlone) {
  SurfaceOrientation cube = orientationOfMesh(BoxMesh().add({0, 0, 0}, {3, 3, 3}).mesh());
  cube.usual = Eigen::Vector3d::UnitY();
  EXPECT_FALSE(cube.up());
  EXPECT_EQ(Verdict::plausible, cube.judge(Eigen::Vector3d::UnitZ()).verdict);
}

TEST(SurfaceOrientation, OfACubeIsUnknown) {
  const SurfaceOrientation found = orientationOfMesh(BoxMesh().add({0, 0, 0}, {3, 3, 3}).mesh());
  EXPECT_EQ(3u, found.candidates().size());
  EXPECT_FALSE(found.up());
  for (int k = 0; k < 3; ++k) EXPECT_EQ(Verdict::plausible, found.judge(Eigen::Vector3d::Unit(k)).verdict);
  EXPECT_EQ(Verdict::other_axis, found.judge(Eigen::Vector3d(1, 1, 1).normalized()).verdict);
}

}  // namespace
}  // namespace facetloc
