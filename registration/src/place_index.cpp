// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/binary_archive.h>
#include <facetloc/features/so3.h>
#include <facetloc/registration/place_alignment.h>
#include <facetloc/registration/place_index.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <flann/flann.hpp>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace facetloc {

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
void fields(Archive& archive, PlaceSignature& p) {
  archive(p.R_u_c, p.height, p.walls, p.surfaces, p.picture.camera, p.picture.depth);
}

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
constexpr std::size_t kSeen = 5;         // times as many as are aligned have an outlook; half of all at least
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
      const float turn = std::abs(wrapped(other.heading - w.heading));
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

// Keeps its own, reordered copy of the points.
using Tree = flann::KDTreeSingleIndex<flann::L2_Simple<float>>;
const flann::KDTreeSingleIndexParams kTreeParams(10, true);

auto byScore(const std::vector<float>& score) {
  return [&score](int a, int b) { return score[a] != score[b] ? score[a] > score[b] : a < b; };
}

// T_m_c of an alignment.
Eigen::Isometry3d cameraPose(const PlaceAlignment& a, const PlaceSignature& scene,
                             const PlaceSignature& model) {
  const Eigen::Matrix3f turn = Eigen::AngleAxisf(a.heading, Eigen::Vector3f::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3f to_camera = model.R_u_c.transpose();
  Eigen::Isometry3d T_m_c = Eigen::Isometry3d::Identity();
  T_m_c.linear() = Eigen::Quaternionf(to_camera * turn * scene.R_u_c).cast<double>().normalized().matrix();
  T_m_c.translation() = (to_camera * Eigen::Vector3f(a.x, a.y, scene.height - model.height)).cast<double>();
  return T_m_c;
}

/** What FLANN writes to a C stream and reads from one. */
class TreeBytes {
public:
  TreeBytes() : file_(std::tmpfile(), std::fclose) {
    if (!file_) throw std::runtime_error("PlaceIndex: there is no room for a temporary file");
  }
  std::vector<char> of(Tree& tree) {
    tree.saveIndex(file_.get());
    std::vector<char> bytes(static_cast<std::size_t>(std::ftell(file_.get())));
    std::rewind(file_.get());
    require(std::fread(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size());
    return bytes;
  }
  std::unique_ptr<Tree> tree(const std::vector<char>& bytes, std::size_t points) {
    require(std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size());
    std::rewind(file_.get());
    // FLANN wants points of that number, though it reads and uses its own.
    std::vector<float> none(points * kDimensions);
    auto tree = std::make_unique<Tree>(flann::Matrix<float>(none.data(), points, kDimensions), kTreeParams);
    tree->loadIndex(file_.get());
    return tree;
  }

private:
  static void require(bool done) {
    if (!done) throw std::runtime_error("PlaceIndex: a temporary file cannot be used");
  }
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

/** What a written index depends on. */
struct Header {
  std::string format = "facetloc place index 1";  // changes with signatures and descriptors
  std::size_t models = 0;
  double height = 0, tilt_deg = 0;  // of the camera
  Eigen::Matrix3d floor = Eigen::Matrix3d::Zero();

  Header() = default;
  Header(const Map& map, const PosePriorParams& prior)
      : models(map.models.size()),
        height(map.mounting->height),
        tilt_deg(map.mounting->tilt_deg),
        floor(floorCovariance(prior)) {}
  bool operator==(const Header& o) const {
    return format == o.format && models == o.models && height == o.height && tilt_deg == o.tilt_deg &&
           floor == o.floor;
  }
};

}  // namespace

template <class Archive>
void fields(Archive& archive, Header& h) {
  archive(h.format, h.models, h.height, h.tilt_deg, h.floor);
}

struct PlaceIndex::Impl {
  PlaceIndexParams params;
  PosePriorParams prior;
  CameraMounting mounting;
  Header header;
  std::vector<PlaceSignature> places;
  std::vector<int> owner;       // model of each descriptor
  std::vector<float> heading;   // of each descriptor
  std::vector<float> expected;  // of each model: grows with the votes that it gets anyway
  std::unique_ptr<Tree> tree;   // of the descriptors; null without any

  Impl(const Map& map, const PlaceIndexParams& params, const PosePriorParams& prior);
  void build(const Map& map);
  void expectVotes();
  std::vector<int> likeliest(const PlaceSignature& scene, PlaceAligner& aligner, int n) const;
  std::vector<float> votes(const PlaceSignature& scene) const;
};

PlaceIndex::Impl::Impl(const Map& map, const PlaceIndexParams& index_params,
                       const PosePriorParams& pose_prior)
    : params(index_params), prior(pose_prior) {
  if (!map.mounting)
    throw std::invalid_argument("PlaceIndex: the map does not tell how its camera is mounted");
  mounting = *map.mounting;
  header = Header(map, prior);
}

void PlaceIndex::Impl::build(const Map& map) {
  std::vector<float> points;  // kDimensions each
  const int n = static_cast<int>(map.models.size());
  for (int m = 0; m < n; ++m) {
    places.push_back(placeSignature(*map.view(m), mounting, prior));
    for (const Descriptor& d : describe(places.back())) {
      points.insert(points.end(), d.at.begin(), d.at.end());
      owner.push_back(m);
      heading.push_back(d.heading);
    }
  }
  expectVotes();
  if (owner.empty()) return;
  tree = std::make_unique<Tree>(flann::Matrix<float>(points.data(), owner.size(), kDimensions), kTreeParams);
  tree->buildIndex();
}

void PlaceIndex::Impl::expectVotes() {
  constexpr float kBaseCount = 5;
  expected.assign(places.size(), kBaseCount);
  for (const int m : owner) ++expected[static_cast<std::size_t>(m)];
  for (float& e : expected) e = std::sqrt(e);
}

PlaceIndex::PlaceIndex(const Map& map, const PlaceIndexParams& params, const PosePriorParams& prior) {
  auto impl = std::make_unique<Impl>(map, params, prior);
  impl->build(map);
  impl_ = std::move(impl);
}

PlaceIndex::PlaceIndex(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}

PlaceIndex PlaceIndex::of(const Map& map, const PlaceIndexParams& params, const PosePriorParams& prior) {
  const auto written = map.store ? map.store->placeIndex() : nullptr;
  auto read = written ? PlaceIndex::read(*written, map, params, prior) : std::nullopt;
  return read ? std::move(*read) : PlaceIndex(map, params, prior);
}

void PlaceIndex::write(std::ostream& out) const {
  BinaryWriter archive(out);
  archive(impl_->header, impl_->places, impl_->owner, impl_->heading);
  if (impl_->tree) archive(TreeBytes().of(*impl_->tree));
}

std::optional<PlaceIndex> PlaceIndex::read(std::istream& in, const Map& map, const PlaceIndexParams& params,
                                           const PosePriorParams& prior) {
  auto impl = std::make_unique<Impl>(map, params, prior);
  BinaryReader archive(in);
  Header written;
  archive(written);
  if (!(written == impl->header)) return std::nullopt;
  archive(impl->places, impl->owner, impl->heading);
  const int models = static_cast<int>(map.models.size());
  if (impl->places.size() != map.models.size() || impl->heading.size() != impl->owner.size() ||
      !std::all_of(impl->owner.begin(), impl->owner.end(), [models](int m) { return 0 <= m && m < models; }))
    throw std::runtime_error("PlaceIndex: these bytes are not an index");
  impl->expectVotes();
  if (!impl->owner.empty()) {
    std::vector<char> tree;
    archive(tree);
    impl->tree = TreeBytes().tree(tree, impl->owner.size());
  }
  return PlaceIndex(std::move(impl));
}

PlaceIndex::PlaceIndex(PlaceIndex&&) noexcept = default;
PlaceIndex& PlaceIndex::operator=(PlaceIndex&&) noexcept = default;
PlaceIndex::~PlaceIndex() = default;

// At most n models, by votes and by outlook.
std::vector<int> PlaceIndex::Impl::likeliest(const PlaceSignature& scene, PlaceAligner& aligner,
                                             int n) const {
  std::vector<int> order(places.size());
  std::iota(order.begin(), order.end(), 0);
  if (order.size() <= static_cast<std::size_t>(n)) return order;
  const std::vector<float> by_vote = votes(scene);
  const std::size_t seen = std::max(kSeen * static_cast<std::size_t>(n), order.size() / 2);
  if (seen < order.size()) {
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(seen), order.end(),
                     byScore(by_vote));
    order.resize(seen);
  }
  const auto voted = order.begin() + static_cast<std::ptrdiff_t>(kVoted * n), last = order.begin() + n;
  std::nth_element(order.begin(), voted, order.end(), byScore(by_vote));
  std::vector<float> outlook(places.size(), 0);
  for (auto m = voted; m != order.end(); ++m) outlook[*m] = aligner.outlook(places[*m]);
  std::nth_element(voted, last, order.end(), byScore(outlook));
  order.erase(last, order.end());
  return order;
}

std::vector<float> PlaceIndex::Impl::votes(const PlaceSignature& scene) const {
  std::vector<Descriptor> asked = describe(scene);
  std::vector<float> total(places.size(), 0);
  if (!tree || asked.empty()) return total;
  std::vector<float> sums(places.size() * kBins, 0), nearest(places.size() * kBins, 0);
  std::vector<const Descriptor*> last(places.size(), nullptr);  // that a model has something like
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
        const float turn = wrapped(heading[id] - d.heading);
        if (std::abs(turn) > kLargestTurn) continue;
        bin = static_cast<int>((turn + kLargestTurn) / kTurnBin);
      }
      const int cell = owner[id] * kBins + bin;
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
    const float* bins = &sums[m * kBins];
    float best = 0;
    for (int b = 0; b + 1 < kTurnBins; ++b) best = std::max(best, bins[b] + bins[b + 1]);
    total[m] = (best + bins[kNoTurn]) / expected[m];
  }
  return total;
}

