// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/depth_drawing.h"

#include "drawing/pictures.h"

#include <facetloc/registration/calibration.h>
#include <facetloc/registration/candidate_pairs.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <jpeglib.h>  // which needs <cstdio>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

namespace facetloc {

namespace {

/** True at the outline of a segment; holes of one pixel are no outline. */
bool isBorder(const LabelImage& labels, int u, int v) {
  const auto at = [&](int x, int y) -> int {
    if (x < 0 || y < 0 || x >= labels.width || y >= labels.height) return -1;
    return labels.label[static_cast<std::size_t>(y) * labels.width + x];
  };
  const int label = at(u, v);
  const auto endsTowards = [&](int du, int dv) {
    return at(u + du, v + dv) != label && at(u + 2 * du, v + 2 * dv) != label;
  };
  return label > 0 && (endsTowards(1, 0) || endsTowards(0, 1) || endsTowards(-1, 0) || endsTowards(0, -1));
}

/** Mixes a colour into a pixel by its alpha, rounded. */
void mixInto(std::uint8_t* pixel, const Colour& colour) {
  const std::array<int, 3> rgb = {colour.red, colour.green, colour.blue};
  for (int i = 0; i < 3; ++i)
    pixel[i] =
        static_cast<std::uint8_t>((pixel[i] * (255 - colour.alpha) + rgb[i] * colour.alpha + 127) / 255);
}

/** How far a segment of a view is from explaining a pixel; infinite if the pixel cannot be of the segment.
 * \param z depth of the pixel [m], 0 = unknown. */
double misfitOf(const Segment& segment, const DepthPicture& picture, const Eigen::Vector3d& ray, float z) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double predicted = segment.normal().dot(ray) / segment.offset();  // inverse depth [1/m]
  if (!(predicted > 0)) return kNever;
  const Eigen::Vector3d in_plane = segment.R.transpose() * (ray / predicted - segment.t);
  if (!segment.hull.contains(in_plane.head<2>().cast<float>())) return kNever;
  if (picture.empty()) return 1 / predicted;
  if (!(z > 0)) return kNever;
  const double error = std::abs(1 / z - predicted);
  const DepthCalibration p;
  const double noise = picture.noise.ofInverseDepth(1 / predicted);
  const double tolerance = p.gate * (p.absolute_error * noise + p.relative_error * predicted);
  return error <= tolerance ? error : kNever;
}

/** The label of the segment that explains a pixel best; 0 if none does. */
std::uint16_t labelOf(const View& view, const Eigen::Vector3d& ray, float z) {
  std::uint16_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < view.segments.size(); ++k) {
    const double misfit = misfitOf(view.segments[k], view.depth, ray, z);
    if (misfit >= least) continue;
    least = misfit;
    best = static_cast<std::uint16_t>(k + 1);
  }
  return best;
}

/** The cosine between the ray of a pixel and the normal of the surface there, by a plane in inverse depth
 * through the pixels around; 0 if it is not known. */
double facingAt(const DepthImage& image, int u, int v) {
  constexpr int kReach = 4;          // [px]
  constexpr double kSurface = 0.06;  // largest difference of inverse depth on a surface, as a share of it
  const Intrinsics& camera = image.camera;
  if (!(image.at(u, v) > 0)) return 0;
  const double here = 1 / static_cast<double>(image.at(u, v));
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (int y = std::max(0, v - kReach); y <= std::min(camera.height - 1, v + kReach); ++y)
    for (int x = std::max(0, u - kReach); x <= std::min(camera.width - 1, u + kReach); ++x) {
      if (!(image.at(x, y) > 0)) continue;
      const double q = 1 / static_cast<double>(image.at(x, y));
      if (std::abs(q - here) > kSurface * here) continue;
      const Eigen::Vector3d ray = camera.ray(x, y);
      A += ray * ray.transpose();
      b += ray * q;
    }
  const Eigen::Vector3d plane = A.ldlt().solve(b);  // q = plane . ray, so the plane's normal
  const Eigen::Vector3d ray = camera.ray(u, v);
  const double facing = plane.dot(ray) / (plane.norm() * ray.norm());
  return facing > 0 ? facing : 0;  // also where the pixels fix no plane
}

