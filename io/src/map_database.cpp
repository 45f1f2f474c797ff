// SPDX-License-Identifier: BSD-3-Clause
#include "depth_blob.h"
#include "files.h"
#include "map_schema.h"
#include "pose_columns.h"
#include "sqlite.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <cmath>
#include <cstring>
#include <stdexcept>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using sqlite::BadCell;
using sqlite::Blob;
using sqlite::Connection;
using sqlite::Statement;
using sqlite::Transaction;

constexpr double kRotationTolerance = 1e-6;   // of |q|^2 and R^T R
constexpr double kSymmetryTolerance = 1e-9;   // of covariances, relative to their largest value
constexpr int kMaxPictureSide = 4096;         // [px] bounds what a corrupt picture can claim
constexpr const char* kFormatKey = "format";  // meta rows that belong to the file format
constexpr const char* kConventionsKey = "conventions";

bool isReserved(const std::string& key) { return key == kFormatKey || key == kConventionsKey; }

std::string nameOf(int model, const std::string& name) {
  return "model " + std::to_string(model) + " ('" + name + "')";
}

// ---- What a sound map holds. BadCell says what is wrong.
// -------------------------------------------------------------

void require(bool condition, const char* fault) {
  if (!condition) throw BadCell(fault);
}

void requireSound(const Intrinsics& camera) {
  require(camera.valid(), "its camera intrinsics are impossible");
}

void requireRotation(const Eigen::Matrix3d& R) {
  require(R.allFinite() && (R.transpose() * R).isIdentity(kRotationTolerance) && R.determinant() > 0,
          "its rotation matrix is not a rotation");
}

void requireSound(const Segment& s) {
  requireRotation(s.R);
  require(s.t.allFinite(), "its centroid is not finite");
  require(s.Sigma_q.allFinite() && s.Sigma_q.isApprox(s.Sigma_q.transpose(), kSymmetryTolerance) &&
              s.Sigma_q.llt().info() == Eigen::Success,
          "its Sigma_q is not positive definite");
  require(s.lambda.allFinite() && s.lambda[0] >= s.lambda[1] && s.lambda[1] >= 0,
          "its lambda are not finite, descending and positive");
  require(s.num_points >= 0, "its number of points is negative");
  require(s.hull.size >= 0 && s.hull.size <= ConvexHull::kMaxVertices, "its hull has too many vertices");
  for (const Eigen::Vector2f& vertex : s.hull) require(vertex.allFinite(), "its hull is not finite");
}

void requireSound(const Eigen::Isometry3d& T) {
  require(T.translation().allFinite(), "its pose is not finite");
  requireRotation(T.linear());
}

/** A link may be known exactly: its covariance need not be regular. */
void requireSound(const Link& link) {
  require(link.from != link.to, "it leads from a model to itself");
  requireSound(link.T_from_to.T);
  const Matrix6d& P = link.T_from_to.P;
  require(P.allFinite(), "its covariance is not finite");
  const double rounding = kSymmetryTolerance * P.cwiseAbs().maxCoeff();
  require((P - P.transpose()).cwiseAbs().maxCoeff() <= rounding &&
              Eigen::SelfAdjointEigenSolver<Matrix6d>(P, Eigen::EigenvaluesOnly).eigenvalues()[0] >=
                  -rounding,
          "its covariance is not symmetric and positive");
}

void requireSound(const DepthPicture& picture) {
  if (picture.empty()) return;
  requireSound(picture.camera);
  require(picture.camera.width <= kMaxPictureSide && picture.camera.height <= kMaxPictureSide,
          "its depth picture is too large");
  require(picture.inverse_depth.size() == std::size_t(picture.camera.width) * picture.camera.height,
          "its depth picture has the wrong size");
}

void requireSound(const LocalModel& model) {
  require(!model.name.empty(), "it has no name");
  require(std::isfinite(model.stamp), "its stamp is not finite");
  requireSound(model.view.camera);
  if (model.T_w_m) requireSound(*model.T_w_m);
  requireSound(model.view.depth);
}

// ---- Values to columns and back
// --------------------------------------------------------------------------------------

Statement& operator<<(Statement& s, const Intrinsics& k) {
  return s << k.width << k.height << k.fx << k.fy << k.cx << k.cy;
}
Statement& operator<<(Statement& s, const Eigen::Isometry3d& T) { return s.bindAll(toColumns(T)); }

