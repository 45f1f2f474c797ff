// SPDX-License-Identifier: BSD-3-Clause
#include "random.h"

#include <facetloc/features/so3.h>
#include <facetloc/io/simulated_camera.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace facetloc {

// ---- The world
// -------------------------------------------------------------------------------------------------------

void addBox(Scene& scene, const Eigen::Isometry3d& T_w_box, const Eigen::Vector3d& half_size,
            std::uint16_t& next_id) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const int side : {-1, 1}) {
      Rectangle face;
      face.centre = T_w_box * (side * half_size[axis] * Eigen::Vector3d::Unit(axis));
      face.axis_u = T_w_box.linear().col(u);
      face.axis_v = T_w_box.linear().col(v);
      face.half_u = half_size[u];
      face.half_v = half_size[v];
      face.plane_id = next_id++;
      scene.push_back(face);
    }
  }
}

namespace {

/** The sizes of a room and of what stands in it [m]. */
constexpr double kMinRoom = 3, kMaxRoom = 7;
constexpr double kMinCeiling = 2.4, kMaxCeiling = 3.0;
constexpr double kMinBoxHeight = 0.3, kMaxBoxHeight = 2.0;
constexpr double kMinBoxSide = 0.3, kMaxBoxSide = 1.2;
constexpr double kMinCupboardDepth = 0.25, kMaxCupboardDepth = 0.6;
constexpr double kMaxCupboardHeight = 1.0;
constexpr double kFreeRadius = 0.8;  // the middle of the room stays free for a camera
constexpr double kShareOfCupboards = 0.35;
constexpr double kShareOfTurnedBoxes = 0.5;
constexpr double kShrink = 0.95;  // of a box that found no place, before the next try

Eigen::Isometry3d boxPose(double x, double y, double z, double yaw) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() << x, y, z;
  return T;
}

/** A box on the floor, anywhere but in the free middle. */
void addFloorBox(Scene& scene, const Eigen::Vector3d& room, Random& random, std::uint16_t& next_id) {
  const double yaw = random.uniform() < kShareOfTurnedBoxes ? random.uniform(0, EIGEN_PI / 2) : 0.0;
  const double half_height = random.uniform(kMinBoxHeight, kMaxBoxHeight) / 2;
  double a = random.uniform(kMinBoxSide, kMaxBoxSide) / 2, b = random.uniform(kMinBoxSide, kMaxBoxSide) / 2;
  for (;; a *= kShrink, b *= kShrink) {
    const double c = std::abs(std::cos(yaw)), s = std::abs(std::sin(yaw));
    const double room_x = room.x() / 2 - (c * a + s * b), room_y = room.y() / 2 - (s * a + c * b);
    const double x = random.uniform(-room_x, room_x), y = random.uniform(-room_y, room_y);
    if (std::hypot(x, y) - std::hypot(a, b) < kFreeRadius) continue;
    return addBox(scene, boxPose(x, y, half_height, yaw), {a, b, half_height}, next_id);
  }
}

/** A box on a wall, at any height. */
void addCupboard(Scene& scene, const Eigen::Vector3d& room, Random& random, std::uint16_t& next_id) {
  const int wall = static_cast<int>(4 * random.uniform());
  const double half_depth = random.uniform(kMinCupboardDepth, kMaxCupboardDepth) / 2;
  const double half_width = random.uniform(kMinBoxSide, kMaxBoxSide) / 2;
  const double half_height = random.uniform(kMinBoxHeight, kMaxCupboardHeight) / 2;
  const bool on_x = wall < 2;
  const double sign = wall % 2 ? 1.0 : -1.0;
  const double to_wall = sign * ((on_x ? room.x() : room.y()) / 2 - half_depth);
  const double margin = (on_x ? room.y() : room.x()) / 2 - half_width;
  const double along = random.uniform(-margin, margin);
  const double z = random.uniform(half_height, room.z() - half_height);
  const Eigen::Vector3d half_size = on_x ? Eigen::Vector3d(half_depth, half_width, half_height)
                                         : Eigen::Vector3d(half_width, half_depth, half_height);
  addBox(scene, on_x ? boxPose(to_wall, along, z, 0) : boxPose(along, to_wall, z, 0), half_size, next_id);
}

}  // namespace

