// SPDX-License-Identifier: BSD-3-Clause
#include "map_reader.h"

#include "map_rows.h"
#include "map_schema.h"

#include <facetloc/features/map_parts.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace map_rows;
using sqlite::BadCell;
using sqlite::Connection;
using sqlite::Statement;

std::string nameOf(int model, const std::string& name) {
  return "model " + std::to_string(model) + " ('" + name + "')";
}

void MapReader::readAll(Pictures pictures) {
  readMeta();
  readCamera();
  readModels();
  if (pictures != Pictures::cameras_only) readSegments();
  readPictures(pictures);
  readNoise();
  readLookalikes();
  readLinks();
}

Map MapReader::read() {
  readAll(Pictures::keep);
  return std::move(map_);
}

void MapReader::check() { readAll(Pictures::look_at); }

Map MapReader::readWithoutViews() {
  readAll(Pictures::cameras_only);
  return std::move(map_);
}

void MapReader::requireSound() const {
  if (faults_.empty()) return;
  const std::string more =
      faults_.size() > 1 ? " (and " + std::to_string(faults_.size() - 1) + " more faults)" : "";
  throw IoError(db_.name(), "is not sound: " + faults_.front() + more);
}

Map readSound(sqlite::Connection& db, bool with_views) {
  MapReader reader(db);
  Map map = with_views ? reader.read() : reader.readWithoutViews();
  reader.requireSound();
  placeByLinks(map);
  return map;
}

/** Calls a function for every row; a bad row is reported with the label that the function has set so far. */
template <typename Function>
void MapReader::forEachRow(const std::string& sql, const Function& function) {
  Statement row(db_, sql);
  while (row.step()) {
    std::string label = "a row";
    try {
      function(row, label);
    } catch (const BadCell& e) {
      faults_.push_back(label + ": " + e.what());
    }
  }
}

/** The model that a row belongs to. */
LocalModel& MapReader::modelOf(int id, std::string& label) {
  label += " of model " + std::to_string(id);
  require(id >= 0 && id < static_cast<int>(map_.models.size()), "there is no such model");
  return map_.models[id];
}

void MapReader::readMeta() {
  forEachRow(schema::select("key, value", "meta", "key"), [this](Statement& row, std::string& label) {
    label = "a row of meta";
    const std::string key = row.text();
    map_.meta[key] = row.text();
  });
}

void MapReader::readCamera() {
  if (sqlite::hasTable(db_, "camera"))
    forEachRow(schema::select(schema::kCameraColumns, "camera", "id"),
               [this](Statement& row, std::string& label) {
                 label = "the camera";
                 row.skip(1);
                 map_.camera = map_rows::readCamera(row);
               });
  if (sqlite::hasTable(db_, "camera_range"))
    forEachRow(schema::select(schema::kRangeColumns, "camera_range", "id"),
               [this](Statement& row, std::string& label) {
                 label = "the range of the camera";
                 row.skip(1);
                 readRange(row, map_.camera);
               });
  forEachRow(schema::select("height, tilt_deg", "mounting", "id"),
             [this](Statement& row, std::string& label) {
               label = "the camera mounting";
               const double height = row.real(), tilt_deg = row.real();
               const CameraMounting mounting{height, tilt_deg};
               map_rows::requireSound(mounting);
               map_.camera.mounting = mounting;
             });
  if (map_.camera.mounting && sqlite::hasTable(db_, "mounting_turn"))
    forEachRow(schema::select(schema::kMountingTurnColumns, "mounting_turn", "id"),
               [this](Statement& row, std::string& label) {
                 label = "the camera mounting";
                 row.skip(1);
                 CameraMounting mounting = *map_.camera.mounting;
                 mounting.roll_deg = row.real(), mounting.pan_deg = row.real();
                 mounting.x = row.real(), mounting.y = row.real();
                 map_rows::requireSound(mounting);
                 map_.camera.mounting = mounting;
               });
  readDistortion();
  readAmbiguity();
}

void MapReader::readAmbiguity() {
  if (!sqlite::hasTable(db_, "ambiguity")) return;
  forEachRow(schema::select(schema::kAmbiguityColumns, "ambiguity", "id"),
             [this](Statement& row, std::string& label) {
               label = "the ambiguity";
               row.skip(1);
               map_.ambiguity = map_rows::readAmbiguity(row);
             });
}

