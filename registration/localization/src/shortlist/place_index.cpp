// SPDX-License-Identifier: BSD-3-Clause
#include "base/binary_archive.h"
#include "shortlist/coarse_aligner.h"

#include <facetloc/features/pose.h>
#include <facetloc/localization/place_index.h>

#include <boost/crc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <flann/flann.hpp>
#include <fmt/format.h>
#include <future>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace facetloc::internal {

template <class Archive>
void fields(Archive& archive, Wall& w) {
  archive(w.heading, w.cosine, w.sine, w.offset, w.right, w.left, w.bottom, w.top, w.weight, w.right_end,
          w.left_end, w.bottom_end, w.top_end);
}
template <class Archive>
void fields(Archive& archive, LevelSurface& s) {
  archive(s.height, s.from_below, s.x, s.y);
}
template <class Archive>
void fields(Archive& archive, PlaceDescriptor& p) {
  archive(p.R_u_c, p.height, p.main_heading, p.walls, p.surfaces, p.picture.camera, p.picture.depth);
  for (std::int32_t& first : p.facing) archive(first);
}

}  // namespace facetloc::internal

namespace facetloc {

using namespace internal;

namespace {

constexpr int kDimensions = 5;

/** A point in a space where neighbours are about one apart. */
struct Descriptor {
  std::array<float, kDimensions> at;
  float heading;  // heading of the wall [rad]
};

// Kinds are farther from each other than any neighbours.
enum Kind { kTop, kBottom };
constexpr float kKindDistance = 1000;

// How much things differ between two views of one place, standard deviations.
constexpr float kHeadingStd = 20 * static_cast<float>(kDegree), kPositionStd = 1;  // the prior's [m]
constexpr float kHeightStd = 0.08f;  // standard deviation of an upper or lower edge [m]
constexpr float kRadius = 1.3f;      // search radius of neighbours
// Weight of votes in the prescore, and of both in the score of an alignment.
constexpr float kVotesWeight = 0.3f, kPrescoreWeight = 0.1f;
constexpr float kNotAligned = -100;  // less than any alignment

std::vector<Descriptor> describe(const PlaceDescriptor& place) {
  constexpr float kBaseboard = 0.15f;  // [m]
  std::vector<Descriptor> all;
  for (const Wall& w : place.walls) {
    const auto add = [&](Kind kind, float height) {
      all.push_back(
          {{kKindDistance * static_cast<float>(kind) + height / kHeightStd, w.cosine / kHeadingStd,
            w.sine / kHeadingStd, w.offset / kPositionStd, 0.5f * (w.right + w.left) / kPositionStd},
           w.heading});
    };
    if (w.top_end) add(kTop, w.top);
    if (w.bottom_end && w.bottom > kBaseboard) add(kBottom, w.bottom);
  }
  return all;
}

// Headings of a model relative to a view; two neighbouring bins count as one.
constexpr float kLargestTurn = kReachTurnDeg * static_cast<float>(kDegree),
                kTurnBin = 4 * static_cast<float>(kDegree);
constexpr int kTurnBins = 31;

// Keeps its own, reordered copy of the points.
using Tree = flann::KDTreeSingleIndex<flann::L2_Simple<float>>;
const flann::KDTreeSingleIndexParams kTreeParams(10, true);

/** The n best models, the best first; ties by index. */
void keepBest(const std::vector<float>& score, int n, std::vector<int>& models) {
  const auto isBetter = [&score](int a, int b) { return score[a] != score[b] ? score[a] > score[b] : a < b; };
  if (static_cast<std::size_t>(n) < models.size()) {
    std::nth_element(models.begin(), models.begin() + n, models.end(), isBetter);
    models.resize(static_cast<std::size_t>(n));
  }
  std::sort(models.begin(), models.end(), isBetter);
}

/** Asks for elements that are needed soon: those of places are all over the memory. */
template <class T>
void prefetch(const std::vector<T>& values) {
  constexpr std::size_t kLine = 64;
  const char* bytes = reinterpret_cast<const char*>(values.data());
  for (std::size_t i = 0; i < values.size() * sizeof(T); i += kLine) __builtin_prefetch(bytes + i);
}

// T_m_c of an alignment.
Eigen::Isometry3d cameraPose(const PlaceAlignment& a, const PlaceDescriptor& scene,
                             const PlaceDescriptor& model) {
  const Eigen::Matrix3f turn = Eigen::AngleAxisf(a.heading, Eigen::Vector3f::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3f to_camera = model.R_u_c.transpose();
  Eigen::Isometry3d T_m_c = Eigen::Isometry3d::Identity();
  T_m_c.linear() = Eigen::Quaternionf(to_camera * turn * scene.R_u_c).cast<double>().normalized().matrix();
  T_m_c.translation() = (to_camera * Eigen::Vector3f(a.x, a.y, scene.height - model.height)).cast<double>();
  return T_m_c;
}

/** Checksum of all models' names and stamps in their order, which a map knows without its views. */
std::uint32_t checksumOfNames(const Map& map) {
  boost::crc_32_type sum;
  for (const LocalModel& m : map.models) {
    sum.process_bytes(m.name.c_str(), m.name.size() + 1);
    sum.process_bytes(&m.stamp, sizeof m.stamp);
  }
  return sum.checksum();
}

constexpr const char* kFormat = "facetloc place index 1.0";  // changes with descriptors

/** The data that a written index depends on. */
struct Header {
  std::string format = kFormat;
  std::size_t models = 0;
  std::uint32_t names = 0;
  Vector6d mounting = Vector6d::Zero();  // mounting of the camera
  Eigen::Matrix3d floor = Eigen::Matrix3d::Zero();

  Header() = default;
  Header(const Map& map, const PosePriorParams& prior)
      : models(map.models.size()), names(checksumOfNames(map)), floor(floorCovariance(prior)) {
    const CameraMounting& m = *map.camera.mounting;
    mounting << m.height, m.tilt_deg, m.roll_deg, m.pan_deg, m.x, m.y;
  }
  bool isOf(const Header& o) const {
    return format == o.format && models == o.models && names == o.names && mounting == o.mounting &&
           floor == o.floor;
  }
};

template <class Archive>
void fields(Archive& archive, Header& h) {
  archive(h.format, h.models, h.names, h.mounting, h.floor);
}

}  // namespace

struct PlaceIndex::Impl {
  ShortlistParams params;
  PosePriorParams prior;
  CameraMounting mounting;
  Header header;
  std::vector<PlaceDescriptor> places;
  std::vector<int> owner;                                // model of each descriptor
  std::vector<float> heading;                            // heading of each descriptor
  std::vector<float> expected;                           // expected votes of each model by chance
  std::shared_future<std::shared_ptr<const Tree>> tree;  // index of the descriptors; null without any

