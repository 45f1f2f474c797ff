// SPDX-License-Identifier: BSD-3-Clause
#include "batch/bytes.h"

#include "base/binary_archive.h"

#include <facetloc/io/map_database.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace facetloc {
namespace internal {

template <class Archive, class First, class Second>
void fields(Archive& archive, std::pair<First, Second>& pair) {
  archive(pair.first, pair.second);
}

}  // namespace internal

using namespace internal;
namespace {

void require(bool condition) {
  if (!condition) throw std::runtime_error("a message of another rank is torn");
}

}  // namespace

template <class Archive>
void fields(Archive& archive, ConvexHull& hull) {
  archive(hull.size);
  require(hull.size >= 0 && hull.size <= ConvexHull::kMaxVertices);
  for (int i = 0; i < hull.size; ++i) archive(hull.vertex[i]);
}

template <class Archive>
void fields(Archive& archive, Segment& s) {
  archive(s.R, s.t, s.Sigma_q, s.lambda, s.num_points, s.hull, s.noise);
}

template <class Archive>
void fields(Archive& archive, DepthDistortion& distortion) {
  Eigen::Vector2d low = distortion.extent().min(), high = distortion.extent().max();
  std::vector<double> nodes(distortion.values().begin(), distortion.values().end());
  archive(low, high, nodes);
  if (!Archive::kReads) return;
  DepthDistortion::Values values;
  require(nodes.size() == values.size());
  std::copy(nodes.begin(), nodes.end(), values.begin());
  try {
    distortion = DepthDistortion({low, high}, values);
  } catch (const std::invalid_argument&) {
    require(false);
  }
}

template <class Archive>
void fields(Archive& archive, Gravity& gravity) {
  archive(gravity.down, gravity.std);
}

template <class Archive>
void fields(Archive& archive, View& view) {
  // Its camera is known to whoever receives it, and its picture is packed.
  DepthNoise& noise = view.depth.noise;
  archive(view.intrinsics, view.segments, view.depth.camera, noise.inverse_depth_std, noise.depth_std,
          noise.depth_std_slope, view.gravity);
}

template <class Archive>
void fields(Archive& archive, PackedModel& packed) {
  LocalModel& model = packed.model;
  archive(model.name, model.stamp, model.T_w_m, packed.view, packed.depth);
}

template <class Archive>
void fields(Archive& archive, AnswerState& state) {
  int number = static_cast<int>(state);
  archive(number);
  require(number >= static_cast<int>(AnswerState::sure) && number <= static_cast<int>(AnswerState::unknown));
  state = static_cast<AnswerState>(number);
}

template <class Archive>
void fields(Archive& archive, ViewShares& shares) {
  for (const auto& [name, share] : ViewShares::kNamed) archive(shares.*share);
}

template <class Archive>
void fields(Archive& archive, NextLook& look) {
  archive(look.yaw, look.ahead, look.gain, look.sure);
}

template <class Archive>
void fields(Archive& archive, ResultRow& row) {
  for (const ResultColumn& column : resultColumns())
    std::visit([&](auto member) { archive(row.*member); }, column.value);
  archive(row.P_w_c, row.shares, row.next_look);
}

template <class Archive>
void fields(Archive& archive, FrameResult& result) {
  TimingRow& t = result.timing;
  archive(result.stamp, result.rows, t.frame, t.segment_ms, t.features_ms, t.localize_ms, t.models);
}

template <class Archive>
void fields(Archive& archive, ViewTraits& traits) {
  archive(traits.noise, traits.fov, traits.depth);
}

template <class T>
std::string toBytes(const T& value) {
  std::ostringstream out;
  BinaryWriter archive(out);
  archive(value);
  return out.str();
}

template <class T>
T fromBytes(const std::string& bytes) {
  std::istringstream in(bytes);
  BinaryReader archive(in);
  T value{};
  archive(value);
  require(in.peek() == std::char_traits<char>::eof());
  return value;
}

#define FACETLOC_BYTES_OF(...)                                                                               \
  template std::string toBytes(const __VA_ARGS__&);                                                          \
  template __VA_ARGS__ fromBytes(const std::string&);
FACETLOC_BYTES_OF(std::size_t)
FACETLOC_BYTES_OF(std::vector<std::size_t>)
FACETLOC_BYTES_OF(std::vector<std::string>)
FACETLOC_BYTES_OF(ModelsOrder)
FACETLOC_BYTES_OF(PackedModel)
FACETLOC_BYTES_OF(LocalizedImage)
#undef FACETLOC_BYTES_OF

}  // namespace facetloc