template <typename Matrix>
Statement& bindUpperTriangle(Statement& s, const Matrix& m) {
  for (int row = 0; row < m.rows(); ++row)
    for (int col = row; col < m.cols(); ++col) s << m(row, col);
  return s;
}

Intrinsics readIntrinsics(Statement& row) {
  Intrinsics k;
  k.width = row.integer(), k.height = row.integer();
  k.fx = row.real(), k.fy = row.real(), k.cx = row.real(), k.cy = row.real();
  requireSound(k);
  return k;
}

Eigen::Isometry3d readPose(Statement& row) {
  const auto T = fromColumns(row.reals<7>(), kRotationTolerance);
  require(T.has_value(), "its pose is not finite or not a rotation");
  return *T;
}

template <typename Matrix>
void readUpperTriangle(Statement& row, Matrix& m) {
  for (int i = 0; i < m.rows(); ++i)
    for (int j = i; j < m.cols(); ++j) m(i, j) = m(j, i) = row.real();
}

Blob hullBlob(const ConvexHull& hull) {
  Blob blob;
  for (const Eigen::Vector2f& vertex : hull) {
    for (const float coordinate : {vertex.x(), vertex.y()}) {
      std::uint32_t bits;
      std::memcpy(&bits, &coordinate, sizeof bits);
      for (int shift = 0; shift < 32; shift += 8) blob.push_back(static_cast<std::uint8_t>(bits >> shift));
    }
  }
  return blob;
}

ConvexHull hullOf(const Blob& blob) {
  constexpr std::size_t kVertexBytes = 8;
  require(blob.size() % kVertexBytes == 0 && blob.size() <= kVertexBytes * ConvexHull::kMaxVertices,
          "its hull has the wrong size");
  const auto coordinate = [&blob](std::size_t offset) {
    std::uint32_t bits = 0;
    for (int i = 0; i < 4; ++i) bits |= std::uint32_t(blob[offset + i]) << (8 * i);
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  };
  ConvexHull hull;
  hull.size = static_cast<int>(blob.size() / kVertexBytes);
  for (int i = 0; i < hull.size; ++i)
    hull.vertex[i] = {coordinate(kVertexBytes * i), coordinate(kVertexBytes * i + 4)};
  return hull;
}

Segment readSegment(Statement& row) {
  Segment s;
  const Eigen::Isometry3d T = readPose(row);
  s.R = T.linear();
  s.t = T.translation();
  readUpperTriangle(row, s.Sigma_q);
  s.lambda[0] = row.real(), s.lambda[1] = row.real();
  s.num_points = row.integer();
  s.hull = hullOf(row.blob());
  requireSound(s);
  return s;
}

LocalModel readModel(Statement& row) {
  LocalModel model;
  model.name = row.text();
  model.stamp = row.real();
  if (row.isNull())
    row.skip(std::tuple_size<PoseColumns>::value);
  else
    model.T_w_m = readPose(row);
  model.view.camera = readIntrinsics(row);
  requireSound(model);
  return model;
}

DepthPicture readPicture(Statement& row) {
  const Intrinsics camera = readIntrinsics(row);
  require(camera.width <= kMaxPictureSide && camera.height <= kMaxPictureSide,
          "its depth picture is too large");
  require(row.text() == depth_blob::kEncoding, "its depth picture is of an unknown encoding");
  auto values = depth_blob::decode(row.blob(), camera.width, camera.height);
  require(values.has_value(), "its depth picture is corrupt");
  return DepthPicture::fromStored(camera, std::move(*values));
}

Link readLink(Statement& row) {
  Link link;
  link.from = row.integer();
  link.to = row.integer();
  link.T_from_to.T = readPose(row);
  readUpperTriangle(row, link.T_from_to.P);
  requireSound(link);
  return link;
}

// ---- Opening
// ---------------------------------------------------------------------------------------------------------

int pragma(Connection& db, const std::string& name) {
  Statement statement(db, "PRAGMA " + name);
  return statement.step() ? statement.integer() : 0;
}

std::string versionText(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000);
}

constexpr int kVersion = 1000 * MapDatabase::kMajor + MapDatabase::kMinor;

/** Throws unless the file is a map of a format that we understand. Newer minor formats only add columns and
 * tables. */
