// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/so3.h>
#include <facetloc/registration/place_alignment.h>
#include <facetloc/registration/place_index.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <flann/flann.hpp>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace facetloc {
namespace {

constexpr int kDimensions = 5;

/** A point in a space where neighbours are about one apart. */
struct Descriptor {
  std::array<float, kDimensions> at;
  float heading;  // of what it describes [rad]; NaN if it has none
};

// Kinds are farther from each other than any neighbours.
enum Kind { kWall, kSameWay, kAcross, kTop, kBottom, kSurface, kCeiling };
constexpr float kKindDistance = 2000;

// How much things differ between two views of one place, standard deviations.
constexpr float kHeadingStd = 20 * static_cast<float>(kDegree), kPositionStd = 1;  // the prior's [m]
constexpr float kSizeStd = 1;            // of the logarithm of the area
constexpr float kDifferenceStd = 0.04f;  // of the distance of two parallel walls [m]
constexpr float kEdgeStd = 0.08f;        // of an upper or lower edge [m]
constexpr float kHeightStd = 0.03f;      // of a level surface [m]
constexpr float kRadius = 1.3f;          // of neighbours
constexpr double kVoted = 0.33;          // share of the aligned models that are there by votes
constexpr float kParallel = 4 * static_cast<float>(kDegree);

std::vector<Descriptor> describe(const PlaceSignature& place) {
  constexpr float kPi = 180 * static_cast<float>(kDegree), kSmallArea = 0.02f,
                  kBaseboard = 0.15f;  // [m^2], [m]
  std::vector<Descriptor> all;
  const auto add = [&all](Kind kind, float precise, float b, float c, float d, float e, float heading) {
    all.push_back({{kKindDistance * static_cast<float>(kind) + precise, b, c, d, e}, heading});
  };
  for (const Wall& w : place.walls) {
    const float x = w.cosine / kHeadingStd, y = w.sine / kHeadingStd, offset = w.offset / kPositionStd,
                middle = 0.5f * (w.right + w.left) / kPositionStd;
    const float area = w.weight * w.weight * w.weight * w.weight;
    add(kWall, std::log(area + kSmallArea) / kSizeStd, x, y, offset, middle, w.heading);
    if (w.top_end) add(kTop, w.top / kEdgeStd, x, y, offset, middle, w.heading);
    if (w.bottom_end && w.bottom > kBaseboard)
      add(kBottom, w.bottom / kEdgeStd, x, y, offset, middle, w.heading);
    for (const Wall& other : place.walls) {
      const float turn = std::abs(std::remainder(other.heading - w.heading, 2 * kPi));
      const float other_middle = 0.5f * (other.right + other.left) / kPositionStd;
      if (&other == &w) continue;
      if (turn < kParallel && w.offset <= other.offset)
        add(kSameWay, (other.offset - w.offset) / kDifferenceStd, x, y, offset, other_middle - middle,
            w.heading);
      else if (turn > kPi - kParallel && w.heading >= 0)
        add(kAcross, (other.offset + w.offset) / kDifferenceStd, x, y, offset, other_middle + middle,
            w.heading);
    }
  }
  for (const LevelSurface& s : place.surfaces)
    add(s.from_below ? kCeiling : kSurface, s.height / kHeightStd, s.x / kPositionStd, s.y / kPositionStd, 0,
        0, std::numeric_limits<float>::quiet_NaN());
  return all;
}

// Headings of a model relative to a view; two neighbouring bins count as one. The last bin is for what has
// none.
constexpr float kLargestTurn = 60 * static_cast<float>(kDegree), kTurnBin = 4 * static_cast<float>(kDegree);
constexpr int kTurnBins = 31, kNoTurn = kTurnBins, kBins = kTurnBins + 1;

using Index = flann::KDTreeSingleIndex<flann::L2_Simple<float>>;

}  // namespace

struct PlaceIndex::Impl {
  PlaceIndexParams params;
  PosePriorParams prior;
  CameraMounting mounting;
  std::vector<PlaceSignature> places;
  std::vector<float> points;    // kDimensions each
  std::vector<int> owner;       // model of each descriptor
  std::vector<float> heading;   // of each descriptor
  std::vector<float> expected;  // of each model: grows with the votes that it gets anyway
  std::unique_ptr<Index> tree;

  std::vector<float> votes(const PlaceSignature& scene) const;
};

PlaceIndex::PlaceIndex(const Map& map, const PlaceIndexParams& params, const PosePriorParams& prior) {
  if (!map.mounting)
    throw std::invalid_argument("PlaceIndex: the map does not tell how its camera is mounted");
  auto impl = std::make_unique<Impl>();
  impl->params = params;
  impl->prior = prior;
  impl->mounting = *map.mounting;
  const int n = static_cast<int>(map.models.size());
  constexpr float kBaseCount = 5;
  for (int m = 0; m < n; ++m) {
    impl->places.push_back(placeSignature(map.models[m].view, *map.mounting, prior));
    const std::vector<Descriptor> descriptors = describe(impl->places.back());
    for (const Descriptor& d : descriptors) {
      impl->points.insert(impl->points.end(), d.at.begin(), d.at.end());
      impl->owner.push_back(m);
      impl->heading.push_back(d.heading);
    }
    impl->expected.push_back(std::sqrt(static_cast<float>(descriptors.size()) + kBaseCount));
  }
  if (!impl->owner.empty()) {
    constexpr int kLeaf = 10;
    impl->tree =
        std::make_unique<Index>(flann::Matrix<float>(impl->points.data(), impl->owner.size(), kDimensions),
                                flann::KDTreeSingleIndexParams(kLeaf, true));
    impl->tree->buildIndex();
  }
  impl_ = std::move(impl);
}

