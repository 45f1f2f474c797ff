// SPDX-License-Identifier: BSD-3-Clause
#include "shortlist/place_descriptor.h"

#include "base/lanes.h"
#include "depth/depth_consistency.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>

namespace facetloc::internal {
namespace {

constexpr double kPlaneStd =
    0.3 * kDegree;  // standard deviation of the slope of horizontal and vertical surfaces
constexpr double kFirstGate = 7 * kDegree, kGate = 3 * kDegree;  // 3 std of pitch and roll, then of planes
constexpr double kOblique = 6 * kDegree;  // a plane farther from vertical and horizontal is neither
constexpr float kQuarter = static_cast<float>(90 * kDegree);
constexpr double kFloorHeight = 0.05;  // a level surface within this is the floor [m]
constexpr float kFloorPixels = 0.12f;  // lower pixels may be of the floor, which every view shows [m]
constexpr double kMargin = 7;          // [px] of the working image: nearer to its border a hull is cut off
constexpr int kPictureStep = 4, kPointStep = 2;  // pixels of the depth picture, of the coarse picture
constexpr double kMostMillimetres = 65535;
constexpr float kFarthestPoint = 7;  // [m]

bool isSound(const Segment& s) { return s.R.allFinite() && s.t.allFinite() && s.Sigma_q.allFinite(); }

constexpr float kFarthest =
    1e5f;  // largest distance from the camera [m]; farther points are no part of a place

bool isNear(float x) { return std::abs(x) <= kFarthest; }  // and a number

bool isSound(const Wall& w) {
  constexpr float kRounding = 1e-3f, kHalfTurn = static_cast<float>(180 * kDegree) + kRounding;
  const float extent[] = {w.offset, w.right, w.left, w.bottom, w.top};
  return std::abs(w.heading) <= kHalfTurn && std::abs(w.cosine - std::cos(w.heading)) <= kRounding &&
         std::abs(w.sine - std::sin(w.heading)) <= kRounding && w.weight >= 0 && isNear(w.weight) &&
         std::all_of(std::begin(extent), std::end(extent), isNear);
}

bool isSound(const LevelSurface& s) { return isNear(s.height) && isNear(s.x) && isNear(s.y); }

/** Camera axes in the upright frame: small turns about x and y that make the planes vertical or level. */
Eigen::Matrix3d upright(const std::vector<Segment>& segments, const Eigen::Matrix3d& R_nominal,
                        const PosePriorParams& prior) {
  // Roll and pitch in the prior's sense; the same that the floor does to any pose.
  const Eigen::Matrix2d information = floorCovariance(prior).topLeftCorner<2, 2>().inverse();
  Eigen::Matrix3d R = R_nominal;
  constexpr int kIterations = 3;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const double gate = iteration == 0 ? kFirstGate : kGate;
    const Eigen::Vector2d turned = logSO3(R * R_nominal.transpose()).head<2>();
    Eigen::Matrix2d A = information;
    Eigen::Vector2d b = -information * turned;
    for (const Segment& s : segments) {
      const Eigen::Vector3d n = R * s.normal();
      const double w = 1 / (s.Sigma_q(0, 0) + s.Sigma_q(1, 1) + kPlaneStd * kPlaneStd);
      // n + omega x n has no horizontal part, or no vertical one.
      if (std::abs(n.z()) > std::cos(gate)) {
        A += w * n.z() * n.z() * Eigen::Matrix2d::Identity();
        b += w * n.z() * Eigen::Vector2d(n.y(), -n.x());
      } else if (std::abs(n.z()) < std::sin(gate)) {
        const Eigen::Vector2d J(n.y(), -n.x());
        A += w * J * J.transpose();
        b -= w * n.z() * J;
      }
    }
    const Eigen::Vector2d step = A.inverse() * b;
    R = expSO3({step.x(), step.y(), 0}) * R;
  }
  return R;
}

/** Height of the camera by the floor, if one is where it should be. */
double heightAboveFloor(const std::vector<Segment>& segments, const Eigen::Matrix3d& R, double nominal) {
  double height = nominal, least = kFloorHeight;
  for (const Segment& s : segments) {
    if (!isSound(s) || (R * s.normal()).z() > -std::cos(kGate)) continue;
    const double z = -(R * s.t).z();
    if (std::abs(z - nominal) >= least) continue;
    least = std::abs(z - nominal);
    height = z;
  }
  return height;
}

Wall wallOf(const Segment& s, const Eigen::Matrix3d& R, double height, const Intrinsics& camera) {
  const Eigen::Vector3d n = R * s.normal();
  const Eigen::Vector2d normal = n.head<2>().normalized(), along(-normal.y(), normal.x());
  Wall w;
  w.heading = static_cast<float>(std::atan2(normal.y(), normal.x()));
  w.cosine = static_cast<float>(normal.x());
  w.sine = static_cast<float>(normal.y());
  w.offset = static_cast<float>(normal.dot((R * s.t).head<2>()));
  w.weight = static_cast<float>(std::sqrt(std::sqrt(s.area())));
  w.right = w.bottom = std::numeric_limits<float>::max();
  w.left = w.top = std::numeric_limits<float>::lowest();
  for (const Eigen::Vector2f& vertex : s.hull) {
    const Eigen::Vector3d in_camera = s.R.leftCols<2>() * vertex.cast<double>() + s.t, p = R * in_camera;
    const Eigen::Vector2d pixel = camera.project(in_camera);
    const bool inside = in_camera.z() > 0 && pixel.x() >= kMargin && pixel.y() >= kMargin &&
                        pixel.x() < camera.width - 1 - kMargin && pixel.y() < camera.height - 1 - kMargin;
    const auto a = static_cast<float>(along.dot(p.head<2>())), z = static_cast<float>(p.z() + height);
    if (a < w.right) w.right = a, w.right_end = inside;
    if (a > w.left) w.left = a, w.left_end = inside;
    if (z < w.bottom) w.bottom = z, w.bottom_end = inside;
    if (z > w.top) w.top = z, w.top_end = inside;
  }
  return w;
}

/** The least turn that makes one heading the other or one across it [rad]. */
float turnToMainHeading(float heading, float main_heading) {
  const float turn = heading - main_heading;
  return turn - kQuarter * std::round(turn / kQuarter);
}

/** The heading that most walls face or lie across. */
float mainHeading(const std::vector<Wall>& walls) {
  constexpr auto kAlike = static_cast<float>(4 * kDegree);
  float heading = 0, most = 0;
  for (const Wall& about : walls) {
    float weight = 0, moment = 0;
    for (const Wall& w : walls) {
      const float turn = turnToMainHeading(w.heading, about.heading);
      if (std::abs(turn) > kAlike) continue;
      weight += w.weight;
      moment += w.weight * turn;
    }
    if (weight <= most) continue;
    most = weight;
    heading = turnToMainHeading(about.heading + moment / weight, 0);
  }
  return heading;
}

void sortByHeading(PlaceDescriptor& place) {
  constexpr auto kAlong = static_cast<float>(8 * kDegree);
  place.main_heading = mainHeading(place.walls);
  const auto quarters = [&place](const Wall& w) {  // 4 for a wall that faces no main heading
    if (std::abs(turnToMainHeading(w.heading, place.main_heading)) > kAlong) return 4;
    return static_cast<int>(std::lround((w.heading - place.main_heading) / kQuarter)) & 3;
  };
  std::stable_sort(place.walls.begin(), place.walls.end(),
                   [&](const Wall& a, const Wall& b) { return quarters(a) < quarters(b); });
  for (int k = 0; k < 5; ++k)
    place.facing[k] = static_cast<std::int32_t>(std::count_if(
        place.walls.begin(), place.walls.end(), [&](const Wall& w) { return quarters(w) < k; }));
}

DepthThumbnail depthThumbnail(const DepthPicture& picture) {
  DepthThumbnail coarse;
  const Intrinsics& c = picture.camera;
  if (picture.empty() || c.width < kPictureStep || c.height < kPictureStep) return coarse;
  constexpr int kFirst = kPictureStep / 2;
  coarse.camera = {c.width / kPictureStep, c.height / kPictureStep,        c.fx / kPictureStep,
                   c.fy / kPictureStep,    (c.cx - kFirst) / kPictureStep, (c.cy - kFirst) / kPictureStep};
  coarse.depth.reserve(static_cast<std::size_t>(coarse.camera.width) * coarse.camera.height);
  for (int v = 0; v < coarse.camera.height; ++v)
    for (int u = 0; u < coarse.camera.width; ++u) {
      const std::uint16_t q =
          picture.inverse_depth[static_cast<std::size_t>(v * kPictureStep + kFirst) * c.width +
                                u * kPictureStep + kFirst];
      const double mm = q == 0 ? 0 : 1000 / (q * DepthPicture::kQuantum);
      coarse.depth.push_back(mm <= kMostMillimetres ? static_cast<std::uint16_t>(mm) : std::uint16_t{0});
    }
  return coarse;
}

}  // namespace

