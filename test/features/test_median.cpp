// SPDX-License-Identifier: BSD-3-Clause
#include "base/median.h"

#include <gtest/gtest.h>

#include <array>

namespace facetloc::internal {
namespace {

TEST(Median, IsTheValueInTheMiddle) {
  EXPECT_EQ(median(std::vector<int>{7}), 7);
  EXPECT_EQ(median(std::vector<double>{3, 1, 2}), 2);
  EXPECT_EQ(median(std::vector<double>{5, 1, 1, 9, 1}), 1);
}

TEST(Median, OfAnEvenNumberIsTheUpperOfTwo) {
  EXPECT_EQ(median(std::vector<double>{4, 1}), 4);
  EXPECT_EQ(median(std::vector<double>{4, 1, 3, 2}), 3);
}

TEST(Median, OfPartOfARangeLeavesTheRestWhereItIs) {
  std::array<float, 5> values = {3, 1, 2, -1, -2};
  EXPECT_EQ(median(values.begin(), values.begin() + 3), 2);
  EXPECT_EQ(values[3], -1);
  EXPECT_EQ(values[4], -2);
}

}  // namespace
}  // namespace facetloc::internal
