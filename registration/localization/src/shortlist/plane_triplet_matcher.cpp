// SPDX-License-Identifier: BSD-3-Clause
#include "shortlist/plane_triplet_matcher.h"

#include "base/lanes.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <cmath>

namespace facetloc::internal {
namespace {

constexpr int kSeedPlanes = 8;        // most useful ones of which seeds are made
constexpr int kSeeds = 4;             // that are tried
constexpr float kLeastVolume = 0.3f;  // volume spanned by the normals of three planes that fix a pose
constexpr float kLeastSine = 0.4f;    // sine of the angle between two
constexpr float kAngle = static_cast<float>(8 * kDegree);  // between normals of one plane
constexpr float kGate = 3;                                 // standard deviations of the prior
constexpr float kPriorWeight = 0.02f;                      // weight of the squared distance from the prior
constexpr float kAbsolute = 0.05f, kRelative = 0.02f;      // distance of a centroid from its plane [m], 1

const float kCosine = std::cos(kAngle);

// A right-handed orthonormal frame that is symmetric in two unit vectors.
Eigen::Matrix3f frameOf(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  Eigen::Matrix3f F;
  F.col(0) = (a + b).normalized();
  F.col(1) = (a - b).normalized();
  F.col(2) = F.col(0).cross(F.col(1));
  return F;
}

// The weight of the planes of the scene that T_m_c = (R, t), or it with a move along a free direction, lays
// on planes of the model.
FACETLOC_MULTIVERSION float weightLaid(const PlaneColumns& scene, const PlaneColumns& model,
                                       const Eigen::Matrix3f& R, const Eigen::Vector3f& t,
                                       const Eigen::Vector3f& free) {
  float weight = 0;
  const float free_length = free.squaredNorm();  // 1 m, or none
  for (int s = 0; s < scene.size; ++s) {
    const Eigen::Vector3f n = R * scene.normal(s), c = R * scene.centroid(s) + t;
    const float near = kAbsolute + kRelative * scene.cz[s];
    for (int i = 0; i < model.size; i += kLanes) {
      Floats nx, ny, nz, cx, cy, cz, offset, radius;
      std::memcpy(&nx, &model.nx[i], sizeof nx), std::memcpy(&ny, &model.ny[i], sizeof ny);
      std::memcpy(&nz, &model.nz[i], sizeof nz), std::memcpy(&offset, &model.offset[i], sizeof offset);
      std::memcpy(&cx, &model.cx[i], sizeof cx), std::memcpy(&cy, &model.cy[i], sizeof cy);
      std::memcpy(&cz, &model.cz[i], sizeof cz), std::memcpy(&radius, &model.radius[i], sizeof radius);
      const Floats off = nx * c.x() + ny * c.y() + nz * c.z() - offset;
      const Floats slide = nx * free.x() + ny * free.y() + nz * free.z();
      const Floats slack = near + (slide < 0 ? -slide : slide);
      const Floats dx = cx - c.x(), dy = cy - c.y(), dz = cz - c.z();
      const Floats reach = 1.2f * (radius + scene.radius[s]) + 0.1f + free_length;
      const Ints laid = (nx * n.x() + ny * n.y() + nz * n.z() >= kCosine) & (off <= slack) & (off >= -slack) &
                        (dx * dx + dy * dy + dz * dz <= reach * reach);
      std::int32_t any = 0;
      for (int k = 0; k < kLanes; ++k) any |= laid[k];
      if (!any) continue;
      weight += scene.weight[s];
      break;
    }
  }
  return weight;
}

}  // namespace

PlaneColumns::PlaneColumns(const View& view) {
  for (const Segment& s : view.segments) {
    if (size == kMost) return;
    if (!s.R.allFinite() || !s.t.allFinite() || !s.lambda.allFinite()) continue;
    const Eigen::Vector3f n = s.normal().cast<float>(), c = s.t.cast<float>();
    nx[size] = n.x(), ny[size] = n.y(), nz[size] = n.z();
    cx[size] = c.x(), cy[size] = c.y(), cz[size] = c.z();
    offset[size] = n.dot(c);
    radius[size] = static_cast<float>(std::sqrt(3 * std::max(0.0, s.lambda.x())));
    weight[size] = std::sqrt(static_cast<float>(std::max(1, s.num_points)));
    ++size;
  }
}

PlaneTripletMatcher::PlaneTripletMatcher(const View& scene, const PoseWithCovariance& prior, double tilt_std)
    : scene_(scene),
      rotation_std_(static_cast<float>(std::sqrt(prior.P(0, 0)))),
      translation_std_(static_cast<float>(std::sqrt(prior.P(3, 3)))),
      tilt_std_(static_cast<float>(tilt_std)) {
  for (int i = 0; i < scene_.size; ++i) total_weight_ += scene_.weight[i];
  std::vector<Seed> seeds;
  findTriples(seeds);
  if (seeds.empty()) findPairs(seeds);
  keepDifferent(std::move(seeds));
}

void PlaneTripletMatcher::findTriples(std::vector<Seed>& seeds) const {
  const int n = std::min(scene_.size, kSeedPlanes);
  const auto cosine = [this](int a, int b) { return std::abs(scene_.normal(a).dot(scene_.normal(b))); };
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j)
      for (int k = j + 1; k < n; ++k) {
        const float volume = std::abs(scene_.normal(i).cross(scene_.normal(j)).dot(scene_.normal(k)));
        if (!(volume >= kLeastVolume)) continue;
        const float weight = std::cbrt(scene_.weight[i] * scene_.weight[j] * scene_.weight[k]);
        Seed seed{{i, j, k}, 3, volume * weight};
        if (cosine(j, k) < std::min(cosine(i, j), cosine(i, k)))
          seed.planes = {j, k, i};
        else if (cosine(i, k) < cosine(i, j))
          seed.planes = {i, k, j};
        seeds.push_back(seed);
      }
}

