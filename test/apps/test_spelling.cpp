// SPDX-License-Identifier: BSD-3-Clause
#include "cli/spelling.h"

#include <gtest/gtest.h>

namespace facetloc::test {
namespace {

TEST(Spelling, TheNearestWordIsNamedIfOneIsNear) {
  const std::vector<std::string> known = {"device", "map", "every-frame", "ekf.iterations"};
  EXPECT_EQ(nearestWord("devcie", known), "device") << "swapped";
  EXPECT_EQ(nearestWord("devic", known), "device");
  EXPECT_EQ(nearestWord("every_frames", known), "every-frame");
  EXPECT_EQ(nearestWord("iterations", known), "ekf.iterations");
  EXPECT_EQ(nearestWord("iteratoins", known), "ekf.iterations");
  EXPECT_EQ(nearestWord("mop", known), "map");
  EXPECT_EQ(nearestWord("xyz", known), "");
  EXPECT_EQ(nearestWord("", known), "");
  EXPECT_EQ(nearestWord(std::string(100000, 'x'), known), "");
  EXPECT_EQ(didYouMean("mapp", known, "--"), "; did you mean '--map'?");
  EXPECT_EQ(didYouMean("nothing_like_it", known), "");
}

}  // namespace
}  // namespace facetloc::test
