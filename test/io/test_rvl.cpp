// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/depth_messages.h"
#include "temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace facetloc::internal {
namespace {

using test::ioErrorOf;
using testing::ElementsAre;
using testing::HasSubstr;

Bytes code(std::uint8_t width, std::uint8_t height, const Bytes& words) {
  Bytes bytes(8 + words.size());
  bytes[0] = width, bytes[4] = height;
  std::copy(words.begin(), words.end(), bytes.begin() + 8);
  return bytes;
}

StoredDepth read(const Bytes& bytes) { return readRvl({bytes.data(), bytes.size()}, "image"); }

// Encoded by hand: 2 zeros, 3 others: +10 = 20 = 4 + 2*8 -> C 2; -1 -> 1; +2 -> 4; nibbles 2 3 C 2 1 4,
// filled up with 0.
TEST(Rvl, RunsAndDifferencesAreThoseOfThePaper) {
  EXPECT_THAT(read(code(5, 1, {0x00, 0x14, 0xC2, 0x23})).numbers, ElementsAre(0, 0, 10, 9, 11));
  EXPECT_THAT(read(code(2, 3, {0, 0, 0, 0x60})).numbers, ElementsAre(0, 0, 0, 0, 0, 0)) << "zeros alone";
}

TEST(Rvl, CodesOfAnotherNumberOfPixelsAreRefused) {
  const Bytes sound = code(5, 1, {0x00, 0x14, 0xC2, 0x23});
  for (std::size_t size = 0; size < sound.size(); ++size)
    EXPECT_THAT(ioErrorOf([&] {
                  read({sound.begin(), sound.begin() + static_cast<std::ptrdiff_t>(size)});
                }),
                HasSubstr("image"));
  EXPECT_THAT(ioErrorOf([&] { read(code(4, 1, {0x00, 0x14, 0xC2, 0x23})); }), HasSubstr("corrupt"));
  EXPECT_THAT(ioErrorOf([&] { read(code(0, 7, {})); }), HasSubstr("0x7"));
  EXPECT_THAT(ioErrorOf([&] { read(Bytes(64, 0xFF)); }), HasSubstr("claims"));
  Bytes huge = code(0, 0, {0x00, 0x14, 0xC2, 0x23});
  huge[1] = huge[5] = 0x20;  // 8192 x 8192
  EXPECT_THAT(ioErrorOf([&] { read(huge); }), HasSubstr("corrupt"));
}

TEST(Rvl, AnyBytesAreAnImageOrRefused) {
  std::mt19937 random(1);
  for (int n = 0; n < 20000; ++n) {
    Bytes bytes =
        code(static_cast<std::uint8_t>(random() % 20), static_cast<std::uint8_t>(random() % 20), {});
    for (std::size_t k = random() % 60; k > 0; --k) bytes.push_back(static_cast<std::uint8_t>(random()));
    ioErrorOf([&] { EXPECT_EQ(read(bytes).numbers.size(), std::size_t(bytes[0]) * bytes[4]); });
  }
}

}  // namespace
}  // namespace facetloc::internal
