// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "images/depth_blob.h"
#include "maps/map_reader.h"
#include "maps/map_schema.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/features/map_metadata.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/map_database.h>

#include <array>
#include <fmt/format.h>
#include <fstream>
#include <stdexcept>
#include <string_view>

namespace facetloc {
namespace {
using namespace map_connection;
using namespace map_rows;
using namespace sqlite;

bool isReserved(const std::string& key) { return key == kFormatKey || key == kConventionsKey; }

// Writing, inside a transaction of the caller.

/** Runs work that may fail, and names the item that it failed for. */
template <typename Work>
void describing(const Connection& db, const std::string& thing, const Work& work) {
  sqlite::naming(db.name(), fmt::format("cannot add {}: ", thing), work);
}

void insertMeta(Connection& db, const std::string& key, const std::string& value) {
  (Statement(db, "INSERT OR REPLACE INTO meta(key, value) VALUES(?, ?)") << key << value).run();
}

void insertCamera(Connection& db, const Camera& camera) {
  describing(db, "the camera", [&] { requireSound(camera); });
  db.execute("DELETE FROM camera");
  (Statement(db, schema::insert(schema::kCameraColumns, "camera")) << 0 << camera).run();
}

/** Removes findings about the map as it was. */
void removeFindings(Connection& db) {
  (Statement(db, "DELETE FROM meta WHERE key = ?") << kSureKey).run();
  if (!Statement(db, "SELECT 1 FROM ambiguity").step()) return;  // and no score of any model
  db.execute("DELETE FROM ambiguity; UPDATE model SET lookalike_score = NULL");
}

void insertAmbiguity(Connection& db, const MapAmbiguity& ambiguity,
                     const std::vector<std::optional<double>>& alias_scores) {
  describing(db, "the ambiguity", [&] {
    requireSound(ambiguity);
    for (const std::optional<double>& score : alias_scores)
      if (score) requirePossibleScore(*score);
  });
  removeFindings(db);
  Statement statement(db, schema::insert(schema::kAmbiguityColumns, "ambiguity"));
  (statement << 0 << ambiguity.score << ambiguity.views).run();
  Statement of_model(db, "UPDATE model SET lookalike_score = ? WHERE id = ?");
  for (std::size_t i = 0; i < alias_scores.size(); ++i)
    (of_model << alias_scores[i] << static_cast<int>(i)).run();
}

int nextId(Connection& db, const std::string& table) {
  Statement statement(db, "SELECT coalesce(max(id) + 1, 0) AS next_id FROM " + table);
  statement.step();
  return statement.integer();
}

void insertSegments(Connection& db, int model_id, const PackedModel& packed) {
  Statement statement(db, schema::insert(schema::kSegmentColumns, "segment"));
  for (std::size_t i = 0; i < packed.view.segments.size(); ++i) {
    const Segment& s = packed.view.segments[i];
    describing(db, fmt::format("segment {} of {}", i, nameOf(model_id, packed.model.name)),
               [&] { requireSound(s); });
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = s.R;
    T.translation() = s.t;
    statement << model_id << static_cast<int>(i) << T;
    bindUpperTriangle(statement, s.Sigma_q);
    statement << s.lambda[0] << s.lambda[1] << s.num_points << hullBlob(s.hull);
    statement.run();
  }
}

void insertPicture(Connection& db, int model_id, const PackedModel& packed) {
  if (packed.depth.empty()) return;
  const DepthNoise& of_picture = packed.view.depth.noise;
  describing(db, nameOf(model_id, packed.model.name), [&] {
    requireSizeOfPicture(packed.view.depth.camera, packed.view.intrinsics);
    requireSound(of_picture);
  });
  Statement statement(db, schema::insert(schema::kPictureColumns, "depth_picture"));
  (statement << model_id << packed.view.depth.camera << of_picture << std::string(depth_blob::kEncoding)
             << packed.depth)
      .run();
}

void insertGravity(Connection& db, int model_id, const PackedModel& packed) {
  if (!packed.view.gravity) return;
  const Gravity& gravity = *packed.view.gravity;
  describing(db, nameOf(model_id, packed.model.name), [&] { requireSound(gravity); });
  if (!hasGravity(db)) db.execute(schema::kGravityTable);
  Statement statement(db, schema::insert(schema::kGravityColumns, "gravity"));
  (statement << model_id << gravity.down.x() << gravity.down.y() << gravity.down.z() << gravity.std).run();
}

int insertModel(Connection& db, const PackedModel& packed) {
  const LocalModel& model = packed.model;
  const int id = nextId(db, "model");
  describing(db, nameOf(id, model.name), [&] { requireSound(model, packed.view); });
  Statement statement(db, schema::insert(schema::kModelColumns, "model"));
  statement << id << model.name << model.stamp;
  statement << model.givenPose();
  statement << packed.view.intrinsics << static_cast<int>(packed.view.segments.size()) << nullptr;
  statement.run();
  insertSegments(db, id, packed);
  insertPicture(db, id, packed);
  insertGravity(db, id, packed);
  place_index_parts::remove(db);  // it does not know this model
  removeFindings(db);
  return id;
}

/** Packs it first, if there is sense in it. */
int insertModel(Connection& db, const LocalModel& model, const View& view) {
  describing(db, nameOf(nextId(db, "model"), model.name), [&] { requireSound(model, view); });
  return insertModel(db, packed(model, view));
}

void insertLink(Connection& db, const Link& link) {
  describing(db, fmt::format("link {} -> {}", link.from, link.to), [&] { requireSound(link); });
  Statement statement(db, schema::insert(schema::kLinkColumns, "link"));
  statement << nextId(db, "link") << link.from << link.to << link.T_from_to.T;
  bindUpperTriangle(statement, link.T_from_to.P);
  statement.run();
}

void updatePose(Connection& db, int model_id, const std::optional<Eigen::Isometry3d>& T_w_m) {
  describing(db, fmt::format("the pose of local model {}", model_id), [&] {
    if (T_w_m) requireSound(*T_w_m);
  });
  Statement statement(db,
                      "UPDATE model SET tx = ?, ty = ?, tz = ?, qx = ?, qy = ?, qz = ?, qw = ? WHERE id = ?");
  (statement << T_w_m << model_id).run();
}

// Checking.

void addIntegrityFaults(Connection& db, std::vector<std::string>& faults) {
  Statement integrity(db, "PRAGMA integrity_check");
  while (integrity.step()) {
    const std::string answer = integrity.text();
    if (answer != "ok") faults.push_back("SQLite's integrity check: " + answer);
  }
  Statement keys(db, "PRAGMA foreign_key_check");
  while (keys.step()) faults.push_back(fmt::format("a row of table {} belongs to nothing", keys.text()));
}

}  // namespace

// The public face.

struct MapDatabase::Impl {
  template <class... Model>
  int add(const Model&... model) {
    Transaction transaction(db);
    const int id = insertModel(db, model...);
    transaction.commit();
    return id;
  }