PlaceIndex::PlaceIndex(PlaceIndex&&) noexcept = default;
PlaceIndex& PlaceIndex::operator=(PlaceIndex&&) noexcept = default;
PlaceIndex::~PlaceIndex() = default;

std::vector<float> PlaceIndex::Impl::votes(const PlaceSignature& scene) const {
  std::vector<Descriptor> asked = describe(scene);
  std::vector<float> total(places.size(), 0);
  if (!tree || asked.empty()) return total;
  std::vector<float> sums(places.size() * kBins, 0), nearest(places.size() * kBins, 0);
  std::vector<int> cells;
  std::vector<std::vector<int>> found;
  std::vector<std::vector<float>> distances;
  const flann::SearchParams unlimited(flann::FLANN_CHECKS_UNLIMITED, 0, false);
  for (Descriptor& d : asked) {
    tree->radiusSearch(flann::Matrix<float>(d.at.data(), 1, kDimensions), found, distances, kRadius * kRadius,
                       unlimited);
    cells.clear();
    int models = 0;
    for (std::size_t i = 0; i < found[0].size(); ++i) {
      const int id = found[0][i];
      int bin = kNoTurn;
      if (std::isfinite(d.heading)) {
        const float turn = std::remainder(heading[id] - d.heading, 360 * static_cast<float>(kDegree));
        if (std::abs(turn) > kLargestTurn) continue;
        bin = static_cast<int>((turn + kLargestTurn) / kTurnBin);
      }
      const int cell = owner[id] * kBins + bin;
      if (nearest[cell] == 0) cells.push_back(cell);
      nearest[cell] = std::max(nearest[cell], std::exp(-0.5f * distances[0][i]));
    }
    std::sort(cells.begin(), cells.end());
    for (std::size_t i = 0; i < cells.size(); ++i)
      models += i == 0 || cells[i] / kBins != cells[i - 1] / kBins;
    const float rarity =
        std::log((static_cast<float>(places.size()) + 1) / static_cast<float>(std::max(models, 1)));
    for (const int cell : cells) {
      sums[cell] += rarity * nearest[cell];
      nearest[cell] = 0;
    }
  }
  for (std::size_t m = 0; m < places.size(); ++m) {
    const float* bins = &sums[m * kBins];
    float best = 0;
    for (int b = 0; b + 1 < kTurnBins; ++b) best = std::max(best, bins[b] + bins[b + 1]);
    total[m] = (best + bins[kNoTurn]) / expected[m];
  }
  return total;
}

std::vector<int> PlaceIndex::shortlist(const View& view, int n) const {
  const PlaceSignature scene = placeSignature(view, impl_->mounting, impl_->prior);
  if (n <= 0 || (scene.walls.empty() && scene.surfaces.empty())) return {};
  const auto byScore = [](const std::vector<float>& score) {
    return [&score](int a, int b) { return score[a] != score[b] ? score[a] > score[b] : a < b; };
  };
  PlaceAligner aligner;
  const std::size_t all = impl_->places.size();
  const auto kept = static_cast<std::size_t>(std::max(n, impl_->params.aligned_models));
  std::vector<int> order(all);
  std::iota(order.begin(), order.end(), 0);
  if (all > kept) {
    const std::vector<float> votes = impl_->votes(scene);
    const auto by_votes = static_cast<std::ptrdiff_t>(kVoted * static_cast<double>(kept)),
               by_outlook = static_cast<std::ptrdiff_t>(kept);
    std::nth_element(order.begin(), order.begin() + by_votes, order.end(), byScore(votes));
    std::vector<float> outlook(all, 0);
    for (auto m = order.begin() + by_votes; m != order.end(); ++m)
      outlook[*m] = aligner.outlook(scene, impl_->places[*m]);
    std::nth_element(order.begin() + by_votes, order.begin() + by_outlook, order.end(), byScore(outlook));
    order.resize(kept);
  }
  std::vector<float> score(all, 0);
  for (const int m : order) {
    const PlaceSignature& place = impl_->places[m];
    score[m] = aligner.align(scene, place).score;
  }
  const std::size_t listed = std::min(order.size(), static_cast<std::size_t>(n));
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(listed), order.end(),
                    byScore(score));
  order.resize(listed);
  const float hopeless =
      order.empty() ? 0 : score[order.front()] - static_cast<float>(impl_->params.shortlist_gap);
  while (!order.empty() && score[order.back()] < hopeless) order.pop_back();
  return order;
}

std::size_t PlaceIndex::models() const { return impl_->places.size(); }
std::size_t PlaceIndex::descriptors() const { return impl_->owner.size(); }

std::size_t PlaceIndex::bytes() const {
  std::size_t sum = sizeof *impl_;
  for (const PlaceSignature& p : impl_->places)
    sum += sizeof p + p.walls.capacity() * sizeof(Wall) + p.surfaces.capacity() * sizeof(LevelSurface) +
           p.picture.depth.capacity() * sizeof(std::uint16_t) + p.points.capacity() * sizeof(Eigen::Vector3f);
  sum += impl_->points.capacity() * sizeof(float) + impl_->owner.capacity() * sizeof(int) +
         (impl_->heading.capacity() + impl_->expected.capacity()) * sizeof(float);
  if (impl_->tree)
    sum += static_cast<std::size_t>(impl_->tree->usedMemory()) + impl_->points.size() * sizeof(float);
  return sum;
}

}  // namespace facetloc