void MapReader::readDistortion() {
  if (!sqlite::hasTable(db_, "distortion")) return;
  std::vector<Eigen::Vector2d> rays;
  DepthDistortion::Values values;
  forEachRow(schema::select(schema::kDistortionColumns, "distortion", "node"),
             [&](Statement& row, std::string& label) {
               label = "the distortion";
               require(rays.size() < values.size(), "it has too many nodes");
               require(row.integer() == static_cast<int>(rays.size()), "its node numbers have a gap");
               const double x = row.real(), y = row.real();
               values[rays.size()] = row.real();
               rays.emplace_back(x, y);
             });
  if (rays.empty()) return;
  try {
    require(rays.size() == values.size(), "it has too few nodes");
    map_.camera.distortion.emplace(Eigen::AlignedBox2d(rays.front(), rays.back()), values);
  } catch (const std::exception& e) {
    faults_.push_back(std::string("the distortion: ") + e.what());
  }
}

void MapReader::readModels() {
  forEachRow(
      schema::select(schema::kModelColumns, "model", "id"), [this](Statement& row, std::string& label) {
        const int index = static_cast<int>(map_.models.size());
        label = "model " + std::to_string(index);
        map_.models.emplace_back();  // even a bad model keeps its place, so that the next ones have theirs
        num_segments_.push_back(0);
        require(row.integer() == index, "the model numbers have a gap before it");
        map_.models.back() = readModel(row);
        num_segments_.back() = row.integer();
      });
}

void MapReader::readSegments() {
  std::vector<int> found(map_.models.size(), 0);
  forEachRow(schema::select(schema::kSegmentColumns, "segment", "model_id, idx"),
             [&](Statement& row, std::string& label) {
               label = "a segment";
               const int model_id = row.integer(), index = row.integer();
               label = "segment " + std::to_string(index);
               LocalModel& model = modelOf(model_id, label);
               require(index == found[model_id]++, "the segment numbers have a gap before it");
               model.view.segments.push_back(readSegment(row));
             });
  for (std::size_t i = 0; i < found.size(); ++i)
    if (found[i] != num_segments_[i])
      faults_.push_back(nameOf(static_cast<int>(i), map_.models[i].name) + ": num_segments says " +
                        std::to_string(num_segments_[i]) + ", but there are " + std::to_string(found[i]));
}

/** Before anything is unpacked: what all pictures would take, each of two bytes a pixel and as much for each
 * of two extremes, by what the file is large. Pictures of real images pack to a third, ones of blank walls to
 * a hundredth. */
void MapReader::requireMemoryForPictures() {
  constexpr double kBytesPerPixel = 6, kAlways = 512e6, kMostPacked = 100;
  Statement sum(db_, "SELECT coalesce(sum(1.0 * width * height), 0), coalesce(sum(1.0 * length(data)), 0) "
                     "FROM depth_picture");
  sum.step();
  const double unpacked = kBytesPerPixel * sum.real(), in_file = sum.real();
  if (unpacked > kAlways + kMostPacked * in_file)
    throw IoError(db_.name(), "is not sound: its depth pictures would take " +
                                  std::to_string(static_cast<long>(unpacked / 1e6)) + " MB of memory");
}

void MapReader::readPictures(Pictures pictures) {
  const bool whole = pictures != Pictures::cameras_only;
  if (whole) requireMemoryForPictures();
  forEachRow(schema::select(whole ? schema::kPictureColumns : schema::kPictureCameraColumns, "depth_picture",
                            "model_id"),
             [&](Statement& row, std::string& label) {
               label = "the depth picture";
               LocalModel& model = modelOf(row.integer(), label);
               const Intrinsics camera = readPictureCamera(row, model.view.intrinsics);
               DepthPicture picture;
               if (whole) picture = unpackedPicture(camera, readPackedPicture(row));
               if (pictures == Pictures::keep) model.view.depth = std::move(picture);
               model.view.depth.camera = camera;
             });
}

