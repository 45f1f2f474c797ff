// SPDX-License-Identifier: BSD-3-Clause
#include "models/model_points.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/core.h>
#include <limits>
#include <stdexcept>

namespace facetloc::internal {
namespace {

const pcl::PCLPointField* fieldOf(const pcl::PCLPointCloud2& cloud, const std::string& name) {
  for (const pcl::PCLPointField& field : cloud.fields)
    if (field.name == name && field.datatype == pcl::PCLPointField::FLOAT32 &&
        field.offset + sizeof(float) <= cloud.point_step)
      return &field;
  return nullptr;
}

using Triangles = std::vector<std::array<std::uint32_t, 3>>;
using Eigen::Vector2d, Eigen::Vector3d;

constexpr std::size_t kMostCorners = 10000;  // time and memory grow with the square

/** Twice the area of a triangle, positive if it is anticlockwise. */
double doubledArea(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  const Vector2d ab = b - a, ac = c - a;
  return ab.x() * ac.y() - ab.y() * ac.x();
}

/** Corners in the plane of Newell's normal, where the polygon is anticlockwise. */
struct PlanePolygon {
  explicit PlanePolygon(const std::vector<Eigen::Vector3f>& corners) {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3f& corner : corners) box.extend(corner.cast<double>());
    const Vector3d middle = box.center();
    const auto own = [&](std::size_t i) {
      return Vector3d(corners[i % corners.size()].cast<double>() - middle);
    };
    Vector3d normal = Vector3d::Zero();
    for (std::size_t i = 0; i < corners.size(); ++i) normal += own(i).cross(own(i + 1));
    // Coordinates are floats: areas up to this one are none.
    constexpr double kRoundings = 8;
    const double largest = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
    flat = kRoundings * std::numeric_limits<float>::epsilon() * largest * box.sizes().norm();
    if (!(normal.norm() > flat)) return;
    const Vector3d z = normal.normalized(), x = z.unitOrthogonal(), y = z.cross(x);
    for (std::size_t i = 0; i < corners.size(); ++i) points.emplace_back(x.dot(own(i)), y.dot(own(i)));
  }

  std::vector<Vector2d> points;  // empty for a polygon without an area
  double flat = 0;               // largest doubled area of corners that count as collinear
};

/** The corners that are left of a polygon while its ears are cut off. */
class EarClipping {
public:
  /** \param polygon is borrowed */
  explicit EarClipping(const PlanePolygon& polygon)
      : p_(polygon.points),
        flat_(polygon.flat),
        left_(p_.size()),
        next_(left_),
        before_(left_),
        is_ear_(left_) {
    for (std::size_t i = 0; i < p_.size(); ++i) {
      next_[i] = (i + 1) % p_.size();
      before_[(i + 1) % p_.size()] = i;
    }
  }

  /** Triangles that have all the same direction of rotation: they cover the polygon once.
   * \return empty if there are none, since the polygon crosses itself */
  Triangles triangles() {
    constexpr int kMostTurns = 16;
    Triangles found;
    dropFlat([this](std::size_t i) { return isSpike(i); });
    for (int turns = 0; left_ >= 3; ++turns) {
      const std::size_t before = left_;
      clip(Touching::blocks, found);
      if (left_ == before) dropFlat([](std::size_t) { return true; });
      if (left_ == before) clip(Touching::is_free, found);
      if (left_ == before || turns == kMostTurns) return {};
    }
    return found;
  }

private:
  enum class Touching { blocks, is_free };

  double area(std::size_t i) const { return doubledArea(p_[before_[i]], p_[i], p_[next_[i]]); }

  /** Does a corner at the place of the tip lead into the ear? */
  bool leadsInto(std::size_t tip, std::size_t corner) const {
    const auto within = [&](std::size_t i) {
      return doubledArea(p_[before_[tip]], p_[tip], p_[i]) > flat_ &&
             doubledArea(p_[tip], p_[next_[tip]], p_[i]) > flat_;
    };
    return within(before_[corner]) || within(next_[corner]);
  }

  bool isEar(std::size_t tip, Touching touching) const {
    if (!(area(tip) > flat_)) return false;
    const Vector2d &a = p_[before_[tip]], &b = p_[tip], &c = p_[next_[tip]];
    const Eigen::AlignedBox2d box(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c));
    for (std::size_t i = next_[next_[tip]]; i != before_[tip]; i = next_[i]) {
      const Vector2d& p = p_[i];
      if (!box.contains(p) || p == a || p == c) continue;
      if (p == b) {
        if (leadsInto(tip, i)) return false;
        continue;
      }
      const double inside = std::min({doubledArea(a, b, p), doubledArea(b, c, p), doubledArea(c, a, p)});
      if (touching == Touching::blocks ? inside >= 0 : inside > flat_) return false;
    }
    return true;
  }

