// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/flat_surfaces.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

namespace facetloc::internal {
namespace {

constexpr double kLeastAngle = 20;     // between surfaces of a pair [deg]; parallel ones stay so
constexpr double kLeastShare = 0.025;  // least share of the image of a surface
constexpr std::size_t kLeastPairs = 5, kLeastImages = 5;
constexpr double kSharp = 1.5;       // standard deviation of an angle between two surfaces [deg]
constexpr double kSmooth = 6;        // width of the kernel for unrelated angles [deg]
constexpr double kRight = 0.2;       // probability of a right angle
constexpr double kUnrelated = 0.2;   // probability of an angle that no other image shows
constexpr double kAnywhere = 0.1;    // share of a uniform density among unrelated angles
constexpr double kCell = 0.5;        // [deg]
constexpr std::size_t kCells = 361;  // 0 to 180 deg
constexpr double kSquare = 0.04;     // standard deviation of ln(fx / fy): pixels are square
constexpr double kCentral = 0.05;    // standard deviation of the centre, as a share of the width
constexpr double kFocalTolerance = 0.04, kCentreTolerance = 0.03;  // usual errors of calibrations

/** Two surfaces of one image. */
struct SurfacePair {
  std::size_t image;
  Eigen::Vector3d a, b;  // m of their planes, as read
  double weight;
};

/** Logarithms of the factors of fx and fy, and displacement of the centre as a ray. */
using Change = Eigen::Vector4d;

Eigen::Vector3d changed(const Eigen::Vector3d& m, const Change& c) {
  const double x = m.x() * std::exp(c[0]), y = m.y() * std::exp(c[1]);
  return Eigen::Vector3d(x, y, m.z() - x * c[2] - y * c[3]).normalized();
}

double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0)) / kDegree;
}

double gauss(double x, double std) {
  return std::exp(-x * x / (2 * std * std)) / (std * std::sqrt(2 * EIGEN_PI));
}

/** Pairs of the surfaces of each image, their mean weight 1. */
std::vector<SurfacePair> pairsOf(const std::vector<FlatSurface>& surfaces) {
  std::vector<SurfacePair> pairs;
  double weights = 0;
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    for (std::size_t j = i + 1; j < surfaces.size() && surfaces[j].image == surfaces[i].image; ++j) {
      const FlatSurface &a = surfaces[i], &b = surfaces[j];
      if (std::min(a.share, b.share) < kLeastShare) continue;
      const Eigen::Vector3d m = a.plane.normalized(), n = b.plane.normalized();
      if (std::abs(m.dot(n)) > std::cos(kLeastAngle * kDegree)) continue;
      pairs.push_back({a.image, m, n, std::sqrt(std::min(a.share, b.share))});
      weights += pairs.back().weight;
    }
  for (SurfacePair& pair : pairs) pair.weight *= static_cast<double>(pairs.size()) / weights;
  return pairs;
}

/** Density of angles: weights in cells, smoothed by a Gaussian. */
class AngleDensity {
public:
  void add(double degrees, double weight) {
    const auto cell = static_cast<std::size_t>(degrees / kCell);
    const double part = degrees / kCell - static_cast<double>(cell);
    cells_[cell] += weight * (1 - part);
    if (cell + 1 < kCells) cells_[cell + 1] += weight * part;
  }
  void smooth(double std) {
    const auto reach = static_cast<std::ptrdiff_t>(4 * std / kCell);
    std::vector<double> kernel;
    for (std::ptrdiff_t i = -reach; i <= reach; ++i)
      kernel.push_back(gauss(static_cast<double>(i) * kCell, std));
    std::vector<double> smoothed(kCells);
    for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(kCells); ++i)
      if (cells_[static_cast<std::size_t>(i)] != 0)
        for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, i - reach);
             j <= std::min<std::ptrdiff_t>(kCells - 1, i + reach); ++j)
          smoothed[static_cast<std::size_t>(j)] +=
              cells_[static_cast<std::size_t>(i)] * kernel[static_cast<std::size_t>(j - i + reach)];
    cells_ = std::move(smoothed);
  }
  /** Sum of the weighted Gaussians there. */
  double at(double degrees) const {
    const auto cell = std::min(static_cast<std::size_t>(degrees / kCell), kCells - 2);
    const double part = degrees / kCell - static_cast<double>(cell);
    return cells_[cell] * (1 - part) + cells_[cell + 1] * part;
  }