void PlaneTripletMatcher::findPairs(std::vector<Seed>& seeds) const {
  const int n = std::min(scene_.size, kSeedPlanes);
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j) {
      const float sine = scene_.normal(i).cross(scene_.normal(j)).norm();
      if (sine >= kLeastSine)
        seeds.push_back({{i, j, -1}, 2, sine * std::sqrt(scene_.weight[i] * scene_.weight[j])});
    }
}

// Keeps the best, of which no two have more than one plane in common: an error of one plane does not spoil
// all.
void PlaneTripletMatcher::keepDifferent(std::vector<Seed> seeds) {
  std::stable_sort(seeds.begin(), seeds.end(),
                   [](const Seed& a, const Seed& b) { return a.worth > b.worth; });
  const auto isLike = [](const Seed& a, const Seed& b) {
    const auto end = b.planes.begin() + b.size;
    return std::count_if(a.planes.begin(), a.planes.begin() + a.size,
                         [&](int plane) { return std::find(b.planes.begin(), end, plane) != end; }) > 1;
  };
  for (const Seed& seed : seeds) {
    if (static_cast<int>(seeds_.size()) == kSeeds) return;
    if (std::none_of(seeds_.begin(), seeds_.end(), [&](const Seed& other) { return isLike(seed, other); }))
      seeds_.push_back(seed);
  }
}

Overlay PlaneTripletMatcher::on(const PlaneColumns& model) const {
  Overlay best;
  for (const Seed& seed : seeds_) lay(seed, model, best);
  return best;
}

