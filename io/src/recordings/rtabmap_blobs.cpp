// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/rtabmap_blobs.h"

#include "images/png_memory.h"
#include "recordings/pose_table.h"
#include "recordings/rvl.h"

#include <facetloc/features/depth_image.h>
#include <facetloc/io/error.h>

#include <cstring>
#include <fmt/format.h>
#include <libdeflate.h>
#include <memory>
#include <stdexcept>

namespace facetloc::internal {
namespace {

constexpr std::size_t kPoseNumbers = 12;

Eigen::Matrix4d matrixOf(const float* numbers) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  for (int k = 0; k < static_cast<int>(kPoseNumbers); ++k) m(k / 4, k % 4) = numbers[k];
  return m;
}

std::optional<Eigen::Isometry3d> poseOf(const float* numbers, const std::string& name) {
  const Eigen::Matrix4d m = matrixOf(numbers);
  if (!m.allFinite() || m.topLeftCorner<3, 3>().isZero()) return {};
  try {
    return poseOfMatrix(m);
  } catch (const std::invalid_argument& e) {
    throw IoError(name, std::string("has a pose that ") + e.what());
  }
}

/** A matrix of OpenCV with numbers of 4 bytes. */
template <typename Number>
std::vector<Number> unpacked(ByteView packed, const std::string& name) {
  constexpr std::size_t kSizes = 3 * sizeof(std::int32_t);
  constexpr std::uint64_t kMostTimes = 1032;  // that zlib makes of one byte
  std::int32_t sizes[3] = {};                 // rows, columns, type
  if (packed.size > kSizes) std::memcpy(sizes, packed.data + packed.size - kSizes, kSizes);
  const std::uint64_t n = std::uint64_t(std::max(sizes[0], 0)) * std::uint64_t(std::max(sizes[1], 0));
  if (n == 0 || n > kMostTimes * packed.size) throw IoError(name, "has a corrupt graph");
  std::vector<Number> numbers(n);
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> zlib(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (!zlib || libdeflate_zlib_decompress(zlib.get(), packed.data, packed.size - kSizes, numbers.data(),
                                          n * sizeof(Number), nullptr) != LIBDEFLATE_SUCCESS)
    throw IoError(name, "has a corrupt graph");
  return numbers;
}

template <std::size_t N>
std::array<double, N> reals(MessageReader& fields) {
  std::array<double, N> values;
  for (double& value : values) value = fields.number<double>();
  return values;
}

RtabmapCamera cameraOf(MessageReader& fields) {
  fields.skip<std::int32_t>(3);  // version
  if (fields.number<std::int32_t>() != 0) throw BadMessage("is a stereo camera's, whose depth is not stored");
  RtabmapCamera camera;
  Intrinsics& k = camera.intrinsics;
  k.width = fields.number<std::int32_t>(), k.height = fields.number<std::int32_t>();
  std::array<std::int32_t, 5> sizes;  // sizes of K, D, R, P and the local transform
  for (std::int32_t& size : sizes) size = fields.number<std::int32_t>();
  if ((sizes[0] != 0 && sizes[0] != 9) || sizes[1] < 0 || sizes[2] < 0 || (sizes[3] != 0 && sizes[3] != 12) ||
      (sizes[4] != 0 && sizes[4] != static_cast<std::int32_t>(kPoseNumbers)))
    throw BadMessage("is corrupt, or was written by a version before 0.12");
  if (sizes[0] > 0) {
    const auto K = reals<9>(fields);
    k.fx = K[0], k.fy = K[4], k.cx = K[2], k.cy = K[5];
  }
  fields.skip<double>(static_cast<std::size_t>(sizes[1]) + static_cast<std::size_t>(sizes[2]));
  if (sizes[3] > 0) {  // its images are rectified
    const auto P = reals<12>(fields);
    if (P[0] > 0) k.fx = P[0], k.fy = P[5], k.cx = P[2], k.cy = P[6];
  }
  if (!k.valid()) throw BadMessage("has no intrinsics");
  if (sizes[4] > 0) {
    float numbers[kPoseNumbers];
    for (float& number : numbers) number = fields.number<float>();
    if (const auto T = poseOf(numbers, "")) camera.T_b_c = *T;
  }
  return camera;
}

}  // namespace

RtabmapCamera readRtabmapCamera(ByteView bytes, const std::string& name) {
  try {
    MessageReader fields(bytes, WireFormat::ros1);  // packed the same way
    const RtabmapCamera camera = cameraOf(fields);
    if (!fields.atEnd()) throw BadMessage("has several cameras, and facetloc takes one");
    return camera;
  } catch (const BadMessage& e) {
    throw IoError(name, std::string("its calibration ") + e.what());
  } catch (const IoError&) {
    throw IoError(name, "its calibration has a local transform that is not a pose");
  }
}

std::optional<Eigen::Isometry3d> readRtabmapPose(ByteView bytes, const std::string& name) {
  float numbers[kPoseNumbers];
  if (bytes.size == 0) return {};
  if (bytes.size != sizeof numbers)
    throw IoError(name, fmt::format("has a pose of {} bytes instead of {}", bytes.size, sizeof numbers));
  std::memcpy(numbers, bytes.data, sizeof numbers);
  return poseOf(numbers, name);
}

std::map<int, Eigen::Isometry3d> readRtabmapGraph(ByteView ids, ByteView poses, const std::string& name) {
  const auto nodes = unpacked<std::int32_t>(ids, name);
  const auto numbers = unpacked<float>(poses, name);
  if (numbers.size() != kPoseNumbers * nodes.size())
    throw IoError(name, "has a graph of other nodes than poses");
  std::map<int, Eigen::Isometry3d> graph;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (const auto T = poseOf(numbers.data() + kPoseNumbers * i, name)) graph.emplace(nodes[i], *T);
  return graph;
}

StoredDepth readRtabmapDepth(ByteView bytes, const std::string& name) {
  constexpr char kRvl[] = "DEPTHRVL";
  constexpr std::size_t kRvlSize = sizeof kRvl - 1;
  if (bytes.size > kRvlSize && std::memcmp(bytes.data, kRvl, kRvlSize) == 0)
    return readRvl({bytes.data + kRvlSize, bytes.size - kRvlSize}, name);
  if (!isRgbaPng(bytes.data, bytes.size)) {
    constexpr int kBits = 16;
    Raster<std::uint16_t> raster = readGreyPng(bytes.data, bytes.size, name, kBits);
    return {raster.width, raster.height, {}, std::move(raster.data)};
  }
  const Raster<std::uint8_t> raster = readRgbaPng(bytes.data, bytes.size, name);
  StoredDepth image{raster.width, raster.height, {}, {}};
  image.metres.resize(raster.data.size() / sizeof(float));
  for (std::size_t i = 0; i < image.metres.size(); ++i) {
    const std::uint8_t* rgba = raster.data.data() + sizeof(float) * i;
    const std::uint8_t bytes_of_float[] = {rgba[2], rgba[1], rgba[0], rgba[3]};  // OpenCV's order
    float z = 0;
    std::memcpy(&z, bytes_of_float, sizeof z);
    image.metres[i] = isMeasured(z) ? z : 0;
  }
  return image;
}

}  // namespace facetloc::internal
