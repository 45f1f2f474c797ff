// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/testing/synthetic_depth.h>

#include <cmath>
#include <random>

namespace facetloc::test {

Intrinsics smallCamera() { return {320, 240, 290, 292, 159.5, 120.25}; }
Intrinsics tinyCamera() { return {160, 120, 145, 146, 79.5, 60.25}; }

Face endlessPlane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d n = normal.normalized(), x = n.unitOrthogonal();
  return {point, x, n.cross(x), 0, 0};
}

Scene box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const Eigen::Vector3d c = (low + high) / 2, h = (high - low) / 2;
  Scene faces;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const int i = (axis + 1) % 3, k = (axis + 2) % 3;
      faces.push_back({c + side * h[axis] * Eigen::Vector3d::Unit(axis), Eigen::Vector3d::Unit(i),
                       Eigen::Vector3d::Unit(k), h[i], h[k]});
    }
  return faces;
}

Scene operator+(Scene a, const Scene& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Rendering render(const Scene& scene, const Intrinsics& camera, const Eigen::Isometry3d& T_w_c,
                 double farthest) {
  Rendering out;
  out.image.camera = camera;
  out.image.depth.assign(static_cast<std::size_t>(camera.width) * camera.height, 0.f);
  out.labels = {camera.width, camera.height, std::vector<std::uint16_t>(out.image.depth.size(), 0)};
  const Eigen::Vector3d origin = T_w_c.translation();
  std::vector<Eigen::Vector3d> normals;
  std::vector<double> offsets;  // offsets of the faces from the camera
  for (const Face& f : scene) {
    normals.push_back(f.x.cross(f.y));
    offsets.push_back(normals.back().dot(f.centre - origin));
  }
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = T_w_c.linear() * camera.ray(u, v);
      double nearest = farthest;
      const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
      for (std::size_t k = 0; k < scene.size(); ++k) {
        const Face& f = scene[k];
        const double z = offsets[k] / normals[k].dot(ray);
        if (!(z > 0.05) || z >= nearest) continue;
        const Eigen::Vector3d d = origin + z * ray - f.centre;
        if (f.half_x > 0 && (std::abs(f.x.dot(d)) > f.half_x || std::abs(f.y.dot(d)) > f.half_y)) continue;
        nearest = z;
        out.image.depth[i] = static_cast<float>(z);
        out.labels.label[i] = static_cast<std::uint16_t>(k + 1);
      }
    }
  return out;
}

DepthImage noisy(DepthImage image, double inverse_depth_std, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> noise(0, inverse_depth_std);
  for (float& z : image.depth)
    if (z > 0) z = static_cast<float>(1 / (1 / double(z) + noise(rng)));
  return image;
}

DepthImage smoothlyNoisy(DepthImage image, double inverse_depth_std, double smoothing, unsigned seed) {
  const int w = image.camera.width, h = image.camera.height,
            reach = static_cast<int>(std::ceil(3 * smoothing));
  std::vector<double> weights;
  for (int i = -reach; i <= reach; ++i) weights.push_back(std::exp(-0.5 * i * i / (smoothing * smoothing)));
  double power = 0;  // sum of squares of the weights of one direction
  for (const double weight : weights) power += weight * weight;
  std::mt19937 rng(seed);
  std::normal_distribution<double> white(0, inverse_depth_std / power);
  std::vector<double> noise(image.depth.size()), along_rows(image.depth.size());
  for (double& x : noise) x = white(rng);
  const auto at = [&](const std::vector<double>& x, int u, int v) {  // beyond its edge the noise repeats
    return x[static_cast<std::size_t>((v + h) % h) * w + (u + w) % w];
  };
  for (int v = 0; v < h; ++v)
    for (int u = 0; u < w; ++u)
      for (int i = -reach; i <= reach; ++i)
        along_rows[static_cast<std::size_t>(v) * w + u] += weights[i + reach] * at(noise, u + i, v);
  for (int v = 0; v < h; ++v)
    for (int u = 0; u < w; ++u) {
      double sum = 0;
      for (int i = -reach; i <= reach; ++i) sum += weights[i + reach] * at(along_rows, u, v + i);
      float& z = image.depth[static_cast<std::size_t>(v) * w + u];
      if (z > 0) z = static_cast<float>(1 / (1 / double(z) + sum));
    }
  return image;
}

DepthImage rounded(DepthImage image) {
  for (float& z : image.depth)
    if (z > 0) z = static_cast<float>(kinectDepth(std::round(kinectDisparity(z))));
  return image;
}

Eigen::Isometry3d lookingAlong(const Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                               const Eigen::Vector3d& down) {
  const Eigen::Vector3d z = direction.normalized(), x = down.cross(z).normalized();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << x, z.cross(x), z;
  T.translation() = position;
  return T;
}

Scene furnishedRoom() {
  return box({0, 0, 0}, {4, 5, 2.5}) + box({2.6, 3.2, 0}, {3.4, 4.2, 0.8}) +
         box({0, 3.5, 0}, {0.5, 4.5, 1.6});
}

}  // namespace facetloc::test