Scene randomRoom(std::uint64_t seed, int boxes) {
  Random random(seed);
  Eigen::Vector3d room;  // one draw per statement: the order of arguments is the compiler's choice
  room.x() = random.uniform(kMinRoom, kMaxRoom);
  room.y() = random.uniform(kMinRoom, kMaxRoom);
  room.z() = random.uniform(kMinCeiling, kMaxCeiling);
  Scene scene;
  std::uint16_t next_id = 1;
  addBox(scene, boxPose(0, 0, room.z() / 2, 0), room / 2, next_id);  // walls, floor and ceiling
  for (int i = 0; i < boxes; ++i) {
    const bool on_wall = random.uniform() < kShareOfCupboards;
    (on_wall ? addCupboard : addFloorBox)(scene, room, random, next_id);
  }
  return scene;
}

// ---- Rays
// ------------------------------------------------------------------------------------------------------------

namespace {

constexpr double kNearPlane = 0.05;      // [m]
constexpr double kEdgeTolerance = 1e-9;  // [m] closes the cracks between rectangles that share an edge

/** A rectangle in the camera frame, ready for rays: the plane n . p = d and the two coordinates in it. */
struct Facet {
  Eigen::Vector3d normal, axis_u, axis_v;
  double distance, centre_u, centre_v, half_u, half_v;
  std::uint16_t plane_id;

  Facet(const Rectangle& r, const Eigen::Isometry3d& T_c_w)
      : axis_u(T_c_w.linear() * r.axis_u),
        axis_v(T_c_w.linear() * r.axis_v),
        half_u(r.half_u),
        half_v(r.half_v),
        plane_id(r.plane_id) {
    const Eigen::Vector3d centre = T_c_w * r.centre;
    normal = axis_u.cross(axis_v);
    distance = normal.dot(centre);
    centre_u = axis_u.dot(centre);
    centre_v = axis_v.dot(centre);
  }
  /** Depth at which a ray with b_z = 1 meets the plane; negative or infinite if it does not. */
  double depthAlong(const Eigen::Vector3d& ray) const { return distance / normal.dot(ray); }
  bool contains(const Eigen::Vector3d& p) const {
    return std::abs(axis_u.dot(p) - centre_u) <= half_u + kEdgeTolerance &&
           std::abs(axis_v.dot(p) - centre_v) <= half_v + kEdgeTolerance;
  }
  std::array<Eigen::Vector3d, 4> corners() const {
    const Eigen::Vector3d centre = distance * normal + centre_u * axis_u + centre_v * axis_v;
    const Eigen::Vector3d u = half_u * axis_u, v = half_v * axis_v;
    return {centre - u - v, centre + u - v, centre + u + v, centre - u + v};
  }
};

/** Pixels [u0, u1) x [v0, v1). */
struct PixelBox {
  int u0 = 0, u1 = 0, v0 = 0, v1 = 0;
};

/** The pixels that can see a facet: the bounding box of its projection, cut off at the near plane. */
PixelBox boundingBox(const Facet& facet, const Intrinsics& camera) {
  Eigen::Vector2d lowest = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()),
                  highest = -lowest;
  const auto include = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector2d pixel = camera.project(p);
    lowest = lowest.cwiseMin(pixel);
    highest = highest.cwiseMax(pixel);
  };
  const auto corners = facet.corners();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    if (a.z() >= kNearPlane) include(a);
    if ((a.z() < kNearPlane) != (b.z() < kNearPlane)) {
      Eigen::Vector3d cut = a + (kNearPlane - a.z()) / (b.z() - a.z()) * (b - a);
      cut.z() = kNearPlane;
      include(cut);
    }
  }
  if (!(lowest.x() <= highest.x())) return {};
  // One pixel more on each side makes up for rounding.
  const auto first = [](double x, int size) {
    return static_cast<int>(std::clamp(std::floor(x) - 1, 0.0, double(size)));
  };
  const auto end = [](double x, int size) {
    return static_cast<int>(std::clamp(std::ceil(x) + 2, 0.0, double(size)));
  };
  return {first(lowest.x(), camera.width), end(highest.x(), camera.width), first(lowest.y(), camera.height),
          end(highest.y(), camera.height)};
}

constexpr int kNothing = -1;

/** What every pixel sees: the depth and the index of a facet. */
struct Hits {
  std::vector<Facet> facets;
  std::vector<double> depth;
  std::vector<int> facet;
};

