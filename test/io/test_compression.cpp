// SPDX-License-Identifier: BSD-3-Clause
// Held against PCL's own LZF.
#include "bytes/lzf.h"
#include "recordings/depth_messages.h"
#include "temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/io/lzf.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace facetloc::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/** Random bytes of few values, so that some of them repeat; the more values, the less. */
std::string randomBytes(std::size_t size, unsigned values, unsigned seed) {
  std::mt19937 random(seed);
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random() % values);
  return bytes;
}

std::vector<std::string> examples() {
  std::vector<std::string> all = {"", "a", "ab", "abc", "aaa", "aaaa", std::string(100000, 'x')};
  for (const unsigned values : {2u, 5u, 256u})
    for (const std::size_t size : {31u, 32u, 33u, 264u, 265u, 8191u, 8200u, 70000u})
      all.push_back(randomBytes(size, values, values + static_cast<unsigned>(size)));
  all.push_back(randomBytes(8192, 256, 1) + randomBytes(8192, 256, 1));  // as far as a repetition can be away
  all.push_back(randomBytes(8193, 256, 1) + randomBytes(8193, 256, 1));
  return all;
}

TEST(Lzf, PclUnpacksWhatIsPacked) {
  for (const std::string& bytes : examples()) {
    const std::string packed = lzfPacked(bytes);
    EXPECT_LE(packed.size(), bytes.size() + bytes.size() / 32 + 1);
    EXPECT_EQ(packed, lzfPacked(std::string(bytes)));
    if (bytes.empty()) continue;
    std::string unpacked(bytes.size(), '?');
    ASSERT_EQ(pcl::lzfDecompress(packed.data(), static_cast<unsigned>(packed.size()), unpacked.data(),
                                 static_cast<unsigned>(unpacked.size())),
              bytes.size());
    EXPECT_EQ(unpacked, bytes);
  }
  EXPECT_LT(lzfPacked(std::string(100000, 'x')).size(), 1500u);
}

TEST(Lzf, UnpacksWhatPclPacks) {
  for (const std::string& bytes : examples()) {
    std::string packed(2 * bytes.size() + 100, '?');
    const unsigned size = bytes.size() < 4
                              ? 0
                              : pcl::lzfCompress(bytes.data(), static_cast<unsigned>(bytes.size()),
                                                 packed.data(), static_cast<unsigned>(packed.size()));
    if (size == 0) continue;  // PCL packs no few bytes
    Bytes unpacked(bytes.size());
    ASSERT_TRUE(lzfUnpack(std::string_view(packed).substr(0, size), unpacked)) << bytes.size();
    EXPECT_TRUE(std::equal(unpacked.begin(), unpacked.end(), bytes.begin(),
                           [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); }));
  }
}

TEST(Lzf, AnyBytesAreUnpackedOrRefused) {
  std::mt19937 random(3);
  const std::string packed = lzfPacked(randomBytes(3000, 3, 3));
  for (int n = 0; n < 20000; ++n) {
    std::string torn = packed.substr(0, random() % (packed.size() + 1));
    for (int k = 0; k < 3 && !torn.empty(); ++k) torn[random() % torn.size()] = static_cast<char>(random());
    Bytes bytes(random() % 4000);
    lzfUnpack(torn, bytes);
  }
  Bytes other(2999), same(3000), more(3001);
  EXPECT_FALSE(lzfUnpack(packed, other));
  EXPECT_TRUE(lzfUnpack(packed, same));
  EXPECT_FALSE(lzfUnpack(packed, more));
}

Bytes code(std::uint8_t width, std::uint8_t height, const Bytes& words) {
  Bytes bytes(8 + words.size());
  bytes[0] = width, bytes[4] = height;
  std::copy(words.begin(), words.end(), bytes.begin() + 8);
  return bytes;
}

StoredDepth read(const Bytes& bytes) { return internal::readRvl({bytes.data(), bytes.size()}, "image"); }

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
}  // namespace facetloc::test
