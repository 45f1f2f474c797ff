// SPDX-License-Identifier: BSD-3-Clause
#include "maps/map_reader.h"

#include "maps/map_schema.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/map_parts.h>

#include <fmt/format.h>
#include <set>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace map_rows;
using namespace sqlite;

std::string nameOf(int model, const std::string& name) { return fmt::format("model {} ('{}')", model, name); }

/** Maps that were made before gravity could be measured lack its table. */
bool hasGravity(Connection& db) {
  return Statement(db, "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = 'gravity'").step();
}

namespace {

/** Reads a map, skips invalid rows and lists them in faults(). For one reading each: reads one
 * snapshot; writers wait until it is destroyed. */
class MapReader {
public:
  /** All views, or none is kept, so that a large map takes little memory; or only their sizes are looked at.
   */
  enum class Views { keep, look_at, leave };

  explicit MapReader(Connection& db) : db_(db), snapshot_(db, "BEGIN") {}

  Map read(Views views) {
    readMeta();
    readCamera();
    readAmbiguity();
    readModels();
    if (views != Views::leave) readSegments();
    readGravity();
    readPictures(views);
    readLinks();
    for (std::size_t i = 0; i < views_.size() && views == Views::keep; ++i)
      map_.models[i].setView(std::move(views_[i]));
    return std::move(map_);
  }

  const std::vector<std::string>& faults() const { return faults_; }
  /** Throws IoError with the first fault, if there is one. */
  void requireSound() const {
    if (faults_.empty()) return;
    const std::string more =
        faults_.size() > 1 ? fmt::format(" (and {} more faults)", faults_.size() - 1) : "";
    throw IoError(db_.name(), fmt::format("is not sound: {}{}", faults_.front(), more));
  }

private:
  /** Calls a function for every row; a bad row is reported with its label, which the function may make
   * clearer.
   */
  template <typename Function>
  void forEachRow(const char* columns, const char* table, const char* order, const char* label,
                  const Function& function) {
    Statement row(db_, schema::select(columns, table) + " ORDER BY " + order);
    while (row.step()) {
      std::string of_row = label;
      try {
        function(row, of_row);
      } catch (const BadCell& e) {
        faults_.push_back(fmt::format("{}: {}", of_row, e.what()));
      }
    }
  }

  /** The model that a row belongs to. */
  std::size_t modelOf(int id, std::string& label) const {
    label += fmt::format(" of model {}", id);
    require(id >= 0 && id < static_cast<int>(map_.models.size()), "there is no such model");
    return static_cast<std::size_t>(id);
  }

  void readMeta() {
    forEachRow("key, value", "meta", "key", "a row of meta", [this](Statement& row, std::string&) {
      const std::string key = row.text();
      map_.meta[key] = row.text();
    });
    try {
      sureThresholdOf(map_);
    } catch (const std::invalid_argument& e) {
      faults_.push_back(e.what());
    }
  }

  void readCamera() {
    forEachRow(schema::kCameraColumns, "camera", "id", "the camera", [this](Statement& row, std::string&) {
      row.skip(1);
      map_.camera = map_rows::readCamera(row);
    });
  }

  void readAmbiguity() {
    forEachRow(schema::kAmbiguityColumns, "ambiguity", "id", "the ambiguity",
               [this](Statement& row, std::string&) {
                 row.skip(1);
                 map_.ambiguity = map_rows::readAmbiguity(row);
               });
  }

  void readModels() {
    forEachRow(schema::kModelColumns, "model", "id", "a row", [this](Statement& row, std::string& label) {
      const int index = static_cast<int>(map_.models.size());
      label = fmt::format("model {}", index);
      map_.models.emplace_back();  // even a bad model keeps its place, so that the next ones have theirs
      views_.emplace_back();
      num_segments_.push_back(0);
      require(row.integer() == index, "the model numbers have a gap before it");
      ModelRow read = readModel(row);
      map_.models.back() = std::move(read.model);
      views_.back().intrinsics = read.intrinsics;
      views_.back().depth.noise = map_.camera.noise;  // unless it has a picture
      num_segments_.back() = read.num_segments;
    });
  }

