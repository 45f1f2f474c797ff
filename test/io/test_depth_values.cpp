// SPDX-License-Identifier: BSD-3-Clause
#include "example_sequence.h"

#include <facetloc/io/depth_values.h>
#include <facetloc/io/png.h>

#include <functional>

namespace facetloc::test {
namespace {

/** A sequence whose values are changed after they were written. */
ValueCheck check(const std::function<int(int)>& change, double depth_scale = 1000) {
  const TemporaryFolder folder;
  const ExampleSequence example;
  example.write(folder.path());
  for (int i = 0; i < example.frames; ++i) {
    Raster<std::uint16_t> raster = readGreyPng(example.image(folder.path(), i), 16);
    for (std::uint16_t& value : raster.data)
      if (value != 0) value = static_cast<std::uint16_t>(change(value));
    writePng(example.image(folder.path(), i), raster);
  }
  return checkValues(depthValues(DepthSequence::open(folder.path())), depth_scale);
}

TEST(DepthValues, FindNoFaultWithMillimetres) {
  const ValueCheck found = check([](int v) { return v; });
  EXPECT_THAT(found.faults, IsEmpty());
  EXPECT_FALSE(found.impossible);
  EXPECT_EQ(found.values.divisor, 1);
  EXPECT_GT(found.median_depth, 0.6);
  EXPECT_THAT(check([](int v) { return 5 * v; }, 5000).faults, IsEmpty()) << "steps of a millimetre";
}

TEST(DepthValues, NameSwappedBytes) {
  const ValueCheck found = check([](int v) { return (v >> 8) | (v << 8); });
  EXPECT_THAT(found.faults, ElementsAre(HasSubstr("bytes of the PNG values are swapped")));
  EXPECT_TRUE(found.impossible);
}

TEST(DepthValues, NameRotatedBits) {
  const ValueCheck found = check([](int v) { return (v << 3) | (v >> 13); });
  ASSERT_FALSE(found.faults.empty());
  EXPECT_THAT(found.faults.front(), HasAll("multiples of 8", "8000", "by 3"));
}

TEST(DepthValues, NameEightBits) {
  EXPECT_THAT(check([](int v) { return 257 * (v / 16); }).faults.front(), HasSubstr("8 bits"));
  EXPECT_THAT(check([](int v) { return v / 16; }, 62.5).faults.front(), HasSubstr("8 bits"));
}

TEST(DepthValues, NameAScaleThatNoCameraHas) {
  EXPECT_THAT(check([](int v) { return v; }, 50).faults, ElementsAre(HasSubstr("beyond 10 m")));
  EXPECT_THAT(check([](int v) { return v; }, 5000).faults,
              ElementsAre(HasSubstr("nearer than depth cameras")));
}

TEST(DepthValues, OtherFormatsAreUnknown) {
  const ValueCheck found = checkValues({}, 1000);
  EXPECT_THAT(found.faults, IsEmpty());
  EXPECT_FALSE(found.impossible);
}

TEST(Optics, OfAnotherSizeOrUnitAreNamed) {
  EXPECT_EQ(opticsFault({}), "");
  EXPECT_EQ(opticsFault(kinectIntrinsics()), "");
  EXPECT_EQ(opticsFault({640, 576, 252, 252, 310, 340}), "") << "120 deg";
  EXPECT_THAT(opticsFault({160, 120, 262, 262, 159.5, 119.5}), HasSubstr("probably of images of 320x240"));
  EXPECT_THAT(opticsFault({640, 480, 525, 525, 319.5, 20}), HasSubstr("border: is the calibration"));
  EXPECT_THAT(opticsFault({160, 120, 0.91, 0.91, 0.5, 0.5}), HasSubstr("beyond 150 deg"));
}

}  // namespace
}  // namespace facetloc::test
