// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/pose_graph.h"

#include <facetloc/features/pose.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace facetloc::internal {

// A pose as Ceres sees it. Its manifold turns a quaternion from the left, by half of the angle.
struct Parameters {
  Eigen::Quaterniond q;
  Eigen::Vector3d t;
};

template <class Matrix>
Matrix whiteningOf(const Matrix& P, const char* of_what) {
  const Eigen::LLT<Matrix> llt(P);
  if (!P.allFinite() || llt.info() != Eigen::Success)
    throw std::invalid_argument(std::string("pose graph: the covariance of ") + of_what +
                                " is not positive definite");
  return llt.matrixL().solve(Matrix::Identity());
}

// The left, decoupled perturbation between a measured motion and the one of two poses, in its standard
// deviations.
class Mismatch {
public:
  explicit Mismatch(const PoseWithCovariance& T_from_to)
      : q_(T_from_to.T.linear()),
        t_(T_from_to.T.translation()),
        whitening_(whiteningOf(T_from_to.P, "an edge")) {}

  template <class Number>
  bool operator()(const Number* q_from, const Number* t_from, const Number* q_to, const Number* t_to,
                  Number* residual) const {
    using Quaternion = Eigen::Quaternion<Number>;
    using Vector3 = Eigen::Matrix<Number, 3, 1>;
    const Eigen::Map<const Quaternion> from(q_from), to(q_to);
    const Eigen::Map<const Vector3> at(t_from), then(t_to);
    const Quaternion back = from.conjugate();
    const Quaternion turn = back * to * q_.conjugate().cast<Number>();
    const Number wxyz[4] = {turn.w(), turn.x(), turn.y(), turn.z()};
    Eigen::Matrix<Number, 6, 1> d;
    ceres::QuaternionToAngleAxis(wxyz, d.data());
    d.template tail<3>() = back * (then - at) - t_.cast<Number>();
    Eigen::Map<Eigen::Matrix<Number, 6, 1>> whitened(residual);
    whitened = whitening_.cast<Number>() * d;
    return true;
  }

private:
  Eigen::Quaterniond q_;
  Eigen::Vector3d t_;
  Matrix6d whitening_;
};

// The alternative that fits best, in a seventh residual with its odds: max-mixture (METHOD 1.3).
class LeastMismatch {
public:
  explicit LeastMismatch(const PoseEdge& edge) : modes_{{Mismatch(edge.T_from_to), 0}} {
    for (const AlternativeMotion& other : edge.others)
      modes_.push_back({Mismatch(other.T_from_to), std::sqrt(-2 * std::min(0.0, other.log_odds))});
  }

  template <class Number>
  bool operator()(const Number* q_from, const Number* t_from, const Number* q_to, const Number* t_to,
                  Number* residual) const {
    using Residuals = Eigen::Matrix<Number, 7, 1>;
    Eigen::Map<Residuals> least(residual);
    for (const Mode& mode : modes_) {
      Residuals of_mode;
      mode.mismatch(q_from, t_from, q_to, t_to, of_mode.data());
      of_mode(6) = Number(mode.of_odds);
      if (&mode == &modes_.front() || of_mode.squaredNorm() < least.squaredNorm()) least = of_mode;
    }
    return true;
  }

private:
  struct Mode {
    Mismatch mismatch;
    double of_odds;
  };
  std::vector<Mode> modes_;
};

// (roll, pitch, height) of a robot about the floor, in their standard deviations.
class Standing {
public:
  explicit Standing(const LevelFloor& floor)
      : q_(floor.T_b_c.inverse().linear()),
        t_(floor.T_b_c.inverse().translation()),
        whitening_(whiteningOf(floor.covariance, "the floor")) {}

  template <class Number>
  bool operator()(const Number* q_node, const Number* t_node, Number* residual) const {
    const Eigen::Map<const Eigen::Quaternion<Number>> q(q_node);
    const Eigen::Map<const Eigen::Matrix<Number, 3, 1>> t(t_node);
    const Eigen::Matrix<Number, 3, 3> R = (q * q_.cast<Number>()).toRotationMatrix();
    const Eigen::Matrix<Number, 3, 1> at = q * t_.cast<Number>() + t;
    Eigen::Map<Eigen::Matrix<Number, 3, 1>> whitened(residual);
    whitened = whitening_.cast<Number>() * Eigen::Matrix<Number, 3, 1>(R(2, 1), -R(2, 0), at.z());
    return true;
  }

private:
  Eigen::Quaterniond q_;  // rotation of the robot in its camera
  Eigen::Vector3d t_;
  Eigen::Matrix3d whitening_;
};

// A node that keeps its place and heading on the floor.
class Anchor {
public:
  explicit Anchor(const Parameters& at) : q_(at.q), t_(at.t) {}

  template <class Number>
  bool operator()(const Number* q_node, const Number* t_node, Number* residual) const {
    const Eigen::Map<const Eigen::Quaternion<Number>> q(q_node);
    const Eigen::Quaternion<Number> turn = q * q_.conjugate().cast<Number>();
    constexpr double kStd = 1e-5;  // [m, rad]
    residual[0] = (t_node[0] - t_.x()) / kStd;
    residual[1] = (t_node[1] - t_.y()) / kStd;
    residual[2] = 2.0 * turn.z() / kStd;
    return true;
  }

private:
  Eigen::Quaterniond q_;
  Eigen::Vector3d t_;
};

