// SPDX-License-Identifier: BSD-3-Clause
#include "shortlist/coarse_aligner.h"

#include "base/lanes.h"
#include "depth/moved_pixels.h"

#include <facetloc/features/pose.h>

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>

namespace facetloc::internal {
namespace {

constexpr float kTwoPi = static_cast<float>(360 * kDegree);
constexpr float kDegreeF = static_cast<float>(kDegree);
constexpr float kLargestTurn = kReachTurnDeg;
constexpr float kTurnStep = 2;  // [deg]
constexpr int kTurnBins = static_cast<int>(2 * kLargestTurn / kTurnStep) + 1;
constexpr int kTurnLanes = (kTurnBins + kLanes - 1) / kLanes * kLanes;  // filled up to whole vectors
constexpr int kTurns = 2;                                               // headings that are tried
constexpr int kTurnGap = 3;                                             // bins between them
constexpr float kTurnStd = 30 * kDegreeF;                               // wide, for the prior is wide
constexpr float kParallel = 3 * kDegreeF;
constexpr float kReach = kReachMove;
constexpr float kCell = 0.2f;  // size of a cell of the grid of positions [m]
constexpr int kCells = static_cast<int>(2 * kReach / kCell) + 1;
constexpr int kStride = kCells + 2;      // with a border
constexpr int kPositions = 3;            // for each heading
constexpr int kCompared = 3;             // poses that are compared in depth
constexpr float kEnd = 1, kEdge = 0.5f;  // worth of a matching end, upper or lower edge, in walls
constexpr float kEndError = 0.1f;        // [m]
constexpr float kWallStd = 0.05f;        // [m]

// Prior of each bin of headings.
const std::array<float, kTurnLanes>& turnPrior() {
  static const std::array<float, kTurnLanes> prior = [] {
    std::array<float, kTurnLanes> p{};
    for (int b = 0; b < kTurnBins; ++b) {
      const float turn = (kTurnStep * static_cast<float>(b) - kLargestTurn) * kDegreeF / kTurnStd;
      p[b] = std::exp(-0.5f * turn * turn);
    }
    return p;
  }();
  return prior;
}

struct Comparison {
  int agree = 0, in_front = 0, behind = 0;
};

// Points seen from elsewhere against a picture: x_c = R x + t.
FACETLOC_MULTIVERSION Comparison compare(const PointColumns& points, const Eigen::Matrix3f& R,
                                         const Eigen::Vector3f& t, const DepthThumbnail& picture) {
  constexpr float kAbsolute = 0.04f, kRelative = 0.02f, kNearest = 0.3f;  // [m], 1, [m]
  const Intrinsics& c = picture.camera;
  const auto fx = static_cast<float>(c.fx), fy = static_cast<float>(c.fy),
             cx = static_cast<float>(c.cx) + 0.5f, cy = static_cast<float>(c.cy) + 0.5f;
  const float *x = points.x.data(), *y = points.y.data(), *z = points.z.data();
  const auto n = static_cast<std::int32_t>(points.size());
  if (picture.depth.empty()) return {};
  Ints agree{}, in_front{}, behind{};
  for (std::int32_t i = 0; i < n; i += kLanes) {
    Floats px, py, pz;
    load(x + i, x + n, px), load(y + i, y + n, py), load(z + i, z + n, pz);
    const Floats qx = R(0, 0) * px + R(0, 1) * py + R(0, 2) * pz + t[0],
                 qy = R(1, 0) * px + R(1, 1) * py + R(1, 2) * pz + t[1],
                 qz = R(2, 0) * px + R(2, 1) * py + R(2, 2) * pz + t[2];
    const Floats scale = 1 / qz;
    Ints judged = (kLane < n - i) & (qz >= kNearest), column, row, millimetres;
    findPixels(qx * scale * fx + cx, qy * scale * fy + cy, c.width, c.height, 0, judged, column, row);
    const Ints at = row * c.width + column;
    for (int k = 0; k < kLanes; ++k) millimetres[k] = picture.depth[static_cast<std::size_t>(at[k])];
    judged &= millimetres > 0;
    const Floats measured = 0.001f * __builtin_convertvector(millimetres, Floats);
    const Floats tolerance = kAbsolute + kRelative * measured, d = qz - measured;
    const Ints nearer = judged & (d < -tolerance), farther = judged & (d > tolerance);
    in_front -= nearer, behind -= farther, agree -= judged & ~nearer & ~farther;
  }
  Comparison found;
  for (int k = 0; k < kLanes; ++k)
    found.agree += agree[k], found.in_front += in_front[k], found.behind += behind[k];
  return found;
}

// Saturates: a moved object or a passer-by costs more, the less of it is in view.
constexpr float kMostWorth = 1;
float worth(const Comparison& found, std::size_t points) {
  constexpr float kFewPoints = 10, kFewJudged = 20, kUnknown = 2;  // a pose that nothing tests is in doubt
  constexpr float kBehind = 0.6f, kUsualShare = 0.05f, kWeight = 0.2f;
  const float judged = static_cast<float>(found.agree + found.in_front + found.behind);
  const float against = static_cast<float>(found.in_front) + kBehind * static_cast<float>(found.behind);
  return std::sqrt(static_cast<float>(found.agree) / (static_cast<float>(points) + kFewPoints)) -
         kWeight * std::log1p((against + kUnknown) / (judged + kFewJudged) / kUsualShare);
}

}  // namespace

CoarseAligner::CoarseAligner(const PlaceDescriptor& scene)
    : scene_(scene), scene_walls_(scene.walls), matching_(scene_walls_.size() + 1) {
  pointsAboveFloor(scene_, scene_points_);
}

// The numbers of the walls that may be this wall of a model; returns how many.
FACETLOC_MULTIVERSION int CoarseAligner::findMatching(const WallColumns& walls, const Wall& wall,
                                                      int* matching) {
  constexpr float kLargest = kLargestTurn * kDegreeF;
  int n = 0;
  for (std::size_t i = 0; i < walls.size(); i += kLanes) {
    Floats heading, offset, right, left, bottom, top;
    std::memcpy(&heading, &walls.heading[i], sizeof heading);
    std::memcpy(&offset, &walls.offset[i], sizeof offset);
    std::memcpy(&right, &walls.right[i], sizeof right);
    std::memcpy(&left, &walls.left[i], sizeof left);
    std::memcpy(&bottom, &walls.bottom[i], sizeof bottom);
    std::memcpy(&top, &walls.top[i], sizeof top);
    const Floats none{}, turn = wall.heading - heading, move = wall.offset - offset;
    const Floats once = turn > kTwoPi / 2 ? none + kTwoPi : turn < -kTwoPi / 2 ? none - kTwoPi : none;
    const Floats wrapped = turn - once, first = wall.right - left, last = wall.left - right;
    Ints overlaps;
    overlapInHeight(bottom, top, wall, overlaps);
    const Ints fits = overlaps & (wrapped <= kLargest) & (wrapped >= -kLargest) & (move <= kReach) &
                      (move >= -kReach) & (first <= last) & (first <= kReach) & (last >= -kReach);
    std::int32_t fit[kLanes];
    std::memcpy(fit, &fits, sizeof fit);
    for (int k = 0; k < kLanes; ++k) {
      matching[n] =
          static_cast<int>(i) + k;  // kept or written over: no branch, since it would be mispredicted
      n -= fit[k];
    }
  }
  return n;
}

void CoarseAligner::findPairs(const PlaceDescriptor& model) {
  pairs_.clear();
  for (const Wall& b : model.walls) {
    const int n = findMatching(scene_walls_, b, matching_.data());
    for (int k = 0; k < n; ++k) {
      const Wall& a = scene_.walls[static_cast<std::size_t>(matching_[k])];
      Pair p;
      p.turn = wrapped(b.heading - a.heading);
      p.move = b.offset - a.offset;
      p.slide0 = std::max(-kReach, b.right - a.left);
      p.slide1 = std::min(kReach, b.left - a.right);
      p.weight = std::min(a.weight, b.weight);
      p.scene = &a, p.model = &b;
      pairs_.push_back(p);
    }
  }
}

void CoarseAligner::findTurns() {
  float votes[kTurnLanes + 2] = {};  // with a border
  for (const Pair& p : pairs_) {
    const float at = (p.turn / kDegreeF + kLargestTurn) / kTurnStep + 1;
    const int bin = static_cast<int>(at);
    const float rest = at - static_cast<float>(bin);
    votes[bin] += p.weight * (1 - rest);
    votes[bin + 1] += p.weight * rest;
  }
  using Bins = Eigen::Array<float, kTurnLanes, 1>;
  const auto from = [&votes](int first) { return Eigen::Map<const Bins>(votes + first); };
  Bins smooth = (from(1) + 0.5f * (from(0) + from(2))) * Eigen::Map<const Bins>(turnPrior().data());
  turns_.clear();
  for (int k = 0; k < kTurns; ++k) {
    const float most = smooth.maxCoeff();
    if (most <= 0) return;
    const int best =
        static_cast<int>(std::find(smooth.data(), smooth.data() + kTurnBins, most) - smooth.data());
    const float sum = votes[best] + votes[best + 1] + votes[best + 2];
    const float centre = static_cast<float>(best) + (votes[best + 2] - votes[best]) / sum;
    turns_.push_back((centre * kTurnStep - kLargestTurn) * kDegreeF);
    const int first = std::max(0, best - kTurnGap);
    smooth.segment(first, std::min(kTurnBins, best + kTurnGap + 1) - first) = 0;
  }
}

void CoarseAligner::findPositions(float turn) {
  grid_.assign(static_cast<std::size_t>(kStride) * kStride, 0);
  parallel_.clear();
  const auto vote = [this](const ParallelPair& p, float slide, float weight) {
    const float x = (p.move * p.cosine - slide * p.sine + kReach) / kCell,
                y = (p.move * p.sine + slide * p.cosine + kReach) / kCell;
    if (!(x >= 0 && y >= 0 && x < kCells - 1 && y < kCells - 1)) return;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const float right = x - static_cast<float>(column), up = y - static_cast<float>(row);
    float* cell = &grid_[static_cast<std::size_t>(row + 1) * kStride + column + 1];
    cell[0] += weight * (1 - right) * (1 - up);
    cell[1] += weight * right * (1 - up);
    cell[kStride] += weight * (1 - right) * up;
    cell[kStride + 1] += weight * right * up;
  };
  for (const Pair& pair : pairs_) {
    if (std::abs(pair.turn - turn) > kParallel) continue;
    const Wall &a = *pair.scene, &b = *pair.model;
    float edges;
    countEdges(b.seenBottom() - a.seenBottom(), b.seenTop() - a.seenTop(), edges);
    const ParallelPair p{pair,
                         b.cosine,
                         b.sine,
                         1 + kEdge * edges,
                         b.seenRight() - a.seenRight(),
                         b.seenLeft() - a.seenLeft()};
    parallel_.push_back(p);
    const float weight = p.weight * p.walls;
    for (float slide = p.slide0; slide <= p.slide1; slide += kCell) vote(p, slide, weight);
    vote(p, p.right, kEnd * p.weight);
    vote(p, p.left, kEnd * p.weight);
  }
  std::array<float, kStride> most;  // most votes of each row
  const auto findMost = [&](int first, int last) {
    for (int row = std::max(first, 0); row <= std::min(last, kStride - 1); ++row)
      most[row] = Eigen::Map<const Eigen::Array<float, kStride, 1>>(&grid_[row * kStride]).maxCoeff();
  };
  findMost(0, kStride - 1);
  for (int k = 0; k < kPositions; ++k) {
    const auto row_of_best = std::max_element(most.begin(), most.end());
    if (*row_of_best <= 0) return;
    const auto row_number = static_cast<int>(row_of_best - most.begin());
    const auto start_of_row = grid_.begin() + row_number * kStride;
    const auto best =
        static_cast<int>(std::find(start_of_row, start_of_row + kStride, *row_of_best) - grid_.begin());
    float sum = 0, x = 0, y = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int i = best + dy * kStride + dx;
        if (i < 0 || i >= kStride * kStride) continue;
        const float votes = std::max(0.f, grid_[i]);
        sum += votes;
        x += votes * static_cast<float>(dx);
        y += votes * static_cast<float>(dy);
        grid_[i] = 0;
      }
    findMost(row_number - 1, row_number + 1);
    const auto column = static_cast<float>(best % kStride - 1), row = static_cast<float>(row_number - 1);
    poses_.push_back({turn, (column + x / sum) * kCell - kReach, (row + y / sum) * kCell - kReach, 0});
  }
}

