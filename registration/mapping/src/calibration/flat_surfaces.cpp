// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/flat_surfaces.h"

#include <facetloc/segmentation/plane_segmenter.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <map>

namespace facetloc::internal {
namespace {

constexpr double kLeastShare = 0.01;      // least share of the image of an examined surface
constexpr std::size_t kMostSurfaces = 8;  // surfaces used of an image
constexpr double kSamples = 1500;         // approximate number of samples of a surface

double rayLength(double x, double y) { return std::sqrt(1 + x * x + y * y); }

/** The z that a number stands for. \param usual depth of the image, which inverse depths are scaled to [m] */
double meant(DepthIs meaning, double value, double ray_length, double usual) {
  switch (meaning) {
  case DepthIs::distance:
    return value / ray_length;
  case DepthIs::product:
    return value * ray_length;
  case DepthIs::inverse:
    return usual * usual / value;
  case DepthIs::z:
    break;
  }
  return value;
}

DepthImage readAs(DepthIs meaning, DepthImage image, double usual) {
  if (meaning == DepthIs::z) return image;
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u) {
      float& z = image.depth[static_cast<std::size_t>(v) * image.camera.width + u];
      if (isMeasured(z)) z = static_cast<float>(meant(meaning, z, image.camera.ray(u, v).norm(), usual));
    }
  return image;
}

/** The k-th plane of an image; without samples if none of its pixels is among those that are taken. */
FlatSurface surfaceOf(const DepthImage& image, const LabelledPlanes& planes, std::size_t k,
                      const DepthNoise& noise) {
  FlatSurface surface;
  surface.share = planes.support[k] / static_cast<double>(image.depth.size());
  surface.plane = planes.planes[k].toSpace(image.camera);
  const int step = std::max(1, static_cast<int>(std::sqrt(planes.support[k] / kSamples)));
  double sum = 0;
  for (int v = 0; v < image.camera.height; v += step)
    for (int u = 0; u < image.camera.width; u += step) {
      const std::size_t i = static_cast<std::size_t>(v) * image.camera.width + u;
      if (planes.labels.label[i] != k + 1 || !isMeasured(image.depth[i])) continue;
      const Eigen::Vector3d b = image.camera.ray(u, v);
      surface.samples.emplace_back(b.x(), b.y(), 1 / image.depth[i]);
      sum += surface.samples.back().z();
    }
  if (surface.samples.empty()) return surface;
  const double depth = static_cast<double>(surface.samples.size()) / sum;
  surface.weight = std::pow(std::max(DepthNoise::kLeastInverseDepthStd, noise.ofInverseDepth(depth)), -2);
  return surface;
}

/** Weighted products of the columns of one surface, less their parts that a plane explains: inverse depths,
 * the bend by the length of rays, and the bend by a lens. */
Eigen::Matrix3d productsOf(const FlatSurface& s) {
  const auto n = static_cast<Eigen::Index>(s.samples.size());
  Eigen::Matrix<double, Eigen::Dynamic, 3> plane(n, 3), rest(n, 3);  // rest: inverse depth, and both bends
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d& p = s.samples[static_cast<std::size_t>(i)];
    const double r2 = p.x() * p.x() + p.y() * p.y();
    plane.row(i) << p.x(), p.y(), 1;
    rest.row(i) << p.z(), p.z() * std::log(rayLength(p.x(), p.y())),
        -(s.plane.x() * p.x() + s.plane.y() * p.y()) * r2;
  }
  const Eigen::Matrix3d fit = (plane.transpose() * plane).ldlt().solve(plane.transpose() * rest);
  rest -= plane * fit;
  return s.weight * (rest.transpose() * rest);
}

}  // namespace

FlatSurfaces flatSurfaces(const std::vector<DepthImage>& images, const Camera& camera, DepthIs meaning) {
  FlatSurfaces flat;
  if (images.empty()) return flat;
  PlaneSegmenter segmenter({}, camera.noise);
  LabelledPlanes planes;
  const double usual = usualDepth(images.front());
  for (std::size_t i = 0; i < images.size(); ++i) {
    const DepthImage image = readAs(meaning, images[i], usual);
    const auto pixels = static_cast<double>(image.depth.size());
    segmenter.segment(image, planes);
    double measured = 0, squares = 0;
    for (const float z : image.depth) measured += isMeasured(z);
    for (const int n : planes.support) squares += double(n) * n;
    if (measured > 0) flat.flat_share += squares / measured / pixels;
    for (std::size_t k = 0; k < std::min(planes.support.size(), kMostSurfaces); ++k) {
      if (planes.support[k] < kLeastShare * pixels) continue;
      FlatSurface surface = surfaceOf(image, planes, k, camera.noise);
      surface.image = i;
      if (!surface.samples.empty()) flat.surfaces.push_back(std::move(surface));
    }
  }
  flat.flat_share /= static_cast<double>(images.size());
  return flat;
}

SurfaceBend bendOf(const FlatSurfaces& flat) {
  std::map<std::size_t, Eigen::Matrix3d> of_images;  // neighbouring pixels and surfaces share their errors
  Eigen::Matrix3d all = Eigen::Matrix3d::Zero();
  for (const FlatSurface& s : flat.surfaces) {
    const Eigen::Matrix3d products = productsOf(s);
    of_images.try_emplace(s.image, Eigen::Matrix3d::Zero()).first->second += products;
    all += products;
  }
  const Eigen::Matrix2d H = all.bottomRightCorner<2, 2>();  // normal equations of both bends
  const Eigen::Vector2d g = all.bottomLeftCorner<2, 1>();
  SurfaceBend bend;
  bend.flat_share = flat.flat_share;
  const Eigen::LDLT<Eigen::Matrix2d> solver(H);
  if (flat.surfaces.empty() || !solver.isPositive() || !(H.determinant() > 0)) return bend;
  const Eigen::Vector2d best = -solver.solve(g);
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const auto& [image, products] : of_images) {
    const Eigen::Vector2d score =
        products.bottomLeftCorner<2, 1>() + products.bottomRightCorner<2, 2>() * best;
    scatter += score * score.transpose();
  }
  const Eigen::Matrix2d inverse = H.inverse(), covariance = inverse * scatter * inverse;
  bend.ray_exponent = best.x(), bend.ray_exponent_std = std::sqrt(covariance(0, 0));
  bend.lens = -best.y(), bend.lens_std = std::sqrt(covariance(1, 1));
  const double squares = all(0, 0), left = squares + g.dot(best);
  bend.residual_ratio = left > 0 ? squares / left : 1;
  return bend;
}

}  // namespace facetloc::internal
