// SPDX-License-Identifier: BSD-3-Clause
#include "motion/view_odometry.h"

#include <facetloc/features/pose.h>
#include <facetloc/registration/pose_prior.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace facetloc::internal {
namespace {

constexpr int kFewestPixels = 60;           // that must be compared before their agreement says anything
constexpr double kLongStep = 0.2;           // after which a velocity says nothing of the next one [s]
constexpr double kLeastAgreement = 0.7;     // share of the depth pixels that the keyframes must confirm
constexpr int kKeys = 2;                    // nearest keyframes that a view is aligned with
constexpr int kKeptKeys = 20;               // latest keyframes that are kept
constexpr double kSlipSpeed = 0.01;         // speed of a robot on wheels, sideways and up and down [m/s]
constexpr double kTiltRate = 10 * kDegree;  // roll and pitch of a robot on wheels [rad/s]
constexpr double kSlipTime = 1.0;           // time over which the slip of wheels is correlated [s]
constexpr double kSideSlipChange = 0.2;     // change of the speed sideways in a second [m/s]
constexpr double kSure = 3;                 // standard deviations
constexpr double kGate = chiSquareQuantile(6, 0.99);
// Keeps the prior regular when no time has passed.
constexpr double kLeastRotation = 1e-4, kLeastTranslation = 1e-4;  // [rad, m]

}  // namespace

void ViewOdometry::reset() {
  keys_.clear();
  T_o_c_.setIdentity();
  velocity_.setZero();
  side_slip_ = {};
}

ViewMotion ViewOdometry::add(const View& view, double dt) {
  ViewMotion out;
  camera_motion_.reset();
  if (view.camera && view.camera->mounting) {
    camera_motion_ = cameraMotion(*view.camera->mounting);
    jolt_ = posePrior(*view.camera->mounting, {kLeastRotation / kDegree, kLeastTranslation, {}});
  }
  const PoseWithCovariance predicted = predict(dt);
  PoseWithCovariance T_o_c = predicted;
  if (!keys_.empty()) {
    const LocalMap around_us = around(predicted.T);
    T_o_c = aligned(view, around_us, predicted);
    const DepthAgreement found =
        compareWithAll(view.depth, T_o_c.T, around_us.pictures, comparison_, kFineColumns);
    if (found.judged() >= kFewestPixels) {
      out.agreement = found.agree / double(found.judged());
      out.broken = !(out.agreement >= kLeastAgreement);
    }
  }
  if (out.broken) {
    T_o_c = predicted;
    keys_.clear();
    velocity_.setZero();
    side_slip_ = {};
  }
  const bool moves = !out.broken && dt > 0 && dt < kLongStep;
  if (moves) learnVelocity(predicted, T_o_c, dt);
  if (!out.broken) T_o_c.P = errorOfStep(predicted.P, T_o_c);
  if (!moves && dt > 0) velocity_.setZero();
  if (camera_motion_ && moves) applyNonholonomic(T_o_c, dt);

  out.T_a_b = T_o_c_.inverse() * T_o_c;
  T_o_c_ = T_o_c.T;
  takeKey(view);
  return out;
}

// A robot on wheels tilts slowly, but for a jolt: where the views deny the prediction, they are believed.
PoseWithCovariance ViewOdometry::aligned(const View& view, const LocalMap& around_us,
                                         const PoseWithCovariance& predicted) const {
  if (!camera_motion_) return alignView(view, around_us, predicted, alignment_).T_w_c;
  PoseWithCovariance jolted = predicted;
  jolted.P += rotateCovariance(T_o_c_.linear(), jolt_);
  const PoseWithCovariance seen = alignView(view, around_us, jolted, alignment_).T_w_c;
  const Matrix6d of_jolted = symmetricInverse(jolted.P), of_prediction = symmetricInverse(predicted.P);
  const Matrix6d of_views = symmetricInverse(seen.P) - of_jolted;
  const Matrix6d P = symmetricInverse(of_views + of_prediction);
  const Vector6d off = boxminus(predicted.T, seen.T), shift = P * (of_prediction - of_jolted) * off;
  const Vector6d left = off - shift;
  if (shift.dot(of_views * shift) + left.dot(of_prediction * left) > kGate) return seen;
  return {boxplus(seen.T, shift), P};
}

// Kalman update of the pose after a motion by wheels that do not slip sideways, seen through the mounting. A
// robot that has been seen to slip sideways is believed.
void ViewOdometry::applyNonholonomic(PoseWithCovariance& T_o_c, double dt) {
  const Eigen::Matrix3d R_c_o = T_o_c_.linear().transpose();
  const Vector6d sideways =
      camera_motion_->inverse().row(4).transpose();  // row of a motion in the last camera's axes
  Vector6d h;
  h << R_c_o.transpose() * sideways.head<3>(), R_c_o.transpose() * sideways.tail<3>();
  const Eigen::Isometry3d motion = T_o_c_.inverse() * T_o_c.T;
  const double shift = sideways.dot(boxminus(motion, Eigen::Isometry3d::Identity()));
  const double variance = h.dot(T_o_c.P * h);

  side_slip_.variance += kSideSlipChange * kSideSlipChange * dt;
  const double weight = side_slip_.variance / (side_slip_.variance + variance / (dt * dt));
  side_slip_.speed += weight * (shift / dt - side_slip_.speed);
  side_slip_.variance *= 1 - weight;
  if (slips()) return;

  const double slip = kSlipSpeed * std::sqrt(dt * kSlipTime) + kLeastTranslation;
  const Vector6d gain = T_o_c.P * h / (variance + slip * slip);
  T_o_c.T = boxplus(T_o_c.T, -gain * shift);
  const Matrix6d left = Matrix6d::Identity() - gain * h.transpose();  // Joseph form
  T_o_c.P = left * T_o_c.P * left.transpose() + slip * slip * gain * gain.transpose();
}

