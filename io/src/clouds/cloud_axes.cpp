// SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_axes.h"

#include "base/median.h"
#include "bytes/files.h"
#include "clouds/point_formats.h"

#include <facetloc/features/organized_cloud.h>

#include <Eigen/Geometry>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

namespace facetloc::internal {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

constexpr std::uint32_t kNoPixel = std::numeric_limits<std::uint32_t>::max();
constexpr double kLensAtMost = 0.12;  // share of the width by which a lens moves pixels in the median
constexpr double kSmooth = 0.5;       // [px] that a smooth lens may leave
constexpr std::size_t kSamples = 4000, kEnough = 50;

struct Sample {
  Eigen::Vector2d pixel;
  Eigen::Vector3d point;
};

/** Spread over the cloud; diagonals meet all columns and rows. */
std::vector<Sample> samplesOf(const Cloud& cloud) {
  const auto step = std::max(std::uint32_t{1}, static_cast<std::uint32_t>(cloud.size() / kSamples));
  std::vector<Sample> samples;
  for (std::uint32_t v = 0; v < cloud.height; ++v)
    for (std::uint32_t u = v % step; u < cloud.width; u += step)
      if (const auto& p = cloud(u, v); std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z))
        samples.push_back({{u, v}, p.getVector3fMap().cast<double>()});
  return samples;
}

/** How far samples are from where a pinhole camera would see them, in the median [px]; infinite if most of
 * them are not in front of it, or if columns or rows run the wrong way. */
double residual(const std::vector<Sample>& samples, const Eigen::Matrix3d& axes,
                Intrinsics* found = nullptr) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  detail::PixelLine columns, rows;
  std::vector<Sample> in_front;
  for (const Sample& sample : samples)
    if (const Eigen::Vector3d p = axes * sample.point; p.z() > kNearestMeasured) {
      columns.add(sample.pixel.x(), p.x() / p.z()), rows.add(sample.pixel.y(), p.y() / p.z());
      in_front.push_back({sample.pixel, p});
    }
  Intrinsics k{1, 1, 0, 0, 0, 0};
  if (in_front.size() < kEnough || 2 * in_front.size() < samples.size() || !columns.solve(k.fx, k.cx) ||
      !rows.solve(k.fy, k.cy))
    return kNone;
  std::vector<double> distances;
  for (const Sample& sample : in_front) distances.push_back((k.project(sample.point) - sample.pixel).norm());
  if (found) *found = k;
  return internal::median(std::move(distances));
}

/** The signed permutation that makes the points those of a camera best; not of determinant -1, since the
 * rows are turned over instead. */
struct Turn {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  bool rows_from_below = false;
  double residual = std::numeric_limits<double>::infinity();
};

