// SPDX-License-Identifier: BSD-3-Clause
#include "cli/text.h"

#include <gtest/gtest.h>

#include <sstream>

namespace facetloc::test {
namespace {

TEST(Text, CountedThings) {
  EXPECT_EQ(counted(1, "image"), "1 image");
  EXPECT_EQ(counted(0, "image"), "0 images");
}

TEST(Text, ControlCharactersAreSpelledOut) {
  EXPECT_EQ(printable("a\tb\n\xC3\xA4"), "a\tb\n\xC3\xA4");
  EXPECT_EQ(printable("\x1B[31mred\r\x7F"), "\\x1b[31mred\\x0d\\x7f");
  EXPECT_EQ(printable("\xC2\x9B"
                      "1m\xC2\xA0\xC2"),
            "\\x9b"
            "1m\xC2\xA0\xC2");
  EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
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
}  // namespace facetloc::test
