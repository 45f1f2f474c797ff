// SPDX-License-Identifier: BSD-3-Clause
#include "hits.h"
#include "random.h"
#include "waves.h"

#include <facetloc/features/pose.h>
#include <facetloc/simulation/simulated_camera.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace facetloc {

namespace {

constexpr double kGap = 0.05;       // [1/m] a smaller step of inverse depth is no silhouette
constexpr double kReach = 0.3;      // [m] of light between two surfaces
constexpr double kInFront = 0.005;  // [m] a surface that faces another lies at least so far before it

/** Sums of inverse depths, and how many of them, weighted. */
struct WeightedSums {
  std::vector<double> sum, weight;

  double mean(std::size_t i) const { return weight[i] > 0 ? sum[i] / weight[i] : 0; }
};

/** Sums along an axis of n pixels that are so far apart, over all lines of it, the first ones of which are
 * given. */
WeightedSums alongAxis(const WeightedSums& image, const std::vector<double>& kernel, int n, int stride,
                       int lines, int between_lines) {
  const int radius = static_cast<int>(kernel.size()) - 1;
  WeightedSums out{std::vector<double>(image.sum.size(), 0.0), std::vector<double>(image.sum.size(), 0.0)};
  for (int line = 0; line < lines; ++line)
    for (int i = 0; i < n; ++i) {
      const std::size_t to = std::size_t(line) * between_lines + std::size_t(i) * stride;
      for (int k = std::max(0, i - radius); k <= std::min(n - 1, i + radius); ++k) {
        const std::size_t from = std::size_t(line) * between_lines + std::size_t(k) * stride;
        out.sum[to] += kernel[std::abs(k - i)] * image.sum[from];
        out.weight[to] += kernel[std::abs(k - i)] * image.weight[from];
      }
    }
  return out;
}

/** Around each pixel, of the inverse depths that are known (0 = not). */
WeightedSums gaussianSums(const std::vector<double>& inverse, const Intrinsics& camera, double sigma) {
  constexpr double kSigmas = 3;
  std::vector<double> kernel;
  for (int k = 0; k <= std::ceil(kSigmas * sigma); ++k)
    kernel.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
  WeightedSums image{inverse, std::vector<double>(inverse.size())};
  std::transform(inverse.begin(), inverse.end(), image.weight.begin(), [](double d) { return d > 0; });
  const int width = camera.width, height = camera.height;
  return alongAxis(alongAxis(image, kernel, width, 1, height, width), kernel, height, width, width, 1);
}

std::vector<double> inverted(std::vector<double> values) {
  for (double& value : values) value = value > 0 ? 1 / value : 0;
  return values;
}

/** Makes pixels near a step of inverse depth unknown. */
std::vector<double> withoutSilhouettes(const std::vector<double>& inverse, const Intrinsics& camera,
                                       int radius) {
  std::vector<double> out = inverse;
  const auto at = [&](int u, int v) { return std::size_t(v) * camera.width + u; };
  const auto isStep = [&](std::size_t a, std::size_t b) {
    return inverse[a] > 0 && inverse[b] > 0 && std::abs(inverse[a] - inverse[b]) > kGap;
  };
  for (int v = 0; v + 1 < camera.height; ++v)
    for (int u = 0; u + 1 < camera.width; ++u) {
      if (!isStep(at(u, v), at(u + 1, v)) && !isStep(at(u, v), at(u, v + 1))) continue;
      for (int y = std::max(0, v - radius + 1); y <= std::min(camera.height - 1, v + radius); ++y)
        for (int x = std::max(0, u - radius + 1); x <= std::min(camera.width - 1, u + radius); ++x)
          out[at(x, y)] = 0;
    }
  return out;
}

/** The surfaces as a stereo camera sees them: nearer ones grow by `px` pixels, since its matching window sees
 * them first. */
std::vector<int> fattened(const Hits& hits, const Intrinsics& camera, double px) {
  const int radius = static_cast<int>(std::lround(px));
  if (radius < 1) return hits.surface;
  // The nearest pixel around, first of the row, then of these.
  std::vector<std::size_t> of_row(hits.depth.size()), nearest(hits.depth.size());
  const auto isNearer = [&](std::size_t a, std::size_t b) { return hits.depth[a] < hits.depth[b]; };
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t row = std::size_t(v) * camera.width;
      std::size_t best = row + u;
      for (int x = std::max(0, u - radius); x <= std::min(camera.width - 1, u + radius); ++x)
        if (isNearer(row + x, best)) best = row + x;
      of_row[row + u] = best;
    }
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      std::size_t best = of_row[std::size_t(v) * camera.width + u];
      for (int y = std::max(0, v - radius); y <= std::min(camera.height - 1, v + radius); ++y)
        if (const std::size_t other = of_row[std::size_t(y) * camera.width + u]; isNearer(other, best))
          best = other;
      nearest[std::size_t(v) * camera.width + u] = best;
    }
  std::vector<int> seen(hits.surface);
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (1 / hits.depth[nearest[i]] - 1 / hits.depth[i] > kGap) seen[i] = hits.surface[nearest[i]];
  return seen;
}

