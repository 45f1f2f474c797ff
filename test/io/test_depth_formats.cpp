// SPDX-License-Identifier: BSD-3-Clause
// Depth in formats other than PNG: the same depth comes out of each; a broken file is an error with its
// name.
#include "images/depth_file.h"
#include "temporary_folder.h"

#include <facetloc/io/depth_sequence.h>

#include <pcl/io/lzf_image_io.h>

#include <cstring>
#include <random>

namespace facetloc::test {
namespace {

constexpr int kWidth = 3, kHeight = 2;
const std::vector<std::uint16_t> kNumbers = {0, 1000, 1001, 2000, 65534, 3};

template <typename T>
std::string bytes(const std::vector<T>& values, bool big_endian = false) {
  std::string out;
  for (const T value : values) {
    std::string one(sizeof value, '\0');
    std::memcpy(one.data(), &value, sizeof value);
    out += big_endian ? std::string(one.rbegin(), one.rend()) : one;
  }
  return out;
}

/** An uncompressed TIFF of one strip, little-endian. \param kind 1: whole numbers, 3: floating point */
template <typename T>
std::string tiff(const std::vector<T>& values, int kind, int channels = 1) {
  const std::string pixels = bytes(values);
  const auto entry = [](std::uint16_t tag, std::uint16_t type, std::uint32_t value) {
    return bytes<std::uint16_t>({tag, type}) + bytes<std::uint32_t>({1, value});
  };
  constexpr std::uint16_t kShort = 3, kLong = 4;
  const std::vector<std::string> entries = {entry(256, kLong, kWidth),
                                            entry(257, kLong, kHeight),
                                            entry(258, kShort, 8 * sizeof(T)),
                                            entry(259, kShort, 1),
                                            entry(262, kShort, 1),
                                            entry(273, kLong, 8),
                                            entry(277, kShort, static_cast<std::uint32_t>(channels)),
                                            entry(278, kLong, kHeight),
                                            entry(279, kLong, static_cast<std::uint32_t>(pixels.size())),
                                            entry(339, kShort, static_cast<std::uint32_t>(kind))};
  std::string file = "II" + bytes<std::uint16_t>({42}) +
                     bytes<std::uint32_t>({static_cast<std::uint32_t>(8 + pixels.size())}) + pixels;
  file += bytes<std::uint16_t>({static_cast<std::uint16_t>(entries.size())});
  for (const std::string& e : entries) file += e;
  return file + bytes<std::uint32_t>({0});
}

std::string npy(const std::string& type, const std::string& shape, const std::string& pixels,
                const char* order = "False") {
  std::string header =
      "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': (" + shape + "), }";
  header.resize(118, ' ');
  return "\x93NUMPY\x01" + std::string(1, '\0') +
         bytes<std::uint16_t>({static_cast<std::uint16_t>(header.size())}) + header + pixels;
}

class DepthFormats : public InAFolder {
protected:
  StoredDepth read(const std::string& name, const std::string& content) const {
    return readDepthValues(putBytes(folder_ / name, content));
  }
  std::string errorOf(const std::string& name, const std::string& content) const {
    return ioErrorOf([&] { read(name, content); });
  }
  void expectNumbers(const std::string& name, const std::string& content) const {
    const StoredDepth values = read(name, content);
    EXPECT_EQ(values.width, kWidth) << name;
    EXPECT_EQ(values.height, kHeight) << name;
    EXPECT_EQ(values.numbers, kNumbers) << name;
  }
};

TEST_F(DepthFormats, WholeNumbers) {
  expectNumbers("a.tiff", tiff(kNumbers, 1));
  expectNumbers("a.TIF", tiff(kNumbers, 1));
  expectNumbers("a.npy", npy("<u2", "2, 3", bytes(kNumbers)));
  expectNumbers("a.npy", npy(">u2", "2, 3", bytes(kNumbers, true)));
  expectNumbers("a.npy", npy("<u2", "2, 3, 1", bytes(kNumbers)));
  expectNumbers("a.npy", npy("<u2", "1, 2, 3", bytes(kNumbers)));
  expectNumbers("a.npy", npy("<i4", "2, 3", bytes<std::int32_t>({-1, 1000, 1001, 2000, 65534, 3})));
  expectNumbers("a.npy", npy("<u2", "2, 3", bytes<std::uint16_t>({0, 2000, 1000, 65534, 1001, 3}), "True"));
  expectNumbers("a.pgm", "P5\n# a comment\n3 2\n65535\n" + bytes(kNumbers, true));
  std::string decimal = "P2 3 2 65535";
  for (const std::uint16_t number : kNumbers) decimal += " " + std::to_string(number);
  expectNumbers("a.pgm", decimal);
  const fs::path packed = folder_ / "frame_20200101T000000.000000_depth.pclzf";
  pcl::io::LZFDepth16ImageWriter writer;
  ASSERT_TRUE(writer.write(reinterpret_cast<const char*>(kNumbers.data()), kWidth, kHeight, packed.string()));
  EXPECT_EQ(readDepthValues(packed).numbers, kNumbers);
}

TEST_F(DepthFormats, SignedNumbersOfTwoBytes) {
  const StoredDepth values =
      read("a.npy", npy("<i2", "2, 3", bytes<std::int16_t>({-1, 0, 1, 1000, 32767, -32768})));
  EXPECT_THAT(values.numbers, ElementsAre(0, 0, 1, 1000, 32767, 0));
}

TEST_F(DepthFormats, FloatingPointIsInMetres) {
  const float kNone = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> metres = {0, 1, 1.5f, kNone, 2, -1};
  const auto expect = [](const StoredDepth& values) {
    EXPECT_THAT(values.metres, ElementsAre(0, 1, 1.5f, 0, 2, 0));
  };
  expect(read("a.tif", tiff(metres, 3)));
  expect(read("a.tif", tiff(std::vector<double>(metres.begin(), metres.end()), 3)));
  expect(read("a.npy", npy("<f4", "2, 3", bytes(metres))));
  expect(read("a.npy", npy("<f8", "2, 3", bytes(std::vector<double>(metres.begin(), metres.end())))));
  expect(
      read("a.npy", npy("<f2", "2, 3", bytes<std::uint16_t>({0, 0x3C00, 0x3E00, 0x7E00, 0x4000, 0xBC00}))));
  std::vector<float> from_below(metres.begin() + 3, metres.end());
  from_below.insert(from_below.end(), metres.begin(), metres.begin() + 3);
  expect(read("a.pfm", "Pf\n3 2\n-1.0\n" + bytes(from_below)));
}

TEST_F(DepthFormats, FloatingPointMillimetresAreKnownByTheirSize) {
  EXPECT_THAT(read("a.tif", tiff<float>({0, 1000, 1500, 2000, 2500, 3000}, 3)).metres,
              ElementsAre(0, 1, 1.5f, 2, 2.5f, 3));
}

TEST_F(DepthFormats, DepthAlongTheNegativeAxisIsTurned) {
  EXPECT_THAT(read("a.tif", tiff<float>({0, -1, -1.5f, -2, -2.5f, 3}, 3)).metres,
              ElementsAre(0, 1, 1.5f, 2, 2.5f, 0));
}

TEST_F(DepthFormats, FilesThatAreNotOneDepthImageAreNamed) {
  EXPECT_THAT(errorOf("a.npy", npy("<u2", "5, 2, 3", bytes(kNumbers))), HasAll("a.npy", "5, 2, 3"));
  EXPECT_THAT(errorOf("a.npy", npy("|u1", "2, 3", "abcdef")), HasSubstr("u1"));
  EXPECT_THAT(errorOf("a.npy", npy("<u2", "70000, 70000", "")), HasSubstr("claims"));
  EXPECT_THAT(errorOf("a.npy", npy("<u2", "2, 3", "abc")), HasSubstr("truncated"));
  EXPECT_THAT(errorOf("a.npy", "numpy"), HasSubstr("not an NPY"));
  EXPECT_THAT(errorOf("a.pgm", "P5 3 2 255 abcdef"), HasSubstr("8 bits"));
  EXPECT_THAT(errorOf("a.pgm", "P4 3 2 1"), HasSubstr("not a PGM"));
  EXPECT_THAT(errorOf("a.pfm", "PF\n3 2\n-1.0\n"), HasSubstr("one channel"));
  EXPECT_THAT(errorOf("a.tif", tiff<std::uint8_t>({1, 2, 3, 4, 5, 6}, 1)), HasSubstr("8 bits"));
  EXPECT_THAT(errorOf("a.tif", tiff(kNumbers, 1, 2)), HasSubstr("channels"));
  EXPECT_THAT(errorOf("a.tif", "II*"), HasSubstr("TIFF"));
  EXPECT_THAT(errorOf("a.tif", ""), HasSubstr("TIFF"));
  EXPECT_THAT(errorOf("a.pclzf", "PCLZF"), HasSubstr("truncated"));
}

TEST_F(DepthFormats, TruncatedAndFlippedBytesAreErrorsOrImages) {
  const fs::path packed = folder_ / "x.pclzf";
  pcl::io::LZFDepth16ImageWriter().write(reinterpret_cast<const char*>(kNumbers.data()), kWidth, kHeight,
                                         packed.string());
  std::mt19937 engine(5);
  for (const auto& [name, sound] : {std::pair<std::string, std::string>{"a.tif", tiff(kNumbers, 1)},
                                    {"a.npy", npy("<u2", "2, 3", bytes(kNumbers))},
                                    {"a.pgm", "P5 3 2 65535\n" + bytes(kNumbers, true)},
                                    {"a.pfm", "Pf 3 2 -1\n" + bytes<float>({1, 2, 3, 4, 5, 6})},
                                    {"a.pclzf", bytesOf(packed)}})
    for (int i = 0; i < 300; ++i) {
      std::string broken = sound;
      if (i % 3 == 0) broken.resize(engine() % broken.size());
      if (i % 3 != 0) broken[engine() % broken.size()] = static_cast<char>(engine());
      errorOf(name, broken);
    }
}

TEST_F(DepthFormats, ASequenceReadsThem) {
  putBytes(folder_ / "camera.ini", "width=3 height=2 fx=2 fy=2 cx=1 cy=0.5 depth_scale=2000");
  putBytes(folder_ / "depth/1.5.npy", npy("<u2", "2, 3", bytes(kNumbers)));
  putBytes(folder_ / "depth/1.6.tif", tiff<float>({1, 1, 2, 2, 3, 3}, 3));
  const DepthSequence sequence = DepthSequence::open(folder_.path());
  EXPECT_EQ(sequence.load(0).depth[1], 0.5f);
  EXPECT_EQ(sequence.load(1).depth[2], 2);
}

TEST_F(DepthFormats, PclsRecordingsBringTheirCamera) {
  const std::string name = "frame_20200101T000000.250000";
  pcl::io::LZFDepth16ImageWriter writer;
  writer.write(reinterpret_cast<const char*>(kNumbers.data()), kWidth, kHeight,
               (folder_ / (name + "_depth.pclzf")).string());
  writer.writeParameters({7, 8, 1.5, 0.5}, (folder_ / (name + ".xml")).string());
  const DepthSequence sequence = DepthSequence::open(folder_.path());
  EXPECT_EQ(sequence.frames()[0].name, "1577836800.250000");
  EXPECT_EQ(sequence.camera()->camera.intrinsics, (Intrinsics{3, 2, 7, 8, 1.5, 0.5}));
  EXPECT_NEAR(sequence.load(0).depth[3], 2, 1e-6);
}

}  // namespace
}  // namespace facetloc::test
