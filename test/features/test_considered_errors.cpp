// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/map_metadata.h>

#include <gtest/gtest.h>

#include <stdexcept>

namespace facetloc {
namespace {

TEST(ConsideredErrors, AreKeptInTheMetaDataOfAMap) {
  Map map;
  EXPECT_EQ(consideredErrorsOf(map).views, 0);
  EXPECT_EQ(consideredErrorsOf(map).pixels_as_one, ConsideredErrors().pixels_as_one);
  map.meta[kConsideredErrorsKey] = toText(ConsideredErrors{62, 0.12 * kDegree, 0.005, 57});
  const ConsideredErrors read = consideredErrorsOf(map);
  EXPECT_DOUBLE_EQ(read.pixels_as_one, 62);
  EXPECT_DOUBLE_EQ(read.rotation_std, 0.12 * kDegree);
  EXPECT_DOUBLE_EQ(read.translation_std, 0.005);
  EXPECT_EQ(read.views, 57);
  EXPECT_EQ(read.toString(), "0.12 deg, 5 mm, and 62 pixels as one; from 57 of its views");
}

TEST(ConsideredErrors, NothingInAFileIsTrusted) {
  Map map;
  for (const char* text : {"", "62 0.12 0.005 57", "pixels_as_one=62 rotation_deg=0.12 translation=0.005",
                           "pixels_as_one=0 rotation_deg=0.12 translation=0.005 views=57",
                           "pixels_as_one=1e-300 rotation_deg=0.12 translation=0.005 views=57",
                           "pixels_as_one=62 rotation_deg=1e300 translation=0.005 views=57",
                           "pixels_as_one=62 rotation_deg=nan translation=0.005 views=57",
                           "pixels_as_one=62 rotation_deg=0.12 translation=inf views=57",
                           "pixels_as_one=62 rotation_deg=0.12 translation=-1 views=57",
                           "pixels_as_one=62 rotation_deg=0.12 translation=0.005 views=-1",
                           "rotation_deg=0.12 pixels_as_one=62 translation=0.005 views=57"}) {
    map.meta[kConsideredErrorsKey] = text;
    EXPECT_THROW(consideredErrorsOf(map), std::invalid_argument) << text;
  }
  EXPECT_THROW(toText(ConsideredErrors{-1, 0.1, 0.1, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace facetloc
