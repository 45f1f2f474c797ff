// SPDX-License-Identifier: BSD-3-Clause
#include "models/view_cover.h"

#include <gtest/gtest.h>

#include <random>

namespace facetloc::internal {
namespace {

bool covers(const Substitutes& substitutes, const std::vector<std::size_t>& chosen, double shared) {
  std::vector<bool> covered(substitutes.of.size());
  for (const std::size_t i : chosen) {
    covered[i] = true;
    for (const Substitutes::Entry& e : substitutes.of[i])
      if (e.shared >= shared) covered[e.view] = true;
  }
  return std::count(covered.begin(), covered.end(), false) == 0;
}

/** Size of the smallest cover, by trying all. */
std::size_t least(const Substitutes& substitutes, double shared) {
  const std::size_t n = substitutes.of.size();
  std::size_t best = n;
  for (unsigned set = 0; set < 1u << n; ++set) {
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < n; ++i)
      if (set >> i & 1) chosen.push_back(i);
    if (chosen.size() < best && covers(substitutes, chosen, shared)) best = chosen.size();
  }
  return best;
}

TEST(CoveringViews, CoverAllWithFew) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> share(0, 1);
  int chosen_in_all = 0, least_in_all = 0;
  for (int run = 0; run < 50; ++run) {
    Substitutes substitutes;
    substitutes.of.resize(10);
    for (std::uint32_t i = 0; i < 10; ++i)
      for (std::uint32_t j = 0; j < 10; ++j)
        if (i != j && share(random) < 0.3f) substitutes.of[i].push_back({j, share(random)});
    const auto chosen = coveringViews(substitutes, 0.4);
    EXPECT_TRUE(covers(substitutes, chosen, 0.4));
    EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
    chosen_in_all += static_cast<int>(chosen.size());
    least_in_all += static_cast<int>(least(substitutes, 0.4));
  }
  EXPECT_LT(chosen_in_all, 1.15 * least_in_all);
}

TEST(SharedPart, IsTheShareOfThePixelsThatBothSee) {
  // Cameras that look at a wall at a depth of 2 m, the second one to the right by half of the width of an
  // image there.
  const Intrinsics camera{40, 30, 40, 40, 19.5, 14.5};
  const auto seen = [&](double x, double z) {
    SmallView view{Eigen::Isometry3d::Identity(), std::vector<float>(40 * 30, 2.0f - static_cast<float>(z))};
    view.T_w_c.translation() << x, 0, z;
    return view;
  };
  EXPECT_DOUBLE_EQ(1, sharedPart(seen(0, 0), seen(0, 0), camera));
  EXPECT_NEAR(0.5, sharedPart(seen(0, 0), seen(1, 0), camera), 0.05);
  EXPECT_NEAR(0.25, sharedPart(seen(0, 0), seen(0, 1), camera), 0.05);  // seen at half the distance
  EXPECT_NEAR(1, sharedPart(seen(0, 1), seen(0, 0), camera), 0.05);
  SmallView hidden = seen(0, 0);
  hidden.depth.assign(hidden.depth.size(), 1.0f);  // something stands in front of the wall
  EXPECT_DOUBLE_EQ(0, sharedPart(seen(0, 0), hidden, camera));
  SmallView unknown = seen(0, 0);
  unknown.depth.assign(unknown.depth.size(), 0.0f);
  EXPECT_DOUBLE_EQ(0, sharedPart(seen(0, 0), unknown, camera));
  EXPECT_DOUBLE_EQ(0, sharedPart(unknown, seen(0, 0), camera));
}

}  // namespace
}  // namespace facetloc::internal
