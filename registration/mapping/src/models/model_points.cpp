// SPDX-License-Identifier: BSD-3-Clause
#include "models/model_points.h"

#include <cstring>
#include <fmt/core.h>
#include <stdexcept>

namespace facetloc::internal {
namespace {

const pcl::PCLPointField* fieldOf(const pcl::PCLPointCloud2& cloud, const std::string& name) {
  for (const pcl::PCLPointField& field : cloud.fields)
    if (field.name == name && field.datatype == pcl::PCLPointField::FLOAT32 &&
        field.offset + sizeof(float) <= cloud.point_step)
      return &field;
  return nullptr;
}

}  // namespace

ModelPoints::ModelPoints(const pcl::PCLPointCloud2& cloud)
    : cloud_(cloud), size_(static_cast<std::size_t>(cloud.width) * cloud.height) {
  constexpr std::array<const char*, 3> kNames{"x", "y", "z"};
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const pcl::PCLPointField* field = fieldOf(cloud, kNames[k]);
    if (!field) throw std::invalid_argument(fmt::format("its points have no field {} of floats", kNames[k]));
    offsets_[k] = field->offset;
  }
  if (cloud.data.size() / cloud.point_step < size_)
    throw std::invalid_argument(fmt::format("it has less data than its {} points need", size_));
}

Eigen::Vector3f ModelPoints::operator[](std::size_t i) const {
  const std::uint8_t* point = cloud_.data.data() + i * cloud_.point_step;
  Eigen::Vector3f value;
  for (int k = 0; k < 3; ++k)
    std::memcpy(&value[k], point + offsets_[static_cast<std::size_t>(k)], sizeof(float));
  return value;
}

void requireResolved(const Eigen::AlignedBox3d& bounds) {
  constexpr double kFarthest = 1e4;  // [m] beyond, floats are a millimetre apart
  if (bounds.isEmpty()) return;
  const double farthest = bounds.min().cwiseAbs().cwiseMax(bounds.max().cwiseAbs()).maxCoeff();
  if (farthest > kFarthest)
    throw std::invalid_argument(fmt::format(
        "its coordinates reach {:.4g} km from the origin, where floats do not resolve millimetres; "
        "check the unit, or subtract an offset",
        farthest / 1e3));
}

}  // namespace facetloc::internal
