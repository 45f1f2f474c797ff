// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/answer_state.h>
#include <facetloc/features/map_metadata.h>

#include <gmock/gmock.h>

#include <stdexcept>

namespace facetloc {
namespace {

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

}  // namespace
}  // namespace facetloc
