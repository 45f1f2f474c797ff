// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/depth_messages.h"
#include "recordings/ros_messages.h"

#include <facetloc/io/error.h>
#include <facetloc/testing/matchers.h>

#include <random>

namespace facetloc::internal {
namespace {

MessageReader readerOf(const Bytes& bytes, WireFormat format) {
  return {{bytes.data(), bytes.size()}, format};
}

// Handmade after XTypes 7.4.1: numbers begin at multiples of their size, counted after the encapsulation.
TEST(MessageReader, NumbersOfCdrAreAligned) {
  const Bytes little{0, 1, 0, 0, 7, 0, 2, 1, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F, 5};
  const Bytes big{0, 0, 0, 0, 7, 0, 1, 2, 9, 0, 0, 0, 0x3F, 0xF0, 0, 0, 0, 0, 0, 0, 5};
  for (const Bytes& bytes : {little, big}) {
    MessageReader reader = readerOf(bytes, WireFormat::cdr);
    EXPECT_EQ(reader.number<std::uint8_t>(), 7);
    EXPECT_EQ(reader.number<std::uint16_t>(), 0x102);
    EXPECT_EQ(reader.number<std::uint8_t>(), 9);
    EXPECT_EQ(reader.number<double>(), 1.0);
    EXPECT_EQ(reader.number<std::uint8_t>(), 5);
    EXPECT_TRUE(reader.atEnd());
    EXPECT_THROW(reader.number<std::uint8_t>(), BadMessage);
  }
}

TEST(MessageReader, NumbersOfRos1ArePacked) {
  const Bytes bytes{7, 2, 1, 3, 0, 0, 0, 'a', 'b', 'c', 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F};
  MessageReader reader = readerOf(bytes, WireFormat::ros1);
  EXPECT_EQ(reader.number<std::uint8_t>(), 7);
  EXPECT_EQ(reader.number<std::uint16_t>(), 0x102);
  EXPECT_EQ(reader.text(), "abc");
  EXPECT_THAT(reader.reals(), testing::ElementsAre(1.0));
  EXPECT_TRUE(reader.atEnd());
}

TEST(MessageReader, TextsOfCdrEndWithAZeroThatIsCountedOrAreEmpty) {
  const Bytes bytes{0, 1, 0, 0, 3, 0, 0, 0, 'a', 'b', 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0};
  MessageReader reader = readerOf(bytes, WireFormat::cdr);
  EXPECT_EQ(reader.text(), "ab");
  EXPECT_EQ(reader.text(), "");
  EXPECT_EQ(reader.text(), "");
}

TEST(MessageReader, OtherRepresentationsAreRefused) {
  for (const Bytes& bytes :
       {Bytes{0, 3, 0, 0, 1}, Bytes{0, 7, 0, 0, 1}, Bytes{1, 1, 0, 0, 1}, Bytes{0, 1, 0}, Bytes{}})
    EXPECT_THROW(readerOf(bytes, WireFormat::cdr), BadMessage);
  EXPECT_THROW(readerOf({0, 1, 0, 0}, WireFormat::other), BadMessage);
}

TEST(MessageReader, Xcdr2IsNamedWithWhatToDo) {
  for (std::uint8_t kind = 0; kind < 14; ++kind) {
    const std::string complaint = test::messageOf<BadMessage>([&] {
      readerOf({0, kind, 0, 0, 1}, WireFormat::cdr);
    });
    EXPECT_EQ(complaint.empty(), kind <= 1) << complaint;
    EXPECT_EQ(complaint.find("ros2 bag play") != std::string::npos, kind >= 6 && kind <= 11) << complaint;
  }
}

template <typename Message>
void readAny(const Bytes& bytes, WireFormat format) {
  try {
    MessageReader reader = readerOf(bytes, format);
    Message::read(reader);
  } catch (const BadMessage&) {
  }
}

TEST(MessageReader, AnyBytesAreAMessageOrRefused) {
  std::mt19937 random(1);
  for (int n = 0; n < 20000; ++n) {
    Bytes bytes(random() % 400);
    for (std::uint8_t& byte : bytes) byte = random() % 3 == 0 ? static_cast<std::uint8_t>(random()) : 0;
    if (bytes.size() > 1) bytes[0] = 0, bytes[1] = random() % 2;
    for (const WireFormat format : {WireFormat::ros1, WireFormat::cdr}) {
      readAny<ImageMessage>(bytes, format);
      readAny<CompressedImageMessage>(bytes, format);
      readAny<CameraInfoMessage>(bytes, format);
      readAny<OdometryMessage>(bytes, format);
      readAny<TransformsMessage>(bytes, format);
      readAny<ImuMessage>(bytes, format);
    }
  }
}

TEST(DepthMessages, MayBeBigEndianAndOtherEncodingsAreNamed) {
  const std::uint8_t thousand[] = {0x03, 0xE8};
  ImageMessage image;
  image.width = image.height = 1, image.step = 2;
  image.big_endian = true;
  image.data = {thousand, sizeof thousand};
  image.encoding = "16UC1";
  EXPECT_EQ(readDepth(image, "an image").numbers, std::vector<std::uint16_t>{1000});
  image.encoding = "bgr8";
  EXPECT_THAT(test::messageOf<IoError>([&] { readDepth(image, "an image"); }),
              test::HasAll("'bgr8'", "16UC1"));
}

TEST(CameraInfo, IsReducedToTheRegionAndTheBinsOfTheImages) {
  CameraInfoMessage info;
  info.width = 640, info.height = 480;
  info.K = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  info.P = {490, 0, 318, 0, 0, 494, 236, 0, 0, 0, 1, 0};
  EXPECT_FALSE(info.isReduced());
  info.roi = {100, 40, 400, 480};
  info.binning = {2, 4};
  EXPECT_TRUE(info.isReduced());
  const CameraInfoMessage own = info.ofImage();
  EXPECT_EQ(own.width, 240u);
  EXPECT_EQ(own.height, 100u);
  EXPECT_EQ(own.K, (std::array<double, 9>{250, 0, 110, 0, 127.5, 50, 0, 0, 1}));
  EXPECT_EQ(own.P, (std::array<double, 12>{245, 0, 109, 0, 0, 123.5, 49, 0, 0, 0, 1, 0}));
}

}  // namespace
}  // namespace facetloc::internal
