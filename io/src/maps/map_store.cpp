// SPDX-License-Identifier: BSD-3-Clause
#include "maps/map_connection.h"
#include "maps/map_reader.h"
#include "maps/place_index_parts.h"

#include <facetloc/io/map_database.h>

#include <algorithm>
#include <fmt/format.h>
#include <list>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

using sqlite::Connection;
using sqlite::Statement;

/** Pixels of a usual depth picture, half of 320x240. */
constexpr std::size_t kUsualPixels = 160 * 120;

/** The views that were requested last, fewer if their pictures are larger than usual. */
class RecentViews {
public:
  explicit RecentViews(std::size_t most) : most_pixels_(most * kUsualPixels) {}

  std::shared_ptr<const View> find(int model) {
    const auto found = places_.find(model);
    if (found == places_.end()) return nullptr;
    views_.splice(views_.begin(), views_, found->second);
    return found->second->second;
  }
  void add(int model, std::shared_ptr<const View> view) {
    if (places_.count(model)) return;  // another thread was faster
    pixels_ += pixelsOf(*view);
    views_.emplace_front(model, std::move(view));
    places_[model] = views_.begin();
    while (pixels_ > most_pixels_ && views_.size() > 1) {
      pixels_ -= pixelsOf(*views_.back().second);
      places_.erase(views_.back().first);
      views_.pop_back();
    }
  }

private:
  /** Its segments take no more than a usual picture. */
  static std::size_t pixelsOf(const View& view) {
    return std::max(kUsualPixels, view.depth.inverse_depth.size());
  }

  using Views = std::list<std::pair<int, std::shared_ptr<const View>>>;
  std::size_t most_pixels_, pixels_ = 0;
  Views views_;  // the latest first
  std::unordered_map<int, Views::iterator> places_;
};

/** Flags the local models that have a depth picture. \param n number of models */
std::vector<bool> pictured(Connection& db, std::size_t n) {
  std::vector<bool> found(n, false);
  Statement row(db, fmt::format("SELECT model_id FROM depth_picture WHERE model_id BETWEEN 0 AND {} - 1", n));
  while (row.step()) found[static_cast<std::size_t>(row.integer())] = true;
  return found;
}

/** Reads views from a map file when they are asked for. */
class MapFileStore : public MapStore {
public:
  MapFileStore(Connection db, const Map& map, std::size_t views)
      : db_(std::move(db)),
        pictured_(pictured(db_, map.models.size())),
        reader_(db_, map.camera.noise),
        recent_(views) {}

  std::string name() const override { return db_.name(); }
  std::shared_ptr<const View> view(int i) const override {
    std::unique_lock<std::mutex> lock(mutex_);
    if (auto known = recent_.find(i)) return known;
    PackedView packed = reader_.read(i);
    lock.unlock();  // unpacking takes long
    auto view = std::make_shared<const View>(std::move(packed).unpacked());
    lock.lock();
    recent_.add(i, view);
    return view;
  }
  bool hasPicture(int i) const override { return pictured_[static_cast<std::size_t>(i)]; }
  std::unique_ptr<std::istream> placeIndex() const override { return place_index_parts::open(db_, mutex_); }

private:
  mutable std::mutex mutex_;
  mutable Connection db_;
  const std::vector<bool> pictured_;  // models
  mutable ViewReader reader_;
  mutable RecentViews recent_;
};

/** Can all views be in memory, as that many usual ones can? */
bool isSmall(Connection& db, std::size_t views) {
  Statement size(db, "SELECT (SELECT count(*) FROM model), "
                     "(SELECT coalesce(sum(1.0 * width * height), 0) FROM depth_picture)");
  size.step();
  const auto models = static_cast<std::size_t>(size.integer());
  return models <= views && size.real() <= static_cast<double>(views * kUsualPixels);
}

}  // namespace

Map openMap(const std::filesystem::path& path, std::size_t views_in_memory) {
  Connection db = map_connection::openForReading(path);
  const bool small = isSmall(db, views_in_memory);
  Map map = readSound(db, small);
  if (!small) map.setStore(std::make_shared<MapFileStore>(std::move(db), map, views_in_memory));
  return map;
}

}  // namespace facetloc
