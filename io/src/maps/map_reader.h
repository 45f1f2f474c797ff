// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/sqlite.h"

#include <facetloc/features/local_model.h>

#include <filesystem>
#include <functional>
#include <istream>
#include <memory>
#include <mutex>
#include <ostream>
#include <string>
#include <vector>

namespace facetloc {

/** Map files that are opened. */
namespace map_connection {

inline constexpr const char* kFormatKey = "format";  ///< meta rows that belong to the file format
inline constexpr const char* kConventionsKey = "conventions";

/** \brief A new database with empty tables. \param shown its name in errors */
sqlite::Connection create(const std::filesystem::path& path, const std::filesystem::path& shown);
sqlite::Connection openForWriting(const std::filesystem::path& path);
/** \brief Read-only. Only where a killed writer has left half a transaction, that is rolled back first. */
sqlite::Connection openForReading(const std::filesystem::path& path);

std::filesystem::path journalOf(const std::filesystem::path& path);
/** \brief A journal that outlives its database would be rolled back into the next one of that name. */
void removeWithJournal(const std::filesystem::path& path);

}  // namespace map_connection

/** The parts of a map as rows of its file, and their valid values. Reading and requireSound() throw BadCell,
 * which names the fault of the part. */
namespace map_rows {

void require(bool condition, const char* fault);
/** \brief A depth picture is no larger than the working image that it is made of. */
void requireSizeOfPicture(const Intrinsics& picture, const Intrinsics& working_image);
void requireSound(const Eigen::Isometry3d& T);
void requireSound(const DepthNoise& noise);
void requireSound(const Camera& camera);
void requireSound(const Segment& segment);
void requireSound(const LocalModel& model, const View& view);
void requireSound(const Link& link);
void requireSound(const MapAmbiguity& ambiguity);
void requireSound(const Gravity& gravity);
void requirePossibleScore(double score);

sqlite::Statement& operator<<(sqlite::Statement& s, const Intrinsics& camera);
sqlite::Statement& operator<<(sqlite::Statement& s, const Eigen::Isometry3d& T);
sqlite::Statement& operator<<(sqlite::Statement& s, const std::optional<Eigen::Isometry3d>& T);
sqlite::Statement& operator<<(sqlite::Statement& s, const DepthNoise& noise);
sqlite::Statement& operator<<(sqlite::Statement& s, const Camera& camera);
template <typename Matrix>
sqlite::Statement& bindUpperTriangle(sqlite::Statement& s, const Matrix& m) {
  for (int row = 0; row < m.rows(); ++row)
    for (int col = row; col < m.cols(); ++col) s << m(row, col);
  return s;
}
sqlite::Blob hullBlob(const ConvexHull& hull);

/** \brief A local model as its row has it, without its view. */
struct ModelRow {
  LocalModel model;
  Intrinsics intrinsics;  ///< intrinsics of the view
  int num_segments = 0;
};

/** \brief Each reads its cells from where the row is. */
Segment readSegment(sqlite::Statement& row);
ModelRow readModel(sqlite::Statement& row);
Link readLink(sqlite::Statement& row);
Camera readCamera(sqlite::Statement& row);
MapAmbiguity readAmbiguity(sqlite::Statement& row);
Gravity readGravity(sqlite::Statement& row);

/** \brief A depth picture as its row has it. */
struct PackedPicture {
  Intrinsics camera;
  DepthNoise noise;
  sqlite::Blob data;
};
PackedPicture readPictureHead(sqlite::Statement& row, const Intrinsics& working_image);
/** \brief The same with its data. */
PackedPicture readPicture(sqlite::Statement& row, const Intrinsics& working_image);
DepthPicture unpacked(const PackedPicture& packed);

}  // namespace map_rows

/** \brief "model 3 ('name')" */
std::string nameOf(int model, const std::string& name);

/** \brief Has a map file the table of gravity? */
bool hasGravity(sqlite::Connection& db);

/** \brief Reads a map, with or without its views, and places it by its links. Throws IoError unless it is
 * sound.
 */
Map readSound(sqlite::Connection& db, bool with_views);
/** \brief Adds the faults of all rows and of the place index, which are looked at, and none kept. */
void findFaults(sqlite::Connection& db, std::vector<std::string>& faults);

/** The place index in a map file, as a stream of bytes in checksummed parts. */
namespace place_index_parts {

/** \brief Replaces the former index, within a transaction of the caller. */
void write(sqlite::Connection& db, const std::function<void(std::ostream&)>& writer);
void remove(sqlite::Connection& db);
/** \brief 0 if there is no index. */
int number(sqlite::Connection& db);
/** \brief Null if the map has none. A part that differs from the one written throws IoError when it is
 * reached. \param mutex is locked while the database, which must outlive the stream, is read */
std::unique_ptr<std::istream> open(sqlite::Connection& db, std::mutex& mutex);
/** \brief Its faults, in words. */
std::vector<std::string> faults(sqlite::Connection& db);

}  // namespace place_index_parts
}  // namespace facetloc
