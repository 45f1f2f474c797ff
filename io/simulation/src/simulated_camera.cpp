// SPDX-License-Identifier: BSD-3-Clause
#include "random.h"

#include <facetloc/features/so3.h>
#include <facetloc/simulation/simulated_camera.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace facetloc {

// ---- Rays ----

namespace {

constexpr double kNearPlane = 0.05;      // [m]
constexpr double kEdgeTolerance = 1e-9;  // [m] closes the cracks between rectangles that share an edge
constexpr double kMiss = std::numeric_limits<double>::infinity();

/** A rectangle in the camera frame, ready for rays: the plane n . p = d and the two coordinates in it. */
struct Facet {
  Eigen::Vector3d normal, axis_u, axis_v;
  double distance, centre_u, centre_v, half_u, half_v;
  std::uint16_t label;
  Material material;

  Facet(const Rectangle& r, const Eigen::Isometry3d& T_c_w)
      : axis_u(T_c_w.linear() * r.axis_u),
        axis_v(T_c_w.linear() * r.axis_v),
        half_u(r.half_u),
        half_v(r.half_v),
        label(r.plane_id),
        material(r.material) {
    const Eigen::Vector3d centre = T_c_w * r.centre;
    normal = axis_u.cross(axis_v);
    distance = normal.dot(centre);
    centre_u = axis_u.dot(centre);
    centre_v = axis_v.dot(centre);
  }
  /** Depth at which a ray with b_z = 1 meets the whole plane; negative or infinite if it does not. */
  double depthAlong(const Eigen::Vector3d& ray) const { return distance / normal.dot(ray); }
  /** ... the rectangle itself. */
  double hitAlong(const Eigen::Vector3d& ray) const {
    const double z = depthAlong(ray);
    return z >= kNearPlane && contains(z * ray) ? z : kMiss;
  }
  bool contains(const Eigen::Vector3d& p) const {
    return std::abs(axis_u.dot(p) - centre_u) <= half_u + kEdgeTolerance &&
           std::abs(axis_v.dot(p) - centre_v) <= half_v + kEdgeTolerance;
  }
  Eigen::Vector3d normalAt(const Eigen::Vector3d&) const { return normal; }
  std::array<Eigen::Vector3d, 4> corners() const {
    const Eigen::Vector3d centre = distance * normal + centre_u * axis_u + centre_v * axis_v;
    const Eigen::Vector3d u = half_u * axis_u, v = half_v * axis_v;
    return {centre - u - v, centre + u - v, centre + u + v, centre - u + v};
  }
};

/** A round body in the camera frame: |S (p - c)| = 1, where S scales the axes that are round. */
struct Quadric {
  std::uint16_t label = 0;  // it is no plane
  Eigen::Isometry3d T_b_c;
  Eigen::Vector3d half_size, round;  // round: 1 / half size, 0 along a cylinder
  Material material;

  Quadric(const RoundBody& body, const Eigen::Isometry3d& T_c_w)
      : T_b_c((T_c_w * body.T_w_b).inverse()),
        half_size(body.half_size),
        round(half_size.cwiseInverse()),
        material(body.material) {
    if (body.shape == RoundBody::Shape::cylinder) round.z() = 0;
  }
  /** Depth at which a ray first enters, or leaves from inside an open end. */
  double depthAlong(const Eigen::Vector3d& ray) const {
    const Eigen::Vector3d direction = T_b_c.linear() * ray;
    const Eigen::Vector3d o = round.cwiseProduct(T_b_c.translation()), d = round.cwiseProduct(direction);
    const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - 1;
    const double discriminant = b * b - a * c;
    if (!(a > 0 && discriminant > 0)) return kMiss;
    for (const double root : {-std::sqrt(discriminant), std::sqrt(discriminant)}) {
      const double z = (root - b) / a;
      const double height = T_b_c.translation().z() + z * direction.z();
      if (z >= kNearPlane && std::abs(height) <= half_size.z()) return z;
    }
    return kMiss;
  }
  double hitAlong(const Eigen::Vector3d& ray) const { return depthAlong(ray); }
  Eigen::Vector3d normalAt(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d gradient = round.cwiseAbs2().cwiseProduct(T_b_c * p);
    return (T_b_c.linear().transpose() * gradient).normalized();
  }
  std::array<Eigen::Vector3d, 8> corners() const {
    const Eigen::Isometry3d T_c_b = T_b_c.inverse();
    std::array<Eigen::Vector3d, 8> corners;
    for (int i = 0; i < 8; ++i)
      corners[i] = T_c_b * Eigen::Vector3d(i & 1 ? half_size.x() : -half_size.x(),
                                           i & 2 ? half_size.y() : -half_size.y(),
                                           i & 4 ? half_size.z() : -half_size.z());
    return corners;
  }
};

/** Pixels [u0, u1) x [v0, v1). */
struct PixelBox {
  int u0 = 0, u1 = 0, v0 = 0, v1 = 0;
};

/** Grows around the projections of points. */
class ProjectedBox {
public:
  explicit ProjectedBox(const Intrinsics& camera) : camera_(camera) {}
  void include(const Eigen::Vector3d& p) {
    const Eigen::Vector2d pixel = camera_.project(p);
    lowest_ = lowest_.cwiseMin(pixel);
    highest_ = highest_.cwiseMax(pixel);
  }
  PixelBox pixels() const {
    if (!(lowest_.x() <= highest_.x())) return {};
    // One pixel more on each side makes up for rounding.
    const auto first = [](double x, int size) {
      return static_cast<int>(std::clamp(std::floor(x) - 1, 0.0, double(size)));
    };
    const auto end = [](double x, int size) {
      return static_cast<int>(std::clamp(std::ceil(x) + 2, 0.0, double(size)));
    };
    return {first(lowest_.x(), camera_.width), end(highest_.x(), camera_.width),
            first(lowest_.y(), camera_.height), end(highest_.y(), camera_.height)};
  }

private:
  const Intrinsics& camera_;
  Eigen::Vector2d lowest_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d highest_ = -lowest_;
};

/** The pixels that can see a facet: the bounding box of its projection, cut off at the near plane. */
PixelBox boundingBox(const Facet& facet, const Intrinsics& camera) {
  ProjectedBox box(camera);
  const auto corners = facet.corners();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    if (a.z() >= kNearPlane) box.include(a);
    if ((a.z() < kNearPlane) != (b.z() < kNearPlane)) {
      Eigen::Vector3d cut = a + (kNearPlane - a.z()) / (b.z() - a.z()) * (b - a);
      cut.z() = kNearPlane;
      box.include(cut);
    }
  }
  return box.pixels();
}

