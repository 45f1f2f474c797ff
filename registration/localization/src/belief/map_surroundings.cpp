// SPDX-License-Identifier: BSD-3-Clause
#include "belief/map_surroundings.h"

#include <Eigen/Cholesky>

#include <cmath>

namespace facetloc::internal {
namespace {

/** A robot on a floor: its axes lean against the normal, and it stands above or below. */
struct Stand {
  Eigen::Vector3d residual;  // (roll, pitch, height) about the floor [rad, rad, m]
  Eigen::Matrix3d by_floor;  // covariance of (slope along x, slope along y, height at the origin)

  Stand(const Eigen::Isometry3d& T_w_b, const Eigen::Isometry3d& T_w_f) {
    const Eigen::Isometry3d T_f_b = T_w_f.inverse() * T_w_b;
    const Eigen::Vector3d x = T_f_b.linear().col(0), y = T_f_b.linear().col(1), t = T_f_b.translation();
    residual << y.z(), -x.z(), t.z();
    by_floor << -y.x(), -y.y(), 0, x.x(), x.y(), 0, -t.x(), -t.y(), -1;
  }
};

Eigen::Isometry3d frame(const Eigen::Vector3d& normal, const Eigen::Vector3d& origin) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotationBetween(Eigen::Vector3d::UnitZ(), normal);
  T.translation() = origin;
  return T;
}

}  // namespace

FloorPlane floorUnder(const std::vector<Eigen::Isometry3d>& T_w_c, const CameraMounting& mounting,
                      const Eigen::Matrix3d& covariance, const Eigen::Vector3d& place) {
  constexpr double kUneven = 0.005;  // height of a floor by the distance [m/m]
  const Eigen::Isometry3d T_c_b = mounting.T_b_c().inverse();
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), origin = Eigen::Vector3d::Zero();
  for (const Eigen::Isometry3d& T : T_w_c) {
    const Eigen::Isometry3d T_w_b = T * T_c_b;
    up += T_w_b.linear().col(2);
    origin += T_w_b.translation() / static_cast<double>(T_w_c.size());
  }
  const Eigen::Isometry3d T_w_f = frame(up.normalized(), origin);

  // Linear least squares in the two slopes and the height: tilts of robots are small.
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Eigen::Isometry3d& T : T_w_c) {
    const Eigen::Isometry3d T_w_b = T * T_c_b;
    const Stand stand(T_w_b, T_w_f);
    Eigen::Matrix3d C = covariance;
    C(2, 2) += kUneven * kUneven * (T.translation() - place).squaredNorm();
    const Eigen::Matrix3d WJ = C.ldlt().solve(stand.by_floor);
    A += stand.by_floor.transpose() * WJ;
    b -= WJ.transpose() * stand.residual;
  }
  FloorPlane floor;
  floor.covariance = A.inverse();
  const Eigen::Vector3d found = floor.covariance * b;
  const Eigen::Vector3d normal(-found.x(), -found.y(), 1);
  floor.T_w_f = T_w_f * frame(normal.normalized(), {0, 0, found.z()});  // the covariance's axes stay
  return floor;
}