private:
  std::vector<double> cells_ = std::vector<double>(kCells);
};

/** Log likelihood of the angles in each image, given those of all other images, against angles between
 * surfaces that were never seen together. It does not change if a camera shrinks all angles. */
class AngleLikelihood {
public:
  explicit AngleLikelihood(std::vector<SurfacePair> pairs) : pairs_(std::move(pairs)) {
    constexpr std::size_t kDraws = 4000;
    std::mt19937 random(1);
    for (std::size_t i = 0; i < kDraws; ++i) {
      const std::size_t a = random() % pairs_.size(), b = random() % pairs_.size();
      if (pairs_[a].image != pairs_[b].image) unrelated_.emplace_back(a, b);
    }
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (i == 0 || pairs_[i].image != pairs_[i - 1].image) first_.push_back(i);
      weight_ += pairs_[i].weight;
    }
    first_.push_back(pairs_.size());
  }

  std::size_t pairs() const { return pairs_.size(); }
  std::size_t images() const { return first_.size() - 1; }
  /** False if all pairs are of one image. */
  bool canBeCompared() const { return !unrelated_.empty(); }

  /** One sum per image. The pairs of an image share its surfaces and its noise: together they count as one
   * observation. */
  std::vector<double> byImage(const Change& change) const {
    std::vector<Eigen::Vector3d> a, b;
    std::vector<double> angles;
    AngleDensity all, unrelated;
    for (const SurfacePair& pair : pairs_) {
      a.push_back(changed(pair.a, change)), b.push_back(changed(pair.b, change));
      angles.push_back(angleBetween(a.back(), b.back()));
      all.add(angles.back(), pair.weight);
    }
    all.smooth(kSharp);
    const double draw = 1 / static_cast<double>(unrelated_.size());
    for (const auto& [i, j] : unrelated_) unrelated.add(angleBetween(a[i], b[j]), draw);
    unrelated.smooth(kSmooth);
    std::vector<double> sums;
    for (std::size_t image = 0; image < images(); ++image) {
      double others = weight_, likelihood = 0;
      for (std::size_t i = first_[image]; i < first_[image + 1]; ++i) others -= pairs_[i].weight;
      for (std::size_t i = first_[image]; i < first_[image + 1]; ++i) {
        double density = all.at(angles[i]);
        for (std::size_t j = first_[image]; j < first_[image + 1]; ++j)
          density -= pairs_[j].weight * gauss(angles[i] - angles[j], kSharp);
        const double by_chance = (1 - kAnywhere) * unrelated.at(angles[i]) + kAnywhere / (180 - kLeastAngle);
        const double seen_again = others > 0 ? std::max(density, 0.0) / others : by_chance;
        likelihood +=
            pairs_[i].weight *
            std::log(((1 - kRight - kUnrelated) * seen_again + kRight * gauss(angles[i] - 90, kSharp)) /
                         by_chance +
                     kUnrelated);
      }
      sums.push_back(likelihood * static_cast<double>(images()) / weight_);
    }
    return sums;
  }

  double operator()(const Change& change) const {
    const std::vector<double> of_images = byImage(change);
    return std::accumulate(of_images.begin(), of_images.end(), 0.0);
  }

private:
  std::vector<SurfacePair> pairs_;
  std::vector<std::pair<std::size_t, std::size_t>> unrelated_;
  std::vector<std::size_t> first_;  // first pair of each image
  double weight_ = 0;
};

/** Cost of intrinsics that depth cameras seldom have [nats]. */
class Unusual {
public:
  explicit Unusual(const Intrinsics& k)
      : aspect_(std::log(k.fx / k.fy)),
        fx_(k.fx / k.width),
        fy_(k.fy / k.width),
        x_((k.cx + 0.5) / k.width - 0.5),
        y_((k.cy + 0.5 - k.height / 2.0) / k.width) {}

