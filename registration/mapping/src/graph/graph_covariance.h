// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/pose_graph.h"

#include <Eigen/SparseCholesky>

#include <mutex>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief How well the nodes of a graph are known: columns of the inverse of its normal matrix, at given
 * poses and with the robust weights of these. Never changes; thread-safe. */
class GraphCovariance {
public:
  /** \param threads of the computation, 0 = all cores Throws the exceptions of optimized(). */
  explicit GraphCovariance(const PoseGraph& graph, int threads = 1);

  /** \brief T_a_b of two nodes with its covariance; nothing if they are in different parts. */
  std::optional<PoseWithCovariance> between(int a, int b) const;

  /** \name Results that take as long for one node as for all; computed by the first of these calls */
  /// @{
  /** \brief Covariance of each node relative to the first of its part. */
  const std::vector<Matrix6d>& ofNodes() const;
  /** \brief T_node_n of each node n with its covariance; nothing for nodes of other parts. */
  std::vector<std::optional<PoseWithCovariance>> relativeTo(int node) const;
  /// @}

private:
  Eigen::MatrixXd columns(int node) const;
  Matrix6d effectOfFirst(int a, int b) const;
  PoseWithCovariance relative(int a, int b, const Matrix6d& of_difference) const;

  std::vector<Eigen::Isometry3d> T_w_n_;
  std::vector<int> part_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  int threads_;
  bool holds_first_;  // node of each part
  mutable std::once_flag computed_;
  mutable std::vector<Matrix6d> of_nodes_;
};

}  // namespace facetloc::internal