  Connection db;
};

MapDatabase::MapDatabase(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapDatabase::MapDatabase(MapDatabase&&) noexcept = default;
MapDatabase& MapDatabase::operator=(MapDatabase&&) noexcept = default;
MapDatabase::~MapDatabase() = default;

MapDatabase MapDatabase::create(const fs::path& path, bool overwrite) {
  files::requireFolderOf(path);
  std::error_code ignored;
  if (files::isFolder(path)) throw IoError(path.string(), "is a folder, not a file");
  const bool is_empty = files::isFile(path) && fs::file_size(path, ignored) == 0;
  if (files::isThere(path) && !is_empty && !overwrite) throw IoError(path.string(), "exists already");
  if (!is_empty) removeWithJournal(path);
  fs::remove(journalOf(path), ignored);
  try {
    return MapDatabase(std::make_unique<Impl>(Impl{map_connection::create(path, path)}));
  } catch (const IoError&) {
    fs::remove(path, ignored);  // it is no map, and would be in the way of the next one
    fs::remove(journalOf(path), ignored);
    throw;
  }
}

MapDatabase MapDatabase::open(const fs::path& path) {
  return MapDatabase(std::make_unique<Impl>(Impl{openForWriting(path)}));
}

void MapDatabase::setMeta(const std::string& key, const std::string& value) {
  if (isReserved(key))
    throw std::invalid_argument(fmt::format("MapDatabase: the meta key {} belongs to the file format", key));
  insertMeta(impl_->db, key, value);
}

void MapDatabase::setCamera(const Camera& camera) {
  Transaction transaction(impl_->db);
  insertCamera(impl_->db, camera);
  transaction.commit();
}

void MapDatabase::setAmbiguity(const MapAmbiguity& ambiguity,
                               const std::vector<std::optional<double>>& alias_scores) {
  Transaction transaction(impl_->db);
  if (!alias_scores.empty() && nextId(impl_->db, "model") != static_cast<int>(alias_scores.size()))
    throw std::invalid_argument("MapDatabase: there must be as many scores as local models");
  insertAmbiguity(impl_->db, ambiguity, alias_scores);
  transaction.commit();
}

void MapDatabase::setPlaceIndex(const std::function<void(std::ostream&)>& write) {
  Transaction transaction(impl_->db);
  place_index_parts::write(impl_->db, write);
  transaction.commit();
}

PackedModel packed(LocalModel model, View view) {
  DepthPicture& picture = view.depth;
  std::vector<std::uint8_t> depth;
  if (!picture.empty()) depth = depth_blob::encode(picture.inverse_depth, picture.camera.width);
  DepthPicture rest;
  rest.camera = picture.camera;
  rest.noise = picture.noise;
  picture = std::move(rest);
  return {std::move(model), std::move(view), std::move(depth)};
}

int MapDatabase::add(const LocalModel& model, const View& view) { return impl_->add(model, view); }

int MapDatabase::add(const PackedModel& model) { return impl_->add(model); }

void MapDatabase::add(const Link& link) {
  Transaction transaction(impl_->db);
  insertLink(impl_->db, link);
  transaction.commit();
}

void MapDatabase::setPoses(const std::vector<std::optional<Eigen::Isometry3d>>& T_w_m,
                           const std::vector<Link>& links) {
  Connection& db = impl_->db;
  Transaction transaction(db);
  if (nextId(db, "model") != static_cast<int>(T_w_m.size()))
    throw std::invalid_argument("MapDatabase: there must be as many poses as local models");
  for (std::size_t i = 0; i < T_w_m.size(); ++i) updatePose(db, static_cast<int>(i), T_w_m[i]);
  db.execute("DELETE FROM link");
  for (const Link& link : links) insertLink(db, link);
  place_index_parts::remove(db);
  removeFindings(db);
  transaction.commit();
}

std::vector<std::string> MapDatabase::modelNames() const {
  std::vector<std::string> names;
  Statement row(impl_->db, "SELECT name FROM model ORDER BY id");
  sqlite::naming(impl_->db.name(), "", [&] {
    while (row.step()) names.push_back(row.text());
  });
  return names;
}

Map readMap(const fs::path& path) {
  Connection db = openForReading(path);
  return readSound(db, true);
}

void replaceMap(const fs::path& asked, const std::function<void(const fs::path& temporary)>& write) {
  const fs::path path = files::linkedFrom(asked);
  writeAtomically(path, [&](const fs::path& temporary) {
    try {
      write(temporary);
    } catch (const WriteError& e) {  // the error must not name the temporary file
      if (e.path() == temporary) throw WriteError(asked.string(), e.why());
      throw;
    }
    std::error_code ignored;
    fs::remove(journalOf(path), ignored);
  });
}

void writeMap(const fs::path& path, const Map& map, const std::function<void(std::ostream&)>& place_index) {
  replaceMap(path, [&](const fs::path& temporary) {
    Connection db = map_connection::create(temporary, path);
    Transaction transaction(db);
    insertCamera(db, map.camera);
    for (std::size_t i = 0; i < map.models.size(); ++i)
      insertModel(db, map.models[i], *map.view(static_cast<int>(i)));
    for (const Link& link : map.links) insertLink(db, link);
    if (map.ambiguity) {
      std::vector<std::optional<double>> alias_scores;
      for (const LocalModel& model : map.models) alias_scores.push_back(model.alias_score);
      insertAmbiguity(db, *map.ambiguity, alias_scores);
    }
    for (const auto& [key, value] : map.meta)
      if (!isReserved(key)) insertMeta(db, key, value);
    if (place_index) place_index_parts::write(db, place_index);
    transaction.commit();
  });
}

std::vector<std::string> checkMap(const fs::path& path) {
  Connection db = openForReading(path);
  std::vector<std::string> faults;
  try {
    addIntegrityFaults(db, faults);
    findFaults(db, faults);
  } catch (const IoError& e) {
    faults.push_back(std::string("cannot be read: ") + e.what());
  } catch (const BadCell& e) {
    faults.push_back(e.what());
  }
  return faults;
}

bool isMapFile(const fs::path& path) {
  constexpr std::string_view kMagic = "SQLite format 3";
  if (!files::isFile(path)) return false;
  std::array<char, kMagic.size()> head{};
  std::ifstream in(path, std::ios::binary);
  return in.read(head.data(), head.size()) && std::string_view(head.data(), head.size()) == kMagic;
}

CameraFile cameraOfMap(const fs::path& map, const std::optional<CameraFile>& stored) {
  CameraFile file = stored.value_or(CameraFile{});
  const Intrinsics own = file.camera.intrinsics;
  file.camera = openMap(map).camera;
  file.camera.distortion.reset();
  file.preset.clear();
  if (!file.camera.intrinsics.valid()) file.camera.intrinsics = own;
  if (!file.camera.intrinsics.valid())
    throw IoError(map.string(),
                  "does not say the intrinsics of its camera, as each of its images has its own; give a "
                  "camera.ini");
  return file;
}

Camera cameraNamed(const std::string& file_or_name) {
  if (isMapFile(file_or_name)) return cameraOfMap(file_or_name).camera;
  if (files::isThere(file_or_name)) return readCameraFile(file_or_name).camera;
  const CameraPreset* preset = findCameraPreset(file_or_name);
  if (!preset)
    throw IoError(file_or_name, fmt::format("is neither the file of a camera nor the name of one (known: {})",
                                            cameraPresetNames()));
  Camera camera = preset->camera();
  camera.intrinsics = preset->intrinsics();
  return camera;
}

}  // namespace facetloc
