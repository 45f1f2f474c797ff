// SPDX-License-Identifier: BSD-3-Clause
// Held against PCL's own LZF.
#include "bytes/lzf.h"

#include <gtest/gtest.h>
#include <pcl/io/lzf.h>

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

}  // namespace
}  // namespace facetloc::test