// One problem for all parts: they do not see each other.
class PoseProblem {
public:
  PoseProblem(const PoseGraph& graph, const std::vector<int>& part) : graph_(graph) {
    for (const Eigen::Isometry3d& T : graph.T_w_n)
      nodes_.push_back({Eigen::Quaterniond(T.linear()).normalized(), T.translation()});
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_ = std::make_unique<ceres::Problem>(options);
    for (Parameters& p : nodes_) {
      problem_->AddParameterBlock(p.q.coeffs().data(), 4, &manifold_);
      problem_->AddParameterBlock(p.t.data(), 3);
    }
    for (const PoseEdge& e : graph.edges) {
      Parameters &from = nodes_[e.from], &to = nodes_[e.to];
      ceres::CostFunction* cost =
          e.others.empty()
              ? static_cast<ceres::CostFunction*>(
                    new ceres::AutoDiffCostFunction<Mismatch, 6, 4, 3, 4, 3>(new Mismatch(e.T_from_to)))
              : new ceres::AutoDiffCostFunction<LeastMismatch, 7, 4, 3, 4, 3>(new LeastMismatch(e));
      problem_->AddResidualBlock(cost, e.may_be_wrong ? &loss_ : nullptr, from.q.coeffs().data(),
                                 from.t.data(), to.q.coeffs().data(), to.t.data());
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (graph.floor) applyFloor(nodes_[i], *graph.floor);
      if (part[i] == static_cast<int>(i)) hold(nodes_[i]);
    }
  }

  bool solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 100;
    options.num_threads = 1;  // so that sums have one order
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem_.get(), &summary);
    return summary.IsSolutionUsable() && summary.termination_type == ceres::CONVERGENCE;
  }

  Eigen::Isometry3d pose(std::size_t i) const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = nodes_[i].q.normalized().toRotationMatrix();
    T.translation() = nodes_[i].t;
    return T;
  }

  /** Jacobian by the poses' left, decoupled perturbations, with the robust weights of these poses: one row
   * for each residual, six columns for each node. */
  Eigen::SparseMatrix<double> jacobian() const {
    ceres::Problem::EvaluateOptions options;
    options.num_threads = 1;
    for (const Parameters& p : nodes_) {
      options.parameter_blocks.push_back(const_cast<double*>(p.q.coeffs().data()));
      options.parameter_blocks.push_back(const_cast<double*>(p.t.data()));
    }
    ceres::CRSMatrix rows;
    problem_->Evaluate(options, nullptr, nullptr, nullptr, &rows);
    std::vector<int> column;  // columns of the nodes that are not fixed
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (!problem_->IsParameterBlockConstant(nodes_[i].t.data()))
        for (int k = 0; k < 6; ++k) column.push_back(static_cast<int>(6 * i) + k);
    const bool is_whole = rows.num_cols == static_cast<int>(6 * nodes_.size());
    std::vector<Eigen::Triplet<double>> entries;
    for (int r = 0; r < rows.num_rows; ++r)
      for (int i = rows.rows[r]; i < rows.rows[r + 1]; ++i) {
        const int c = is_whole ? rows.cols[i] : column[rows.cols[i]];
        const double of_angle = c % 6 < 3 ? 0.5 : 1;  // the manifold counts halves of angles
        entries.emplace_back(r, c, of_angle * rows.values[i]);
      }
    Eigen::SparseMatrix<double> J(rows.num_rows, static_cast<Eigen::Index>(6 * nodes_.size()));
    J.setFromTriplets(entries.begin(), entries.end());
    return J;
  }

private:
  void applyFloor(Parameters& p, const LevelFloor& floor) {
    problem_->AddResidualBlock(new ceres::AutoDiffCostFunction<Standing, 3, 4, 3>(new Standing(floor)),
                               &floor_loss_, p.q.coeffs().data(), p.t.data());
  }

  void hold(Parameters& p) {
    if (graph_.floor) {
      problem_->AddResidualBlock(new ceres::AutoDiffCostFunction<Anchor, 3, 4, 3>(new Anchor(p)), nullptr,
                                 p.q.coeffs().data(), p.t.data());
      return;
    }
    problem_->SetParameterBlockConstant(p.q.coeffs().data());
    problem_->SetParameterBlockConstant(p.t.data());
  }

  static constexpr double kEllipsoid = chiSquareQuantile(6, 0.95);
  static constexpr double kFloorEllipsoid = chiSquareQuantile(3, 0.95);
  const PoseGraph& graph_;
  ceres::EigenQuaternionManifold manifold_;
  ceres::CauchyLoss loss_{std::sqrt(kEllipsoid)}, floor_loss_{std::sqrt(kFloorEllipsoid)};
  std::vector<Parameters> nodes_;
  std::unique_ptr<ceres::Problem> problem_;
};

}  // namespace facetloc::internal
