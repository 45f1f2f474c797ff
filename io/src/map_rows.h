// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "sqlite.h"

#include <facetloc/features/local_model.h>

/** \file
 * The parts of a map as rows of its file, and what a sound map holds; private to io.
 *
 * Reading and requireSound() throw BadCell, which says what is wrong with the part. */

namespace facetloc::map_rows {

void require(bool condition, const char* fault);
/** \brief A depth picture is no larger than the working image that it is made of. */
void requireSizeOfPicture(const Intrinsics& picture, const Intrinsics& working_image);
void requireSoundPose(const Eigen::Isometry3d& T);
void requireSound(const DepthNoise& noise);
void requireSound(const Camera& camera);
void requireSound(const CameraMounting& mounting);
void requireSound(const Segment& segment);
void requireSound(const LocalModel& model);
void requireSound(const Link& link);
void requireSound(const MapAmbiguity& ambiguity);
void requirePossibleScore(double score);

sqlite::Statement& operator<<(sqlite::Statement& s, const Intrinsics& camera);
sqlite::Statement& operator<<(sqlite::Statement& s, const Eigen::Isometry3d& T);
template <typename Matrix>
sqlite::Statement& bindUpperTriangle(sqlite::Statement& s, const Matrix& m) {
  for (int row = 0; row < m.rows(); ++row)
    for (int col = row; col < m.cols(); ++col) s << m(row, col);
  return s;
}
sqlite::Blob hullBlob(const ConvexHull& hull);

/** \brief Each reads its cells from where the row is. */
Intrinsics readIntrinsics(sqlite::Statement& row);
Segment readSegment(sqlite::Statement& row);
LocalModel readModel(sqlite::Statement& row);
Link readLink(sqlite::Statement& row);
/** \brief The camera of a depth picture of that working image. */
Intrinsics readPictureCamera(sqlite::Statement& row, const Intrinsics& working_image);
/** \brief The camera of the map, without mounting, distortion and what readRange() reads, which have tables
 * of their own. */
Camera readCamera(sqlite::Statement& row);
/** \brief What else is known of a camera's noise and range. */
void readRange(sqlite::Statement& row, Camera& camera);
MapAmbiguity readAmbiguity(sqlite::Statement& row);
/** \brief Noise of a depth picture, as far as it is constant in inverse depth. */
DepthNoise readNoise(sqlite::Statement& row);
/** \brief ... and the rest. */
void readNoiseOverRange(sqlite::Statement& row, DepthNoise& noise);
/** \brief The rest of a depth picture, still packed. */
sqlite::Blob readPackedPicture(sqlite::Statement& row);
DepthPicture unpackedPicture(const Intrinsics& camera, const sqlite::Blob& packed);

}  // namespace facetloc::map_rows