void requireMap(Connection& db) {
  int id = 0;
  try {
    id = pragma(db, "application_id");
  } catch (const IoError&) {
    if ((db.lastCode() & 0xFF) == SQLITE_NOTADB)
      throw IoError(db.name(), "is not a map: it is no SQLite database");
    throw;
  }
  if (id != MapDatabase::kApplicationId)
    throw IoError(db.name(), "is not a map: it is an SQLite database of another application, or empty");
  const int version = pragma(db, "user_version");
  const std::string ours = std::to_string(MapDatabase::kMajor) + ".x";
  if (version / 1000 > MapDatabase::kMajor)
    throw IoError(db.name(), "map format " + versionText(version) +
                                 " is newer than this program understands (" + ours + ")");
  if (version / 1000 < MapDatabase::kMajor)
    throw IoError(db.name(),
                  "map format " + versionText(version) + " is unknown to this program (" + ours + ")");
}

void configureForWriting(Connection& db) {
  db.execute("PRAGMA journal_mode = DELETE; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON");
}

Connection openForWriting(const fs::path& path) {
  files::requireFile(path);
  Connection db(path, SQLITE_OPEN_READWRITE);
  requireMap(db);
  configureForWriting(db);
  return db;
}

/** Read-only. Only where a killed writer has left half a transaction, that is rolled back first. */
Connection openForReading(const fs::path& path) {
  files::requireFile(path);
  Connection db(path, SQLITE_OPEN_READONLY);
  try {
    requireMap(db);
    return db;
  } catch (const IoError&) {
    if (db.lastCode() != SQLITE_READONLY_ROLLBACK) throw;
  }
  openForWriting(path);
  Connection recovered(path, SQLITE_OPEN_READONLY);
  requireMap(recovered);
  return recovered;
}

fs::path journalOf(const fs::path& path) { return path.string() + "-journal"; }

/** A journal that outlives its database would be rolled back into the next one of that name. */
void removeWithJournal(const fs::path& path) {
  std::error_code error;
  fs::remove(journalOf(path), error);
  if (!error) fs::remove(path, error);
  if (error) throw IoError(path.string(), "cannot be replaced: " + error.message());
}