void CoarseAligner::refine(Pose& pose) const {
  constexpr float kGates[] = {0.25f, 0.12f};  // [m]
  constexpr float kInformation = 400;         // information of a wall of weight 1: 1 / kWallStd^2 [1/m^2]
  constexpr float kPositionInformation =
      4;  // information about the position found, along directions that no wall fixes [1/m^2]
  const auto slideOf = [&](const ParallelPair& p) { return pose.y * p.cosine - pose.x * p.sine; };
  const auto overlap = [&](const ParallelPair& p) {
    const float slide = slideOf(p);
    return slide >= p.slide0 && slide <= p.slide1;
  };
  const auto residual = [&](const ParallelPair& p) { return p.move - p.cosine * pose.x - p.sine * pose.y; };
  for (const float gate : kGates) {
    Eigen::Matrix2f A = kPositionInformation * Eigen::Matrix2f::Identity();
    Eigen::Vector2f b = kPositionInformation * Eigen::Vector2f(pose.x, pose.y);
    float turn = 0, sum = 0;
    for (const ParallelPair& p : parallel_) {
      if (std::abs(residual(p)) > gate || !overlap(p)) continue;
      const Eigen::Vector2f n(p.cosine, p.sine);
      const float w = p.weight * p.weight;
      A += kInformation * w * n * n.transpose();
      b += kInformation * w * p.move * n;
      turn += w * p.turn;
      sum += w;
    }
    if (sum <= 0) break;
    const Eigen::Vector2f t = A.inverse() * b;
    pose = {turn / sum, t.x(), t.y(), 0};
  }
  float support = 0;
  for (const ParallelPair& p : parallel_) {
    const float r = residual(p) / kWallStd;
    if (r * r > 9 || !overlap(p)) continue;
    const float slide = slideOf(p);
    float walls = p.walls;
    if (std::abs(p.right - slide) < kEndError) walls += kEnd;
    if (std::abs(p.left - slide) < kEndError) walls += kEnd;
    support += p.weight * walls * std::exp(-0.5f * r * r);
  }
  pose.support = support;
}

