// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/text.h>

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

namespace facetloc {
namespace {

TEST(Text, Numbers) {
  EXPECT_EQ(fixed(2.345, 1), "2.3");
  EXPECT_EQ(fixed(-0.0, 2), "0.00");
  EXPECT_EQ(shortNumber(1.0 / 3), "0.333333333");
  EXPECT_EQ(toNumber(exactNumber(1.0 / 3)), 1.0 / 3);
  EXPECT_EQ(toNumber("+5"), 5);  // as in all files
  EXPECT_FALSE(toNumber("1.5 m"));
  EXPECT_FALSE(toNumber(""));
  EXPECT_EQ(counted(1, "image"), "1 image");
  EXPECT_EQ(counted(0, "image"), "0 images");
}

TEST(Text, CsvCells) {
  EXPECT_EQ(csvCell("plain"), "plain");
  EXPECT_EQ(csvCell("a, b"), "\"a, b\"");
  EXPECT_EQ(csvCell("say \"a\""), "\"say \"\"a\"\"\"");
}

TEST(TextTable, AlignsColumns) {
  TextTable table({"", "n", "remark"});
  table.setWordsLast();
  table.add({"one", "1", "x"});
  table.add({"more", "100"});
  std::ostringstream out;
  out << table;
  EXPECT_EQ(out.str(), "        n  remark\n"
                       "one     1  x\n"
                       "more  100\n");
}

}  // namespace
}  // namespace facetloc