/** The pixels that can see a round body: all of them if it reaches behind the camera. */
PixelBox boundingBox(const Quadric& quadric, const Intrinsics& camera) {
  const auto corners = quadric.corners();
  const auto inFront = [](const Eigen::Vector3d& p) { return p.z() >= kNearPlane; };
  if (std::none_of(corners.begin(), corners.end(), inFront)) return {};
  if (!std::all_of(corners.begin(), corners.end(), inFront)) return {0, camera.width, 0, camera.height};
  ProjectedBox box(camera);
  for (const Eigen::Vector3d& corner : corners) box.include(corner);
  return box.pixels();
}

constexpr int kNothing = -1;

std::size_t pixelCount(const Intrinsics& camera) { return std::size_t(camera.width) * camera.height; }

/** What every pixel sees: the depth and the number of a surface, first the rectangles, then the bodies. */
class Hits {
public:
  /** \param opaque which pixels are reflected by glass; none if it is empty. */
  Hits(const Scene& scene, const Eigen::Isometry3d& T_w_c, const Intrinsics& camera,
       const std::vector<bool>& opaque = {})
      : depth(pixelCount(camera), kMiss), surface(pixelCount(camera), kNothing) {
    const Eigen::Isometry3d T_c_w = T_w_c.inverse();
    for (const Rectangle& r : scene.rectangles) facets_.emplace_back(r, T_c_w);
    for (const RoundBody& b : scene.bodies) quadrics_.emplace_back(b, T_c_w);
    int number = 0;
    for (const Facet& facet : facets_) cast(facet, number++, camera, opaque);
    for (const Quadric& quadric : quadrics_) cast(quadric, number++, camera, opaque);
  }

  /** Calls what(surface) with the facet or the quadric of that number. */
  template <class What>
  auto with(int number, What&& what) const {
    const int facets = static_cast<int>(facets_.size());
    return number < facets ? what(facets_[number]) : what(quadrics_[number - facets]);
  }

  std::vector<double> depth;
  std::vector<int> surface;

private:
  template <class Surface>
  void cast(const Surface& seen, int number, const Intrinsics& camera, const std::vector<bool>& opaque) {
    const PixelBox box = boundingBox(seen, camera);
    const bool glass = seen.material == Material::glass;
    for (int v = box.v0; v < box.v1; ++v) {
      for (int u = box.u0; u < box.u1; ++u) {
        const std::size_t i = std::size_t(v) * camera.width + u;
        if (glass && (opaque.empty() || !opaque[i])) continue;
        const double z = seen.hitAlong(camera.ray(u, v));
        if (!(z < depth[i])) continue;
        depth[i] = z;
        surface[i] = number;
      }
    }
  }

  std::vector<Facet> facets_;
  std::vector<Quadric> quadrics_;
};

SimulatedFrame emptyFrame(const Intrinsics& camera) {
  return {{camera, std::vector<float>(pixelCount(camera), 0.f)},
          {camera.width, camera.height, std::vector<std::uint16_t>(pixelCount(camera), 0)}};
}

// ---- Errors ----

