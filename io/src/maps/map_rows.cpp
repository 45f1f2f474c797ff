// SPDX-License-Identifier: BSD-3-Clause
#include "images/depth_blob.h"
#include "maps/map_reader.h"
#include "results/pose_columns.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace facetloc::map_rows {

using namespace sqlite;

void require(bool condition, const char* fault) {
  if (!condition) throw BadCell(fault);
}

namespace {

constexpr double kRotationTolerance = 1e-6;  // tolerance of |q|^2 and R^T R
constexpr int kMaxPictureSide = 4096;        // [px] limits the claims of a corrupt map

void requireSound(const Intrinsics& camera) {
  require(camera.valid(), "its camera intrinsics are impossible");
}

void requireRotation(const Eigen::Matrix3d& R) {
  require(R.allFinite() && (R.transpose() * R).isIdentity(kRotationTolerance) && R.determinant() > 0,
          "its rotation matrix is not a rotation");
}

void requireSound(const DepthPicture& picture, const Intrinsics& working_image) {
  if (picture.empty()) return;
  requireSound(picture.camera);
  requireSizeOfPicture(picture.camera, working_image);
  require(picture.inverse_depth.size() == std::size_t(picture.camera.width) * picture.camera.height,
          "its depth picture has the wrong size");
}

void requireSound(const CameraMounting& mounting) {
  require(mounting.height >= 0 && mounting.height <= plausible::kHighest &&
              std::abs(mounting.tilt_deg) <= plausible::kStraightDown &&
              std::abs(mounting.roll_deg) <= plausible::kUpsideDown &&
              std::abs(mounting.pan_deg) <= plausible::kUpsideDown &&
              std::abs(mounting.x) <= plausible::kHighest && std::abs(mounting.y) <= plausible::kHighest,
          "its mounting is no place on a robot");
}

void requireSound(const LocalModel& model) {
  require(!model.name.empty(), "it has no name");
  require(std::isfinite(model.stamp) && plausible::isStamp(model.stamp), "its stamp is impossible");
  if (model.T_w_m) map_rows::requireSound(*model.T_w_m);
  if (model.alias_score) requirePossibleScore(*model.alias_score);
}

Eigen::Isometry3d readPose(Statement& row) {
  const PoseColumns columns = row.reals<7>();
  if (const char* fault = faultOf(columns, kRotationTolerance))
    throw BadCell(std::string("its pose ") + fault);
  return fromColumns(columns, kRotationTolerance);
}

template <typename Matrix>
void readUpperTriangle(Statement& row, Matrix& m) {
  for (int i = 0; i < m.rows(); ++i)
    for (int j = i; j < m.cols(); ++j) m(i, j) = m(j, i) = row.real();
}

/** Cells that are all null, or read. */
template <typename Read>
auto unlessNull(Statement& row, int cells, const Read& read) -> std::optional<decltype(read(row))> {
  if (!row.isNull()) return read(row);
  row.skip(cells);
  return {};
}

constexpr int kIntrinsicsCells = 6, kPoseCells = std::tuple_size<PoseColumns>::value, kMountingCells = 6,
              kDistortionCells = 5;

/** The bytes of numbers, the lowest first. \tparam Bits an unsigned integer of their size */
template <class Bits, class Iterator>
Blob blobOf(Iterator number, Iterator end) {
  Blob blob;
  for (; number != end; ++number) {
    static_assert(sizeof(Bits) == sizeof *number);
    Bits bits;
    std::memcpy(&bits, &*number, sizeof bits);
    for (std::size_t i = 0; i < sizeof bits; ++i) blob.push_back(static_cast<std::uint8_t>(bits >> 8 * i));
  }
  return blob;
}

/** Number i of such a blob. */
template <class Number, class Bits>
Number numberIn(const Blob& blob, std::size_t i) {
  static_assert(sizeof(Bits) == sizeof(Number));
  Bits bits = 0;
  for (std::size_t k = 0; k < sizeof bits; ++k) bits |= Bits(blob[i * sizeof bits + k]) << 8 * k;
  Number number;
  std::memcpy(&number, &bits, sizeof number);
  return number;
}

ConvexHull hullOf(const Blob& blob) {
  constexpr std::size_t kVertexBytes = 2 * sizeof(float);
  require(blob.size() % kVertexBytes == 0 && blob.size() <= kVertexBytes * ConvexHull::kMaxVertices,
          "its hull has the wrong size");
  const auto coordinate = [&blob](int i) {
    return numberIn<float, std::uint32_t>(blob, static_cast<std::size_t>(i));
  };
  ConvexHull hull;
  hull.size = static_cast<int>(blob.size() / kVertexBytes);
  for (int i = 0; i < hull.size; ++i) hull.vertex[i] = {coordinate(2 * i), coordinate(2 * i + 1)};
  return hull;
}

Intrinsics readIntrinsics(Statement& row) {
  Intrinsics k;
  k.width = row.integer(), k.height = row.integer();
  k.fx = row.real(), k.fy = row.real(), k.cx = row.real(), k.cy = row.real();
  requireSound(k);
  return k;
}

CameraMounting readMounting(Statement& row) {
  const auto cells = row.reals<kMountingCells>();
  return {cells[0], cells[1], cells[2], cells[3], cells[4], cells[5]};
}

DepthDistortion readDistortion(Statement& row) {
  const auto border = row.reals<4>();
  const Eigen::AlignedBox2d extent(Eigen::Vector2d(border[0], border[1]),
                                   Eigen::Vector2d(border[2], border[3]));
  const Blob nodes = row.blob();
  DepthDistortion::Values values;
  require(nodes.size() == values.size() * sizeof(double), "its distortion has the wrong size");
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = numberIn<double, std::uint64_t>(nodes, i);
  try {
    return DepthDistortion(extent, values);
  } catch (const std::invalid_argument&) {
    throw BadCell("its distortion is impossible");
  }
}

DepthNoise readNoise(Statement& row) {
  DepthNoise noise;
  noise.inverse_depth_std = row.real(), noise.depth_std = row.real(), noise.depth_std_slope = row.real();
  return noise;
}

}  // namespace