/** How much of its light a pixel gets by way of another surface, in [0, 1]: 1 in the edge where two surfaces
 * meet, 0 from 0.3 m on. Light that comes round a corner has a longer way. */
double cornerShare(const Hits& hits, const Intrinsics& camera, int u, int v) {
  const std::size_t i = std::size_t(v) * camera.width + u;
  if (hits.surface[i] == kNothing) return 0;
  const Eigen::Vector3d p = hits.depth[i] * camera.ray(u, v);
  Eigen::Vector3d n = hits.with(hits.surface[i], [&](const auto& seen) { return seen.normalAt(p); });
  if (n.dot(p) > 0) n = -n;
  double nearest = kReach;
  for (const double away : {0.02, 0.05, 0.1, 0.15, 0.2, 0.3}) {
    const int px = std::max(1, static_cast<int>(std::lround(away * camera.fx / p.z())));
    for (const auto& [du, dv] : {std::pair(px, 0), std::pair(-px, 0), std::pair(0, px), std::pair(0, -px)}) {
      const int x = u + du, y = v + dv;
      if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) continue;
      const std::size_t j = std::size_t(y) * camera.width + x;
      if (hits.surface[j] == kNothing || hits.surface[j] == hits.surface[i]) continue;
      const Eigen::Vector3d way = hits.depth[j] * camera.ray(x, y) - p;
      if (n.dot(way) > kInFront) nearest = std::min(nearest, way.norm());
    }
  }
  return 1 - nearest / kReach;
}

/** Depths [m] (0 = nothing seen) as a window sees them: means of the inverse depths seen around, weighted by
 * a Gaussian of that standard deviation. Planes stay planes, silhouettes become ramps. */
std::vector<double> blurred(const std::vector<double>& depth, const Intrinsics& camera, double px) {
  std::vector<double> inverse = inverted(depth);
  const WeightedSums around = gaussianSums(inverse, camera, px);
  for (std::size_t i = 0; i < inverse.size(); ++i)
    if (inverse[i] > 0) inverse[i] = around.mean(i);
  return inverted(std::move(inverse));
}

/** Depths without holes: pixels within `px` of silhouettes and those not seen are interpolated between the
 * others. Where nothing is seen at all, nothing is invented. */
std::vector<double> filledIn(const std::vector<double>& depth, const Intrinsics& camera, double px) {
  const int radius = std::max(1, static_cast<int>(std::lround(px)));
  const std::vector<double> known = withoutSilhouettes(inverted(depth), camera, radius);
  std::vector<double> filled = known;
  // Each wider window fills those gaps that the narrower ones did not reach across.
  for (double sigma = std::max(1.0, px / 2); sigma < camera.width; sigma *= 2) {
    if (std::find(filled.begin(), filled.end(), 0.0) == filled.end()) break;
    const WeightedSums around = gaussianSums(known, camera, sigma);
    for (std::size_t i = 0; i < filled.size(); ++i)
      if (!(filled[i] > 0)) filled[i] = around.mean(i);
  }
  return inverted(std::move(filled));
}

SimulatedFrame emptyFrame(const Intrinsics& camera) {
  return {{camera, std::vector<float>(pixelCount(camera), 0.f)},
          {camera.width, camera.height, std::vector<std::uint16_t>(pixelCount(camera), 0)}};
}

