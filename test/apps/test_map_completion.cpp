// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/map_completion.h"
#include "process.h"

#include <facetloc/io/map_database.h>
#include <facetloc/localization/place_index.h>
#include <facetloc/testing/synthetic_views.h>

namespace facetloc::test {
namespace {

constexpr CameraMounting kMounting{1.0, 10.0};

Map copiesOfAView(int n) {
  Map map;
  map.camera.mounting = kMounting;
  View view = viewFrom(box({-1, -2, 0}, {5, 3, 2.5}), kMounting.T_b_c(), 1);
  view.depth = {};
  for (int i = 0; i < n; ++i) map.models.emplace_back(std::to_string(i), 0, kMounting.T_b_c(), view);
  return map;
}

void complete(const std::string& path) {
  captured([&](const Console& console) { return completeMap(path, 1, console), kOk; });
}

bool hasItsIndex(const std::string& path) {
  const Map map = openMap(path);
  const auto written = map.store()->placeIndex();
  return written && PlaceIndex::read(*written, map).has_value();
}

using MapCompletion = InAFolder;

TEST_F(MapCompletion, AnIndexIsWrittenWhereItWillBeRead) {
  const std::string path = folder_ / "large.flmap";
  writeMap(path, copiesOfAView(401));
  EXPECT_FALSE(hasItsIndex(path));
  complete(path);
  EXPECT_TRUE(hasItsIndex(path));
  const std::string bytes = contentOf(path);
  complete(path);
  EXPECT_EQ(contentOf(path), bytes) << "nothing was missing";
}

TEST_F(MapCompletion, AnIndexOfAnotherMapIsReplaced) {
  const std::string path = folder_ / "large.flmap";
  Map map = copiesOfAView(401);
  writeMap(path, map);
  std::swap(map.models[1].name, map.models[2].name);
  const PlaceIndex other(map);
  MapDatabase::open(path).setPlaceIndex([&other](std::ostream& out) { other.write(out); });
  EXPECT_FALSE(hasItsIndex(path));
  complete(path);
  EXPECT_TRUE(hasItsIndex(path));
}

TEST_F(MapCompletion, AMapThatIsReadAsAWholeNeedsNoIndex) {
  const std::string path = folder_ / "small.flmap";
  writeMap(path, copiesOfAView(3));
  const std::string bytes = contentOf(path);
  complete(path);
  EXPECT_EQ(contentOf(path), bytes);
}

TEST_F(MapCompletion, AnIndexGoesIntoAMapFileAsItIsWritten) {
  const std::string path = folder_ / "large.flmap";
  const Map map = copiesOfAView(401);
  writeMap(path, map, placeIndexOf(map));
  EXPECT_TRUE(hasItsIndex(path));
}

TEST_F(MapCompletion, TheMountingIsFoundByTheFloor) {
  const std::string path = folder_ / "small.flmap";
  Map map = copiesOfAView(12);
  map.camera.mounting.reset();
  for (std::size_t i = 0; i < map.models.size(); ++i)
    map.models[i].T_w_m->translation().x() += 0.3 * static_cast<double>(i);
  writeMap(path, map);
  const auto complete = [&] {
    return captured([&](const Console& console) { return completeMap(path, 1, console, true), kOk; }).out;
  };
  EXPECT_THAT(complete(), HasSubstr("the camera is mounted"));
  ASSERT_TRUE(openMap(path).camera.mounting);
  EXPECT_TRUE(openMap(path).camera.mounting->agreesWith(kMounting));
  EXPECT_EQ(complete(), "") << "it is known";
}

}  // namespace
}  // namespace facetloc::test
