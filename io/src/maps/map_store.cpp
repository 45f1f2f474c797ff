// SPDX-License-Identifier: BSD-3-Clause
#include "maps/map_reader.h"
#include "maps/map_schema.h"

#include <facetloc/io/map_database.h>

#include <algorithm>
#include <fmt/format.h>
#include <list>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

using namespace map_rows;
using namespace sqlite;

/** The view of one local model as its file has it. */
struct PackedView {
  std::string file, cause;  // for errors
  View view;                // without its picture
  std::optional<PackedPicture> picture;

  /** Needs the file no more. Throws IoError if the view is not sound. */
  View unpacked() && {
    if (picture) view.depth = sqlite::naming(file, cause, [this] { return map_rows::unpacked(*picture); });
    return std::move(view);
  }
};

/** The rows that a prepared statement has for a model. Left open, they would keep others from writing. */
class RowsOf {
public:
  RowsOf(Statement& statement, int model) : statement_(statement) { statement_ << model; }
  RowsOf(const RowsOf&) = delete;
  RowsOf& operator=(const RowsOf&) = delete;
  ~RowsOf() { statement_.reset(); }
  Statement* operator->() const { return &statement_; }
  Statement& row() const { return statement_; }

private:
  Statement& statement_;
};

std::string ofModel(const char* columns, const char* table, const char* model) {
  return schema::select(columns, table) + " WHERE " + model + " = ?";
}

/** Looks up views of local models, one at a time. */
class ViewReader {
public:
  /** \param noise of views without a picture */
  ViewReader(Connection& db, const DepthNoise& noise)
      : db_(db),
        usual_noise_(noise),
        of_model_(db, ofModel(schema::kModelColumns, "model", "id")),
        segments_(db, ofModel(schema::kSegmentColumns, "segment", "model_id") + " ORDER BY idx"),
        picture_(db, ofModel(schema::kPictureColumns, "depth_picture", "model_id")) {
    if (hasGravity(db)) gravity_.emplace(db, ofModel(schema::kGravityColumns, "gravity", "model_id"));
  }

  /** Throws IoError if it is missing or invalid. */
  PackedView read(int model) {
    PackedView packed{db_.name(), fmt::format("is not sound: model {}: ", model), {}, {}};
    sqlite::naming(packed.file, packed.cause, [&] { read(model, packed); });
    return packed;
  }

private:
  void read(int model, PackedView& packed) {
    View& view = packed.view;
    const RowsOf of_model(of_model_, model);
    require(of_model->step(), "there is no such model");
    of_model->skip(1);
    const ModelRow of_file = readModel(of_model.row());
    view.intrinsics = of_file.intrinsics;
    view.depth.noise = usual_noise_;

    const RowsOf segment(segments_, model);
    while (segment->step()) {
      segment->skip(1);
      require(segment->integer() == static_cast<int>(view.segments.size()), "its segment numbers have a gap");
      view.segments.push_back(readSegment(segment.row()));
    }
    require(of_file.num_segments == static_cast<int>(view.segments.size()), "num_segments is wrong");

    if (gravity_) {
      const RowsOf gravity(*gravity_, model);
      if (gravity->step()) {
        gravity->skip(1);
        view.gravity = readGravity(gravity.row());
      }
    }

    const RowsOf picture(picture_, model);
    if (!picture->step()) return;
    picture->skip(1);
    packed.picture = readPicture(picture.row(), view.intrinsics);
  }

  Connection& db_;
  DepthNoise usual_noise_;
  Statement of_model_, segments_, picture_;  // statements for the model that is bound to them
  std::optional<Statement> gravity_;         // the same; nothing in a map without the table
};

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