constexpr double kReferenceWidth = 640;  // [px] lengths in SimulatedNoise refer to an image of this width
constexpr double kBlobSize = 6;          // [px] correlation length of what is lost in patches
constexpr double kGlassSeen = 1.3;       // [sigma] blobs above this are seen in a pane: one pixel in ten
constexpr double kDarkSpread = 0.35;     // of the range of dark surfaces, per sigma of the blobs

enum Purpose : std::uint64_t { kDistortion, kDisparity, kSilhouettes, kDropouts, kBlobs };

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
  const double scale = noise.noise_factor * noise.distortion / kKinectGain;
  distortion_.resize(field.size());
  std::transform(field.begin(), field.end(), distortion_.begin(),
                 [scale](double value) { return static_cast<float>(scale * value); });
}

SimulatedFrame SimulatedCamera::renderExact(const Scene& scene, const Eigen::Isometry3d& T_w_c) const {
  const Hits hits(scene, T_w_c, camera_);
  SimulatedFrame frame = emptyFrame(camera_);
  for (std::size_t i = 0; i < hits.surface.size(); ++i) {
    if (hits.surface[i] == kNothing) continue;
    frame.depth.depth[i] = static_cast<float>(hits.depth[i]);
    frame.labels.label[i] = hits.with(hits.surface[i], [](const auto& seen) { return seen.label; });
  }
  return frame;
}

SimulatedFrame SimulatedCamera::render(const Scene& scene, const Eigen::Isometry3d& T_w_c,
                                       std::uint64_t frame_index) const {
  const double scale = camera_.width / kReferenceWidth;
  const auto stream = [&](Purpose purpose) { return Random(derivedSeed(seed_, purpose, frame_index)); };
  const std::vector<double> blobs =
      correlatedNoise(camera_.width, camera_.height, kBlobSize * scale, stream(kBlobs));
  std::vector<bool> opaque(blobs.size());
  std::transform(blobs.begin(), blobs.end(), opaque.begin(), [](double b) { return b > kGlassSeen; });

  const Hits hits(scene, T_w_c, camera_, opaque);
  const std::vector<bool> lit = litByProjector(hits.depth);
  const auto seen =
      jittered(hits.surface, camera_, noise_.noise_factor * noise_.edge_std_px * scale, stream(kSilhouettes));
  const auto noise =
      correlatedNoise(camera_.width, camera_.height, noise_.correlation_px * scale, stream(kDisparity));
  const double disparity_std = noise_.noise_factor * noise_.disparity_std / kKinectGain;
  Random dropouts = stream(kDropouts);

  SimulatedFrame frame = emptyFrame(camera_);
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      const std::size_t i = std::size_t(v) * camera_.width + u;
      const bool dropped = dropouts.uniform() < noise_.random_dropout;
      if (dropped || seen[i] == kNothing || !lit[i]) continue;
      hits.with(seen[i], [&](const auto& surface) {
        const Eigen::Vector3d ray = camera_.ray(u, v);
        const double z = surface.depthAlong(ray);
        const double cosine = std::abs(surface.normalAt(z * ray).dot(ray)) / ray.norm();
        if (!(z > 0 && z < kMiss) || !reflects(surface.material, z, cosine, blobs[i])) return;
        const double depth =
            1 / quantized(1 / z + distortion_[i] + disparity_std * noise[i], noise_.quantization);
        if (!(depth > 0 && depth >= noise_.min_depth && depth <= noise_.max_depth)) return;
        frame.depth.depth[i] = static_cast<float>(depth);
        frame.labels.label[i] = surface.label;
      });
    }
  }
  return frame;
}

/** Is enough of the pattern seen? Blobs shift the limits, so that what fails does so in patches. */
bool SimulatedCamera::reflects(Material material, double z, double cosine, double blob) const {
  const double angle_deg = std::acos(std::min(cosine, 1.0)) / kDegree;
  if (angle_deg > noise_.grazing_dropout_deg + noise_.grazing_spread_deg * blob) return false;
  if (material != Material::dark || noise_.dark_range <= 0) return true;
  const double limit = noise_.dark_range * std::exp(kDarkSpread * blob);
  return z * z < limit * limit * cosine;
}

/** Pixels whose surface the projector reaches: it looks from beside the camera, at +x, and a surface is in
 * shadow where a nearer one to its right is projected onto the same place or beyond. */
std::vector<bool> SimulatedCamera::litByProjector(const std::vector<double>& depth) const {
  std::vector<bool> lit(depth.size(), true);
  const double parallax = camera_.fx * noise_.projector_baseline;
  for (int v = 0; v < camera_.height; ++v) {
    double leftmost = std::numeric_limits<double>::infinity();  // column in the projector's image
    for (int u = camera_.width - 1; u >= 0; --u) {
      const std::size_t i = std::size_t(v) * camera_.width + u;
      const double column = u - parallax / depth[i];
      lit[i] = column <= leftmost;
      leftmost = std::min(leftmost, column);
    }
  }
  return lit;
}

}  // namespace facetloc