void PlaneTripletMatcher::lay(const Seed& seed, const PlaneColumns& model, Overlay& best) const {
  const float least_cosine = std::cos(std::min(kGate * rotation_std_, static_cast<float>(180 * kDegree)));
  const float reach = kGate * translation_std_;
  const float most_tilt = tilt_std_ > 0 ? kGate * tilt_std_ : 2.f;  // largest y component of a unit normal
  std::array<std::array<int, PlaneColumns::kMost>, 3> matching;  // planes of the model, for each of the seed
  std::array<int, 3> count{};
  for (int k = 0; k < seed.size; ++k) {
    const Eigen::Vector3f n = scene_.normal(seed.planes[k]);
    const float offset = scene_.offset[seed.planes[k]];
    for (int i = 0; i < model.size; ++i)
      if (n.dot(model.normal(i)) >= least_cosine && std::abs(model.offset[i] - offset) <= reach &&
          std::abs(model.ny[i] - n.y()) <= most_tilt)
        matching[k][count[k]++] = i;
  }

  const Eigen::Vector3f a = scene_.normal(seed.planes[0]), b = scene_.normal(seed.planes[1]);
  const float cosine = a.dot(b), tolerance = kAngle * std::sqrt(std::max(0.f, 1 - cosine * cosine));
  const Eigen::Matrix3f of_scene = frameOf(a, b).transpose();
  const float least_trace = 1 + 2 * least_cosine;
  for (int p = 0; p < count[0]; ++p)
    for (int q = 0; q < count[1]; ++q) {
      const int i = matching[0][p], j = matching[1][q];
      const Eigen::Vector3f over_a = model.normal(i), over_b = model.normal(j);
      if (!(std::abs(over_a.dot(over_b) - cosine) <= tolerance)) continue;
      const Eigen::Matrix3f R = frameOf(over_a, over_b) * of_scene;
      if (R.trace() < least_trace) continue;
      if (seed.size == 2) {
        judge(seed, {i, j, -1}, R, model, best);
        continue;
      }
      const Eigen::Vector3f c = R * scene_.normal(seed.planes[2]);
      for (int r = 0; r < count[2]; ++r)
        if (c.dot(model.normal(matching[2][r])) >= kCosine)
          judge(seed, {i, j, matching[2][r]}, R, model, best);
    }
}

// The centroids of the seed come to lie in the planes that it is laid over.
void PlaneTripletMatcher::judge(const Seed& seed, const std::array<int, 3>& over, const Eigen::Matrix3f& R,
                                const PlaneColumns& model, Overlay& best) const {
  const auto move = [&](int k) {
    return model.offset[over[k]] - model.normal(over[k]).dot(R * scene_.centroid(seed.planes[k]));
  };
  const bool is_pair = seed.size == 2;
  const Eigen::Vector3f n0 = model.normal(over[0]), n1 = model.normal(over[1]), line = n0.cross(n1);
  const Eigen::Vector3f n2 = is_pair ? Eigen::Vector3f(line.normalized()) : model.normal(over[2]);
  const float move2 = is_pair ? 0 : move(2);
  const Eigen::Vector3f n12 = n1.cross(n2);
  const Eigen::Vector3f t = (move(0) * n12 + move(1) * n2.cross(n0) + move2 * line) / n0.dot(n12);

  const float angle = std::acos(std::clamp((R.trace() - 1) / 2, -1.f, 1.f)) / rotation_std_;
  const float tilt = tilt_std_ > 0 ? std::hypot(R(0, 1), R(2, 1)) / tilt_std_ : 0;  // tilt of the y axis
  const float distance =
      angle * angle + tilt * tilt + t.squaredNorm() / (translation_std_ * translation_std_);
  if (!(distance <= kGate * kGate) || 1 - kPriorWeight * distance <= best.score) return;
  const Eigen::Vector3f free = is_pair ? n2 : Eigen::Vector3f(Eigen::Vector3f::Zero());
  const float score = weightLaid(scene_, model, R, t, free) / total_weight_ - kPriorWeight * distance;
  if (score <= best.score) return;
  best.score = score;
  best.T_m_c.linear() = R;
  best.T_m_c.translation() = t;
}

}  // namespace facetloc::internal
