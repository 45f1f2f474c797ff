// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/graph_covariance.h"

#include "mapping/pose_problem.h"
#include "shared/in_parallel.h"

namespace facetloc::internal {
namespace {

// Of what is held, and keeps the normal matrix regular where nothing is known [1 / rad^2, 1 / m^2].
constexpr double kHeld = 1e12, kLeast = 1e-8;

}  // namespace

GraphCovariance::GraphCovariance(const PoseGraph& graph, int threads)
    : T_w_n_(graph.T_w_n), part_(partsOf(graph)), of_nodes_(graph.T_w_n.size(), Matrix6d::Zero()) {
  const Eigen::SparseMatrix<double> J = PoseProblem(graph, part_).jacobian();
  Eigen::SparseMatrix<double> normal = Eigen::SparseMatrix<double>(J.transpose()) * J;
  Eigen::SparseMatrix<double> least(normal.rows(), normal.cols());
  least.setIdentity();
  least *= kLeast;
  if (!graph.floor)
    for (std::size_t i = 0; i < part_.size(); ++i)
      for (int k = 0; part_[i] == static_cast<int>(i) && k < 6; ++k)
        least.coeffRef(static_cast<Eigen::Index>(6 * i) + k, static_cast<Eigen::Index>(6 * i) + k) = kHeld;
  normal += least;
  factor_.compute(normal);
  if (factor_.info() != Eigen::Success)
    throw std::runtime_error("pose graph: its covariances cannot be computed");
  forEachInParallel(static_cast<int>(of_nodes_.size()), threads, [&](int i) {
    if (!graph.floor && part_[i] == i) return;
    const Matrix6d P = columns(i).middleRows<6>(6 * i);
    of_nodes_[i] = 0.5 * (P + P.transpose());
  });
}

Eigen::MatrixXd GraphCovariance::columns(int node) const {
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(factor_.rows(), 6);
  unit.middleRows<6>(6 * node).setIdentity();
  return factor_.solve(unit);
}

// With the left, decoupled perturbations of both: d phi = R_a^T (d phi_b - d phi_a),
// d t = R_a^T (d t_b - d t_a + [t_b - t_a]x d phi_a).
std::vector<std::optional<PoseWithCovariance>> GraphCovariance::relativeTo(int node) const {
  std::vector<std::optional<PoseWithCovariance>> out(T_w_n_.size());
  const Eigen::MatrixXd of_node = columns(node);
  const Eigen::Isometry3d& T_w_a = T_w_n_[node];
  for (int b = 0; b < static_cast<int>(T_w_n_.size()); ++b) {
    if (part_[b] != part_[node]) continue;
    Matrix6d of_a = -Matrix6d::Identity();
    of_a.bottomLeftCorner<3, 3>() = skew(T_w_n_[b].translation() - T_w_a.translation());
    const Matrix6d P_ba = of_node.middleRows<6>(6 * b);
    const Matrix6d cross = P_ba * of_a.transpose();
    Matrix6d P = of_nodes_[b] + cross + cross.transpose() + of_a * of_nodes_[node] * of_a.transpose();
    if (b == node) P.setZero();
    out[b] = PoseWithCovariance{T_w_a.inverse() * T_w_n_[b], turned(T_w_a.linear().transpose(), P)};
  }
  return out;
}

}  // namespace facetloc::internal