/** The camera's, of a file or a picture without it. */
void MapReader::readNoise() {
  for (LocalModel& model : map_.models) model.view.depth.noise = map_.camera.noise;
  if (!sqlite::hasTable(db_, "picture_noise")) return;
  forEachRow(schema::select(schema::kPictureNoiseColumns, "picture_noise", "model_id"),
             [&](Statement& row, std::string& label) {
               label = "the noise of the depth picture";
               LocalModel& model = modelOf(row.integer(), label);
               model.view.depth.noise = map_rows::readNoise(row);
             });
  if (!sqlite::hasTable(db_, "picture_range_noise")) return;
  forEachRow(schema::select(schema::kRangeNoiseColumns, "picture_range_noise", "model_id"),
             [&](Statement& row, std::string& label) {
               label = "the noise of the depth picture over its range";
               LocalModel& model = modelOf(row.integer(), label);
               readNoiseOverRange(row, model.view.depth.noise);
             });
}

void MapReader::readLookalikes() {
  if (!sqlite::hasTable(db_, "lookalike")) return;
  forEachRow(schema::select(schema::kLookalikeColumns, "lookalike", "model_id"),
             [&](Statement& row, std::string& label) {
               label = "the look-alikes";
               LocalModel& model = modelOf(row.integer(), label);
               const double score = row.real();
               map_rows::requirePossibleScore(score);
               model.lookalike_score = score;
             });
}

void MapReader::readLinks() {
  forEachRow(schema::select(schema::kLinkColumns, "link", "id"), [this](Statement& row, std::string& label) {
    label = "a link";
    label = "link " + std::to_string(row.integer());
    const Link link = readLink(row);
    require(linked_.emplace(link.from, link.to).second, "another one joins the same models");
    for (const int end : {link.from, link.to}) modelOf(end, label);
    map_.links.push_back(link);
  });
}

namespace {

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

}  // namespace

ViewReader::ViewReader(Connection& db, const DepthNoise& noise)
    : db_(db),
      usual_noise_(noise),
      of_model_(db, ofModel(schema::kModelColumns, "model", "id")),
      segments_(db, ofModel(schema::kSegmentColumns, "segment", "model_id") + " ORDER BY idx"),
      picture_(db, ofModel(schema::kPictureColumns, "depth_picture", "model_id")) {
  if (sqlite::hasTable(db, "picture_noise"))
    noise_.emplace(db, ofModel(schema::kPictureNoiseColumns, "picture_noise", "model_id"));
  if (sqlite::hasTable(db, "picture_range_noise"))
    range_noise_.emplace(db, ofModel(schema::kRangeNoiseColumns, "picture_range_noise", "model_id"));
}

PackedView ViewReader::read(int model) {
  PackedView packed;
  packed.file_ = db_.name();
  packed.label_ = "model " + std::to_string(model);
  View& view = packed.view_;
  try {
    const RowsOf of_model(of_model_, model);
    require(of_model->step(), "there is no such model");
    of_model->skip(1);
    view = readModel(of_model.row()).view;
    const int num_segments = of_model->integer();

    const RowsOf segment(segments_, model);
    while (segment->step()) {
      segment->skip(1);
      require(segment->integer() == static_cast<int>(view.segments.size()), "its segment numbers have a gap");
      view.segments.push_back(readSegment(segment.row()));
    }
    require(num_segments == static_cast<int>(view.segments.size()), "num_segments is wrong");

    const RowsOf picture(picture_, model);
    if (!picture->step()) return packed;
    picture->skip(1);
    view.depth.camera = readPictureCamera(picture.row(), view.intrinsics);
    packed.packed_ = readPackedPicture(picture.row());
    view.depth.noise = usual_noise_;
    if (!noise_) return packed;
    const RowsOf noise(*noise_, model);
    if (!noise->step()) return packed;
    noise->skip(1);
    view.depth.noise = readNoise(noise.row());
    if (!range_noise_) return packed;
    const RowsOf range(*range_noise_, model);
    if (!range->step()) return packed;
    range->skip(1);
    readNoiseOverRange(range.row(), view.depth.noise);
  } catch (const BadCell& e) {
    throw IoError(packed.file_, "is not sound: " + packed.label_ + ": " + e.what());
  }
  return packed;
}

View PackedView::unpacked() && {
  try {
    const DepthNoise noise = view_.depth.noise;
    if (!packed_.empty()) view_.depth = unpackedPicture(view_.depth.camera, packed_);
    view_.depth.noise = noise;
  } catch (const BadCell& e) {
    throw IoError(file_, "is not sound: " + label_ + ": " + e.what());
  }
  return std::move(view_);
}

}  // namespace facetloc