constexpr double kReferenceWidth = 640;  // [px] lengths in SimulatedNoise refer to an image of this width
constexpr double kBlobSize = 6;          // [px] correlation length of losses in patches
constexpr double kPatchSize = 12;        // [px] correlation length of the texture of surfaces
constexpr double kGlassSeen = 1.3;       // [sigma] blobs above this are seen in a pane: one pixel in ten
constexpr double kDrawnBack = 0.5;       // share of the way beyond the reliable depth that is seen
constexpr double kDarkSpread = 0.35;     // spread of the range of dark surfaces, per sigma of the blobs

enum Purpose : std::uint64_t {
  kDistortion,
  kDisparity,
  kSilhouettes,
  kDropouts,
  kBlobs,
  kTexture,
  kMixing,
  kSmoothError
};

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

/** True for a share of the pixels, in patches. */
std::vector<bool> patches(double share, const Intrinsics& camera, double size, Random random) {
  std::vector<bool> inside(pixelCount(camera), false);
  if (!(share > 0)) return inside;
  const std::vector<double> field = correlatedNoise(camera.width, camera.height, size, random);
  std::vector<double> sorted = field;
  const auto rank = static_cast<std::ptrdiff_t>(std::min(1.0, share) * static_cast<double>(field.size() - 1));
  std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
  std::transform(field.begin(), field.end(), inside.begin(),
                 [limit = sorted[rank]](double value) { return value < limit; });
  return inside;
}

/** Random field of unit variance, independent in two frames that are `images` apart. */
std::vector<double> slowlyChangingField(const Intrinsics& camera, std::uint64_t seed, std::uint64_t frame,
                                        double images) {
  const double at = static_cast<double>(frame) / images, before = std::floor(at);
  const auto field = [&](double index) {
    return smoothField(camera.width, camera.height,
                       Random(derivedSeed(seed, kSmoothError, static_cast<std::uint64_t>(index))));
  };
  std::vector<double> sum = field(before);
  const double angle = (at - before) * 90 * kDegree;
  if (angle > 0) {
    const std::vector<double> next = field(before + 1);
    for (std::size_t i = 0; i < sum.size(); ++i)
      sum[i] = std::cos(angle) * sum[i] + std::sin(angle) * next[i];
  }
  return sum;
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
  checkRanges(noise);
  const auto field = smoothField(camera.width, camera.height, Random(derivedSeed(seed, kDistortion)));
  const double scale = noise.noise_factor * noise.distortion / kKinectGain;
  distortion_.resize(field.size());
  std::transform(field.begin(), field.end(), distortion_.begin(),
                 [scale](double value) { return static_cast<float>(scale * value); });
}

SimulatedFrame SimulatedCamera::renderExact(const SimulatedWorld& world,
                                            const Eigen::Isometry3d& T_w_c) const {
  const Hits hits(world, T_w_c, camera_);
  BentSurfaces bent(world.bending, T_w_c);
  SimulatedFrame frame = emptyFrame(camera_);
  for (int v = 0; v < camera_.height; ++v)
    for (int u = 0; u < camera_.width; ++u) {
      const std::size_t i = std::size_t(v) * camera_.width + u;
      if (hits.surface[i] == kNothing) continue;
      hits.with(hits.surface[i], [&](const auto& seen) {
        frame.depth.depth[i] = static_cast<float>(bent.depth(seen, camera_.ray(u, v), hits.depth[i]));
        frame.labels.label[i] = seen.label;
      });
    }
  return frame;
}

SimulatedFrame SimulatedCamera::render(const SimulatedWorld& world, const Eigen::Isometry3d& T_w_c,
                                       std::uint64_t frame_index) const {
  Seen seen = surfacesSeen(world, T_w_c, frame_index);
  shareErrors(seen.depth, frame_index);
  return measured(seen, frame_index);
}