void requireSizeOfPicture(const Intrinsics& picture, const Intrinsics& working_image) {
  require(picture.width <= std::min(working_image.width, kMaxPictureSide) &&
              picture.height <= std::min(working_image.height, kMaxPictureSide),
          "its depth picture is larger than its image");
}

void requireSound(const Eigen::Isometry3d& T) {
  require(T.translation().allFinite(), "its pose is not finite");
  require(plausible::isPosition(T.translation()), "its pose is more than 1000 km away");
  requireRotation(T.linear());
}

void requireSound(const DepthNoise& noise) {
  require(noise.inverse_depth_std >= DepthNoise::kLeastInverseDepthStd &&
              noise.inverse_depth_std <= DepthNoise::kLargestInverseDepthStd && noise.depth_std >= 0 &&
              noise.depth_std <= DepthNoise::kLargestDepthStd && noise.depth_std_slope >= 0 &&
              noise.depth_std_slope <= DepthNoise::kLargestDepthStdSlope,
          "its noise is impossible");
}

void requireSound(const Camera& camera) {
  requireSound(static_cast<const DepthNoise&>(camera.noise));
  for (const double distortion : {camera.noise.distortion_offset, camera.noise.distortion_slope})
    require(distortion >= 0 && distortion <= 1, "its expected distortion is impossible");
  require(camera.max_depth > 0, "its largest depth is impossible");
  if (camera.mounting) requireSound(*camera.mounting);
}

void requireSound(const Segment& s) {
  requireRotation(s.R);
  require(s.t.allFinite() && plausible::isPosition(s.t), "its centroid is not finite, or too far away");
  require(plausible::isCovariance(s.Sigma_q),
          "its Sigma_q is not positive definite, or smaller than any camera's");
  require(s.lambda.allFinite() && s.lambda[0] >= s.lambda[1] && s.lambda[1] >= 0,
          "its lambda are not finite, descending and positive");
  require(s.num_points >= 0, "its number of points is negative");
  require(s.hull.size >= 0 && s.hull.size <= ConvexHull::kMaxVertices, "its hull has too many vertices");
  for (const Eigen::Vector2f& vertex : s.hull) require(vertex.allFinite(), "its hull is not finite");
  require(s.hull.size < 3 || s.hull.area() >= 0, "its hull is not counter-clockwise");
}

void requireSound(const Link& link) {
  require(link.from != link.to, "it leads from a model to itself");
  requireSound(link.T_from_to.T);
  require(plausible::isCovariance(link.T_from_to.P),
          "its covariance is not positive definite, or smaller than any sensor's");
}

void requireSound(const LocalModel& model, const View& view) {
  requireSound(model);
  requireSound(view.intrinsics);
  requireSound(view.depth, view.intrinsics);
}

