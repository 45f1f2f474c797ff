// SPDX-License-Identifier: BSD-3-Clause
#include "shortlist/known_gravity.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <vector>

namespace facetloc::internal {
namespace {

constexpr double kMountedStd = 2 * kDegree;  // tilt of a robot on its floor
constexpr double kWorldStd = 0.5 * kDegree;  // error of a world whose z axis the planes confirm

/** Two axes across a direction, as rows. */
Eigen::Matrix<double, 2, 3> across(const Eigen::Vector3d& direction) {
  Eigen::Matrix<double, 2, 3> B;
  B.row(0) = direction.unitOrthogonal();
  B.row(1) = direction.cross(B.row(0).transpose());
  return B;
}

/** How the planes of a map lie to the z axis of its world, by their support. */
class Verticality {
public:
  void add(const Eigen::Vector3d& normal, double weight) {
    constexpr double kNear = 4 * kDegree, kOtherWall = 30 * kDegree;
    const double sine = normal.head<2>().norm(), cosine = std::abs(normal.z());
    all_ += weight;
    if (sine <= std::sin(kNear)) level_ += weight;
    if (cosine > std::sin(kNear)) return;
    upright_ += weight;
    if (!first_wall_) first_wall_ = normal;
    if (first_wall_->cross(normal).norm() > std::sin(kOtherWall)) has_two_walls_ = true;
  }
  bool isVertical() const {
    constexpr double kMost = 0.75, kSome = 0.03;  // shares of the support
    return all_ > 0 && level_ + upright_ >= kMost * all_ && (level_ >= kSome * all_ || has_two_walls_);
  }

private:
  double all_ = 0, level_ = 0, upright_ = 0;
  std::optional<Eigen::Vector3d> first_wall_;
  bool has_two_walls_ = false;
};

}  // namespace

// Along a world in which the camera lies on its side, walls are upright, too: only its own up tells which
// axis of a world of right angles is vertical.
bool isWorldLevel(const Map& map) {
  constexpr std::size_t kViews = 50;
  constexpr double kUpright = 0.8;  // mean of how far the camera's up is up
  if (!map.parts.empty() && !map.parts.front().empty()) return false;
  std::vector<int> models;
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const auto T_w_m = map.models[i].givenPose();
    if (!T_w_m) continue;
    models.push_back(static_cast<int>(i));
    up -= T_w_m->linear().col(1);
  }
  if (models.empty() || up.z() < kUpright * up.norm()) return false;
  Verticality planes;
  const std::size_t step = std::max<std::size_t>(1, models.size() / kViews);
  for (std::size_t k = 0; k < models.size(); k += step) {
    const Eigen::Matrix3d R_w_m = map.models[static_cast<std::size_t>(models[k])].T_w_m->linear();
    const auto view = map.view(models[k]);
    for (const Segment& s : view->segments)
      if (s.R.allFinite()) planes.add(R_w_m * s.normal(), s.num_points);
  }
  return planes.isVertical();
}

bool MapGravity::isLevel() const {
  std::call_once(asked_, [this] { is_level_ = isWorldLevel(map_); });
  return is_level_;
}

std::optional<Gravity> MapGravity::of(int i, const View& view) const {
  if (view.gravity && view.gravity->valid()) return view.gravity;
  const Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  if (map_.camera.mounting)
    return Gravity{map_.camera.mounting->T_b_c().linear().transpose() * down, kMountedStd};
  const LocalModel& model = map_.models[static_cast<std::size_t>(i)];
  if (!model.T_w_m || model.part != 0 || !isLevel()) return {};
  return Gravity{model.T_w_m->linear().transpose() * down, kWorldStd};
}

Matrix6d gravityInformation(const Eigen::Vector3d& down_m, double std) {
  Matrix6d information = Matrix6d::Zero();
  information.topLeftCorner<3, 3>() =
      (Eigen::Matrix3d::Identity() - down_m * down_m.transpose()) / (std * std);
  return information;
}

PoseWithCovariance correctedByGravity(const PoseWithCovariance& prior, const Gravity& of_model,
                                      const Gravity& of_view, bool keeps_mean) {
  PoseWithCovariance out = prior;
  if (!keeps_mean) out.T.linear() = levelling(of_model.down).transpose() * levelling(of_view.down);
  const Eigen::Matrix<double, 2, 3> B = across(of_model.down);
  const Eigen::Vector3d down = out.T.linear() * of_view.down;
  const Eigen::Vector3d residual = logSO3(rotationBetween(down, of_model.down));
  Eigen::Matrix<double, 2, 6> H = Eigen::Matrix<double, 2, 6>::Zero();
  H.leftCols<3>() = B;
  const Eigen::Matrix2d R =
      (of_model.std * of_model.std + of_view.std * of_view.std) * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d S = H * out.P * H.transpose() + R;
  const Eigen::Matrix<double, 6, 2> K = S.ldlt().solve(H * out.P).transpose();
  out.T = boxplus(out.T, K * (B * residual));
  const Matrix6d left = Matrix6d::Identity() - K * H;  // Joseph form: stays positive definite
  out.P = left * out.P * left.transpose() + K * R * K.transpose();
  return out;
}

}  // namespace facetloc::internal
