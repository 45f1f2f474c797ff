// SPDX-License-Identifier: BSD-3-Clause
#include "base/binary_archive.h"

#include <gtest/gtest.h>

#include <limits>
#include <sstream>

namespace facetloc {

using namespace internal;

struct Example {
  std::string name;
  std::optional<double> value;
  std::vector<int> numbers;
  std::vector<Intrinsics> cameras;
  Eigen::Matrix3f matrix = Eigen::Matrix3f::Identity();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  bool yes = false;
};

template <class Archive>
void fields(Archive& archive, Example& e) {
  archive(e.name, e.value, e.numbers, e.cameras, e.matrix, e.T, e.yes);
}

namespace {

Example example() {
  Example e;
  e.name = std::string("with a zero\0 in it", 17);
  e.value = std::numeric_limits<double>::denorm_min();
  e.numbers.assign(100000, -3);
  e.cameras = {{1, 2, 3.5, 4.5, 5.5, 6.5}, {}};
  e.matrix << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  e.T.translation() << 1.0 / 3, -0.0, 2;
  e.yes = true;
  return e;
}

std::string bytesOf(const Example& e) {
  std::ostringstream out;
  BinaryWriter archive(out);
  archive(e);
  return out.str();
}

Example exampleOf(const std::string& bytes) {
  std::istringstream in(bytes);
  BinaryReader archive(in);
  Example e;
  archive(e);
  return e;
}

TEST(BinaryArchive, ReadsItsOutput) {
  const Example e = example(), again = exampleOf(bytesOf(e));
  EXPECT_EQ(again.name, e.name);
  EXPECT_EQ(again.value, e.value);
  EXPECT_EQ(again.numbers, e.numbers);
  EXPECT_EQ(again.cameras, e.cameras);
  EXPECT_EQ(again.matrix, e.matrix);
  EXPECT_EQ(again.T.matrix(), e.T.matrix());
  EXPECT_EQ(again.yes, e.yes);
  EXPECT_EQ(bytesOf(again), bytesOf(e));
  EXPECT_EQ(bytesOf(exampleOf(bytesOf(Example()))), bytesOf(Example()));
}

TEST(BinaryArchive, BytesThatEndTooEarlyThrow) {
  const std::string bytes = bytesOf(example());
  for (std::size_t n = 0; n < bytes.size(); n = 2 * n + 1)
    EXPECT_THROW(exampleOf(bytes.substr(0, n)), std::runtime_error) << n;
}

TEST(BinaryArchive, BytesThatAreNeitherTrueNorFalseThrow) {
  std::string bytes = bytesOf(example());
  bytes.back() = 2;  // the last field is a bool
  EXPECT_THROW(exampleOf(bytes), std::runtime_error);
  bytes = bytesOf(Example());
  bytes[sizeof(std::size_t)] = 2;  // values in an optional, after an empty name
  EXPECT_THROW(exampleOf(bytes + std::string(100, '\0')), std::runtime_error);
}

TEST(BinaryArchive, NoMemoryIsTakenForMissingBytes) {
  std::string bytes(sizeof(std::size_t), '\x7f');  // claims an endless name
  EXPECT_THROW(exampleOf(bytes + "short"), std::runtime_error);
}

}  // namespace
}  // namespace facetloc