Statement& operator<<(Statement& s, const Intrinsics& k) {
  return s << k.width << k.height << k.fx << k.fy << k.cx << k.cy;
}
Statement& operator<<(Statement& s, const Eigen::Isometry3d& T) { return s.bindAll(toColumns(T)); }
Statement& operator<<(Statement& s, const std::optional<Eigen::Isometry3d>& T) {
  return T ? s << *T : s.bindNulls(kPoseCells);
}
Statement& operator<<(Statement& s, const DepthNoise& noise) {
  return s << noise.inverse_depth_std << noise.depth_std << noise.depth_std_slope;
}
Statement& operator<<(Statement& s, const Camera& camera) {
  if (camera.intrinsics.valid())
    s << camera.intrinsics;
  else
    s.bindNulls(kIntrinsicsCells);
  s << static_cast<const DepthNoise&>(camera.noise) << camera.noise.distortion_offset
    << camera.noise.distortion_slope;
  s << (std::isinf(camera.max_depth) ? std::nullopt : std::optional(camera.max_depth));
  if (const auto& m = camera.mounting)
    s << m->height << m->tilt_deg << m->roll_deg << m->pan_deg << m->x << m->y;
  else
    s.bindNulls(kMountingCells);
  if (!camera.distortion) return s.bindNulls(kDistortionCells);
  const Eigen::AlignedBox2d& extent = camera.distortion->extent();
  const DepthDistortion::Values& values = camera.distortion->values();
  return s << extent.min().x() << extent.min().y() << extent.max().x() << extent.max().y()
           << blobOf<std::uint64_t>(values.begin(), values.end());
}

Blob hullBlob(const ConvexHull& hull) {
  std::vector<float> coordinates;
  for (const Eigen::Vector2f& vertex : hull) coordinates.insert(coordinates.end(), {vertex.x(), vertex.y()});
  return blobOf<std::uint32_t>(coordinates.begin(), coordinates.end());
}

Segment readSegment(Statement& row) {
  Segment s;
  const Eigen::Isometry3d T = readPose(row);
  s.R = T.linear();
  s.t = T.translation();
  readUpperTriangle(row, s.Sigma_q);
  s.lambda[0] = row.real(), s.lambda[1] = row.real();
  s.num_points = row.integer();
  s.hull = hullOf(row.blob());
  requireSound(s);
  return s;
}

ModelRow readModel(Statement& row) {
  ModelRow read;
  read.model.name = row.text();
  read.model.stamp = row.real();
  read.model.T_w_m = unlessNull(row, kPoseCells, readPose);
  read.intrinsics = readIntrinsics(row);
  read.num_segments = row.integer();
  read.model.alias_score = row.realOrNull();
  requireSound(read.model);
  return read;
}

Camera readCamera(Statement& row) {
  Camera camera;
  camera.intrinsics = unlessNull(row, kIntrinsicsCells, readIntrinsics).value_or(camera.intrinsics);
  static_cast<DepthNoise&>(camera.noise) = readNoise(row);
  camera.noise.distortion_offset = row.real();
  camera.noise.distortion_slope = row.real();
  camera.max_depth = row.realOrNull().value_or(camera.max_depth);
  camera.mounting = unlessNull(row, kMountingCells, readMounting);
  camera.distortion = unlessNull(row, kDistortionCells, readDistortion);
  requireSound(camera);
  return camera;
}

void requirePossibleScore(double score) {
  constexpr double kMost = 1e4;  // [nats]
  require(std::abs(score) <= kMost, "its score of wrong places is impossible");
}

void requireSound(const Gravity& gravity) { require(gravity.valid(), "its gravity is impossible"); }

void requireSound(const MapAmbiguity& ambiguity) {
  requirePossibleScore(ambiguity.score);
  require(ambiguity.views > 0, "its number of views is impossible");
}

Gravity readGravity(Statement& row) {
  Gravity gravity;
  for (int k = 0; k < 3; ++k) gravity.down[k] = row.real();
  gravity.std = row.real();
  requireSound(gravity);
  return gravity;
}

MapAmbiguity readAmbiguity(Statement& row) {
  MapAmbiguity ambiguity;
  ambiguity.score = row.real();
  ambiguity.views = row.integer();
  requireSound(ambiguity);
  return ambiguity;
}

PackedPicture readPictureHead(Statement& row, const Intrinsics& working_image) {
  PackedPicture packed;
  packed.camera = readIntrinsics(row);
  requireSizeOfPicture(packed.camera, working_image);
  packed.noise = readNoise(row);
  requireSound(packed.noise);
  return packed;
}

PackedPicture readPicture(Statement& row, const Intrinsics& working_image) {
  PackedPicture packed = readPictureHead(row, working_image);
  require(row.text() == depth_blob::kEncoding, "its depth picture is of an unknown encoding");
  packed.data = row.blob();
  return packed;
}

DepthPicture unpacked(const PackedPicture& packed) {
  auto values = depth_blob::decode(packed.data, packed.camera.width, packed.camera.height);
  require(values.has_value(), "its depth picture is corrupt");
  DepthPicture picture = DepthPicture::fromStored(packed.camera, std::move(*values));
  picture.noise = packed.noise;
  return picture;
}

Link readLink(Statement& row) {
  Link link;
  link.from = row.integer();
  link.to = row.integer();
  link.T_from_to.T = readPose(row);
  readUpperTriangle(row, link.T_from_to.P);
  requireSound(link);
  return link;
}

}  // namespace facetloc::map_rows
