// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/mapping/map_builder.h>

#include <cmath>

namespace facetloc {

bool MapBuilder::accept(const Eigen::Isometry3d& T_w_c) {
  constexpr double kSlack = 1e-9;  // exactly half a metre counts as half a metre, whatever the rounding
  if (latest_) {
    const double distance = (T_w_c.translation() - latest_->translation()).norm();
    const double rotation = rotationAngle(T_w_c.linear() * latest_->linear().transpose());
    if (distance < params_.distance - kSlack && rotation < params_.rotation_deg * kDegree - kSlack)
      return false;
  }
  latest_ = T_w_c;
  return true;
}

Link MapBuilder::link(int from, int to, const Eigen::Isometry3d& T_w_from,
                      const Eigen::Isometry3d& T_w_to) const {
  Link l;
  l.from = from;
  l.to = to;
  l.T_from_to.T = T_w_from.inverse() * T_w_to;
  // Both poses err, and an error of the first one's rotation turns the displacement.
  const double rotation = std::pow(params_.pose_rotation_std_deg * kDegree, 2);
  const Eigen::Matrix3d lever = skew(l.T_from_to.T.translation());
  l.T_from_to.P.diagonal() << Eigen::Vector3d::Constant(2 * rotation),
      Eigen::Vector3d::Constant(2 * std::pow(params_.pose_translation_std, 2));
  l.T_from_to.P.bottomRightCorner<3, 3>() += rotation * lever * lever.transpose();
  l.T_from_to.P.bottomLeftCorner<3, 3>() = -rotation * lever;
  l.T_from_to.P.topRightCorner<3, 3>() = -rotation * lever.transpose();
  return l;
}

}  // namespace facetloc