Turn bestTurn(const std::vector<Sample>& samples, double height) {
  std::vector<Sample> turned_over = samples;
  for (Sample& sample : turned_over) sample.pixel.y() = height - 1 - sample.pixel.y();
  Turn best;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Turn turn;
      turn.axes.setZero();
      for (int r = 0; r < 3; ++r) turn.axes(r, order[static_cast<std::size_t>(r)]) = signs >> r & 1 ? -1 : 1;
      if (turn.axes.determinant() < 0) continue;
      for (const bool rows_from_below : {false, true}) {
        turn.rows_from_below = rows_from_below;
        turn.residual = residual(rows_from_below ? turned_over : samples, turn.axes);
        if (turn.residual < best.residual) best = turn;
      }
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

/** "x right, y up, z backward": where the axes of the file point. */
std::string toString(const Eigen::Matrix3d& axes) {
  constexpr const char* kPositive[] = {"right", "down", "forward"};
  constexpr const char* kNegative[] = {"left", "up", "backward"};
  std::string words;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      if (axes(r, c) != 0)
        words += fmt::format("{}{} {}", words.empty() ? "" : ", ", "xyz"[c],
                             axes(r, c) > 0 ? kPositive[r] : kNegative[r]);
  return words;
}

Cloud turned(const Cloud& cloud, const Turn& turn) {
  Cloud out(cloud.width, cloud.height);
  const Eigen::Matrix3f axes = turn.axes.cast<float>();
  for (std::uint32_t v = 0; v < cloud.height; ++v)
    for (std::uint32_t u = 0; u < cloud.width; ++u) {
      const std::uint32_t row = turn.rows_from_below ? cloud.height - 1 - v : v;
      out(u, row).getVector3fMap() = axes * cloud(u, v).getVector3fMap();
    }
  out.is_dense = false;
  return out;
}

Cloud moved(const Cloud& cloud, const Eigen::Isometry3d& T) {
  Cloud out = cloud;
  const Eigen::Isometry3f Tf = T.cast<float>();
  for (auto& p : out) p.getVector3fMap() = Tf * p.getVector3fMap();
  return out;
}

/** Is where the points are seen a smooth function of their pixels alone, as lenses make it: a polynomial of
 * the fifth degree? Where depth changes, points that were moved away from the camera are not. */
bool isSmooth(const std::vector<Sample>& samples, const Intrinsics& camera, double tolerance) {
  constexpr int kDegree = 5, kTerms = (kDegree + 1) * (kDegree + 2) / 2;
  std::vector<const Sample*> used;
  for (const Sample& s : samples)
    if (s.point.z() > kNearestMeasured) used.push_back(&s);
  if (used.size() < kEnough) return false;
  const auto n = static_cast<Eigen::Index>(used.size());
  Eigen::MatrixXd A(n, kTerms), b(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Sample& s = *used[static_cast<std::size_t>(i)];
    const double x = (s.pixel.x() - camera.cx) / camera.fx, y = (s.pixel.y() - camera.cy) / camera.fy;
    Eigen::Index term = 0;
    for (int j = 0; j <= kDegree; ++j)
      for (int k = 0; j + k <= kDegree; ++k) A(i, term++) = std::pow(x, j) * std::pow(y, k);
    b.row(i) = camera.project(s.point).transpose();
  }
  const Eigen::MatrixXd fit = A * A.colPivHouseholderQr().solve(b);
  if (!fit.allFinite()) return false;
  std::vector<double> distances;
  for (Eigen::Index i = 0; i < n; ++i) distances.push_back((fit.row(i) - b.row(i)).norm());
  return internal::median(std::move(distances)) < tolerance;
}

/** Within the distortion of a lens. */
bool isLike(const Intrinsics& found, const Intrinsics& given) {
  constexpr double kFocal = 0.25, kCentre = 0.05;  // shares of the focal length and of the width
  return std::abs(found.fx - given.fx) <= kFocal * given.fx &&
         std::abs(found.fy - given.fy) <= kFocal * given.fy &&
         std::abs(found.cx - given.cx) <= kCentre * given.width &&
         std::abs(found.cy - given.cy) <= kCentre * given.width;
}

constexpr const char* kLensRemark = "the clouds are on the grid of an image with lens distortion: their "
                                    "points are sorted into a pinhole grid";

/** Each pixel takes the depth of the point that is seen nearest to it, within a pixel. */
CloudImage sortedInto(const Intrinsics& camera, const Cloud& cloud) {
  const auto width = static_cast<std::size_t>(camera.width);
  const std::size_t n = width * static_cast<std::size_t>(camera.height);
  CloudImage found{
      {camera, std::vector<float>(n, 0.f)}, kLensRemark, std::vector<std::uint32_t>(cloud.size(), kNoPixel)};
  DepthImage& image = found.image;
  std::vector<double> distance(n, 1.0);
  for (std::size_t point = 0; point < cloud.size(); ++point) {
    const auto& p = cloud[point];
    if (!detail::inFront(p)) continue;
    const Eigen::Vector2d seen = camera.project(p.getVector3fMap().cast<double>());
    if (!(seen.x() > -1 && seen.y() > -1 && seen.x() < camera.width && seen.y() < camera.height)) continue;
    const int u0 = static_cast<int>(std::floor(seen.x())), v0 = static_cast<int>(std::floor(seen.y()));
    double nearest = 1;
    for (const int v : {v0, v0 + 1})
      for (const int u : {u0, u0 + 1}) {
        if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
        const std::size_t i = static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u);
        const double d = (seen - Eigen::Vector2d(u, v)).norm();
        if (d < distance[i]) distance[i] = d, image.depth[i] = p.z;
        if (d < nearest) nearest = d, found.pixels[point] = static_cast<std::uint32_t>(i);
      }
  }
  return found;
}

/** The pixels of points whose rows are stored from the bottom up. */
void turnRows(CloudImage& found) {
  const auto width = static_cast<std::size_t>(found.image.camera.width);
  std::vector<std::uint32_t>& pixels = found.pixels;
  if (pixels.empty()) {
    pixels.resize(found.image.depth.size());
    std::iota(pixels.begin(), pixels.end(), 0);
  }
  for (std::size_t top = 0, bottom = pixels.size(); top + width < bottom; top += width, bottom -= width)
    std::swap_ranges(pixels.begin() + top, pixels.begin() + top + width, pixels.begin() + bottom - width);
}

bool fits(const Cloud& cloud, const Intrinsics& camera) {
  return !detail::isBehind(cloud) && isImageOf(cloud, camera, kCalibrationError * camera.width);
}

/** Image of points that fit a pinhole camera to a pixel; sorted anew if a lens fits much better. */
CloudImage imageOfRecovered(const Cloud& cloud, const Intrinsics& camera) {
  constexpr double kPinhole = 0.1, kMuchBetter = 0.25;  // [px]; of it
  const std::vector<Sample> samples = samplesOf(cloud);
  const double off = residual(samples, Eigen::Matrix3d::Identity());
  if (off > kPinhole && std::isfinite(off) && isSmooth(samples, camera, kMuchBetter * off))
    return sortedInto(camera, cloud);
  return {depthImage(cloud, camera)};
}