/** A new database with empty tables. */
Connection createDatabase(const fs::path& path, const fs::path& shown) {
  Connection db(path, shown, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  configureForWriting(db);
  Transaction transaction(db);
  db.execute("PRAGMA application_id = " + std::to_string(MapDatabase::kApplicationId));
  db.execute("PRAGMA user_version = " + std::to_string(kVersion));
  db.execute(schema::kTables);
  Statement meta(db, schema::insert("key, value", "meta"));
  (meta << kFormatKey << "facetloc map " + versionText(kVersion)).run();
  (meta << kConventionsKey << schema::kConventions).run();
  transaction.commit();
  return db;
}

// ---- Writing, inside a transaction of the caller
// -----------------------------------------------------------------------

/** Runs what may fail, and says which thing it failed for. */
template <typename Work>
void describing(const Connection& db, const std::string& thing, const Work& work) {
  try {
    work();
  } catch (const BadCell& e) {
    throw IoError(db.name(), "cannot add " + thing + ": " + e.what());
  }
}

void insertMeta(Connection& db, const std::string& key, const std::string& value) {
  Statement statement(db, "INSERT OR REPLACE INTO meta(key, value) VALUES(?, ?)");
  (statement << key << value).run();
}

void insertMounting(Connection& db, const CameraMounting& mounting) {
  Statement statement(db, "INSERT OR REPLACE INTO mounting(id, height, tilt_deg) VALUES(0, ?, ?)");
  (statement << mounting.height << mounting.tilt_deg).run();
}

int nextId(Connection& db, const std::string& table) {
  Statement statement(db, "SELECT coalesce(max(id) + 1, 0) AS next_id FROM " + table);
  statement.step();
  return statement.integer();
}

void insertSegments(Connection& db, int model_id, const LocalModel& model) {
  Statement statement(db, schema::insert(schema::kSegmentColumns, "segment"));
  for (std::size_t i = 0; i < model.view.segments.size(); ++i) {
    const Segment& s = model.view.segments[i];
    describing(db, "segment " + std::to_string(i) + " of " + nameOf(model_id, model.name),
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
  Statement statement(db, schema::insert(schema::kPictureColumns, "depth_picture"));
  statement << model_id << packed.model.view.depth.camera << std::string(depth_blob::kEncoding)
            << packed.depth;
  statement.run();
}

int insertModel(Connection& db, const PackedModel& packed) {
  const LocalModel& model = packed.model;
  const int id = nextId(db, "model");
  describing(db, nameOf(id, model.name), [&] { requireSound(model); });
  Statement statement(db, schema::insert(schema::kModelColumns, "model"));
  statement << id << model.name << model.stamp;
  if (model.T_w_m)
    statement << *model.T_w_m;
  else
    statement.bindAll(std::array<std::nullptr_t, std::tuple_size<PoseColumns>::value>{});
  statement << model.view.camera << static_cast<int>(model.view.segments.size());
  statement.run();
  insertSegments(db, id, model);
  insertPicture(db, id, packed);
  return id;
}

/** Packs it first, if there is sense in it. */
int insertModel(Connection& db, const LocalModel& model) {
  describing(db, nameOf(nextId(db, "model"), model.name), [&] { requireSound(model); });
  return insertModel(db, packed(model));
}

void insertLink(Connection& db, const Link& link) {
  describing(db, "link " + std::to_string(link.from) + " -> " + std::to_string(link.to),
             [&] { requireSound(link); });
  Statement statement(db, schema::insert(schema::kLinkColumns, "link"));
  statement << nextId(db, "link") << link.from << link.to << link.T_from_to.T;
  bindUpperTriangle(statement, link.T_from_to.P);
  statement.run();
}

// ---- Reading
// ---------------------------------------------------------------------------------------------------------

/** Reads everything; what is not sound is left out and told. */
class MapReader {
public:
  explicit MapReader(Connection& db) : db_(db) {}

  Map read() {
    readMeta();
    readModels();
    readSegments();
    readPictures();
    readLinks();
    return std::move(map_);
  }
  const std::vector<std::string>& faults() const { return faults_; }

private:
  /** Calls a function for every row; a bad row is told with the label that the function has set so far. */
  template <typename Function>
  void forEachRow(const std::string& sql, const Function& function) {
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
  LocalModel& modelOf(int id, std::string& label) {
    label += " of model " + std::to_string(id);
    require(id >= 0 && id < static_cast<int>(map_.models.size()), "there is no such model");
    return map_.models[id];
  }

  void readMeta() {
    forEachRow(schema::select("key, value", "meta", "key"), [this](Statement& row, std::string& label) {
      label = "a row of meta";
      const std::string key = row.text();
      map_.meta[key] = row.text();
    });
    forEachRow(schema::select("height, tilt_deg", "mounting", "id"),
               [this](Statement& row, std::string& label) {
                 label = "the camera mounting";
                 const double height = row.real(), tilt_deg = row.real();
                 require(std::isfinite(height) && std::isfinite(tilt_deg), "it is not finite");
                 map_.mounting = CameraMounting{height, tilt_deg};
               });
  }

  void readModels() {
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

  void readSegments() {
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

  void readPictures() {
    forEachRow(schema::select(schema::kPictureColumns, "depth_picture", "model_id"),
               [this](Statement& row, std::string& label) {
                 label = "the depth picture";
                 LocalModel& model = modelOf(row.integer(), label);
                 model.view.depth = readPicture(row);
               });
  }

  void readLinks() {
    forEachRow(schema::select(schema::kLinkColumns, "link", "id"),
               [this](Statement& row, std::string& label) {
                 label = "a link";
                 label = "link " + std::to_string(row.integer());
                 const Link link = readLink(row);
                 for (const int end : {link.from, link.to}) modelOf(end, label);
                 map_.links.push_back(link);
               });
  }

  Connection& db_;
  Map map_;
  std::vector<int> num_segments_;
  std::vector<std::string> faults_;
};

// ---- Checking
// --------------------------------------------------------------------------------------------------------

void append(std::vector<std::string>& faults, const std::vector<std::string>& more) {
  faults.insert(faults.end(), more.begin(), more.end());
}

std::vector<std::string> integrityFaults(Connection& db) {
  std::vector<std::string> faults;
  Statement integrity(db, "PRAGMA integrity_check");
  while (integrity.step()) {
    const std::string answer = integrity.text();
    if (answer != "ok") faults.push_back("SQLite's integrity check: " + answer);
  }
  Statement keys(db, "PRAGMA foreign_key_check");
  while (keys.step()) faults.push_back("a row of table " + keys.text() + " belongs to nothing");
  return faults;
}

}  // namespace

// ---- The public face
// -------------------------------------------------------------------------------------------------

struct MapDatabase::Impl {
  template <class Model>
  int add(const Model& model) {
    Transaction transaction(db);
    const int id = insertModel(db, model);
    transaction.commit();
    return id;
  }

  Connection db;
};

MapDatabase::MapDatabase(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MapDatabase::MapDatabase(MapDatabase&&) noexcept = default;
MapDatabase& MapDatabase::operator=(MapDatabase&&) noexcept = default;
MapDatabase::~MapDatabase() = default;

MapDatabase MapDatabase::create(const std::filesystem::path& path, bool overwrite) {
  files::requireFolderOf(path);
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) throw IoError(path.string(), "is a folder, not a file");
  if (fs::exists(path, ignored) && !overwrite) throw IoError(path.string(), "exists already");
  removeWithJournal(path);
  return MapDatabase(std::make_unique<Impl>(Impl{createDatabase(path, path)}));
}

MapDatabase MapDatabase::open(const std::filesystem::path& path) {
  return MapDatabase(std::make_unique<Impl>(Impl{openForWriting(path)}));
}

void MapDatabase::setMeta(const std::string& key, const std::string& value) {
  if (isReserved(key))
    throw std::invalid_argument("MapDatabase: the meta key " + key + " belongs to the file format");
  insertMeta(impl_->db, key, value);
}

void MapDatabase::setMounting(const CameraMounting& mounting) { insertMounting(impl_->db, mounting); }

PackedModel packed(LocalModel model) {
  DepthPicture& picture = model.view.depth;
  std::vector<std::uint8_t> depth;
  if (!picture.empty()) depth = depth_blob::encode(picture.inverse_depth, picture.camera.width);
  const Intrinsics camera = picture.camera;
  picture = {};
  picture.camera = camera;
  return {std::move(model), std::move(depth)};
}

int MapDatabase::add(const LocalModel& model) { return impl_->add(model); }

int MapDatabase::add(const PackedModel& model) { return impl_->add(model); }

void MapDatabase::add(const Link& link) {
  Transaction transaction(impl_->db);
  insertLink(impl_->db, link);
  transaction.commit();
}

std::vector<std::string> MapDatabase::modelNames() const {
  std::vector<std::string> names;
  Statement row(impl_->db, "SELECT name FROM model ORDER BY id");
  try {
    while (row.step()) names.push_back(row.text());
  } catch (const BadCell& e) {
    throw IoError(impl_->db.name(), e.what());
  }
  return names;
}

Map readMap(const std::filesystem::path& path) {
  Connection db = openForReading(path);
  MapReader reader(db);
  Map map = reader.read();
  const auto& faults = reader.faults();
  if (faults.empty()) return map;
  const std::string more =
      faults.size() > 1 ? " (and " + std::to_string(faults.size() - 1) + " more faults)" : "";
  throw IoError(path.string(), "is not sound: " + faults.front() + more);
}

void writeMap(const std::filesystem::path& path, const Map& map) {
  writeAtomically(path, [&](const fs::path& temporary) {
    removeWithJournal(temporary);
    {
      Connection db = createDatabase(temporary, path);
      Transaction transaction(db);
      for (const auto& [key, value] : map.meta)
        if (!isReserved(key)) insertMeta(db, key, value);
      if (map.mounting) insertMounting(db, *map.mounting);
      for (const LocalModel& model : map.models) insertModel(db, model);
      for (const Link& link : map.links) insertLink(db, link);
      transaction.commit();
    }
    std::error_code ignored;
    fs::remove(journalOf(path), ignored);
  });
}

std::vector<std::string> checkMap(const std::filesystem::path& path) {
  Connection db = openForReading(path);
  std::vector<std::string> faults;
  try {
    append(faults, integrityFaults(db));
    MapReader reader(db);
    reader.read();
    append(faults, reader.faults());
  } catch (const IoError& e) {
    faults.push_back(std::string("cannot be read: ") + e.what());
  } catch (const BadCell& e) {
    faults.push_back(e.what());
  }
  return faults;
}

}  // namespace facetloc