bool ViewOdometry::slips() const {
  return std::abs(side_slip_.speed) > kSure * std::sqrt(side_slip_.variance) + kSlipSpeed;
}

// Growth of the error of the camera's pose in this step. Of a posterior P after a prediction P0, the part P
// P0^-1 P comes from the prediction and is new with every view. The other comes from the keyframes, whose
// errors stay the same until the camera has moved on to the next ones.
Matrix6d ViewOdometry::errorOfStep(const Matrix6d& predicted, const PoseWithCovariance& T_o_c) const {
  const Eigen::Isometry3d step = T_o_c_.inverse() * T_o_c.T;
  const double of_keys = step.translation().norm() / params_.key_distance +
                         rotationAngle(step.linear()) / (params_.key_rotation_deg * kDegree);
  const double part = std::min(1.0, of_keys);
  const Matrix6d P = part * T_o_c.P + (1 - part) * T_o_c.P * predicted.ldlt().solve(T_o_c.P);
  return 0.5 * (P + P.transpose());
}

// As far as the views know the motion, and smoothed: the difference of two poses is too rough to go on
// with where the views tell nothing. Who goes straight on will do so; who turns will stop.
void ViewOdometry::learnVelocity(const PoseWithCovariance& predicted, const PoseWithCovariance& found,
                                 double dt) {
  constexpr double kNew = 0.25, kTurn = 1.0;  // share of the new value, time constant of turning [s]
  const Matrix6d known = Matrix6d::Identity() - found.P * predicted.P.inverse();
  const Vector6d change = known * boxminus(found.T, predicted.T) / dt;
  const Eigen::Matrix3d R_c_o = T_o_c_.linear().transpose();
  velocity_.head<3>() *= std::exp(-dt / kTurn);
  velocity_.head<3>() += kNew * R_c_o * change.head<3>();
  velocity_.tail<3>() += kNew * R_c_o * change.tail<3>();
  if (!camera_motion_) return;
  Vector6d base = camera_motion_->partialPivLu().solve(velocity_);
  base[0] = base[1] = base[5] = 0;  // on its floor
  velocity_ = *camera_motion_ * base;
}

PoseWithCovariance ViewOdometry::predict(double dt) const {
  Vector6d motion = dt < kLongStep ? Vector6d(dt * velocity_) : Vector6d(Vector6d::Zero());
  Vector6d std;
  std << Eigen::Vector3d::Constant(kTurnRateChangeDeg * kDegree * dt),
      Eigen::Vector3d::Constant(kSpeedChange * dt);
  Matrix6d P = std.cwiseAbs2().asDiagonal();
  if (camera_motion_) {
    const Matrix6d& A = *camera_motion_;
    Vector6d base = A.partialPivLu().solve(motion);
    if (!slips()) base[4] = 0;
    motion = A * base;
    std[0] = std[1] = kTiltRate * dt;
    std[5] = kSlipSpeed * std::sqrt(dt * kSlipTime);
    P = A * std.cwiseAbs2().asDiagonal() * A.transpose();
  }
  P.diagonal().head<3>().array() += kLeastRotation * kLeastRotation;
  P.diagonal().tail<3>().array() += kLeastTranslation * kLeastTranslation;
  return T_o_c_ * PoseWithCovariance{boxplus(Eigen::Isometry3d::Identity(), motion), P};
}

LocalMap ViewOdometry::around(const Eigen::Isometry3d& T_o_c) const {
  std::vector<std::pair<double, int>> near;
  for (std::size_t i = 0; i < keys_.size(); ++i)
    near.emplace_back(viewDistance(keys_[i].T_o_k, T_o_c), static_cast<int>(i));
  std::sort(near.begin(), near.end());
  if (static_cast<int>(near.size()) > kKeys) near.resize(kKeys);
  LocalMap out;
  for (const auto& [distance, i] : near)
    if (std::isfinite(distance)) out.add(i, unowned(keys_[i].view), keys_[i].T_o_k);
  return out;
}

void ViewOdometry::takeKey(const View& view) {
  if (view.segments.empty() && view.depth.empty()) return;
  const bool known = std::any_of(keys_.begin(), keys_.end(), [&](const Key& key) {
    const Eigen::Isometry3d T = key.T_o_k.inverse() * T_o_c_;
    return T.translation().norm() <= params_.key_distance &&
           rotationAngle(T.linear()) <= params_.key_rotation_deg * kDegree;
  });
  if (known) return;
  keys_.push_back({view, T_o_c_});
  if (static_cast<int>(keys_.size()) > kKeptKeys) keys_.pop_front();
}

}  // namespace facetloc::internal