/** Takes away the grain: a pixel gets the label that most of its surroundings have. */
LabelImage smoothed(const LabelImage& labels) {
  constexpr int kMost = 5;  // pixels of a block of 3x3
  LabelImage out = labels;
  for (int v = 1; v + 1 < labels.height; ++v)
    for (int u = 1; u + 1 < labels.width; ++u) {
      std::array<std::uint16_t, 9> around = {};
      for (int i = 0; i < 9; ++i)
        around[i] = labels.label[static_cast<std::size_t>(v + i / 3 - 1) * labels.width + u + i % 3 - 1];
      std::sort(around.begin(), around.end());
      const std::uint16_t middle = around[4];  // kept if at least five of the nine pixels are known
      if (std::count(around.begin(), around.end(), middle) >= kMost)
        out.label[static_cast<std::size_t>(v) * labels.width + u] = middle;
    }
  return out;
}

/** The first channel of a picture as a grey progressive JPEG. */
std::string greyJpeg(const Raster<std::uint8_t>& picture, int quality) {
  jpeg_compress_struct jpeg;
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);  // ends the process without memory: nothing else can fail
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = static_cast<JDIMENSION>(picture.width);
  jpeg.image_height = static_cast<JDIMENSION>(picture.height);
  jpeg.input_components = 1;
  jpeg.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<std::uint8_t> row(static_cast<std::size_t>(picture.width));
  for (const std::uint8_t* pixel = picture.data.data(); jpeg.next_scanline < jpeg.image_height;) {
    for (std::uint8_t& grey : row) grey = *pixel, pixel += picture.channels;
    JSAMPROW line = row.data();
    jpeg_write_scanlines(&jpeg, &line, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  std::string text(bytes, bytes + size);
  std::free(bytes);
  return text;
}

}  // namespace

Raster<std::uint8_t> greyDepth(const DepthImage& image, const GreyScale& scale) {
  float nearest = std::numeric_limits<float>::max(), farthest = 0;
  for (const float z : image.depth)
    if (z > 0) nearest = std::min(nearest, z), farthest = std::max(farthest, z);
  const auto darkest = static_cast<float>(scale.darkest), brightest = static_cast<float>(scale.brightest);
  const float slope = (brightest - darkest) / std::max(farthest - nearest, 1e-6f);
  Raster<std::uint8_t> picture{image.camera.width, image.camera.height, 3, {}};
  picture.data.reserve(3 * image.depth.size());
  for (const float z : image.depth)
    picture.data.insert(picture.data.end(), 3,
                        z > 0 ? static_cast<std::uint8_t>(darkest + slope * (z - nearest)) : scale.unknown);
  return picture;
}

Raster<std::uint8_t> litDepth(const DepthImage& image) {
  constexpr double kBrightest = 235;
  Raster<std::uint8_t> picture{image.camera.width, image.camera.height, 3, {}};
  picture.data.reserve(3 * image.depth.size());
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u)
      picture.data.insert(picture.data.end(), 3,
                          static_cast<std::uint8_t>(kBrightest * facingAt(image, u, v)));
  return picture;
}

void paintBorders(Raster<std::uint8_t>& picture, const LabelImage& labels,
                  const std::vector<Colour>& colours) {
  for (int v = 0; v < labels.height; ++v)
    for (int u = 0; u < labels.width; ++u) {
      if (!isBorder(labels, u, v)) continue;
      const std::size_t i = static_cast<std::size_t>(v) * labels.width + u, label = labels.label[i];
      if (label <= colours.size()) mixInto(&picture.data[3 * i], colours[label - 1]);
    }
}

Raster<std::uint8_t> overlay(const DepthImage& image, const LabelImage& labels) {
  constexpr Colour kGreen = {0, 220, 0};
  Raster<std::uint8_t> picture = greyDepth(image);
  paintBorders(picture, labels, std::vector<Colour>(static_cast<std::size_t>(labels.maxLabel()), kGreen));
  return picture;
}

void paintSegments(Raster<std::uint8_t>& picture, const LabelImage& labels,
                   const std::vector<Colour>& colours) {
  for (std::size_t i = 0; i < labels.label.size(); ++i) {
    const std::size_t label = labels.label[i];
    if (label > 0 && label <= colours.size()) mixInto(&picture.data[3 * i], colours[label - 1]);
  }
}

DepthImage depthOf(const View& view) {
  DepthImage image;
  image.camera = view.depth.empty() ? view.intrinsics.subsampled(2) : view.depth.camera;
  image.depth.assign(static_cast<std::size_t>(image.camera.width) * image.camera.height, 0.f);
  for (std::size_t i = 0; i < view.depth.inverse_depth.size(); ++i)
    if (view.depth.inverse_depth[i] > 0)
      image.depth[i] = static_cast<float>(1 / (view.depth.inverse_depth[i] * DepthPicture::kQuantum));
  return image;
}