std::vector<int> PlaceIndex::shortlist(const View& view, int n) const {
  std::vector<int> models;
  for (const Candidate& candidate : candidates(view, n)) models.push_back(candidate.model);
  return models;
}

std::vector<Candidate> PlaceIndex::candidates(const View& view, int n) const {
  const PlaceSignature scene = placeSignature(view, impl_->mounting, impl_->prior);
  if (n <= 0 || (scene.walls.empty() && scene.surfaces.empty())) return {};
  PlaceAligner aligner(scene);
  std::vector<int> order = impl_->likeliest(scene, aligner, std::max(n, impl_->params.aligned_models));
  std::vector<PlaceAlignment> found(impl_->places.size());
  for (const int m : order) found[m] = aligner.align(impl_->places[m]);
  const std::size_t listed = std::min(order.size(), static_cast<std::size_t>(n));
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(listed), order.end(),
                    [&found](int a, int b) {
                      return found[a].score != found[b].score ? found[a].score > found[b].score : a < b;
                    });
  const auto gap = static_cast<float>(impl_->params.shortlist_gap);
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < listed && found[order[i]].score >= found[order[0]].score - gap; ++i) {
    const PlaceAlignment& a = found[order[i]];
    Candidate candidate{order[i], static_cast<int>(i), {}};
    if (impl_->params.start_translation > 0 && a.score > PlaceAlignment{}.score)
      candidate.start = cameraPose(a, scene, impl_->places[order[i]]);
    candidates.push_back(candidate);
  }
  return candidates;
}

std::size_t PlaceIndex::models() const { return impl_->places.size(); }
std::size_t PlaceIndex::descriptors() const { return impl_->owner.size(); }

std::size_t PlaceIndex::bytes() const {
  std::size_t sum = sizeof *impl_;
  for (const PlaceSignature& p : impl_->places)
    sum += sizeof p + p.walls.capacity() * sizeof(Wall) + p.surfaces.capacity() * sizeof(LevelSurface) +
           p.picture.depth.capacity() * sizeof(std::uint16_t);
  sum += impl_->owner.capacity() * sizeof(int) +
         (impl_->heading.capacity() + impl_->expected.capacity()) * sizeof(float);
  // FLANN does not count its points, nor that it keeps a pointer to each and its number.
  constexpr std::size_t kPoint = kDimensions * sizeof(float) + sizeof(float*) + sizeof(std::size_t);
  if (impl_->tree) sum += static_cast<std::size_t>(impl_->tree->usedMemory()) + impl_->owner.size() * kPoint;
  return sum;
}

}  // namespace facetloc