PlaceAlignment CoarseAligner::align(const PlaceDescriptor& model, float least) {
  constexpr float kSupport = 0.4f;                          // worth of the walls, by their square root
  constexpr float kTurnPrior = 0.01f, kMovePrior = 0.005f;  // [1], [1/m^2]
  findPairs(model);
  findTurns();
  poses_.clear();
  for (const float turn : turns_) {
    const std::size_t first = poses_.size();
    findPositions(turn);
    for (std::size_t i = first; i < poses_.size(); ++i) refine(poses_[i]);
  }
  std::stable_sort(poses_.begin(), poses_.end(),
                   [](const Pose& a, const Pose& b) { return a.support > b.support; });
  if (poses_.size() > kCompared) poses_.resize(kCompared);

  PlaceAlignment best;
  bool has_points = false;
  for (const Pose& p : poses_) {
    const Eigen::Matrix3f turn = Eigen::AngleAxisf(p.turn, Eigen::Vector3f::UnitZ()).toRotationMatrix();
    const Eigen::Vector3f move(p.x, p.y, scene_.height - model.height);
    const Eigen::Matrix3f to_model = model.R_u_c.transpose(), to_scene = (turn * scene_.R_u_c).transpose();
    float score = kSupport * std::sqrt(p.support) - kTurnPrior * p.turn * p.turn / (kTurnStd * kTurnStd) -
                  kMovePrior * (p.x * p.x + p.y * p.y);
    if (score + 2 * kMostWorth <= std::max(best.score, least)) continue;
    score +=
        worth(compare(scene_points_, to_model * turn, to_model * move, model.picture), scene_points_.size());
    if (score + kMostWorth <= std::max(best.score, least)) continue;
    if (!has_points) pointsAboveFloor(model, model_points_);
    has_points = true;
    score +=
        worth(compare(model_points_, to_scene, -(to_scene * move), scene_.picture), model_points_.size());
    if (score > best.score) best = {score, p.turn, p.x, p.y};
  }
  return best;
}

}  // namespace facetloc::internal
