// SPDX-License-Identifier: BSD-3-Clause
#include "tools/text.h"

#include <gtest/gtest.h>

#include <sstream>

namespace facetloc {
namespace {

TEST(Text, CountedThings) {
  EXPECT_EQ(counted(1, "image"), "1 image");
  EXPECT_EQ(counted(0, "image"), "0 images");
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
