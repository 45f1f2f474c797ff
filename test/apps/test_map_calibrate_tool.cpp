// SPDX-License-Identifier: BSD-3-Clause
#include "example_room.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/io/map_database.h>

namespace facetloc::test {
namespace {

SureThreshold strict() {
  SureThreshold t;
  t.min_probability = 1;
  t.alpha = 0.01;
  t.confidence = 0.95;
  t.images = t.sure = 500;
  t.source = "a walk";
  return t;
}

/** The room has few images: a large alpha and little confidence. */
TEST_F(Tools, MapIsCalibratedByARecording) {
  const std::string copy = folder_ / "copy.flmap";
  fs::copy_file(map(), copy);
  EXPECT_THAT(runMap({"info", copy}).out, HasSubstr("p >= 0.9, not calibrated"));
  const auto calibrated = ok(runMap({"calibrate", copy, query(), "--alpha", "0.4", "--confidence", "0.5"}));
  EXPECT_THAT(calibrated.out, HasSubstr("at most 40 % of the sure answers are wrong, with 50 % confidence"));
  const auto threshold = sureThresholdOf(openMap(copy));
  ASSERT_TRUE(threshold);
  EXPECT_EQ(threshold->alpha, 0.4);
  EXPECT_LE(threshold->images, kFrames);
  EXPECT_THAT(threshold->source, HasSubstr("query"));
  EXPECT_THAT(runMap({"info", copy}).out, HasSubstr(threshold->toString()));
  ok(runMap({"check", copy}));

  const auto own = runMap({"calibrate", copy, "--alpha", "0.5", "--confidence", "0.1"});
  if (own.code == kOk) {
    EXPECT_EQ(sureThresholdOf(openMap(copy))->source, "the map itself");
  } else {
    EXPECT_THAT(own.err, HasSubstr("no threshold is shown"));
  }
}

TEST_F(Tools, CalibrateSaysHowManyImagesAreMissing) {
  const std::string copy = folder_ / "copy.flmap", bytes = contentOf(map());
  fs::copy_file(map(), copy);
  EXPECT_THAT(runMap({"calibrate", copy, query()}), fails("are too few; it takes about "));
  EXPECT_TRUE(contentOf(copy) == bytes) << "the map stays as it is";
}

TEST_F(Tools, CalibrateWarnsOfTheRecordingThatTheMapIsMadeOf) {
  const std::string copy = folder_ / "copy.flmap";
  fs::copy_file(map(), copy);
  const auto same = runMap({"calibrate", copy, map_run(), "--alpha", "0.4", "--confidence", "0.5"});
  EXPECT_THAT(same.err, HasSubstr("are local models of the map and left out"));
  EXPECT_THAT(runMap({"calibrate", copy, query()}).err, Not(HasSubstr("left out")));
}

TEST_F(Tools, CalibrateRefusesSenselessOptions) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"calibrate", map(), query(), "--alpha", "0"},
                                             {"calibrate", map(), query(), "--alpha", "1"},
                                             {"calibrate", map(), query(), "--alpha", "nan"},
                                             {"calibrate", map(), query(), "--confidence", "1.5"},
                                             {"calibrate", map(), query(), "--max-translation", "-1"},
                                             {"calibrate", map(), query(), query()},
                                             {"calibrate", map(), "--poses", "x"},
                                             {"calibrate"}})
    EXPECT_EQ(runMap(arguments).code, kUsage) << arguments.back();
  EXPECT_EQ(runMap({"calibrate", folder_ / "no.flmap"}).code, kFailed);
  const std::string bare = folder_.copyOf(query(), "bare");
  fs::remove(bare + "/groundtruth.txt");
  EXPECT_THAT(runMap({"calibrate", map(), bare}), fails("has no poses"));
}

TEST_F(Tools, LocalizeIsAsSureAsTheMapWasCalibrated) {
  const std::string copy = folder_ / "copy.flmap", results = folder_ / "results";
  fs::copy_file(map(), copy);
  MapDatabase::open(copy).setMeta(kSureKey, toText(strict()));
  ok(runTool<localizeApp>({copy, query(), "-o", results}));
  EXPECT_THAT(contentOf(results + "/params.ini"), HasSubstr("min-probability = 1\n"));
  const auto by_user = runTool<localizeApp>({copy, query(), "-o", results, "--min-probability", "0.9"});
  EXPECT_THAT(by_user.out, Not(HasSubstr(" 0 sure")));
  EXPECT_THAT(contentOf(results + "/params.ini"), HasSubstr("min-probability = 0.9\n"));
}

/** It was found for the map as it was. */
TEST_F(Tools, AChangedMapIsNotCalibrated) {
  const std::string copy = folder_ / "copy.flmap", merged = folder_ / "merged.flmap";
  fs::copy_file(map(), copy);
  MapDatabase::open(copy).setMeta(kSureKey, toText(strict()));
  ok(runMap({"merge", copy, map(), "-o", merged}));
  const Map both = readMap(merged);
  EXPECT_FALSE(sureThresholdOf(both));
  for (const auto& [key, value] : both.meta) EXPECT_THAT(key, Not(EndsWith(kSureKey)));
  const Map whole = readMap(copy);
  writeMap(folder_ / "written.flmap", whole);
  EXPECT_TRUE(sureThresholdOf(readMap(folder_ / "written.flmap"))) << "a copy is as good";
  LocalModel another = whole.models[0];
  another.name = "another";
  MapDatabase::open(copy).add(another, *whole.view(0));
  EXPECT_FALSE(sureThresholdOf(readMap(copy)));
}

TEST_F(Tools, CheckFindsAThresholdThatIsImpossible) {
  const std::string copy = folder_ / "copy.flmap";
  fs::copy_file(map(), copy);
  MapDatabase::open(copy).setMeta(kSureKey, "min_probability=7");
  const auto check = runMap({"check", copy});
  EXPECT_EQ(check.code, kFailed);
  EXPECT_THAT(check.out, HasSubstr("the threshold of sure answers"));
  EXPECT_THAT(runMap({"info", copy}).err, HasSubstr("the threshold of sure answers"));
}

}  // namespace
}  // namespace facetloc::test