PlaceDescriptor placeDescriptor(const View& view, const CameraMounting& mounting,
                                const PosePriorParams& prior) {
  const Eigen::Isometry3d T_b_c = mounting.T_b_c();
  std::vector<Segment> sound;
  std::copy_if(view.segments.begin(), view.segments.end(), std::back_inserter(sound),
               [](const Segment& s) { return isSound(s); });
  const Eigen::Matrix3d R = upright(sound, T_b_c.linear(), prior);
  const double height = heightAboveFloor(sound, R, mounting.height);
  PlaceDescriptor out;
  out.R_u_c = R.cast<float>();
  out.height = static_cast<float>(height);
  for (const Segment& s : sound) {
    const double vertical = std::abs((R * s.normal()).z());
    if (vertical < std::sin(kOblique) && s.hull.size > 0) {
      const Wall wall = wallOf(s, R, height, view.intrinsics);
      if (isSound(wall)) out.walls.push_back(wall);
    } else if (vertical > std::cos(kOblique)) {
      const Eigen::Vector3f t = (R * s.t).cast<float>();
      const float z = t.z() + out.height;
      const LevelSurface surface{z, (R * s.normal()).z() > 0, t.x(), t.y()};
      if (std::abs(z) >= kFloorHeight && isSound(surface)) out.surfaces.push_back(surface);
    }
  }
  sortByHeading(out);
  out.picture = depthThumbnail(view.depth);
  return out;
}

