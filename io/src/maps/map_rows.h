// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/sqlite.h"

#include <facetloc/features/local_model.h>

/** \file
 * The parts of a map as rows of its file, and their valid values; private to io.
 *
 * Reading and requireSound() throw BadCell, which names the fault of the part. */

namespace facetloc::map_rows {

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

}  // namespace facetloc::map_rows
