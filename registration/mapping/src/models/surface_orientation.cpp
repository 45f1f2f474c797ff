// SPDX-License-Identifier: BSD-3-Clause
#include "base/median.h"
#include "models/free_places.h"
#include "threads/in_parallel.h"

#include <facetloc/features/pose.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

namespace facetloc {

using namespace internal;

namespace {

// ---- the surface as seen from inside

/** A direction in which a surface is seen, where it is flat. */
struct SurfaceSample {
  Eigen::Vector3f point, normal;  ///< unit normal towards the viewer
  float weight = 0;               ///< share of all that is seen
};

/** The part of a surface that is visible from inside. */
struct SurfaceSamples {
  std::vector<Eigen::Vector3d> positions;  ///< viewpoints of the samples
  std::vector<SurfaceSample> samples;
  double distance = 0;  ///< median of those seen [units of the surface]
};

constexpr int kPositions = 1500;        // spread over the bounds, those in walls and outside included
constexpr std::size_t kMostUsed = 400;  // positions inside the surface
constexpr int kSide = 16;               // width of each face of a cube [px]
constexpr double kFlat = 0.02;          // distance of a pixel from the plane of its neighbours, of its depth
constexpr double kSurrounded = 0.5;     // share of the directions in which the surface is met, inside
constexpr double kOpen = 0.2;           // ... of a surface that surrounds nothing
constexpr double kFewestInside = 0.01;  // share of the positions that are inside, unless it is open
constexpr double kNarrow = 0.25;        // share of the usual distance: inside a wall or a cupboard

/** Element i of the Halton sequence, between 0 and 1. */
double radicalInverse(int i, int base) {
  double value = 0, digit = 1;
  for (; i > 0; i /= base) digit /= base, value += digit * (i % base);
  return value;
}

/** The surface as seen from one position. */
struct Surroundings {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<SurfaceSample> samples;
  double known = 0;     // share of the directions
  double distance = 0;  // median
};

/** The plane through the pixels around one, seen from its camera; false where pixels are missing. */
bool planeAt(const DepthImage& face, int u, int v, SurfaceSample& sample) {
  const auto pointAt = [&](int x, int y) {
    return Eigen::Vector3d(static_cast<double>(face.at(x, y)) * face.camera.ray(x, y));
  };
  for (const auto& [x, y] : {std::pair(u, v), {u - 1, v}, {u + 1, v}, {u, v - 1}, {u, v + 1}})
    if (!isMeasured(face.at(x, y))) return false;
  const Eigen::Vector3d p = pointAt(u, v), left = pointAt(u - 1, v), up = pointAt(u, v - 1);
  Eigen::Vector3d normal = (pointAt(u + 1, v) - left).cross(pointAt(u, v + 1) - up);
  if (!(normal.norm() > 0)) return false;
  normal.normalize();
  const double off = kFlat * p.norm();
  if (std::abs(normal.dot(left - p)) > off || std::abs(normal.dot(up - p)) > off) return false;
  sample.point = p.cast<float>();
  sample.normal = (normal.dot(p) > 0 ? -normal : normal).cast<float>();
  return true;
}

Surroundings lookedAt(const SpaceProbe& space, const Eigen::Vector3d& position) {
  Surroundings seen;
  seen.position = position;
  std::vector<double> distances;
  double all = 0, known = 0;
  space.look(position, kSide, [&](const Eigen::Isometry3d& T_w_c, const DepthImage& face) {
    for (int v = 0; v < kSide; ++v)
      for (int u = 0; u < kSide; ++u) {
        const double length = face.camera.ray(u, v).norm();
        const double solid_angle = 1 / (length * length * length);
        all += solid_angle;
        if (!isMeasured(face.at(u, v))) continue;
        known += solid_angle;
        distances.push_back(face.at(u, v) * length);
        SurfaceSample sample;
        if (u == 0 || v == 0 || u == kSide - 1 || v == kSide - 1 || !planeAt(face, u, v, sample)) continue;
        sample.point = (T_w_c * sample.point.cast<double>()).cast<float>();
        sample.normal = T_w_c.linear().cast<float>() * sample.normal;
        sample.weight = static_cast<float>(solid_angle);
        seen.samples.push_back(sample);
      }
  });
  seen.known = known / all;
  if (!distances.empty()) seen.distance = median(distances);
  return seen;
}

void keep(std::vector<Surroundings>& all, const std::function<bool(const Surroundings&)>& isKept) {
  all.erase(std::remove_if(all.begin(), all.end(), [&](const Surroundings& s) { return !isKept(s); }),
            all.end());
}

double usualDistance(const std::vector<Surroundings>& all) {
  std::vector<double> distances;
  for (const Surroundings& s : all) distances.push_back(s.distance);
  return median(distances);
}

/** Looks around from positions spread over the bounds, as far as they are in free space that the
 * surface surrounds. \param threads 0 = all cores */
SurfaceSamples samplesFromInside(const SpaceProbe& space, int threads) {
  SurfaceSamples out;
  const Eigen::AlignedBox3d bounds = space.bounds();
  if (bounds.isEmpty()) return out;
  std::vector<Surroundings> seen(kPositions);
  forEachInParallel(kPositions, threads, [&](int i) {
    const Eigen::Vector3d share(radicalInverse(i + 1, 2), radicalInverse(i + 1, 3), radicalInverse(i + 1, 5));
    seen[static_cast<std::size_t>(i)] = lookedAt(space, bounds.min() + share.cwiseProduct(bounds.sizes()));
  });
  const auto inside =
      std::count_if(seen.begin(), seen.end(), [](const Surroundings& s) { return s.known >= kSurrounded; });
  const double least = static_cast<double>(inside) >= kFewestInside * kPositions ? kSurrounded : kOpen;
  keep(seen, [&](const Surroundings& s) { return s.known >= least; });
  if (seen.empty()) return out;
  out.distance = usualDistance(seen);
  keep(seen, [&](const Surroundings& s) { return s.distance >= kNarrow * out.distance; });
  seen.resize(std::min(seen.size(), kMostUsed));
  double all = 0;
  for (const Surroundings& s : seen) {
    out.positions.push_back(s.position);
    out.samples.insert(out.samples.end(), s.samples.begin(), s.samples.end());
    for (const SurfaceSample& sample : s.samples) all += sample.weight;
  }
  for (SurfaceSample& sample : out.samples) sample.weight /= static_cast<float>(all);
  return out;
}

// ---- its orientation

constexpr double kParallel = 8 * kDegree;   // between normals of parallel planes
constexpr double kExact = 3 * kDegree;      // ... of the same plane
constexpr double kSameAxis = 15 * kDegree;  // largest angle between an axis and a named one
constexpr double kInclined = 2 * kDegree;   // largest inclination of a floor
constexpr double kLeastShare = 0.03;        // least share of the visible surface for an axis
constexpr std::size_t kMostAxes = 6;
constexpr std::size_t kSeeds = 256;        // normals that axes are looked for at
constexpr std::size_t kVotes = 20000;      // normals that vote for them
constexpr double kLevel = 0.05;            // thickness of a level, of the usual distance
constexpr double kLevelShare = 0.25;       // least size of further floors or ceilings, by the largest level
constexpr double kCeilingless = 2;         // times as much floor as ceiling
constexpr double kFurnished = 2.5;         // times as much on floors as under ceilings
constexpr double kLeastFurniture = 0.006;  // least share of the visible surface for a sign
constexpr double kOff = 1e-3;              // distance from a surface that is looked from, of a room's height
// Evidence for an axis [nats].
constexpr double kPerSize = 3;          // factor on the logarithm of a size
constexpr double kOneSided = 2;         // one side lacks planes, as scans lack ceilings
constexpr double kSquare = 3;           // surface that is nowhere oblique
constexpr double kFewThings = 0.003;    // share of the visible surface that makes a ratio of furniture count
const double kUsual = std::log(3.0);    // convention of the file's kind
const double kDecided = std::log(4.0);  // lead that decides
const double kOverwhelming = std::log(20.0);  // lead that contradicts a named direction

using Samples = std::vector<SurfaceSample>;

/** The normals within an angle of an axis, in both directions: their weight, and the axis that they have. */
double gathered(const Samples& samples, std::size_t step, double angle, Eigen::Vector3d& axis) {
  const float least = static_cast<float>(std::cos(angle));
  const Eigen::Vector3f a = axis.cast<float>();
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double weight = 0;
  for (std::size_t i = 0; i < samples.size(); i += step) {
    if (std::abs(samples[i].normal.dot(a)) < least) continue;
    const Eigen::Vector3d n = samples[i].normal.cast<double>();
    scatter += samples[i].weight * n * n.transpose();
    weight += samples[i].weight;
  }
  if (weight > 0) {
    const Eigen::Vector3d mean =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(2);
    axis = mean.dot(axis) < 0 ? Eigen::Vector3d(-mean) : mean;
  }
  return weight;
}

bool isAlong(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double angle) {
  return std::abs(a.dot(b)) >= std::cos(angle);
}

/** Axes of parallel planes, whatever their distance, those with most normals first. */
std::vector<Eigen::Vector3d> axesOf(const Samples& samples) {
  std::vector<Eigen::Vector3d> axes;
  const std::size_t vote_step = std::max<std::size_t>(1, samples.size() / kVotes);
  const std::size_t seed_step = std::max<std::size_t>(1, samples.size() / kSeeds);
  std::vector<std::pair<double, Eigen::Vector3d>> seeds;
  for (std::size_t i = 0; i < samples.size(); i += seed_step) {
    Eigen::Vector3d axis = samples[i].normal.cast<double>();
    const double weight = gathered(samples, vote_step, kParallel, axis);
    seeds.emplace_back(weight * static_cast<double>(vote_step), axis);
  }
  std::stable_sort(seeds.begin(), seeds.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  for (auto [weight, axis] : seeds) {
    if (axes.size() >= kMostAxes || weight < kLeastShare) break;
    const auto isKnown = [&axes, &a = axis] {
      return std::any_of(axes.begin(), axes.end(),
                         [&a](const Eigen::Vector3d& other) { return isAlong(a, other, kSameAxis); });
    };
    if (isKnown()) continue;
    for (int i = 0; i < 3; ++i) gathered(samples, 1, i == 0 ? kParallel : kExact, axis);
    if (!isKnown()) axes.push_back(axis);
  }
  return axes;
}

/** The surface that faces one direction, by its height in that direction. */
class Levels {
public:
  Levels(const Samples& samples, const Eigen::Vector3d& facing, double thickness) {
    const Eigen::Vector3f along = facing.cast<float>();
    const auto least = static_cast<float>(std::cos(kParallel));
    std::vector<Item> items;
    for (const SurfaceSample& sample : samples)
      if (sample.normal.dot(along) >= least)
        items.push_back({sample.point.dot(along), &sample}), total_ += sample.weight;
    std::stable_sort(items.begin(), items.end(),
                     [](const Item& a, const Item& b) { return a.height < b.height; });
    while (true) {  // the largest level that is left, with all that is close to it
      const auto [weight, height] = largestOf(items, thickness);
      if (weight <= 0 || weight < kLevelShare * largest_) break;
      largest_ = std::max(largest_, weight);
      items.erase(std::remove_if(items.begin(), items.end(),
                                 [h = height, thickness](const Item& item) {
                                   return std::abs(item.height - h) <= 1.5 * thickness;
                                 }),
                  items.end());
    }
    for (const Item& item : items) rest_.push_back(item.sample);
  }
  double total() const { return total_; }                                  ///< weight
  double largest() const { return largest_; }                              ///< weight of the largest level
  const std::vector<const SurfaceSample*>& rest() const { return rest_; }  ///< on no large level: furniture

private:
  struct Item {
    float height;
    const SurfaceSample* sample;
  };
  /** Weight and middle of the window with most. */
  static std::pair<double, double> largestOf(const std::vector<Item>& items, double thickness) {
    std::pair<double, double> best{0, 0};
    double sum = 0;
    for (std::size_t first = 0, last = 0; last < items.size(); ++last) {
      sum += items[last].sample->weight;
      while (items[last].height - items[first].height > 2 * thickness) sum -= items[first++].sample->weight;
      if (sum > best.first) best = {sum, (items[first].height + items[last].height) / 2.0};
    }
    return best;
  }
  double total_ = 0, largest_ = 0;
  std::vector<const SurfaceSample*> rest_;
};

double clearHeight(const SpaceProbe& space, const SurfaceSamples& seen, const Eigen::Vector3d& axis) {
  std::vector<double> heights;
  for (const Eigen::Vector3d& p : seen.positions) {
    const double height = space.along(p, axis) + space.along(p, -axis);
    if (std::isfinite(height)) heights.push_back(height);
  }
  return 2 * heights.size() < seen.positions.size() || heights.empty() ? 0 : median(heights);
}

/** Weight of objects above a floor, by how much more room is above than below them: of a table its top,
 * not its underside. */
double furnitureOn(const SpaceProbe& space, const Levels& floors, const Eigen::Vector3d& up, double room) {
  double weight = 0;
  for (const SurfaceSample* sample : floors.rest()) {
    const Eigen::Vector3d from = sample->point.cast<double>() + kOff * room * up;
    const double before = std::min(1.0, space.along(from, up) / room);
    weight += std::max(0.0, 2 * before - 1) * sample->weight;
  }
  return weight;
}

/** Lack of a ceiling: 1 if a direction is upwards, -1 if downwards, 0 if neither side is missing. */
int openSide(const Levels& along, const Levels& against) {
  return (along.total() > kCeilingless * against.total()) - (against.total() > kCeilingless * along.total());
}

/** 1 if a direction is upwards, -1 if downwards: by the weight of furniture on floors, of which enough is
 * seen. */
int furnishedSide(double on_floors, double on_ceilings) {
  if (on_floors + on_ceilings < kLeastFurniture) return 0;
  return (on_floors > kFurnished * on_ceilings) - (on_ceilings > kFurnished * on_floors);
}

/** Evidence of a height: people stand in rooms, of which most are 2 to 4 m high [nats]. */
double heightEvidence(double height) {
  constexpr double kLow = 2, kHigh = 4;                                      // [m]
  constexpr double kPerLow = 20, kMostLow = 6, kPerHigh = 1, kMostHigh = 1;  // [nats]
  if (height < kLow) return height > 0 ? -std::min(kMostLow, kPerLow * std::log(kLow / height)) : -kMostLow;
  return height > kHigh ? -std::min(kMostHigh, kPerHigh * std::log(height / kHigh)) : 0;
}

double extentAlong(const Samples& samples, const Eigen::Vector3d& axis) {
  const Eigen::Vector3f a = axis.cast<float>();
  const auto [low, high] = std::minmax_element(
      samples.begin(), samples.end(),
      [&a](const SurfaceSample& s, const SurfaceSample& t) { return s.point.dot(a) < t.point.dot(a); });
  return (high->point - low->point).dot(a);
}

/** Evidence of the size of planes [nats]. A floor is large as its largest level, and in total with the tops
 * of furniture. */
double sizeEvidence(double largest, double total) { return kPerSize * std::log(std::sqrt(largest * total)); }

/** Share of the surface that is across an axis or along it, as floors and walls are; a roof is oblique. */
double squareShare(const Samples& samples, const Eigen::Vector3d& axis) {
  const Eigen::Vector3f a = axis.cast<float>();
  double share = 0;
  for (const SurfaceSample& sample : samples) {
    const double cosine = std::abs(sample.normal.dot(a));
    if (cosine >= std::cos(kParallel) || cosine <= std::sin(kParallel)) share += sample.weight;
  }
  return share;
}

SurfaceAxis axisAlong(const SpaceProbe& space, const SurfaceSamples& seen, const Eigen::Vector3d& direction) {
  const double thickness = kLevel * seen.distance;
  const Levels along(seen.samples, direction, thickness), against(seen.samples, -direction, thickness);
  SurfaceAxis axis{direction, std::max(along.largest(), against.largest()), 0, 0, 0};
  axis.clear_height = clearHeight(space, seen, direction);
  const double height = axis.clear_height > 0 ? axis.clear_height : extentAlong(seen.samples, direction);
  const double on_floors = furnitureOn(space, along, direction, height),
               on_ceilings = furnitureOn(space, against, -direction, height);
  const int open = openSide(along, against);
  axis.upwards = open != 0 || axis.clear_height == 0 ? open : furnishedSide(on_floors, on_ceilings);
  const double furniture = std::log((on_floors + kFewThings) / (on_ceilings + kFewThings));
  axis.evidence = sizeEvidence(axis.support, std::max(along.total(), against.total())) +
                  heightEvidence(height) + kSquare * squareShare(seen.samples, direction) +
                  kOneSided * std::abs(open) + (open != 0 ? open * furniture : std::abs(furniture));
  return axis;
}

/** Direction along an axis that files mean by up. */
Eigen::Vector3d usualSign(const Eigen::Vector3d& axis) {
  for (const int k : {2, 1, 0})
    if (std::abs(axis[k]) > std::sin(kSameAxis)) return axis[k] < 0 ? Eigen::Vector3d(-axis) : axis;
  return axis;
}

Eigen::Vector3d upwardsAlong(const SurfaceAxis& axis) {
  return axis.upwards != 0 ? Eigen::Vector3d(axis.upwards * axis.direction) : usualSign(axis.direction);
}

}  // namespace

double SurfaceOrientation::evidenceFor(const SurfaceAxis& axis) const {
  const bool is_usual = usual && upwardsAlong(axis).dot(*usual) >= std::cos(kSameAxis);
  return axis.evidence + (is_usual ? kUsual : 0);
}

const SurfaceAxis& SurfaceOrientation::best() const {
  return *std::max_element(axes.begin(), axes.end(), [this](const SurfaceAxis& a, const SurfaceAxis& b) {
    return evidenceFor(a) < evidenceFor(b);
  });
}

std::vector<Eigen::Vector3d> SurfaceOrientation::candidates() const {
  std::vector<Eigen::Vector3d> found;
  for (const SurfaceAxis& axis : axes)
    if (evidenceFor(axis) + kDecided >= evidenceFor(best())) found.push_back(upwardsAlong(axis));
  return found;
}

std::optional<Eigen::Vector3d> SurfaceOrientation::up() const {
  const std::vector<Eigen::Vector3d> found = candidates();
  return found.size() == 1 ? std::optional(found.front()) : std::nullopt;
}

SurfaceOrientation::Judgement SurfaceOrientation::judge(const Eigen::Vector3d& up) const {
  Judgement judgement{Verdict::plausible, up, 0};
  if (axes.empty()) return judgement;
  const auto named = std::find_if(axes.begin(), axes.end(), [&](const SurfaceAxis& axis) {
    return isAlong(axis.direction, up, kSameAxis);
  });
  const double evidence = named == axes.end() ? sizeEvidence(kLeastShare, kLeastShare) : evidenceFor(*named);
  if (evidence + kOverwhelming < evidenceFor(best()))
    return {Verdict::other_axis, upwardsAlong(best()), best().clear_height};
  if (named == axes.end()) return judgement;
  const double sign = named->direction.dot(up) < 0 ? -1 : 1;
  judgement.clear_height = named->clear_height;
  judgement.better = sign * named->direction;
  if (sign * named->upwards < 0 && &*named == &best()) {
    judgement.verdict = Verdict::upside_down;
    judgement.better *= -1;
  } else if (!isAlong(named->direction, up, kInclined)) {
    judgement.verdict = Verdict::inclined;
  } else {
    judgement.better = up;
  }
  return judgement;
}

SurfaceOrientation orientationOf(const Surface& surface, int threads) {
  const SpaceProbe space(surface);
  SurfaceOrientation found;
  const SurfaceSamples seen = samplesFromInside(space, threads);
  for (const Eigen::Vector3d& direction : axesOf(seen.samples))
    found.axes.push_back(axisAlong(space, seen, direction));
  std::stable_sort(found.axes.begin(), found.axes.end(),
                   [](const SurfaceAxis& a, const SurfaceAxis& b) { return a.evidence > b.evidence; });
  return found;
}

}  // namespace facetloc
