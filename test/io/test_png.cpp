// SPDX-License-Identifier: BSD-3-Clause
#include "temporary_folder.h"

#include <facetloc/io/png.h>
#include <facetloc/testing/full_disk.h>

#include <random>
#include <stdexcept>

namespace facetloc::test {
namespace {

/** A PNG from the hexadecimal bytes of its chunks. */
std::string png(const std::string& hex) {
  std::string bytes = "\x89PNG\r\n\x1a\n";
  for (std::size_t i = 0; i < hex.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  return bytes;
}

const std::string kEnd = "0000000049454E44AE426082";
const std::string kPalette = png("0000000D49484452000000020000000208030000004568FD16"
                                 "00000006504C5445000000FF00001BFF8D22"
                                 "0000000C4944415478DA636060044200000C0003159E18FC" +
                                 kEnd);
const std::string kOneBit = png("0000000D4948445200000008000000010100000000CB7BD2EE"
                                "0000000A4944415478DA6358050000AC00ABCB839EE6" +
                                kEnd);
const std::string kGreyAlpha = png("0000000D4948445200000001000000010804000000B51C0C02"
                                   "0000000B4944415478DA636064020000070004E5ED94CF" +
                                   kEnd);
const std::string kMillionSquared = png("0000000D49484452000F4240000F424010000000002996BBE2"
                                        "000000094944415478DA63000000010001B10DB693" +
                                        kEnd);

Raster<std::uint16_t> noisyImage(int width, int height) {
  std::mt19937 engine(7);
  Raster<std::uint16_t> image{width, height, 1, {}};
  for (int i = 0; i < width * height; ++i) image.data.push_back(static_cast<std::uint16_t>(engine()));
  return image;
}

std::string errorOf(const std::string& bytes) {
  const TemporaryFolder folder;
  putBytes(folder / "a.png", bytes);
  return ioErrorOf([&] { readGreyPng(folder / "a.png"); });
}

using Png = InAFolder;

TEST_F(Png, SixteenBitsRoundTrip) {
  const auto image = noisyImage(37, 23);
  writePng(folder_ / "a.png", image);
  const auto read = readGreyPng(folder_ / "a.png");
  EXPECT_EQ(read.width, 37);
  EXPECT_EQ(read.height, 23);
  EXPECT_EQ(read.channels, 1);
  EXPECT_EQ(read.data, image.data);
  EXPECT_EQ(folder_.count(), 1);
}

TEST_F(Png, EightBitsRoundTrip) {
  writePng(folder_ / "a.png", Raster<std::uint8_t>{3, 2, 1, {0, 1, 2, 127, 128, 255}});
  EXPECT_EQ(readGreyPng(folder_ / "a.png").data, (std::vector<std::uint16_t>{0, 1, 2, 127, 128, 255}));
  EXPECT_THAT(ioErrorOf([&] { readGreyPng(folder_ / "a.png", 16); }), HasSubstr("8 bits"));
}

TEST_F(Png, SameImageSameBytes) {
  writePng(folder_ / "a.png", noisyImage(64, 48));
  writePng(folder_ / "b.png", noisyImage(64, 48));
  EXPECT_EQ(bytesOf(folder_ / "a.png"), bytesOf(folder_ / "b.png"));
}

TEST_F(Png, RefusesColours) {
  writePng(folder_ / "rgb.png", Raster<std::uint8_t>{1, 2, 3, {1, 2, 3, 4, 5, 6}});
  EXPECT_THAT(ioErrorOf([&] { readGreyPng(folder_ / "rgb.png"); }), HasAll("rgb.png", "colour"));
  EXPECT_THAT(errorOf(kPalette), HasSubstr("palette"));
  EXPECT_THAT(errorOf(kGreyAlpha), HasSubstr("alpha"));
  EXPECT_THAT(errorOf(kOneBit), HasSubstr("1 bits"));
  EXPECT_THAT(errorOf(kMillionSquared), HasSubstr("1000000x1000000"));
}

TEST_F(Png, RefusesOtherFiles) {
  EXPECT_THAT(errorOf(""), HasSubstr("empty"));
  EXPECT_THAT(errorOf("short"), HasSubstr("not a PNG"));
  EXPECT_THAT(errorOf("a text file that is longer than a signature"), HasSubstr("not a PNG"));
  const TemporaryFolder folder;
  EXPECT_THAT(ioErrorOf([&] { readGreyPng(folder / "none.png"); }), HasSubstr("does not exist"));
  EXPECT_THAT(ioErrorOf([&] { readGreyPng(folder.path()); }), HasSubstr("folder"));
}

TEST_F(Png, EveryTruncationIsAnError) {
  writePng(folder_ / "a.png", noisyImage(16, 8));
  const std::string bytes = bytesOf(folder_ / "a.png");
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_NE(errorOf(bytes.substr(0, size)), "") << size;
}

TEST_F(Png, CorruptFilesAreErrorsOrImages) {
  writePng(folder_ / "a.png", noisyImage(16, 8));
  const std::string bytes = bytesOf(folder_ / "a.png");
  std::mt19937 engine(1);
  int refused = 0;
  for (int i = 0; i < 500; ++i) {
    std::string corrupt = bytes;
    corrupt[engine() % bytes.size()] ^= static_cast<char>(1 + engine() % 255);
    refused += !errorOf(corrupt).empty();
  }
  EXPECT_GT(refused, 490) << "the check sums cover nearly every byte";
}

TEST_F(Png, WritingIsChecked) {
  EXPECT_NE(ioErrorOf([&] { writePng(folder_ / "none/a.png", noisyImage(2, 2)); }), "");
  EXPECT_THROW(writePng(folder_ / "a.png", Raster<std::uint16_t>{2, 2, 1, {1}}), std::invalid_argument);
  EXPECT_THROW(writePng(folder_ / "a.png", Raster<std::uint16_t>{}), std::invalid_argument);
  EXPECT_THROW(writePng(folder_ / "a.png", Raster<std::uint8_t>{1, 1, 2, {1, 2}}), std::invalid_argument);
  EXPECT_EQ(folder_.count(), 0);
}

TEST_F(Png, AFullDiskIsAnError) {
  {
    const FullDisk full(1000);
    EXPECT_THAT(ioErrorOf([&] { writePng(folder_ / "a.png", noisyImage(200, 200)); }),
                HasSubstr(FullDisk::kWords));
    EXPECT_THROW(writePng(folder_ / "a.png", noisyImage(200, 200)), WriteError);
  }
  EXPECT_EQ(folder_.count(), 0);
}

TEST_F(Png, KnowsTheBitsOfItsChannels) {
  writePng(folder_ / "depth.png", Raster<std::uint16_t>{2, 1, 1, {1, 2}});
  writePng(folder_ / "picture.png", Raster<std::uint8_t>{1, 1, 3, {1, 2, 3}});
  putBytes(folder_ / "text.png", "no PNG at all");
  EXPECT_EQ(pngSize(folder_ / "depth.png")->bits, 16);
  EXPECT_EQ(pngSize(folder_ / "picture.png")->bits, 8);
  EXPECT_FALSE(pngSize(folder_ / "text.png"));
  EXPECT_FALSE(pngSize(folder_ / "nowhere.png"));
}

}  // namespace
}  // namespace facetloc::test
