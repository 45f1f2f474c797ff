// SPDX-License-Identifier: BSD-3-Clause
#include "map_rows.h"

#include "depth_blob.h"
#include "pose_columns.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace facetloc::map_rows {

using sqlite::BadCell;
using sqlite::Blob;
using sqlite::Statement;

void require(bool condition, const char* fault) {
  if (!condition) throw BadCell(fault);
}

namespace {

constexpr double kRotationTolerance = 1e-6;  // of |q|^2 and R^T R
constexpr int kMaxPictureSide = 4096;        // [px] bounds what a corrupt map can claim

void requireSound(const Intrinsics& camera) {
  require(camera.valid(), "its camera intrinsics are impossible");
}

void requireRotation(const Eigen::Matrix3d& R) {
  require(R.allFinite() && (R.transpose() * R).isIdentity(kRotationTolerance) && R.determinant() > 0,
          "its rotation matrix is not a rotation");
}

void requireSound(const Eigen::Isometry3d& T) {
  require(T.translation().allFinite(), "its pose is not finite");
  require(plausible::isPosition(T.translation()), "its pose is more than 1000 km away");
  requireRotation(T.linear());
}

void requireSound(const DepthPicture& picture, const Intrinsics& working_image) {
  if (picture.empty()) return;
  requireSound(picture.camera);
  requireSizeOfPicture(picture.camera, working_image);
  require(picture.inverse_depth.size() == std::size_t(picture.camera.width) * picture.camera.height,
          "its depth picture has the wrong size");
}

Eigen::Isometry3d readPose(Statement& row) {
  const PoseColumns columns = row.reals<7>();
  if (const char* fault = faultOf(columns, kRotationTolerance))
    throw BadCell(std::string("its pose ") + fault);
  return *fromColumns(columns, kRotationTolerance);
}

template <typename Matrix>
void readUpperTriangle(Statement& row, Matrix& m) {
  for (int i = 0; i < m.rows(); ++i)
    for (int j = i; j < m.cols(); ++j) m(i, j) = m(j, i) = row.real();
}

ConvexHull hullOf(const Blob& blob) {
  constexpr std::size_t kVertexBytes = 8;
  require(blob.size() % kVertexBytes == 0 && blob.size() <= kVertexBytes * ConvexHull::kMaxVertices,
          "its hull has the wrong size");
  const auto coordinate = [&blob](std::size_t offset) {
    std::uint32_t bits = 0;
    for (int i = 0; i < 4; ++i) bits |= std::uint32_t(blob[offset + i]) << (8 * i);
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  };
  ConvexHull hull;
  hull.size = static_cast<int>(blob.size() / kVertexBytes);
  for (int i = 0; i < hull.size; ++i)
    hull.vertex[i] = {coordinate(kVertexBytes * i), coordinate(kVertexBytes * i + 4)};
  return hull;
}

}  // namespace

void requireSizeOfPicture(const Intrinsics& picture, const Intrinsics& working_image) {
  require(picture.width <= std::min(working_image.width, kMaxPictureSide) &&
              picture.height <= std::min(working_image.height, kMaxPictureSide),
          "its depth picture is larger than its image");
}

void requireSoundPose(const Eigen::Isometry3d& T) { requireSound(T); }

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

void requireSound(const CameraMounting& mounting) {
  require(mounting.height >= 0 && mounting.height <= plausible::kHighest &&
              std::abs(mounting.tilt_deg) <= plausible::kStraightDown &&
              std::abs(mounting.roll_deg) <= plausible::kUpsideDown &&
              std::abs(mounting.pan_deg) <= plausible::kUpsideDown &&
              std::abs(mounting.x) <= plausible::kHighest && std::abs(mounting.y) <= plausible::kHighest,
          "it is no place on a robot");
}

void requireSound(const Link& link) {
  require(link.from != link.to, "it leads from a model to itself");
  requireSound(link.T_from_to.T);
  require(plausible::isCovariance(link.T_from_to.P),
          "its covariance is not positive definite, or smaller than any sensor's");
}

