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