LabelImage seenSegments(const View& view) {
  const DepthImage depth = depthOf(view);
  LabelImage labels{depth.camera.width, depth.camera.height, {}};
  labels.label.reserve(depth.depth.size());
  for (int v = 0; v < labels.height; ++v)
    for (int u = 0; u < labels.width; ++u)
      labels.label.push_back(labelOf(view, depth.camera.ray(u, v), depth.at(u, v)));
  return smoothed(labels);
}

SeenImage seeSegments(const std::string& name, View view) {
  SeenImage image;
  image.name = name + ", by its segments";
  image.depth = depthOf(view);
  image.labels = seenSegments(view);
  for (int v = 0; v < image.labels.height; ++v)
    for (int u = 0; u < image.labels.width; ++u) {
      const std::size_t pixel = static_cast<std::size_t>(v) * image.labels.width + u;
      const std::size_t label = image.labels.label[pixel];
      if (label == 0) continue;
      const Segment& s = view.segments[label - 1];
      const double along = s.normal().dot(image.depth.camera.ray(u, v));
      if (along > 0) image.depth.depth[pixel] = static_cast<float>(s.offset() / along);
    }
  image.view = std::move(view);
  return image;
}

std::vector<SegmentPair> matchedSegments(const View& scene, const View& model,
                                         const Eigen::Isometry3d& T_m_c) {
  const ScoreCalibration slack;  // as much as counts for agreement when a hypothesis is scored
  const double rotation_std = slack.slope_slack_deg * kDegree, translation_std = slack.offset_slack;
  PoseWithCovariance pose;
  pose.T = T_m_c;
  pose.P.setZero();
  pose.P.diagonal().head<3>().setConstant(rotation_std * rotation_std);
  pose.P.diagonal().tail<3>().setConstant(translation_std * translation_std);
  MatchingParams all;
  all.max_segments = static_cast<int>(std::max(scene.segments.size(), model.segments.size()));

  std::map<int, SegmentPair> best;  // keyed by scene segment
  for (const SegmentPair& pair : candidatePairs(scene.segments, model.segments, pose, all)) {
    const auto [found, is_new] = best.emplace(pair.scene, pair);
    if (!is_new && pair.distance < found->second.distance) found->second = pair;
  }
  std::vector<SegmentPair> pairs;
  for (const auto& [scene_segment, pair] : best) pairs.push_back(pair);
  return pairs;
}

void checkDrawable(const SeenImage& image) {
  if (!image.depth.valid())
    throw std::invalid_argument(fmt::format("the image {} has no pixels to draw", image.name));
  if (image.labels.width != image.depth.camera.width || image.labels.height != image.depth.camera.height)
    throw std::invalid_argument(fmt::format("the labels of image {} are of another size", image.name));
}

Raster<std::uint8_t> resized(const Raster<std::uint8_t>& picture, int width, int height) {
  Raster<std::uint8_t> out{width, height, picture.channels, {}};
  out.data.reserve(static_cast<std::size_t>(width) * height * picture.channels);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const auto x = static_cast<std::size_t>(static_cast<long>(u) * picture.width / width);
      const auto y = static_cast<std::size_t>(static_cast<long>(v) * picture.height / height);
      const auto* pixel = &picture.data[(y * picture.width + x) * picture.channels];
      out.data.insert(out.data.end(), pixel, pixel + picture.channels);
    }
  return out;
}

Raster<std::uint8_t> averaged(const Raster<std::uint8_t>& picture, int n) {
  Raster<std::uint8_t> out{picture.width / n, picture.height / n, picture.channels, {}};
  out.data.reserve(static_cast<std::size_t>(out.width) * out.height * out.channels);
  const std::size_t stride = static_cast<std::size_t>(picture.width) * picture.channels;
  for (int v = 0; v < out.height; ++v)
    for (int u = 0; u < out.width; ++u)
      for (int c = 0; c < out.channels; ++c) {
        int sum = 0;
        for (int j = 0; j < n; ++j)
          for (int i = 0; i < n; ++i)
            sum += picture.data[(static_cast<std::size_t>(v) * n + j) * stride +
                                (static_cast<std::size_t>(u) * n + i) * picture.channels + c];
        out.data.push_back(static_cast<std::uint8_t>((sum + n * n / 2) / (n * n)));
      }
  return out;
}

std::string depthThumbnail(const View& view, int width) {
  if (!view.hasPicture()) return {};
  const Raster<std::uint8_t> grey = greyDepth(depthOf(view));
  const int factor = std::max(1, grey.width / std::max(1, width));
  if (grey.width < factor || grey.height < factor) return {};
  return greyJpeg(averaged(grey, factor), 60);
}

}  // namespace facetloc