PoseWithCovariance updatedByFloor(const PoseWithCovariance& T_w_c, const CameraMounting& mounting,
                                  const FloorPlane& floor, const Eigen::Matrix3d& covariance,
                                  double repeated) {
  const Eigen::Isometry3d T_w_b = T_w_c.T * mounting.T_b_c().inverse();
  const Eigen::Vector3d x = T_w_b.linear().col(0), y = T_w_b.linear().col(1);
  const Eigen::Vector3d arm = T_w_b.translation() - T_w_c.T.translation();  // turns with the camera
  const Eigen::Vector3d n = floor.T_w_f.linear().col(2);
  const Stand stand(T_w_b, floor.T_w_f);
  Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Zero();
  H.block<1, 3>(0, 0) = y.cross(n).transpose();
  H.block<1, 3>(1, 0) = -x.cross(n).transpose();
  H.block<1, 3>(2, 0) = arm.cross(n).transpose();
  H.block<1, 3>(2, 3) = n.transpose();

  const Eigen::Matrix3d R =
      repeated * (covariance + stand.by_floor * floor.covariance * stand.by_floor.transpose());
  const Eigen::Matrix3d S = H * T_w_c.P * H.transpose() + R;
  const Eigen::Matrix<double, 6, 3> K = S.ldlt().solve(H * T_w_c.P).transpose();
  PoseWithCovariance out;
  out.T = boxplus(T_w_c.T, -K * stand.residual);
  const Matrix6d left = Matrix6d::Identity() - K * H;  // Joseph form: stays positive definite
  out.P = left * T_w_c.P * left.transpose() + K * R * K.transpose();
  return out;
}

MapSurroundings::MapSurroundings(std::shared_ptr<const Map> map, const DepthComparison& comparison)
    : map_(std::move(map)), comparison_(comparison), near_(map_) {}

LocalMap MapSurroundings::around(const View& view, int part, const Eigen::Isometry3d& T_w_c, int n) const {
  constexpr int kCompared = 3;       // times as many models are compared as are wanted
  constexpr int kFewestPixels = 15;  // pixels of the coarse grid that a model must confirm: a twentieth
  struct Found {
    int model;
    std::shared_ptr<const View> view;
  };
  std::vector<Found> confirming, silent;  // nearest first
  for (const int i : near_.bySight(part, T_w_c, kTrackingReach, kCompared * n)) {
    const Eigen::Isometry3d T_m_c = map_->models[i].T_w_m->inverse() * T_w_c;
    Found found{i, map_->view(i)};
    const int pixels = comparison_.count(view.depth, found.view->depth, T_m_c, kCoarseColumns).agree;
    (pixels >= kFewestPixels ? confirming : silent).push_back(std::move(found));
  }
  LocalMap out;
  const auto add = [&](const std::vector<Found>& models, bool with_picture) {
    for (const Found& found : models) {
      if (static_cast<int>(out.views.size()) >= n) return;
      out.add(found.model, found.view, *map_->models[found.model].T_w_m);
      if (!with_picture && !found.view->depth.empty()) out.pictures.pop_back();
    }
  };
  add(confirming, true);
  add(silent, false);
  return out;
}

std::optional<FloorPlane> MapSurroundings::floorNear(int part, const Eigen::Isometry3d& T_w_c, int n,
                                                     const Eigen::Matrix3d& covariance) const {
  constexpr int kAsked = 3;  // times as many models are asked as are wanted
  constexpr double kStep = 0.1,
                   kSlope = 0.05;  // tolerance of one floor [m], and its growth with the distance
  if (!map_->camera.mounting || near_.empty()) return {};
  const std::vector<int> near = near_.byPlace(part, T_w_c.translation(), kAsked * n);
  const Eigen::Isometry3d T_c_b = map_->camera.mounting->T_b_c().inverse();
  const Eigen::Vector3d here = (T_w_c * T_c_b).translation();
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const int i : near) up += map_->models[i].T_w_m->linear() * T_c_b.linear().col(2);
  up.normalize();
  std::vector<Eigen::Isometry3d> poses;  // on the floor that the robot stands on, nearest first
  for (const int i : near) {
    const Eigen::Isometry3d& T_w_m = *map_->models[i].T_w_m;
    const Eigen::Vector3d away = (T_w_m * T_c_b).translation() - here;
    if (std::abs(up.dot(away)) > kStep + kSlope * away.norm()) continue;
    if (static_cast<int>(poses.size()) < n) poses.push_back(T_w_m);
  }
  if (poses.empty()) return {};
  return floorUnder(poses, *map_->camera.mounting, covariance, T_w_c.translation());
}

}  // namespace facetloc::internal
