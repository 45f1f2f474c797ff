// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/params.h>
#include <facetloc/features/segment_estimation.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace facetloc {
namespace {

using testing::HasSubstr;

TEST(Params, DefaultsAreValid) { EXPECT_NO_THROW(SegmentEstimationParams{}.validate()); }

TEST(Params, TheFirstFieldOutsideItsRangeIsNamed) {
  SegmentEstimationParams p;
  p.trim = 0.5;
  p.offset_floor = -1;
  try {
    p.validate();
    FAIL() << "0.5 was accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_THAT(e.what(), HasSubstr("trim = 0.5"));
    EXPECT_THAT(e.what(), HasSubstr("[1, 100]"));
  }
}

TEST(Params, NotANumberIsOutsideEveryRange) {
  SegmentEstimationParams p;
  p.max_depth = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(p.validate(), std::invalid_argument);
}

TEST(Params, IniTextKeepsEveryDigitInTheOrderOfTheDescription) {
  SegmentEstimationParams p;
  p.max_depth = 1.0 / 3;
  const std::string text = toIni(p);
  EXPECT_THAT(text, HasSubstr("max_depth = 0.3333333333333333\n"));
  EXPECT_THAT(text, HasSubstr("offset_floor = 0.002\n"));
  EXPECT_LT(text.find("min_support"), text.find("offset_floor"));
}

}  // namespace
}  // namespace facetloc
