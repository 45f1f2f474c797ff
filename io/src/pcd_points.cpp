// SPDX-License-Identifier: BSD-3-Clause
#include "pcd_points.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <pcl/io/pcd_io.h>

#include <cstddef>
#include <sstream>
#include <string>

namespace facetloc {

pcl::PCLPointCloud2 readPcd(const std::filesystem::path& path, const PcdHeader& header) {
  pcl::PCLPointCloud2 cloud;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0;
  int status = 0;
  try {
    status = pcl::PCDReader().read(path.string(), cloud, origin, orientation, version);
  } catch (const std::exception& e) {
    throw IoError(path.string(), std::string("cannot be read by PCL: ") + e.what());
  }
  const std::size_t points = std::size_t(header.width()) * header.height();
  if (status < 0 || cloud.width != static_cast<unsigned>(header.width()) ||
      cloud.data.size() != points * cloud.point_step)
    throw IoError(path.string(), "is a corrupt PCD file");
  return cloud;
}

void writePcd(const std::filesystem::path& path, const pcl::PCLPointCloud2& points) {
  std::ostringstream bytes;  // where PCL writes a file itself, it does not tell why it cannot
  if (pcl::PCDWriter().writeBinaryCompressed(bytes, points) != 0)
    throw IoError(path.string(), "cannot be written: PCL cannot compress it");
  writeTextAtomically(path, [&](std::ostream& out) { out << bytes.str(); });
}

}  // namespace facetloc
