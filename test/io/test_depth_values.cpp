// SPDX-License-Identifier: BSD-3-Clause
#include "example_sequence.h"

#include <facetloc/io/depth_values.h>
#include <facetloc/io/png.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace facetloc::test {
namespace {

/** The findings on a sequence whose values are changed after they were written. \param change value of an
 * image's number, a pixel and its old value */
Findings findingsOn(const std::function<int(int i, int u, int v, int value)>& change, double depth_scale,
                    double max_depth = std::numeric_limits<double>::infinity()) {
  const TemporaryFolder folder;
  const ExampleSequence example;
  example.write(folder.path());
  CameraFile file;
  file.camera.intrinsics = example.camera;
  file.camera.max_depth = max_depth;
  file.depth_scale = depth_scale;
  writeCameraFile(folder.path() / "camera.ini", file);
  for (int i = 0; i < example.frames; ++i) {
    Raster<std::uint16_t> raster = readGreyPng(example.image(folder.path(), i), 16);
    for (int v = 0; v < raster.height; ++v)
      for (int u = 0; u < raster.width; ++u) {
        std::uint16_t& value = raster.data[static_cast<std::size_t>(v) * raster.width + u];
        value = static_cast<std::uint16_t>(change(i, u, v, value));
      }
    writePng(example.image(folder.path(), i), raster);
  }
  Findings found = readingFindings(DepthSequence::open(folder.path()));
  found.erase(std::remove_if(found.begin(), found.end(),
                             [](const Finding& finding) { return finding.severity == Severity::note; }),
              found.end());
  return found;
}

Findings check(const std::function<int(int)>& change, double depth_scale = 1000) {
  return findingsOn([&](int, int, int, int value) { return value == 0 ? 0 : change(value); }, depth_scale);
}

std::vector<std::string> wordsOf(const Findings& findings) {
  std::vector<std::string> words;
  for (const Finding& finding : findings) words.push_back(finding.words);
  return words;
}

TEST(DepthValues, OfFramesAreJudgedAsThoseOfFiles) {
  const TemporaryFolder folder;
  ExampleSequence().write(folder.path());
  const DepthSequence sequence = DepthSequence::open(folder.path());
  std::vector<DepthImage> images;
  for (std::size_t i = 0; i < sequence.frames().size(); ++i) images.push_back(sequence.load(i));
  const auto ids = [&] {
    std::vector<std::string> found;
    for (const Finding& finding : depthFindings(images, std::numeric_limits<double>::infinity()))
      found.push_back(finding.id);
    return found;
  };
  EXPECT_THAT(ids(), Not(testing::Contains("values.scale")));
  for (DepthImage& image : images)
    for (float& z : image.depth) z *= 100;
  EXPECT_THAT(ids(), testing::Contains("values.scale"));
}

TEST(DepthValues, FindNoFaultWithMillimetres) {
  EXPECT_THAT(check([](int v) { return v; }), IsEmpty());
  EXPECT_THAT(check([](int v) { return 5 * v; }, 5000), IsEmpty()) << "steps of a millimetre";
}

TEST(DepthValues, NameSwappedBytes) {
  const Findings found = check([](int v) { return (v >> 8) | (v << 8); });
  EXPECT_THAT(wordsOf(found), ElementsAre(HasSubstr("bytes of the PNG values are swapped")));
  EXPECT_NE(firstOf(found, Severity::refusal), nullptr);
}

TEST(DepthValues, NameRotatedBits) {
  const Findings found = check([](int v) { return (v << 3) | (v >> 13); });
  ASSERT_FALSE(found.empty());
  EXPECT_THAT(found.front().words, HasAll("multiples of 8", "8000", "by 3"));
}

TEST(DepthValues, NameEightBits) {
  EXPECT_THAT(check([](int v) { return 257 * (v / 16); }).front().words, HasSubstr("8 bits"));
  EXPECT_THAT(check([](int v) { return v / 16; }, 62.5).front().words, HasSubstr("8 bits"));
}

TEST(DepthValues, NameAScaleThatNoCameraHas) {
  EXPECT_THAT(wordsOf(check([](int v) { return v; }, 50)), ElementsAre(HasSubstr("beyond 10 m")));
  EXPECT_THAT(wordsOf(check([](int v) { return v; }, 5000)),
              ElementsAre(HasSubstr("nearer than depth cameras")));
}

TEST(Optics, OfAnotherSizeOrUnitAreNamed) {
  EXPECT_FALSE(opticsFinding({}));
  EXPECT_FALSE(opticsFinding(kinectIntrinsics()));
  EXPECT_FALSE(opticsFinding({640, 576, 252, 252, 310, 340})) << "120 deg";
  EXPECT_THAT(opticsFinding({160, 120, 262, 262, 159.5, 119.5})->words,
              HasSubstr("probably of images of 320x240"));
  EXPECT_THAT(opticsFinding({640, 480, 525, 525, 319.5, 20})->words, HasSubstr("border: is the calibration"));
  EXPECT_THAT(opticsFinding({160, 120, 0.91, 0.91, 0.5, 0.5})->words, HasSubstr("beyond 150 deg"));
}

/** A wall that recedes to the right, in millimetres, and from image to image. */
int wall(int i, int u, int /*v*/) {
  const double x = (u - 31.5) / 60;
  return static_cast<int>(std::lround(1e3 * (1.2 + 0.02 * i) / (1 - 1.2 * x)));
}

/** The ids of the findings on a sequence of such values. */
std::vector<std::string> idsOf(const std::function<int(int i, int u, int v)>& value,
                               double depth_scale = 1000,
                               double max_depth = std::numeric_limits<double>::infinity()) {
  std::vector<std::string> ids;
  for (const Finding& finding :
       findingsOn([&](int i, int u, int v, int) { return value(i, u, v); }, depth_scale, max_depth))
    ids.push_back(finding.id);
  return ids;
}

TEST(ValuesWithoutGeometry, OfAWallAreRight) { EXPECT_THAT(idsOf(wall), IsEmpty()); }

TEST(ValuesWithoutGeometry, OutOfRangeAreALimit) {
  const auto clipped = [](int i, int u, int v) { return std::min(2500, wall(i, u, v)); };
  EXPECT_THAT(idsOf(clipped), ElementsAre("values.limit"));
  EXPECT_THAT(idsOf(clipped, 1000, 2.4), IsEmpty()) << "left out by max_depth";
  EXPECT_THAT(idsOf([](int i, int u, int v) { return v < 10 ? 300 : wall(i, u, v); }),
              ElementsAre("values.limit"));
}

TEST(ValuesWithoutGeometry, OfADepthBufferAreNamed) {
  EXPECT_THAT(idsOf(
                  [](int i, int u, int v) {
                    const double near = 0.05, far = 10, z = wall(i, u, v) / 1e3;
                    return static_cast<int>(65534 * far * (z - near) / (z * (far - near)));
                  },
                  65534),
              ElementsAre("values.buffer"));
}

TEST(ValuesWithoutGeometry, OfAConstantMinusTheDepthAreInverted) {
  EXPECT_THAT(idsOf([](int i, int u, int v) { return 5000 - wall(i, u, v); }),
              ElementsAre("values.inverted"));
}

TEST(ValuesWithoutGeometry, OfEachImageStretched) {
  const auto stretched = [](int limit) {
    return [limit](int i, int u, int v) { return limit * wall(i, u, v) / wall(i, 63, 0); };
  };
  EXPECT_THAT(idsOf(stretched(65535), 20000), ElementsAre("values.stretched"));
}

TEST(ValuesWithoutGeometry, OfOneImageOrOneValue) {
  EXPECT_THAT(idsOf([](int, int u, int v) { return wall(0, u, v); }), ElementsAre("values.frozen"));
  EXPECT_THAT(idsOf([](int, int, int) { return 1200; }), ElementsAre("values.single"));
  EXPECT_THAT(idsOf([](int i, int u, int v) { return i == 0 ? 1200 : wall(i, u, v); }),
              ElementsAre("values.single"));
}

}  // namespace
}  // namespace facetloc::test