  double operator()(const Change& c) const {
    const Eigen::Vector3d errors((aspect_ + c[0] - c[1]) / kSquare,
                                 (x_ - c[2] * std::exp(c[0]) * fx_) / kCentral,
                                 (y_ - c[3] * std::exp(c[1]) * fy_) / kCentral);
    return errors.squaredNorm() / 2;
  }
  /** Square pixels, and the factor of both focal lengths. \param centred with the optical axis in the middle
   */
  Change usual(double log_factor, bool centred) const {
    const Change c(log_factor - aspect_ / 2, log_factor + aspect_ / 2, 0, 0);
    if (!centred) return c;
    return {c[0], c[1], x_ / (fx_ * std::exp(c[0])), y_ / (fy_ * std::exp(c[1]))};
  }
  /** Is the change within the errors of usual calibrations? */
  bool isSmall(const Change& c) const {
    constexpr double kRounding = 1e-9;
    return std::max(std::abs(c[0]), std::abs(c[1])) <= kFocalTolerance + kRounding &&
           std::max(std::abs(c[2]) * fx_, std::abs(c[3]) * fy_) <= kCentreTolerance + kRounding;
  }

private:
  double aspect_, fx_, fy_, x_, y_;  // x_ and y_: of the optical axis from the middle, by the width
};

/** Climbs in ever shorter steps. */
Change climbed(Change at, const std::function<double(const Change&)>& worth,
               const std::function<bool(const Change&)>& allowed) {
  double most = worth(at);
  for (double step = 0.06; step > 0.006; step /= 2)
    for (bool better = true; better;) {
      better = false;
      for (const Change& direction :
           {Change(1, 1, 0, 0), Change(1, -1, 0, 0), Change(0, 0, 0.5, 0), Change(0, 0, 0, 0.5)})
        for (const double d : {step, -step}) {
          const Change next = at + d * direction;
          if (!allowed(next)) continue;
          if (const double w = worth(next); w > most) at = next, most = w, better = true;
        }
    }
  return at;
}

bool isInReach(const Change& c) {
  constexpr double kMostFocal = 1, kMostCentre = 0.4;
  return std::max(std::abs(c[0]), std::abs(c[1])) <= kMostFocal &&
         std::max(std::abs(c[2]), std::abs(c[3])) <= kMostCentre;
}

Change best(const AngleLikelihood& angles, const Unusual& unusual) {
  constexpr double kFarthest = 0.6, kStep = 0.05;
  const auto worth = [&](const Change& c) { return angles(c) - unusual(c); };
  Change start = Change::Zero();
  double most = worth(start);
  for (const bool centred : {false, true})
    for (double focal = -kFarthest; focal <= kFarthest; focal += kStep)
      if (const Change c = unusual.usual(focal, centred); isInReach(c))
        if (const double w = worth(c); w > most) start = c, most = w;
  return climbed(start, worth, isInReach);
}

}  // namespace

std::optional<SurfaceAngles> surfaceAngles(const FlatSurfaces& flat, const Intrinsics& camera) {
  std::vector<SurfacePair> pairs = pairsOf(flat.surfaces);
  if (pairs.size() < kLeastPairs) return {};
  const AngleLikelihood angles(std::move(pairs));
  if (angles.images() < kLeastImages || !angles.canBeCompared()) return {};
  const Unusual unusual(camera);
  const Change as_read =
      climbed(Change::Zero(), std::cref(angles), [&](const Change& c) { return unusual.isSmall(c); });
  const Change change = best(angles, unusual);
  SurfaceAngles found;
  found.pairs = angles.pairs(), found.images = angles.images();
  found.fx = std::exp(change[0]), found.fy = std::exp(change[1]);
  found.cx = -change[2] * found.fx * camera.fx, found.cy = -change[3] * found.fy * camera.fy;
  if (unusual.isSmall(change)) return found;
  const std::vector<double> before = angles.byImage(as_read), after = angles.byImage(change);
  std::vector<double> gains;  // two neighbouring images each, which show the same surfaces
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (i % 2 == 0) gains.push_back(0);
    gains.back() += after[i] - before[i];
  }
  const auto n = static_cast<double>(gains.size());
  const double sum = std::accumulate(gains.begin(), gains.end(), 0.0);
  double squares = 0;
  for (const double gain : gains) squares += (gain - sum / n) * (gain - sum / n);
  found.gain = sum - unusual(change);
  found.gain_std = std::sqrt(squares * n / (n - 1));
  return found;
}

}  // namespace facetloc::internal
