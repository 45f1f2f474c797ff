// SPDX-License-Identifier: BSD-3-Clause
#include "pcd_points.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <pcl/io/pcd_io.h>

#include <clocale>
#include <cstddef>
#include <locale.h>
#include <sstream>
#include <string>

namespace facetloc {

namespace {

/** Numbers with decimal points for this thread, as PCL's reader of ASCII files needs them, while it lives. */
class PlainNumbers {
public:
  PlainNumbers() : plain_(newlocale(LC_NUMERIC_MASK, "C", nullptr)), before_(uselocale(plain_)) {}
  PlainNumbers(const PlainNumbers&) = delete;
  PlainNumbers& operator=(const PlainNumbers&) = delete;
  ~PlainNumbers() {
    uselocale(before_);
    freelocale(plain_);
  }

private:
  locale_t plain_, before_;
};

Eigen::Isometry3d poseOf(const Eigen::Vector4f& origin, const Eigen::Quaternionf& orientation) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Eigen::Quaterniond q = orientation.cast<double>();
  if (!origin.allFinite() || !q.coeffs().allFinite() || !(q.norm() > 0.5)) return T;
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = origin.head<3>().cast<double>();
  return T;
}

}  // namespace

pcl::PCLPointCloud2 readPcd(const std::filesystem::path& path, const PcdHeader& header,
                            Eigen::Isometry3d* viewpoint) {
  const PlainNumbers plain;
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
  if (viewpoint) *viewpoint = poseOf(origin, orientation);
  return cloud;
}

void writePcd(const std::filesystem::path& path, const pcl::PCLPointCloud2& points) {
  std::ostringstream bytes;  // where PCL writes a file itself, it does not tell why it cannot
  if (pcl::PCDWriter().writeBinaryCompressed(bytes, points) != 0)
    throw IoError(path.string(), "cannot be written: PCL cannot compress it");
  writeTextAtomically(path, [&](std::ostream& out) { out << bytes.str(); });
}

}  // namespace facetloc
