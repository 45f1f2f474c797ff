// SPDX-License-Identifier: BSD-3-Clause
#include "place_index_rooms.h"
#include "shortlist/place_descriptor.h"

#include <facetloc/localization/place_index.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace facetloc::test {

void PlaceIndexOfRooms::SetUpTestSuite() {
  auto made = std::make_shared<Map>();
  made->camera.mounting = kMounting;
  for (int r = 0; r < kRooms; ++r)
    for (int i = 0; i < kViews; ++i) {
      const Eigen::Isometry3d T = robotCamera(i < kViews / 2 ? 2 : 3.2, 2.4, 30 * kDegree * i);
      made->models.emplace_back(std::to_string(r) + "/" + std::to_string(i), 0,
                                Eigen::Translation3d(20.0 * r, 0, 0) * T,
                                mounted(viewFrom(room(r), T, unsigned(100 + r * kViews + i)), kMounting));
    }
  map = openedMap(*made);
}

}  // namespace facetloc::test

namespace facetloc {
namespace {

using namespace internal;
using test::facing, test::kMounting, test::PlaceIndexOfRooms, test::robotCamera;

TEST_F(PlaceIndexOfRooms, EveryModelLeadsItsOwnList) {
  const PlaceIndex index(*map, few());
  EXPECT_EQ(index.models(), map->models.size());
  EXPECT_GT(index.descriptors(), map->models.size());
  // Most views are equal in all rooms, but for the noise.
  int near_front = 0;
  for (std::size_t i = 0; i < map->models.size(); ++i) {
    const std::vector<int> list = index.shortlist(viewOf(i), kRooms);
    ASSERT_EQ(list.size(), kRooms);
    EXPECT_EQ(list.front() % kViews, static_cast<int>(i) % kViews);
    near_front += std::count(list.begin(), list.end(), static_cast<int>(i));
  }
  EXPECT_GE(near_front, 0.95 * static_cast<double>(map->models.size()));
}

TEST_F(PlaceIndexOfRooms, TheSameMapGivesTheSameList) {
  const PlaceIndex one(*map, few()), other(*map, few());
  for (unsigned i = 0; i < 6; ++i) {
    const View view = query(int(i % kRooms), 0.9 * i, 500 + i);
    const std::vector<int> list = one.shortlist(view, 20);
    EXPECT_EQ(list, other.shortlist(view, 20));
    EXPECT_EQ(list, one.shortlist(view, 20));
    std::vector<int> sorted = list;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(std::unique(sorted.begin(), sorted.end()), sorted.end());
    const std::vector<int> shorter = one.shortlist(view, 7);
    EXPECT_EQ(shorter, std::vector<int>(list.begin(), list.begin() + 7));
  }
}

TEST_F(PlaceIndexOfRooms, AViewWithHalfOfItsSegmentsFindsItsPlace) {
  const PlaceIndex index(*map, few());
  for (unsigned i = 0; i < 6; ++i) {
    const double heading = 30 * kDegree * i + 0.1;
    View view = query(0, heading, 600 + i);
    std::vector<Segment> half;
    for (std::size_t k = 0; k < view.segments.size(); k += 2) half.push_back(view.segments[k]);
    view.segments = half;
    const std::vector<int> list = index.shortlist(view, 20);
    // Any room's: half of the segments need not tell which.
    const Eigen::Isometry3d truth = robotCamera(2.3, 2.2, heading);
    EXPECT_TRUE(std::any_of(list.begin(), list.end(), [&](int m) {
      return rotationAngle(map->models[m].T_w_m->linear().transpose() * truth.linear()) < 25 * kDegree;
    })) << heading;
  }
}

TEST_F(PlaceIndexOfRooms, HopelessModelsAreLeftOut) {
  const View view = query(1, 0.7, 701);
  const auto listed = [&](double gap) {
    ShortlistParams params = few();
    params.gap = gap;
    return PlaceIndex(*map, params).shortlist(view, 1000);
  };
  const std::vector<int> best = listed(0), some = listed(0.5), all = listed(1e6);
  EXPECT_LE(best.size(), 2u);
  EXPECT_LT(best.size(), some.size());
  EXPECT_LT(some.size(), all.size());
  EXPECT_TRUE(std::equal(some.begin(), some.end(), all.begin()));  // the same order, cut short
}

TEST_F(PlaceIndexOfRooms, CandidatesHaveApproximatePoses) {
  const PlaceIndex index(*map, few());
  int near = 0, all = 0;
  for (unsigned i = 0; i < 12; ++i) {
    const double heading = 30 * kDegree * i + 0.1;
    const Eigen::Isometry3d truth = robotCamera(2.3, 2.2, heading);
    const std::vector<ShortlistedModel> found = index.candidates(query(0, heading, 400 + i), 4);
    ASSERT_FALSE(found.empty());
    for (const ShortlistedModel& c : found) {
      if (c.model >= kViews) continue;  // model of another room
      ASSERT_TRUE(c.start);
      EXPECT_TRUE(c.start->linear().isUnitary(1e-9));
      const Vector6d e = boxminus(map->models[c.model].T_w_m->inverse() * truth, *c.start);
      near += e.head<3>().norm() < 5 * kDegree && e.tail<3>().norm() < 0.4;
      ++all;
    }
  }
  EXPECT_GE(all, 12);
  EXPECT_GE(near, 0.9 * all);
}

TEST_F(PlaceIndexOfRooms, WithoutStartsEveryCandidateIsSearchedEverywhere) {
  ShortlistParams params = few();
  params.start_translation = 0;
  for (const ShortlistedModel& c : PlaceIndex(*map, params).candidates(query(1, 0.4, 77), 10))
    EXPECT_FALSE(c.start);
}

TEST_F(PlaceIndexOfRooms, WithoutWallsTheModelsThatShareLevelSurfacesComeFirst) {
  const auto isLevel = [](const Eigen::Vector3d& n) { return std::abs(n.z()) > 0.98; };
  const auto withTable = [](int i) {  // tables of different heights
    return test::box({0, 0, 0}, {6, 4, 2.4}) + test::box({3.2, 1.2, 0}, {4.6, 2.8, 0.2 + 0.08 * i});
  };
  Map tables;
  tables.camera.mounting = kMounting;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Isometry3d T_w_m = robotCamera(2, 2, 0);
    const View view = facing(viewFrom(withTable(i), T_w_m, unsigned(i)), isLevel);
    ASSERT_GE(placeDescriptor(view, kMounting).surfaces.size(), 1u) << i;
    tables.models.emplace_back(std::to_string(i), 0, T_w_m, view);
  }
  const PlaceIndex index(tables);
  for (int i = 0; i < 6; ++i) {
    const View view = facing(viewFrom(withTable(i), robotCamera(2.1, 2, 0.05), 50u + i), isLevel);
    EXPECT_EQ(index.shortlist(view, 1), std::vector<int>{i});
  }
}

TEST_F(PlaceIndexOfRooms, BadInput) {
  const PlaceIndex index(*map, few());
  EXPECT_TRUE(index.shortlist(View{}, 10).empty());
  EXPECT_TRUE(index.shortlist(viewOf(0), 0).empty());
  View bad = viewOf(0);
  for (Segment& s : bad.segments) s.R(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(index.shortlist(bad, 10).empty());

  Map empty;
  EXPECT_THROW(PlaceIndex{empty}, std::invalid_argument);  // no mounting
  empty.camera.mounting = kMounting;
  EXPECT_TRUE(PlaceIndex(empty).shortlist(viewOf(0), 10).empty());

  Map without_segments = empty;
  without_segments.models.resize(3, {"", 0, {}, View()});
  EXPECT_EQ(PlaceIndex(without_segments).shortlist(viewOf(0), 10), (std::vector<int>{0, 1, 2}));
}

}  // namespace
}  // namespace facetloc
