// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/pose_graph.h"

#include <Eigen/Cholesky>

#include <array>
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <cmath>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace facetloc::internal {
namespace {

// A pose as Ceres sees it. Its manifold turns a quaternion from the left, by half of the angle.
struct Parameters {
  Eigen::Quaterniond q;
  Eigen::Vector3d t;
};

// The left, decoupled perturbation between a measured motion and that of two poses, in its standard
// deviations.
class Mismatch {
public:
  explicit Mismatch(const PoseWithCovariance& T_from_to)
      : q_(T_from_to.T.linear()), t_(T_from_to.T.translation()), whitening_(whiteningOf(T_from_to.P)) {}

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
  static Matrix6d whiteningOf(const Matrix6d& P) {
    const Eigen::LLT<Matrix6d> llt(P);
    if (!P.allFinite() || llt.info() != Eigen::Success)
      throw std::invalid_argument("pose graph: the covariance of an edge is not positive definite");
    return llt.matrixL().solve(Matrix6d::Identity());
  }

  Eigen::Quaterniond q_;
  Eigen::Vector3d t_;
  Matrix6d whitening_;
};

void check(const PoseGraph& graph) {
  const int n = static_cast<int>(graph.T_w_n.size());
  for (const PoseEdge& e : graph.edges)
    if (e.from < 0 || e.to < 0 || e.from >= n || e.to >= n || e.from == e.to)
      throw std::invalid_argument("pose graph: an edge joins " + std::to_string(e.from) + " and " +
                                  std::to_string(e.to) + " of " + std::to_string(n) + " nodes");
}

// One problem for all parts: they do not see each other.
class Optimization {
public:
  explicit Optimization(const PoseGraph& graph, const std::vector<int>& part) : graph_(graph) {
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
      problem_->AddResidualBlock(
          new ceres::AutoDiffCostFunction<Mismatch, 6, 4, 3, 4, 3>(new Mismatch(e.T_from_to)),
          e.may_be_wrong ? &loss_ : nullptr, from.q.coeffs().data(), from.t.data(), to.q.coeffs().data(),
          to.t.data());
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (part[i] == static_cast<int>(i)) hold(nodes_[i]);
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

  std::vector<Matrix6d> covariances() {
    std::vector<Matrix6d> out(nodes_.size(), Matrix6d::Zero());
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::SPARSE_QR;
    options.apply_loss_function = true;
    ceres::Covariance covariance(options);
    std::vector<std::pair<const double*, const double*>> blocks;
    for (const Parameters& p : nodes_) {
      const double *const q = p.q.coeffs().data(), *const t = p.t.data();
      if (problem_->IsParameterBlockConstant(q)) continue;
      blocks.insert(blocks.end(), {{q, q}, {q, t}, {t, t}});
    }
    if (blocks.empty()) return out;
    if (!covariance.Compute(blocks, problem_.get()))
      throw std::runtime_error("pose graph: its covariances cannot be computed");
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const double *const q = nodes_[i].q.coeffs().data(), *const t = nodes_[i].t.data();
      if (problem_->IsParameterBlockConstant(q)) continue;
      using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
      Block qq, qt, tt;
      covariance.GetCovarianceBlockInTangentSpace(q, q, qq.data());
      covariance.GetCovarianceBlockInTangentSpace(q, t, qt.data());
      covariance.GetCovarianceBlockInTangentSpace(t, t, tt.data());
      out[i] << 4 * qq, 2 * qt, 2 * qt.transpose(), tt;  // of angles, not of their halves
    }
    return out;
  }

private:
  void hold(Parameters& p) {
    problem_->SetParameterBlockConstant(p.q.coeffs().data());
    problem_->SetParameterBlockConstant(p.t.data());
  }

  static constexpr double kEllipsoid = 12.59;  // of 95 % in 6 degrees of freedom
  const PoseGraph& graph_;
  ceres::EigenQuaternionManifold manifold_;
  ceres::CauchyLoss loss_{std::sqrt(kEllipsoid)};
  std::vector<Parameters> nodes_;
  std::unique_ptr<ceres::Problem> problem_;
};

}  // namespace

std::vector<int> partsOf(const PoseGraph& graph) {
  check(graph);
  std::vector<int> first(graph.T_w_n.size());
  std::iota(first.begin(), first.end(), 0);
  const auto root = [&first](int i) {
    while (first[i] != i) i = first[i] = first[first[i]];
    return i;
  };
  for (const PoseEdge& e : graph.edges) {
    const int a = root(e.from), b = root(e.to);
    first[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = root(static_cast<int>(i));
  return first;
}

GraphPoses optimized(const PoseGraph& graph, bool with_covariances) {
  GraphPoses out;
  out.part = partsOf(graph);
  Optimization optimization(graph, out.part);
  out.converged = graph.edges.empty() || optimization.solve();
  const std::vector<Matrix6d> P = with_covariances
                                      ? optimization.covariances()
                                      : std::vector<Matrix6d>(graph.T_w_n.size(), Matrix6d::Zero());
  for (std::size_t i = 0; i < graph.T_w_n.size(); ++i) out.nodes.push_back({optimization.pose(i), P[i]});
  for (const PoseEdge& e : graph.edges) {
    const Eigen::Isometry3d T_from_to = out.nodes[e.from].T.inverse() * out.nodes[e.to].T;
    const Vector6d d = perturbation(e.T_from_to.T, T_from_to);
    out.mismatch.push_back(d.dot(e.T_from_to.P.ldlt().solve(d)));
  }
  return out;
}

}  // namespace facetloc::internal