Hits castRays(const Scene& scene, const Eigen::Isometry3d& T_w_c, const Intrinsics& camera) {
  Hits hits;
  const std::size_t pixels = std::size_t(camera.width) * camera.height;
  hits.depth.assign(pixels, std::numeric_limits<double>::infinity());
  hits.facet.assign(pixels, kNothing);
  const Eigen::Isometry3d T_c_w = T_w_c.inverse();
  for (const Rectangle& rectangle : scene) {
    const Facet facet(rectangle, T_c_w);
    const PixelBox box = boundingBox(facet, camera);
    for (int v = box.v0; v < box.v1; ++v) {
      for (int u = box.u0; u < box.u1; ++u) {
        const std::size_t i = std::size_t(v) * camera.width + u;
        const Eigen::Vector3d ray = camera.ray(u, v);
        const double z = facet.depthAlong(ray);
        if (!(z >= kNearPlane && z < hits.depth[i]) || !facet.contains(z * ray)) continue;
        hits.depth[i] = z;
        hits.facet[i] = static_cast<int>(hits.facets.size());
      }
    }
    hits.facets.push_back(facet);
  }
  return hits;
}

SimulatedFrame emptyFrame(const Intrinsics& camera) {
  const std::size_t pixels = std::size_t(camera.width) * camera.height;
  return {{camera, std::vector<float>(pixels, 0.f)},
          {camera.width, camera.height, std::vector<std::uint16_t>(pixels, 0)}};
}

// ---- Errors
// ----------------------------------------------------------------------------------------------------------

constexpr double kReferenceWidth = 640;  // [px] lengths in SimulatedNoise refer to an image of this width

enum Purpose : std::uint64_t { kDistortion, kDisparity, kSilhouettes, kDropouts };

/** Sums of neighbours along one axis, weighted; the image shrinks by the kernel's size minus 1. */
std::vector<double> convolvedRows(const std::vector<double>& image, int width, int height,
                                  const std::vector<double>& kernel) {
  const int out_width = width - static_cast<int>(kernel.size()) + 1;
  std::vector<double> out(std::size_t(out_width) * height, 0.0);
  for (int v = 0; v < height; ++v)
    for (std::size_t k = 0; k < kernel.size(); ++k)
      for (int u = 0; u < out_width; ++u)
        out[std::size_t(v) * out_width + u] += kernel[k] * image[std::size_t(v) * width + u + k];
  return out;
}

std::vector<double> transposed(const std::vector<double>& image, int width, int height) {
  std::vector<double> out(image.size());
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) out[std::size_t(u) * height + v] = image[std::size_t(v) * width + u];
  return out;
}

/** Gaussian weights whose squares sum to one: they leave the variance of white noise as it is. */
std::vector<double> gaussianKernel(double sigma) {
  constexpr double kSigmas = 3, kWhite = 0.1;  // narrower kernels than this have only one weight
  if (sigma < kWhite) return {1.0};
  const int radius = static_cast<int>(std::ceil(kSigmas * sigma));
  std::vector<double> kernel;
  double squares = 0;
  for (int k = -radius; k <= radius; ++k) {
    kernel.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
    squares += kernel.back() * kernel.back();
  }
  for (double& weight : kernel) weight /= std::sqrt(squares);
  return kernel;
}

/** Noise of unit variance, correlated over sigma [px]. */
std::vector<double> correlatedNoise(int width, int height, double sigma, Random random) {
  const std::vector<double> kernel = gaussianKernel(sigma);
  const int pad = static_cast<int>(kernel.size()) - 1;
  std::vector<double> white(std::size_t(width + pad) * (height + pad));
  for (double& value : white) value = random.normal();
  const auto rows = transposed(convolvedRows(white, width + pad, height + pad, kernel), width, height + pad);
  return transposed(convolvedRows(rows, height + pad, width, kernel), height, width);
}

/** A random sum of low cosines without a constant part, root mean square 1. */
std::vector<double> smoothField(int width, int height, Random random) {
  constexpr int kOrders = 4;
  std::vector<double> field(std::size_t(width) * height, 0.0);
  const auto waves = [](int order, int size) {
    std::vector<double> wave(size);
    for (int i = 0; i < size; ++i) wave[i] = std::cos(180 * kDegree * order * (i + 0.5) / size);
    return wave;
  };
  for (int a = 0; a < kOrders; ++a) {
    for (int b = 0; b < kOrders; ++b) {
      const double amplitude = random.normal() / (1 + a + b);
      if (a + b == 0) continue;
      const std::vector<double> across = waves(a, width), down = waves(b, height);
      for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u) field[std::size_t(v) * width + u] += amplitude * across[u] * down[v];
    }
  }
  double squares = 0;
  for (const double value : field) squares += value * value;
  const double rms = std::sqrt(squares / static_cast<double>(field.size()));
  if (rms > 0)
    for (double& value : field) value /= rms;
  return field;
}