/** A pinhole image in the best axes; \param camera as of imageOf() */
std::optional<CloudImage> imageInBestAxes(const Cloud& points, const std::optional<Intrinsics>& camera) {
  const std::vector<Sample> samples = samplesOf(points);
  const Turn turn = bestTurn(samples, points.height);
  if (!std::isfinite(turn.residual)) return {};
  const bool is_turned = turn.rows_from_below || !turn.axes.isIdentity();
  const Cloud cloud = is_turned ? turned(points, turn) : points;
  std::string remark;
  if (!turn.axes.isIdentity())
    remark = fmt::format("the axes of the clouds are {}: they are turned to x right, y down, z forward",
                         toString(turn.axes));
  if (turn.rows_from_below) addSentence("the rows of the clouds are stored from the bottom up", remark);
  const auto inRows = [&](CloudImage found) {
    if (turn.rows_from_below) turnRows(found);
    addSentence(found.remark, remark);
    found.remark = remark;
    return found;
  };
  if (camera) {
    if (fits(cloud, *camera)) return inRows({depthImage(cloud, *camera)});
  } else if (const auto recovered = recoverIntrinsics(cloud)) {
    return inRows({depthImage(cloud, *recovered)});
  }
  if (turn.residual > kLensAtMost * points.width) return {};
  const std::vector<Sample> of_camera = samplesOf(cloud);
  Intrinsics k;
  if (!std::isfinite(residual(of_camera, Eigen::Matrix3d::Identity(), &k)) ||
      !isSmooth(of_camera, k, kSmooth))
    return {};
  k.width = static_cast<int>(cloud.width), k.height = static_cast<int>(cloud.height);
  if (camera && !isLike(k, *camera)) return {};
  if (camera) k = *camera;
  return inRows(sortedInto(k, cloud));
}

/** Empty if nothing fits. */
std::optional<CloudImage> imageOf(const Cloud& points, const Eigen::Isometry3d& viewpoint,
                                  const std::optional<Intrinsics>& camera) {
  const bool is_moved = !viewpoint.isApprox(Eigen::Isometry3d::Identity(), 1e-6);
  std::optional<CloudImage> found;
  if (camera) {
    if (fits(points, *camera)) found = CloudImage{depthImage(points, *camera)};
  } else if (const auto recovered = recoverIntrinsics(points)) {
    found = imageOfRecovered(points, *recovered);
  }
  if (found && is_moved)
    found->remark = "the VIEWPOINT of the clouds is ignored: their points are in the camera's own frame";
  if (!found && is_moved) {
    found = imageInBestAxes(moved(points, viewpoint.inverse()), camera);
    if (found) {
      std::string remark = "the points of the clouds are moved back to where their VIEWPOINT was";
      addSentence(found->remark, remark);
      found->remark = remark;
    }
  }
  if (!found) found = imageInBestAxes(points, camera);
  if (!found) return {};
  constexpr double kFarthest = 100;  // [m] depths that would be beyond it in the median are millimetres
  if (usualDepth(found->image) > kFarthest) {
    for (float& z : found->image.depth) z /= 1000;
    addSentence("the points of the clouds are in millimetres", found->remark);
  }
  return found;
}

/** \param viewpoint receives the one of the header */
Cloud readOrganizedPoints(const fs::path& path, Eigen::Isometry3d& viewpoint) {
  const PcdHeader header(path);
  if (header.height < 2 || header.width < 2)
    throw IoError(path.string(),
                  fmt::format("is not an organized cloud ({}x{})", header.width, header.height));
  const pcl::PCLPointCloud2 raw = readPcd(path, header, &viewpoint);
  const auto coordinate = [&](const char* name) {
    const pcl::PCLPointField* field = fieldOf(raw, name);
    if (!field) throw IoError(path.string(), std::string("has no field ") + name);
    if (!isFloatingPoint(*field))
      throw IoError(path.string(), fmt::format("has a field {} that is not of floating point", name));
    return [&raw, type = field->datatype, offset = field->offset](std::size_t point) {
      return static_cast<float>(numberAt(type, raw.data.data() + point * raw.point_step + offset));
    };
  };
  const auto x = coordinate("x"), y = coordinate("y"), z = coordinate("z");
  Cloud points(header.width, header.height);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = pcl::PointXYZ(x(i), y(i), z(i));
  points.is_dense = false;
  return points;
}

}  // namespace

void requireSizeOf(const Intrinsics& camera, int width, int height, const fs::path& path) {
  if (width == camera.width && height == camera.height) return;
  throw IoError(path.string(), fmt::format("is of {}x{} pixels, but the camera of {}x{}: the calibration in "
                                           "camera.ini must be for images of this size",
                                           width, height, camera.width, camera.height));
}

CloudImage imageOfPcd(const fs::path& path, const std::optional<Intrinsics>& camera) {
  Eigen::Isometry3d viewpoint;
  const Cloud points = readOrganizedPoints(path, viewpoint);
  if (camera) requireSizeOf(*camera, static_cast<int>(points.width), static_cast<int>(points.height), path);
  if (auto found = imageOf(points, viewpoint, camera)) return std::move(*found);
  if (camera) throw IoError(path.string(), "its points are not where the camera of the camera.ini sees them");
  throw IoError(path.string(),
                "does not reveal its intrinsics: it has too few points, or they are not those of a pinhole "
                "camera at the origin (x right, y down, z forward); give a camera.ini");
}

}  // namespace facetloc::internal
