// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/local_model.h>
#include <facetloc/testing/map_of_view.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace facetloc {
namespace {

View viewOf(int segments, bool picture = true) {
  View view;
  view.segments.resize(static_cast<std::size_t>(segments));
  if (picture) view.depth.camera = {160, 120, 130, 130, 80, 60};
  return view;
}

/** View number i has i segments; the odd ones have a picture. */
struct Counting : MapStore {
  std::shared_ptr<const View> view(int i) const override {
    return std::make_shared<const View>(viewOf(i, i % 2 == 1));
  }
};

TEST(Map, HoldsTheViewsOfItsModels) {
  Map map;
  map.models.emplace_back("a", 1, std::nullopt, viewOf(3));
  map.models.emplace_back("b", 2);
  map.models[1].setView(viewOf(5, false));
  EXPECT_EQ(map.view(0)->segments.size(), 3u);
  EXPECT_EQ(map.view(1)->segments.size(), 5u);
  EXPECT_TRUE(map.models[0].hasPicture());
  EXPECT_FALSE(map.models[1].hasPicture());
  EXPECT_EQ(map.store(), nullptr);
}

TEST(Map, SharesItsViewsWithCopies) {
  const Map map = test::mapOf(viewOf(3));
  Map copy = map;
  EXPECT_EQ(copy.view(0), map.view(0));
  copy.models[0].setView(viewOf(4));
  EXPECT_EQ(map.view(0)->segments.size(), 3u);
  EXPECT_EQ(copy.view(0)->segments.size(), 4u);
}

TEST(Map, RefusesToReadAViewThatIsNotThere) {
  Map map;
  map.models.emplace_back("a", 1);
  EXPECT_FALSE(map.models[0].hasPicture());
  EXPECT_THROW(map.view(0), std::logic_error);
}

TEST(Map, FindsTheViewsOfAStoreInAnyOrderAndInOtherMaps) {
  Map stored;
  stored.models.resize(4);
  stored.setStore(std::make_shared<Counting>());
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(stored.view(i)->segments.size(), static_cast<std::size_t>(i));
    EXPECT_EQ(stored.models[static_cast<std::size_t>(i)].hasPicture(), i % 2 == 1);
  }
  std::reverse(stored.models.begin(), stored.models.end());
  EXPECT_EQ(stored.view(0)->segments.size(), 3u);
  Map other = test::mapOf(viewOf(7));
  other.models.push_back(stored.models[1]);
  EXPECT_EQ(other.view(1)->segments.size(), 2u);
  stored.models[0].setView(viewOf(9));
  EXPECT_EQ(stored.view(0)->segments.size(), 9u);
  EXPECT_EQ(stored.view(1)->segments.size(), 2u);
}

}  // namespace
}  // namespace facetloc
