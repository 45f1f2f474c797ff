// SPDX-License-Identifier: BSD-3-Clause
#include "base/place_index_file.h"
#include "process.h"

#include <facetloc/io/map_database.h>
#include <facetloc/localization/place_index.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

namespace facetloc {
namespace {

using test::contentOf;
using test::TemporaryFolder;

constexpr CameraMounting kMounting{1.0, 10.0};

Map copiesOfAView(int n) {
  Map map;
  map.camera.mounting = kMounting;
  LocalModel m;
  m.T_w_m = kMounting.T_b_c();
  m.view = viewFrom(test::box({-1, -2, 0}, {5, 3, 2.5}), *m.T_w_m, 1);
  m.view.depth = {};
  for (int i = 0; i < n; ++i) {
    m.name = std::to_string(i);
    map.models.push_back(m);
  }
  return map;
}

bool hasItsIndex(const std::string& path) {
  const Map map = openMap(path);
  const auto written = map.store->placeIndex();
  return written && PlaceIndex::read(*written, map).has_value();
}

TEST(PlaceIndexFile, IsWrittenWhereItWillBeRead) {
  const TemporaryFolder folder;
  const std::string path = folder / "large.flmap";
  writeMap(path, copiesOfAView(401));
  EXPECT_FALSE(hasItsIndex(path));
  writePlaceIndex(path);
  EXPECT_TRUE(hasItsIndex(path));
  const std::string bytes = contentOf(path);
  writePlaceIndex(path);
  EXPECT_EQ(contentOf(path), bytes) << "nothing was missing";
}

TEST(PlaceIndexFile, OneOfAnotherMapIsReplaced) {
  const TemporaryFolder folder;
  const std::string path = folder / "large.flmap";
  Map map = copiesOfAView(401);
  writeMap(path, map);
  std::swap(map.models[1].name, map.models[2].name);
  const PlaceIndex other(map);
  MapDatabase::open(path).setPlaceIndex([&other](std::ostream& out) { other.write(out); });
  EXPECT_FALSE(hasItsIndex(path));
  writePlaceIndex(path);
  EXPECT_TRUE(hasItsIndex(path));
}

TEST(PlaceIndexFile, AMapThatIsReadAsAWholeNeedsNone) {
  const TemporaryFolder folder;
  const std::string path = folder / "small.flmap";
  writeMap(path, copiesOfAView(3));
  const std::string bytes = contentOf(path);
  writePlaceIndex(path);
  EXPECT_EQ(contentOf(path), bytes);
}

}  // namespace
}  // namespace facetloc