  Impl(const Map& map, const ShortlistParams& params, const PosePriorParams& prior);
  void describePlaces();
  std::vector<float> prescores(const PlaceDescriptor& scene) const;
  std::vector<float> votes(const PlaceDescriptor& scene) const;
};

PlaceIndex::Impl::Impl(const Map& map, const ShortlistParams& index_params, const PosePriorParams& pose_prior)
    : params(index_params), prior(pose_prior) {
  if (!map.camera.mounting)
    throw std::invalid_argument("PlaceIndex: the map does not tell how its camera is mounted");
  mounting = *map.camera.mounting;
  header = Header(map, prior);
}

// Makes the descriptors of all places, and begins to build their search tree: a second for 10 000 places, in
// which the first view can be read and segmented.
void PlaceIndex::Impl::describePlaces() {
  std::vector<float> points;  // kDimensions each
  for (std::size_t m = 0; m < places.size(); ++m)
    for (const Descriptor& d : describe(places[m])) {
      points.insert(points.end(), d.at.begin(), d.at.end());
      owner.push_back(static_cast<int>(m));
      heading.push_back(d.heading);
    }
  constexpr float kBaseCount = 5;
  expected.assign(places.size(), kBaseCount);
  for (const int m : owner) ++expected[static_cast<std::size_t>(m)];
  for (float& e : expected) e = std::sqrt(e);
  if (owner.empty()) return;
  tree = std::async(std::launch::async, [points = std::move(points)]() mutable {
    const flann::Matrix<float> matrix(points.data(), points.size() / kDimensions, kDimensions);
    auto built = std::make_shared<Tree>(matrix, kTreeParams);
    built->buildIndex();
    return std::shared_ptr<const Tree>(std::move(built));
  });
}

PlaceIndex::PlaceIndex(const Map& map, const ShortlistParams& params, const PosePriorParams& prior) {
  auto impl = std::make_unique<Impl>(map, params, prior);
  const int n = static_cast<int>(map.models.size());
  for (int m = 0; m < n; ++m)
    impl->places.push_back(placeDescriptor(*map.view(m), impl->mounting, impl->prior));
  impl->describePlaces();
  impl_ = std::move(impl);
}

bool PlaceIndex::covers(const PoseWithCovariance& prior) {
  constexpr double kTurns = 3, kMoves = 2.8;  // standard deviations
  // Suffices for the usual prior of a camera high above an uneven floor, whose tilts also move it.
  constexpr double kTurn = 1.01 * kReachTurnDeg * kDegree, kMove = 1.1 * kReachMove;
  return rotationAngle(prior.T.linear()) + kTurns * largestRotationStd(prior.P) <= kTurn &&
         prior.T.translation().norm() + kMoves * largestTranslationStd(prior.P) <= kMove;
}

PlaceIndex::PlaceIndex(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}

PlaceIndex PlaceIndex::of(const Map& map, const ShortlistParams& params, const PosePriorParams& prior) {
  const auto written = map.store() ? map.store()->placeIndex() : nullptr;
  if (!written) return PlaceIndex(map, params, prior);
  try {
    auto read = PlaceIndex::read(*written, map, params, prior);
    return read ? std::move(*read) : PlaceIndex(map, params, prior);
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(fmt::format("{}: is not sound: {}", map.store()->name(), e.what()));
  }
}

void PlaceIndex::write(std::ostream& out) const {
  BinaryWriter archive(out);
  archive(impl_->header, impl_->places);
}

std::optional<PlaceIndex> PlaceIndex::read(std::istream& in, const Map& map, const ShortlistParams& params,
                                           const PosePriorParams& prior) {
  auto impl = std::make_unique<Impl>(map, params, prior);
  BinaryReader archive(in);
  Header written;
  archive(written);
  if (!written.isOf(impl->header)) return std::nullopt;
  archive(impl->places);
  if (impl->places.size() != map.models.size() ||
      !std::all_of(impl->places.begin(), impl->places.end(), isSound))
    throw std::runtime_error("its place index holds values that no index has");
  impl->describePlaces();
  return PlaceIndex(std::move(impl));
}

PlaceIndex::PlaceIndex(PlaceIndex&&) noexcept = default;
PlaceIndex& PlaceIndex::operator=(PlaceIndex&&) noexcept = default;
PlaceIndex::~PlaceIndex() = default;

// The prescore of each model, before it is aligned.
std::vector<float> PlaceIndex::Impl::prescores(const PlaceDescriptor& scene) const {
  std::vector<float> score = votes(scene);
  const Prescore prescore(scene);
  constexpr std::size_t kAhead = 4;
  for (std::size_t m = 0; m < places.size(); ++m) {
    const PlaceDescriptor& ahead = places[std::min(m + kAhead, places.size() - 1)];
    prefetch(ahead.walls), prefetch(ahead.surfaces);
    score[m] = kVotesWeight * score[m] + prescore.of(places[m]);
  }
  return score;
}

std::vector<float> PlaceIndex::Impl::votes(const PlaceDescriptor& scene) const {
  std::vector<Descriptor> asked = describe(scene);
  std::vector<float> total(places.size(), 0);
  if (!tree.valid() || asked.empty()) return total;
  const Tree& descriptors = *tree.get();
  std::vector<float> sums(places.size() * kTurnBins, 0), nearest(places.size() * kTurnBins, 0);
  std::vector<const Descriptor*> last(places.size(), nullptr);  // that a model has something like
  std::vector<int> cells;
  std::vector<std::vector<int>> found;
  std::vector<std::vector<float>> distances;
  const flann::SearchParams unlimited(flann::FLANN_CHECKS_UNLIMITED, 0, false);
  for (Descriptor& d : asked) {
    descriptors.radiusSearch(flann::Matrix<float>(d.at.data(), 1, kDimensions), found, distances,
                             kRadius * kRadius, unlimited);
    cells.clear();
    int models = 0;
    for (std::size_t i = 0; i < found[0].size(); ++i) {
      const int id = found[0][i];
      const float turn = wrapped(heading[id] - d.heading);
      if (!(std::abs(turn) <= kLargestTurn)) continue;
      const int cell = owner[id] * kTurnBins + static_cast<int>((turn + kLargestTurn) / kTurnBin);
      if (nearest[cell] == 0) cells.push_back(cell);
      nearest[cell] = std::max(nearest[cell], std::exp(-0.5f * distances[0][i]));
      models += last[owner[id]] != &d;
      last[owner[id]] = &d;
    }
    const float rarity =
        std::log((static_cast<float>(places.size()) + 1) / static_cast<float>(std::max(models, 1)));
    for (const int cell : cells) {
      sums[cell] += rarity * nearest[cell];
      nearest[cell] = 0;
    }
  }
  for (std::size_t m = 0; m < places.size(); ++m) {
    const float* bins = &sums[m * kTurnBins];
    float best = 0;
    for (int b = 0; b + 1 < kTurnBins; ++b) best = std::max(best, bins[b] + bins[b + 1]);
    total[m] = best / expected[m];
  }
  return total;
}

std::vector<int> PlaceIndex::shortlist(const View& view, int n) const {
  std::vector<int> models;
  for (const ShortlistedModel& candidate : candidates(view, n)) models.push_back(candidate.model);
  return models;
}

std::vector<ShortlistedModel> PlaceIndex::candidates(const View& view, int n,
                                                     const std::function<bool(int)>& excluded) const {
  const ShortlistParams& params = impl_->params;
  const std::vector<PlaceDescriptor>& places = impl_->places;
  const PlaceDescriptor scene = placeDescriptor(view, impl_->mounting, impl_->prior);
  if (n <= 0 || (scene.walls.empty() && scene.surfaces.empty())) return {};

  const std::vector<float> prescore = impl_->prescores(scene);
  std::vector<int> models(places.size());
  std::iota(models.begin(), models.end(), 0);
  if (excluded) models.erase(std::remove_if(models.begin(), models.end(), excluded), models.end());
  if (models.empty()) return {};
  keepBest(prescore, std::max(n, params.aligned_models), models);

  CoarseAligner aligner(scene);
  std::vector<PlaceAlignment> found(places.size());
  std::vector<float> score(places.size());
  const auto gap = static_cast<float>(params.gap);
  float best = kNotAligned;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const int m = models[i];
    const PlaceDescriptor& ahead = places[models[std::min(i + 1, models.size() - 1)]];
    prefetch(ahead.walls), prefetch(ahead.picture.depth);
    found[m] = aligner.align(places[m], best - gap - kPrescoreWeight * prescore[m]);
    score[m] = std::max(found[m].score, kNotAligned) + kPrescoreWeight * prescore[m];
    best = std::max(best, score[m]);
  }
  keepBest(score, n, models);

  std::vector<ShortlistedModel> candidates;
  for (const int m : models) {
    if (score[m] < score[models.front()] - gap) break;
    ShortlistedModel candidate{m, static_cast<int>(candidates.size()), {}};
    if (params.start_translation > 0 && found[m].score > PlaceAlignment{}.score)
      candidate.start = cameraPose(found[m], scene, places[m]);
    candidates.push_back(candidate);
  }
  return candidates;
}

std::size_t PlaceIndex::models() const { return impl_->places.size(); }
std::size_t PlaceIndex::descriptors() const { return impl_->owner.size(); }

std::function<void(std::ostream&)> placeIndexOf(const Map& map) {
  constexpr std::size_t kSoonMade = 400;  // local models
  if (!map.camera.mounting || map.models.size() <= kSoonMade) return {};
  return [index = std::make_shared<const PlaceIndex>(map)](std::ostream& out) { index->write(out); };
}

}  // namespace facetloc