  void readSegments() {
    std::vector<int> found(map_.models.size(), 0);
    forEachRow(schema::kSegmentColumns, "segment", "model_id, idx", "a segment",
               [&](Statement& row, std::string& label) {
                 const int model_id = row.integer(), index = row.integer();
                 label = fmt::format("segment {}", index);
                 const std::size_t model = modelOf(model_id, label);
                 require(index == found[model]++, "the segment numbers have a gap before it");
                 views_[model].segments.push_back(readSegment(row));
               });
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i] != num_segments_[i])
        faults_.push_back(fmt::format("{}: num_segments says {}, but there are {}",
                                      nameOf(static_cast<int>(i), map_.models[i].name), num_segments_[i],
                                      found[i]));
  }

  void readGravity() {
    if (!hasGravity(db_)) return;
    forEachRow(schema::kGravityColumns, "gravity", "model_id", "the gravity",
               [this](Statement& row, std::string& label) {
                 View& view = views_[modelOf(row.integer(), label)];
                 view.gravity = map_rows::readGravity(row);
               });
  }

  /** Before anything is unpacked: the memory for all pictures, of two bytes a pixel and as much for each
   * of two extremes, must fit the size of the file. Pictures of real images pack to a third, ones of blank
   * walls to a hundredth. */
  void requireMemoryForPictures() {
    constexpr double kBytesPerPixel = 6, kAlways = 512e6, kMostPacked = 100;
    Statement sum(db_, "SELECT coalesce(sum(1.0 * width * height), 0), coalesce(sum(1.0 * length(data)), 0) "
                       "FROM depth_picture");
    sum.step();
    const double unpacked = kBytesPerPixel * sum.real(), in_file = sum.real();
    if (unpacked > kAlways + kMostPacked * in_file)
      throw IoError(db_.name(), fmt::format("is not sound: its depth pictures would take {} MB of memory",
                                            static_cast<long>(unpacked / 1e6)));
  }

  void readPictures(Views views) {
    const bool whole = views != Views::leave;
    if (whole) requireMemoryForPictures();
    forEachRow(whole ? schema::kPictureColumns : schema::kPictureHeadColumns, "depth_picture", "model_id",
               "the depth picture", [&](Statement& row, std::string& label) {
                 View& view = views_[modelOf(row.integer(), label)];
                 if (views == Views::leave)
                   readPictureHead(row, view.intrinsics);
                 else if (DepthPicture picture = unpacked(readPicture(row, view.intrinsics));
                          views == Views::keep)
                   view.depth = std::move(picture);
               });
  }

  void readLinks() {
    forEachRow(schema::kLinkColumns, "link", "id", "a link", [this](Statement& row, std::string& label) {
      label = fmt::format("link {}", row.integer());
      const Link link = readLink(row);
      require(linked_.emplace(link.from, link.to).second, "another one joins the same models");
      for (const int end : {link.from, link.to}) modelOf(end, label);
      map_.links.push_back(link);
    });
  }

  Connection& db_;
  sqlite::Transaction snapshot_;  // for which others that write wait
  Map map_;
  std::vector<View> views_;  // views of the models
  std::vector<int> num_segments_;
  std::set<std::pair<int, int>> linked_;
  std::vector<std::string> faults_;
};

}  // namespace

Map readSound(Connection& db, bool with_views) {
  MapReader reader(db);
  Map map = reader.read(with_views ? MapReader::Views::keep : MapReader::Views::leave);
  reader.requireSound();
  placeByLinks(map);
  return map;
}

void findFaults(Connection& db, std::vector<std::string>& faults) {
  MapReader reader(db);
  reader.read(MapReader::Views::look_at);
  faults.insert(faults.end(), reader.faults().begin(), reader.faults().end());
  const std::vector<std::string> of_index = place_index_parts::faults(db);
  faults.insert(faults.end(), of_index.begin(), of_index.end());
}

}  // namespace facetloc