void requireSound(const LocalModel& model) {
  require(!model.name.empty(), "it has no name");
  require(std::isfinite(model.stamp) && plausible::isStamp(model.stamp), "its stamp is impossible");
  requireSound(model.view.intrinsics);
  if (model.T_w_m) requireSound(*model.T_w_m);
  requireSound(model.view.depth, model.view.intrinsics);
}

Statement& operator<<(Statement& s, const Intrinsics& k) {
  return s << k.width << k.height << k.fx << k.fy << k.cx << k.cy;
}
Statement& operator<<(Statement& s, const Eigen::Isometry3d& T) { return s.bindAll(toColumns(T)); }

Intrinsics readIntrinsics(Statement& row) {
  Intrinsics k;
  k.width = row.integer(), k.height = row.integer();
  k.fx = row.real(), k.fy = row.real(), k.cx = row.real(), k.cy = row.real();
  requireSound(k);
  return k;
}

Blob hullBlob(const ConvexHull& hull) {
  Blob blob;
  for (const Eigen::Vector2f& vertex : hull) {
    for (const float coordinate : {vertex.x(), vertex.y()}) {
      std::uint32_t bits;
      std::memcpy(&bits, &coordinate, sizeof bits);
      for (int shift = 0; shift < 32; shift += 8) blob.push_back(static_cast<std::uint8_t>(bits >> shift));
    }
  }
  return blob;
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

LocalModel readModel(Statement& row) {
  LocalModel model;
  model.name = row.text();
  model.stamp = row.real();
  if (row.isNull())
    row.skip(std::tuple_size<PoseColumns>::value);
  else
    model.T_w_m = readPose(row);
  model.view.intrinsics = readIntrinsics(row);
  requireSound(model);
  return model;
}

Intrinsics readPictureCamera(Statement& row, const Intrinsics& working_image) {
  const Intrinsics camera = readIntrinsics(row);
  requireSizeOfPicture(camera, working_image);
  return camera;
}

Camera readCamera(Statement& row) {
  Camera camera;
  if (row.isNull())
    row.skip(6);
  else
    camera.intrinsics = readIntrinsics(row);
  camera.noise.inverse_depth_std = row.real();
  camera.noise.distortion_offset = row.real();
  camera.noise.distortion_slope = row.real();
  requireSound(camera);
  return camera;
}

void readRange(Statement& row, Camera& camera) {
  camera.noise.depth_std = row.real();
  camera.noise.depth_std_slope = row.real();
  if (!row.isNull()) camera.max_depth = row.real();
  requireSound(camera);
}

void requirePossibleScore(double score) {
  constexpr double kMost = 1e4;  // [nats]
  require(std::abs(score) <= kMost, "it is impossible");
}

void requireSound(const MapAmbiguity& ambiguity) {
  requirePossibleScore(ambiguity.score);
  require(ambiguity.views > 0, "it is impossible");
}

MapAmbiguity readAmbiguity(Statement& row) {
  MapAmbiguity ambiguity;
  ambiguity.score = row.real();
  ambiguity.views = row.integer();
  requireSound(ambiguity);
  return ambiguity;
}

DepthNoise readNoise(Statement& row) {
  DepthNoise noise;
  noise.inverse_depth_std = row.real();
  requireSound(noise);
  return noise;
}

void readNoiseOverRange(Statement& row, DepthNoise& noise) {
  noise.depth_std = row.real();
  noise.depth_std_slope = row.real();
  requireSound(noise);
}

Blob readPackedPicture(Statement& row) {
  require(row.text() == depth_blob::kEncoding, "its depth picture is of an unknown encoding");
  return row.blob();
}

DepthPicture unpackedPicture(const Intrinsics& camera, const Blob& packed) {
  auto values = depth_blob::decode(packed, camera.width, camera.height);
  require(values.has_value(), "its depth picture is corrupt");
  return DepthPicture::fromStored(camera, std::move(*values));
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