/** The surfaces that the camera perceives in the world, before it measures their distance. */
SimulatedCamera::Seen SimulatedCamera::surfacesSeen(const SimulatedWorld& world,
                                                    const Eigen::Isometry3d& T_w_c,
                                                    std::uint64_t frame_index) const {
  const double scale = camera_.width / kReferenceWidth;
  const auto stream = [&](Purpose purpose) { return Random(derivedSeed(seed_, purpose, frame_index)); };
  const std::vector<double> blobs =
      correlatedNoise(camera_.width, camera_.height, kBlobSize * scale, stream(kBlobs));
  std::vector<bool> opaque(blobs.size());
  std::transform(blobs.begin(), blobs.end(), opaque.begin(), [](double b) { return b > kGlassSeen; });

  const Hits hits(world, T_w_c, camera_, opaque);
  BentSurfaces bent(world.bending, T_w_c);
  const std::vector<bool> lit = litByProjector(hits.depth);
  const auto covered = fattened(hits, camera_, noise_.fattening_px * scale);
  const auto seen =
      jittered(covered, camera_, noise_.noise_factor * noise_.edge_std_px * scale, stream(kSilhouettes));
  const auto mixed_in = jittered(seen, camera_, noise_.flying_px * scale, stream(kMixing));
  const auto untextured = patches(noise_.untextured, camera_, kPatchSize * scale, stream(kTexture));
  Random dropouts = stream(kDropouts), mixing = stream(kMixing);

  Seen result{std::vector<double>(hits.depth.size(), 0.0), emptyFrame(camera_).labels};
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      const std::size_t i = std::size_t(v) * camera_.width + u;
      const bool dropped = dropouts.uniform() < noise_.random_dropout;
      if (dropped || seen[i] == kNothing || !lit[i] || untextured[i]) continue;
      hits.with(seen[i], [&](const auto& surface) {
        const Eigen::Vector3d ray = camera_.ray(u, v);
        double z = surface.depthAlong(ray);
        const double cosine = std::abs(surface.normalAt(z * ray).dot(ray)) / ray.norm();
        if (!(z > 0 && z < kMiss) || !reflects(surface.material, z, cosine, blobs[i])) return;
        z = bent.depth(surface, ray, z);
        if (mixed_in[i] != seen[i]) z = hits.between(z, mixed_in[i], ray, mixing.uniform());
        if (noise_.multipath > 0) z += noise_.multipath * cornerShare(hits, camera_, u, v);
        if (z > noise_.reliable_depth) z = noise_.reliable_depth + kDrawnBack * (z - noise_.reliable_depth);
        result.depth[i] = z;
        result.labels.label[i] = surface.label;
      });
    }
  }
  return result;
}

/** Errors that neighbouring pixels have in common, so that no mean over pixels is free of them. */
void SimulatedCamera::shareErrors(std::vector<double>& depth, std::uint64_t frame_index) const {
  const double scale = camera_.width / kReferenceWidth;
  if (noise_.blur_px > 0) depth = blurred(depth, camera_, noise_.blur_px * scale);
  if (noise_.filling_px > 0) depth = filledIn(depth, camera_, noise_.filling_px * scale);
  if (!(noise_.smooth_error > 0)) return;
  const std::vector<double> field = slowlyChangingField(camera_, seed_, frame_index, noise_.smooth_images);
  for (std::size_t i = 0; i < depth.size(); ++i) depth[i] *= std::exp(noise_.smooth_error * field[i]);
}

SimulatedFrame SimulatedCamera::measured(const Seen& seen, std::uint64_t frame_index) const {
  const auto noise =
      correlatedNoise(camera_.width, camera_.height, noise_.correlation_px * camera_.width / kReferenceWidth,
                      Random(derivedSeed(seed_, kDisparity, frame_index)));
  SimulatedFrame frame = emptyFrame(camera_);
  for (std::size_t i = 0; i < seen.depth.size(); ++i) {
    const double z = seen.depth[i];
    if (!(z > 0)) continue;
    const double depth = 1 / quantized(1 / z + distortion_[i] + randomStd(z) * noise[i], noise_.quantization);
    if (!(depth > 0 && depth >= noise_.min_depth && depth <= noise_.max_depth)) continue;
    frame.depth.depth[i] = static_cast<float>(depth);
    frame.labels.label[i] = seen.labels.label[i];
  }
  return frame;
}

/** Standard deviation of the random error of inverse depth [1/m], at the depth z. */
double SimulatedCamera::randomStd(double z) const {
  const double of_disparity = noise_.noise_factor * noise_.disparity_std / kKinectGain;
  return of_disparity + noise_.noise_factor * (noise_.depth_std_slope + noise_.depth_std / z) / z;
}

/** Is enough of the pattern seen? Blobs shift the limits, so that failures come in patches. */
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