bool isSound(const PlaceDescriptor& p) {
  constexpr float kRounding = 1e-3f;
  constexpr int kLargestPicture = 1024;  // side [px]
  const Intrinsics& camera = p.picture.camera;
  const bool is_picture =
      p.picture.depth.empty()
          ? camera == Intrinsics()
          : camera.valid() && camera.width <= kLargestPicture && camera.height <= kLargestPicture &&
                p.picture.depth.size() == static_cast<std::size_t>(camera.width) * camera.height;
  return is_picture && p.R_u_c.allFinite() && (p.R_u_c.transpose() * p.R_u_c).isIdentity(kRounding) &&
         p.R_u_c.determinant() > 0 && isNear(p.height) &&
         std::abs(p.main_heading) <= kQuarter / 2 + kRounding && p.facing.front() >= 0 &&
         std::is_sorted(p.facing.begin(), p.facing.end()) &&
         static_cast<std::size_t>(p.facing.back()) <= p.walls.size() &&
         std::all_of(p.walls.begin(), p.walls.end(), [](const Wall& w) { return isSound(w); }) &&
         std::all_of(p.surfaces.begin(), p.surfaces.end(), [](const LevelSurface& s) { return isSound(s); });
}

WallColumns::WallColumns(const std::vector<Wall>& walls)
    : size_((walls.size() + kLanes - 1) / kLanes * kLanes) {
  const auto column = [&](auto Wall::*member) {
    std::vector<float> values(size_ + kLanes, Wall::kNotSeen);
    std::transform(walls.begin(), walls.end(), values.begin(), std::mem_fn(member));
    return values;
  };
  heading = column(&Wall::heading), offset = column(&Wall::offset), weight = column(&Wall::weight);
  right = column(&Wall::right), left = column(&Wall::left);
  bottom = column(&Wall::bottom), top = column(&Wall::top);
  seen_right = column(&Wall::seenRight), seen_left = column(&Wall::seenLeft);
  seen_bottom = column(&Wall::seenBottom), seen_top = column(&Wall::seenTop);
}

void pointsAboveFloor(const PlaceDescriptor& place, PointColumns& points) {
  const Intrinsics& c = place.picture.camera;
  const auto fx = static_cast<float>(c.fx), fy = static_cast<float>(c.fy), cx = static_cast<float>(c.cx),
             cy = static_cast<float>(c.cy);
  const Eigen::Vector3f across = place.R_u_c.col(0) / fx, down = place.R_u_c.col(1) / fy,
                        origin = place.R_u_c.col(2) - cx * across - cy * down;
  constexpr int kFirst = kPointStep / 2;
  points.resize(static_cast<std::size_t>(gridPoints(c.width, kPointStep)) * gridPoints(c.height, kPointStep));
  float *x = points.x.data(), *y = points.y.data(), *z = points.z.data();
  std::size_t n = 0;
  for (int v = kFirst; v < c.height; v += kPointStep) {
    const std::uint16_t* depth = place.picture.depth.data() + static_cast<std::size_t>(v) * c.width;
    const Eigen::Vector3f row = static_cast<float>(v) * down + origin;
    for (int u = kFirst; u < c.width; u += kPointStep) {
      const float d = 0.001f * depth[u];
      const Eigen::Vector3f p = d * (static_cast<float>(u) * across + row);
      x[n] = p.x(), y[n] = p.y(),
      z[n] = p.z();  // written over unless it counts: no branch, since it would be mispredicted
      n += (d > 0) & (d <= kFarthestPoint) & (p.z() + place.height > kFloorPixels);
    }
  }
  points.resize(n);
}

}  // namespace facetloc::internal
