// SPDX-License-Identifier: BSD-3-Clause

#include "base/text.h"

#include <gtest/gtest.h>

namespace facetloc {
namespace {

TEST(Text, Numbers) {
  EXPECT_EQ(text::decimals(2.345, 1), "2.3");
  EXPECT_EQ(text::decimals(-0.0, 2), "0.00");
  EXPECT_EQ(text::significant(1.0 / 3), "0.333333333");
  EXPECT_EQ(text::to<double>(text::shortest(1.0 / 3)), 1.0 / 3);
  EXPECT_EQ(text::to<double>("+5"), 5);  // as in all files
  EXPECT_FALSE(text::to<double>("1.5 m"));
  EXPECT_FALSE(text::to<double>(""));
}

TEST(Text, CsvCells) {
  EXPECT_EQ(text::csvCell("plain"), "plain");
  EXPECT_EQ(text::csvCell("a, b"), "\"a, b\"");
  EXPECT_EQ(text::csvCell("say \"a\""), "\"say \"\"a\"\"\"");
}

}  // namespace
}  // namespace facetloc
