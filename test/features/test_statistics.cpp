// SPDX-License-Identifier: BSD-3-Clause
#include "base/median.h"
#include "base/text.h"

#include <facetloc/features/answer_state.h>
#include <facetloc/features/map_metadata.h>
#include <facetloc/features/pose.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <stdexcept>

namespace facetloc::internal {
namespace {

TEST(ChiSquareQuantile, IsThatOfTheDistributionToFourDigits) {
  constexpr struct {
    int n;
    double p;
  } kKnown[] = {{3, 0.95}, {3, 0.99}, {6, 0.95}, {6, 0.99}, {6, 0.999}};
  for (const auto& [n, p] : kKnown) {
    const double exact = boost::math::quantile(boost::math::chi_squared(n), p);
    EXPECT_NEAR(chiSquareQuantile(n, p), exact, 0.005) << n << " degrees of freedom, " << p;
  }
}

TEST(ChiSquareQuantile, IsAConstantOfTheCompiler) {
  constexpr double kGate = chiSquareQuantile(3, 0.99);
  static_assert(kGate > 11 && kGate < 12);
  EXPECT_THROW(chiSquareQuantile(4, 0.99), std::invalid_argument);
  EXPECT_THROW(chiSquareQuantile(3, 0.5), std::invalid_argument);
}

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

using testing::HasSubstr;

SureThreshold someThreshold() {
  SureThreshold t;
  t.min_probability = 0.998, t.alpha = 0.01, t.confidence = 0.95, t.images = 600;
  t.sure = 412, t.wrong = 1;
  t.source = "walks from here to there";
  return t;
}

TEST(SureThreshold, IsKeptInTheMetaDataOfAMap) {
  Map map;
  EXPECT_FALSE(sureThresholdOf(map));
  EXPECT_EQ(minProbabilityOf(map), kMinProbability);
  map.meta[kSureKey] = toText(someThreshold());
  const auto read = sureThresholdOf(map);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->min_probability, 0.998);
  EXPECT_EQ(read->alpha, 0.01);
  EXPECT_EQ(read->confidence, 0.95);
  EXPECT_EQ(read->images, 600);
  EXPECT_EQ(read->sure, 412);
  EXPECT_EQ(read->wrong, 1);
  EXPECT_EQ(read->source, "walks from here to there");
  EXPECT_EQ(minProbabilityOf(map), 0.998);
  EXPECT_THAT(read->toString(),
              HasSubstr("p >= 0.998: at most 1 % of the sure answers are wrong, with 95 %"));
}

TEST(SureThreshold, NothingInAFileIsTrusted) {
  Map map;
  for (const char* text :
       {"", "0.9", "min_probability=0.9",
        "min_probability=1.5 alpha=0.01 confidence=0.95 images=9 sure=5 wrong=0 from x",
        "min_probability=nan alpha=0.01 confidence=0.95 images=9 sure=5 wrong=0 from x",
        "min_probability=0.9 alpha=0 confidence=0.95 images=9 sure=5 wrong=0 from x",
        "min_probability=0.9 alpha=0.01 confidence=0.95 images=9 sure=5 wrong=6 from x",
        "min_probability=0.9 alpha=0.01 confidence=0.95 images=9 sure=50 wrong=0 from x",
        "min_probability=0.9 alpha=0.01 confidence=0.95 images=9 sure=5 wrong=-1 from x",
        "alpha=0.01 min_probability=0.9 confidence=0.95 images=9 sure=5 wrong=0 from x",
        "min_probability=0.9 alpha=0.01 confidence=0.95 images=9999999999 sure=5 wrong=0 from x",
        "min_probability=0.9 alpha=0.01 confidence=0.95 images=9 sure=5 wrong=0"}) {
    map.meta[kSureKey] = text;
    EXPECT_THROW(sureThresholdOf(map), std::invalid_argument) << text;
    EXPECT_THROW(minProbabilityOf(map), std::invalid_argument) << text;
  }
  SureThreshold t = someThreshold();
  t.alpha = 2;
  EXPECT_THROW(toText(t), std::invalid_argument);
}

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
}  // namespace facetloc::internal
