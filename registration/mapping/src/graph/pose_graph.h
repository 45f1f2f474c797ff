// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/mapping/trajectory_estimation.h>

#include <Eigen/SparseCholesky>

#include <mutex>
#include <optional>
#include <vector>

namespace facetloc::internal {

/** \brief A measured motion between two nodes of a graph. */
struct PoseEdge {
  int from = 0, to = 0;          ///< numbers of the nodes
  PoseWithCovariance T_from_to;  ///< positive definite
  bool may_be_wrong = false;     ///< a closed loop: has little weight if it contradicts all other edges
  std::vector<AlternativeMotion> others{};  ///< one of them may be chosen instead (max-mixture)

  /** \brief The motion, k = 0, or one of the others. */
  const PoseWithCovariance& mode(std::size_t k) const { return k == 0 ? T_from_to : others[k - 1].T_from_to; }
  /** \brief Squared Mahalanobis distance of a motion from a mode, less twice the log odds of the mode. */
  double mismatch(std::size_t k, const Eigen::Isometry3d& of_motion) const {
    return squaredMahalanobis(mode(k), of_motion) - (k == 0 ? 0 : 2 * others[k - 1].log_odds);
  }
};

/** \brief A level floor, z = 0, that robots with cameras stand on. */
struct LevelFloor {
  Eigen::Isometry3d T_b_c = Eigen::Isometry3d::Identity();   ///< pose of the camera on its robot
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< (roll, pitch, height) of a robot
};

/** \brief Poses of cameras, and the measurements between them. */
struct PoseGraph {
  std::vector<Eigen::Isometry3d> T_w_n;  ///< a first guess of each node
  std::vector<PoseEdge> edges;
  std::optional<LevelFloor> floor;  ///< that all nodes stand on, unless their edges contradict
};

/** \brief The most likely poses of a graph. */
struct GraphPoses {
  /// T_w_n; the covariance is relative to the first node of its part, which stays where it is; on a floor it
  /// keeps its place and heading there
  std::vector<PoseWithCovariance> nodes;
  std::vector<int> part;         ///< for each node: the number of the first node that edges lead to
  std::vector<double> mismatch;  ///< mismatchOf() each edge, of 6 degrees of freedom
};

/** \brief The number of the first node of its part, for each node: parts have no edge between them. Throws
 * std::invalid_argument if an edge joins an invalid node. */
std::vector<int> partsOf(const PoseGraph& graph);

/** \brief Squared Mahalanobis distance of an edge from the poses of its nodes; of alternatives, the least one
 * less twice their log odds. */
double mismatchOf(const PoseEdge& edge, const std::vector<PoseWithCovariance>& nodes);

/** \brief Least squares over the edges' covariances by Ceres Solver (Agarwal, Mierle et al.), METHOD 1.3.
 *
 * Edges that may be wrong, and the floor, have Cauchy's weight beyond the 95 % ellipsoid. The same graph
 * gives the same poses. \param with_covariances otherwise they are zero Throws std::invalid_argument for an
 * edge that joins an invalid node, or one node with itself, or whose covariance is not positive definite. */
GraphPoses optimized(const PoseGraph& graph, bool with_covariances = true);

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