/** Where silhouettes are seen: every pixel looks up its surface a little aside. */
std::vector<int> jittered(const std::vector<int>& facet, const Intrinsics& camera, double sigma,
                          Random random) {
  if (sigma <= 0) return facet;
  std::vector<int> out(facet.size());
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const int du = static_cast<int>(std::lround(sigma * random.normal()));
      const int dv = static_cast<int>(std::lround(sigma * random.normal()));
      const int from_u = std::clamp(u + du, 0, camera.width - 1),
                from_v = std::clamp(v + dv, 0, camera.height - 1);
      out[std::size_t(v) * camera.width + u] = facet[std::size_t(from_v) * camera.width + from_u];
    }
  }
  return out;
}

double quantized(double inverse_depth, double step) {
  if (step <= 0) return inverse_depth;
  const double disparity = kKinectOffset - kKinectGain * inverse_depth;
  return (kKinectOffset - step * std::round(disparity / step)) / kKinectGain;
}

}  // namespace

SimulatedCamera::SimulatedCamera(const Intrinsics& camera, const SimulatedNoise& noise, std::uint64_t seed)
    : camera_(camera), noise_(noise), seed_(seed) {
  if (!camera.valid()) throw std::invalid_argument("SimulatedCamera: the intrinsics are impossible");
  noise.validate();
  const auto field = smoothField(camera.width, camera.height, Random(derivedSeed(seed, kDistortion)));
  const double scale = noise.distortion / kKinectGain;
  distortion_.resize(field.size());
  std::transform(field.begin(), field.end(), distortion_.begin(),
                 [scale](double value) { return static_cast<float>(scale * value); });
}

SimulatedFrame SimulatedCamera::renderExact(const Scene& scene, const Eigen::Isometry3d& T_w_c) const {
  const Hits hits = castRays(scene, T_w_c, camera_);
  SimulatedFrame frame = emptyFrame(camera_);
  for (std::size_t i = 0; i < hits.facet.size(); ++i) {
    if (hits.facet[i] == kNothing) continue;
    frame.depth.depth[i] = static_cast<float>(hits.depth[i]);
    frame.labels.label[i] = hits.facets[hits.facet[i]].plane_id;
  }
  return frame;
}

SimulatedFrame SimulatedCamera::render(const Scene& scene, const Eigen::Isometry3d& T_w_c,
                                       std::uint64_t frame_index) const {
  const Hits hits = castRays(scene, T_w_c, camera_);
  const double scale = camera_.width / kReferenceWidth;
  const auto stream = [&](Purpose purpose) { return Random(derivedSeed(seed_, purpose, frame_index)); };
  const auto seen = jittered(hits.facet, camera_, noise_.edge_std_px * scale, stream(kSilhouettes));
  const auto noise =
      correlatedNoise(camera_.width, camera_.height, noise_.correlation_px * scale, stream(kDisparity));
  Random dropouts = stream(kDropouts);
  const double min_cosine = std::cos(noise_.grazing_dropout_deg * kDegree);

  SimulatedFrame frame = emptyFrame(camera_);
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      const std::size_t i = std::size_t(v) * camera_.width + u;
      const bool dropped = dropouts.uniform() < noise_.random_dropout;
      if (dropped || seen[i] == kNothing) continue;
      const Facet& facet = hits.facets[seen[i]];
      const Eigen::Vector3d ray = camera_.ray(u, v);
      if (std::abs(facet.normal.dot(ray)) < min_cosine * ray.norm()) continue;
      const double inverse_depth =
          1 / facet.depthAlong(ray) + distortion_[i] + noise_.disparity_std / kKinectGain * noise[i];
      const double depth = 1 / quantized(inverse_depth, noise_.quantization);
      if (!(depth > 0 && depth >= noise_.min_depth && depth <= noise_.max_depth)) continue;
      frame.depth.depth[i] = static_cast<float>(depth);
      frame.labels.label[i] = facet.plane_id;
    }
  }
  return frame;
}

}  // namespace facetloc