  void remove(std::size_t i) {
    next_[before_[i]] = next_[i];
    before_[next_[i]] = before_[i];
    first_ = next_[i];
    --left_;
  }

  /** Cuts off ears until none is left. A cut makes or unmakes ears at its two neighbours alone. */
  void clip(Touching touching, Triangles& found) {
    std::size_t i = first_;
    for (std::size_t k = 0; k < left_; ++k, i = next_[i]) is_ear_[i] = isEar(i, touching);
    for (std::size_t passed = 0; passed < left_ && left_ >= 3;) {
      const std::size_t before = before_[i], next = next_[i];
      if (!is_ear_[i]) {
        ++passed, i = next;
        continue;
      }
      found.push_back({index(before), index(i), index(next)});
      remove(i);
      for (const std::size_t neighbour : {before, next})
        is_ear_[neighbour] = left_ >= 3 && isEar(neighbour, touching);
      passed = 0, i = before;
    }
  }

  /** Does the polygon turn back there, or stay where it is? */
  bool isSpike(std::size_t i) const { return (p_[i] - p_[before_[i]]).dot(p_[next_[i]] - p_[i]) <= 0; }

  /** Leaves out collinear corners of some kind. */
  template <class Which>
  void dropFlat(const Which& isMeant) {
    std::size_t i = first_;
    for (std::size_t passed = 0; passed < left_ && left_ >= 3;) {
      const std::size_t before = before_[i], next = next_[i];
      const bool is_flat = std::abs(area(i)) <= flat_ && isMeant(i);
      if (is_flat) remove(i);
      passed = is_flat ? 0 : passed + 1, i = is_flat ? before : next;
    }
  }

  static std::uint32_t index(std::size_t i) { return static_cast<std::uint32_t>(i); }

  const std::vector<Vector2d>& p_;
  double flat_;
  std::size_t left_, first_ = 0;
  std::vector<std::size_t> next_, before_;
  std::vector<bool> is_ear_;
};

}  // namespace

ModelPoints::ModelPoints(const pcl::PCLPointCloud2& cloud)
    : cloud_(cloud), size_(static_cast<std::size_t>(cloud.width) * cloud.height) {
  constexpr std::array<const char*, 3> kNames{"x", "y", "z"};
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const pcl::PCLPointField* field = fieldOf(cloud, kNames[k]);
    if (!field) throw std::invalid_argument(fmt::format("its points have no field {} of floats", kNames[k]));
    offsets_[k] = field->offset;
  }
  if (cloud.data.size() / cloud.point_step < size_)
    throw std::invalid_argument(fmt::format("it has less data than its {} points need", size_));
}

Eigen::Vector3f ModelPoints::operator[](std::size_t i) const {
  const std::uint8_t* point = cloud_.data.data() + i * cloud_.point_step;
  Eigen::Vector3f value;
  for (int k = 0; k < 3; ++k)
    std::memcpy(&value[k], point + offsets_[static_cast<std::size_t>(k)], sizeof(float));
  return value;
}

void requireResolved(const Eigen::AlignedBox3d& bounds) {
  constexpr double kFarthest = 1e4;  // [m] beyond, floats are a millimetre apart
  if (bounds.isEmpty()) return;
  const double farthest = bounds.min().cwiseAbs().cwiseMax(bounds.max().cwiseAbs()).maxCoeff();
  if (farthest > kFarthest)
    throw std::invalid_argument(fmt::format(
        "its coordinates reach {:.4g} km from the origin, where floats do not resolve millimetres; "
        "check the unit, or subtract an offset",
        farthest / 1e3));
}

Triangles polygonTriangles(const std::vector<Eigen::Vector3f>& corners) {
  Triangles fan;
  for (std::uint32_t i = 2; i < corners.size(); ++i) fan.push_back({0, i - 1, i});
  if (fan.size() < 2 || corners.size() > kMostCorners) return fan;
  const PlanePolygon polygon(corners);
  const std::vector<Vector2d>& p = polygon.points;
  // Triangles of one direction of rotation are each part of the polygon.
  if (p.empty() || std::all_of(fan.begin(), fan.end(), [&](const auto& triangle) {
        return doubledArea(p[triangle[0]], p[triangle[1]], p[triangle[2]]) >= -polygon.flat;
      }))
    return fan;
  Triangles clipped = EarClipping(polygon).triangles();
  return clipped.empty() ? fan : clipped;
}

}  // namespace facetloc::internal
