// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/text.h"

#include <Eigen/Geometry>
#include <pcl/PCLPointCloud2.h>
#include <pcl/PolygonMesh.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

/** \file
 * Files of points and meshes. Own readers and writers, as PCL's are in libpcl_io, which brings VTK along. All
 * throw IoError. Private to io. */

namespace facetloc {

/** \brief The words of a text, one after the other. */
class WordReader {
public:
  /** \param text must outlive the object */
  explicit WordReader(std::string_view text) : rest_(text) {}
  /** \brief The next word; empty at the end. */
  std::string_view next() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(text::kBlank), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(text::kBlank));
    rest_.remove_prefix(word.size());
    return word;
  }
  std::string_view rest() const { return rest_; }

private:
  std::string_view rest_;
};

/** \brief The header of a PCD file, read strictly and compared with the size of the file: it promises no more
 * than the file has. */
struct PcdHeader {
  /** \brief Throws IoError for anything that is not a sound PCD file of the promised length, or has no point,
   * unless it may be empty. */
  explicit PcdHeader(const std::filesystem::path& path, bool may_be_empty = false);

  int width = 0, height = 0;
  std::size_t points = 0;
  std::vector<pcl::PCLPointField> fields;  ///< as in the file, packed
  std::size_t step = 0;                    ///< bytes of a point
  std::vector<double> viewpoint;           ///< x y z qw qx qy qz of the sensor; empty if it is not said
  std::string encoding;                    ///< "ascii", "binary" or "binary_compressed"
  std::uint64_t data_offset = 0;           ///< where the points begin in the file
};

/** \brief The points of a PCD file with a sound header, packed, whatever the locale of the program is.
 * \param viewpoint receives the pose of the sensor that the header says, if not null */
pcl::PCLPointCloud2 readPcd(const std::filesystem::path& path, const PcdHeader& header,
                            Eigen::Isometry3d* viewpoint = nullptr);

/** \brief Writes points, or none, as a binary_compressed PCD, atomically. \param viewpoint as of PcdHeader */
void writePcd(const std::filesystem::path& path, const pcl::PCLPointCloud2& points,
              const std::vector<double>& viewpoint = {});

/** \brief The field of a cloud by its name; null without one. */
const pcl::PCLPointField* fieldOf(const pcl::PCLPointCloud2& cloud, std::string_view name);
/** \brief Are the numbers of a field floats or doubles? */
bool isFloatingPoint(const pcl::PCLPointField& field);
/** \brief A number of at most 32 bits, or of floating point. \param type of a pcl::PCLPointField */
double numberAt(std::uint8_t type, const void* bytes);

/** \brief Reads a PLY file, of text or binary: the positions of its vertices, as doubles, and its faces, if
 * it has some. Throws IoError for a file that is not PLY, has no positions, or ends before the data that its
 * header promises. */
pcl::PolygonMesh readPly(const std::filesystem::path& path);

/** \brief Writes a binary PLY file of positions (x, y, z as floats), of colours if there are some (rgb), and
 * of faces. */
void writePly(std::ostream& out, const pcl::PolygonMesh& mesh);

}  // namespace facetloc
