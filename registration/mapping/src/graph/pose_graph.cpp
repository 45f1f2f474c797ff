// SPDX-License-Identifier: BSD-3-Clause
#include "graph/pose_graph.h"

#include "graph/pose_problem.h"
#include "threads/in_parallel.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>

namespace facetloc::internal {
namespace {

void check(const PoseGraph& graph) {
  const int n = static_cast<int>(graph.T_w_n.size());
  for (const PoseEdge& e : graph.edges)
    if (e.from < 0 || e.to < 0 || e.from >= n || e.to >= n || e.from == e.to)
      throw std::invalid_argument(
          fmt::format("pose graph: an edge joins {} and {} of {} nodes", e.from, e.to, n));
}

bool isOpen(const PoseEdge& edge) { return !edge.others.empty(); }

/** Poses between all alternatives, from where the likeliest in view of all edges is near. */
std::vector<Eigen::Isometry3d> startOf(const PoseGraph& graph, const std::vector<int>& part) {
  if (std::none_of(graph.edges.begin(), graph.edges.end(), isOpen)) return graph.T_w_n;
  PoseGraph all = graph;
  for (PoseEdge& e : all.edges) e = spanned(e, e.T_from_to.T, oddsOf(e));
  PoseProblem problem(all, part);
  problem.solve();
  for (std::size_t i = 0; i < all.T_w_n.size(); ++i) all.T_w_n[i] = problem.pose(i);
  return all.T_w_n;
}

// Information of fixed nodes, and the least of all others, which keeps the normal matrix regular [1 / rad^2,
// 1 / m^2].
constexpr double kHeld = 1e12, kLeast = 1e-8;

/** An edge of the mode that fits the poses best. */
PoseEdge chosen(const PoseEdge& edge, const Eigen::Isometry3d& T_from_to) {
  std::size_t best = 0;
  for (std::size_t k = 1; k <= edge.others.size(); ++k)
    if (edge.mismatch(k, T_from_to) < edge.mismatch(best, T_from_to)) best = k;
  return {edge.from, edge.to, edge.mode(best), edge.may_be_wrong};
}

/** Log odds of the modes of an edge in view of all other edges, whose information is the known pose's less
 * the contained mode's (METHOD 1.3). */
std::vector<double> oddsInGraph(const PoseEdge& edge, const PoseEdge& contained,
                                const PoseWithCovariance& known) {
  const Matrix6d W = contained.T_from_to.P.inverse();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> others(known.P.inverse() - W);
  const Matrix6d I = others.eigenvectors() * others.eigenvalues().cwiseMax(0).asDiagonal() *
                     others.eigenvectors().transpose();
  const Vector6d balance = W * boxminus(known.T, contained.T_from_to.T);
  std::vector<double> odds = oddsOf(edge);
  for (std::size_t k = 0; k < odds.size(); ++k) {
    const Matrix6d W_k = edge.mode(k).P.inverse();
    const Vector6d apart = boxminus(edge.mode(k).T, known.T), pull = balance + W_k * apart;
    const Eigen::LLT<Matrix6d> both(I + W_k);
    odds[k] += 0.5 * (pull.dot(both.solve(pull)) - apart.dot(W_k * apart)) +
               0.5 * std::log(W_k.determinant() / (I + W_k).determinant());
  }
  return odds;
}

/** The graph with each edge of several modes as one Gaussian, of all of them by their odds in the graph. */
PoseGraph settled(PoseGraph graph, int threads) {
  if (std::none_of(graph.edges.begin(), graph.edges.end(), isOpen)) return graph;
  PoseGraph as_solved = graph;
  for (PoseEdge& e : as_solved.edges) e = chosen(e, graph.T_w_n[e.from].inverse() * graph.T_w_n[e.to]);
  const GraphCovariance solved(as_solved, threads);
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    PoseEdge& e = graph.edges[i];
    if (!isOpen(e)) continue;
    const PoseWithCovariance known = *solved.between(e.from, e.to);
    e = spanned(e, known.T, oddsInGraph(e, as_solved.edges[i], known));
  }
  return graph;
}

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

double mismatchOf(const PoseEdge& edge, const std::vector<PoseWithCovariance>& nodes) {
  const Eigen::Isometry3d T_from_to = nodes[edge.from].T.inverse() * nodes[edge.to].T;
  double least = edge.mismatch(0, T_from_to);
  for (std::size_t k = 1; k <= edge.others.size(); ++k) least = std::min(least, edge.mismatch(k, T_from_to));
  return least;
}

std::vector<double> oddsOf(const PoseEdge& edge) {
  std::vector<double> out{0};
  for (const AlternativeMotion& other : edge.others) out.push_back(other.log_odds);
  return out;
}

PoseEdge spanned(const PoseEdge& edge, const Eigen::Isometry3d& about, const std::vector<double>& log_odds) {
  PoseEdge out{edge.from, edge.to, {about, Matrix6d::Zero()}, edge.may_be_wrong};
  const double most = *std::max_element(log_odds.begin(), log_odds.end());
  double sum = 0;
  for (std::size_t k = 0; k < log_odds.size(); ++k) {
    const PoseWithCovariance& mode = edge.mode(k);
    const Vector6d apart = boxminus(mode.T, about);
    const double weight = std::exp(log_odds[k] - most);
    out.T_from_to.P += weight * (mode.P + apart * apart.transpose());
    sum += weight;
  }
  out.T_from_to.P /= sum;
  return out;
}

GraphPoses optimized(const PoseGraph& graph, bool with_covariances) {
  GraphPoses out;
  out.part = partsOf(graph);
  PoseGraph from_start = graph;
  from_start.T_w_n = startOf(graph, out.part);
  PoseProblem problem(from_start, out.part);
  out.converged = graph.edges.empty() || problem.solve();
  for (std::size_t i = 0; i < graph.T_w_n.size(); ++i)
    out.nodes.push_back({problem.pose(i), Matrix6d::Zero()});
  if (with_covariances) {
    for (std::size_t i = 0; i < out.nodes.size(); ++i) from_start.T_w_n[i] = out.nodes[i].T;
    const std::vector<Matrix6d> P = GraphCovariance(from_start).ofNodes();
    for (std::size_t i = 0; i < out.nodes.size(); ++i) out.nodes[i].P = P[i];
  }
  for (const PoseEdge& e : graph.edges) out.mismatch.push_back(mismatchOf(e, out.nodes));
  return out;
}

GraphCovariance::GraphCovariance(const PoseGraph& graph, int threads)
    : T_w_n_(graph.T_w_n), part_(partsOf(graph)), threads_(threads), holds_first_(!graph.floor) {
  const Eigen::SparseMatrix<double> J = PoseProblem(settled(graph, threads), part_).jacobian();
  Eigen::SparseMatrix<double> normal = Eigen::SparseMatrix<double>(J.transpose()) * J;
  Eigen::SparseMatrix<double> least(normal.rows(), normal.cols());
  least.setIdentity();
  least *= kLeast;
  if (holds_first_)
    for (std::size_t i = 0; i < part_.size(); ++i)
      for (int k = 0; part_[i] == static_cast<int>(i) && k < 6; ++k)
        least.coeffRef(static_cast<Eigen::Index>(6 * i) + k, static_cast<Eigen::Index>(6 * i) + k) = kHeld;
  normal += least;
  factor_.compute(normal);
  if (factor_.info() != Eigen::Success)
    throw std::runtime_error("pose graph: its covariances cannot be computed");
}

const std::vector<Matrix6d>& GraphCovariance::ofNodes() const {
  std::call_once(computed_, [&] {
    std::vector<Matrix6d> P(T_w_n_.size(), Matrix6d::Zero());
    forEachInParallel(static_cast<int>(P.size()), threads_, [&](int i) {
      if (holds_first_ && part_[i] == i) return;
      const Matrix6d P_ii = columns(i).middleRows<6>(6 * i);
      P[i] = 0.5 * (P_ii + P_ii.transpose());
    });
    of_nodes_ = std::move(P);
  });
  return of_nodes_;
}

Eigen::MatrixXd GraphCovariance::columns(int node) const {
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(factor_.rows(), 6);
  unit.middleRows<6>(6 * node).setIdentity();
  return factor_.solve(unit);
}

// The perturbation of T_a_b is R_a^T (d_b + B d_a), with the left, decoupled perturbations of both:
// d phi = R_a^T (d phi_b - d phi_a), d t = R_a^T (d t_b - d t_a + [t_b - t_a]x d phi_a).
Matrix6d GraphCovariance::effectOfFirst(int a, int b) const {
  Matrix6d B = -Matrix6d::Identity();
  B.bottomLeftCorner<3, 3>() = skew(T_w_n_[b].translation() - T_w_n_[a].translation());
  return B;
}

PoseWithCovariance GraphCovariance::relative(int a, int b, const Matrix6d& of_difference) const {
  const Eigen::Isometry3d T_a_w = T_w_n_[a].inverse();
  return {T_a_w * T_w_n_[b],
          rotateCovariance(T_a_w.linear(), 0.5 * (of_difference + of_difference.transpose()))};
}

// One solution for the difference: two covariances, far from the first node, would lose it in rounding.
std::optional<PoseWithCovariance> GraphCovariance::between(int a, int b) const {
  if (part_[a] != part_[b]) return {};
  if (a == b) return PoseWithCovariance{Eigen::Isometry3d::Identity(), Matrix6d::Zero()};
  const Matrix6d B = effectOfFirst(a, b);
  Eigen::MatrixXd difference = Eigen::MatrixXd::Zero(factor_.rows(), 6);
  difference.middleRows<6>(6 * a) = B.transpose();
  difference.middleRows<6>(6 * b).setIdentity();
  const Eigen::MatrixXd P = factor_.solve(difference);
  return relative(a, b, P.middleRows<6>(6 * b) + B * P.middleRows<6>(6 * a));
}

std::vector<std::optional<PoseWithCovariance>> GraphCovariance::relativeTo(int node) const {
  const std::vector<Matrix6d>& P = ofNodes();
  std::vector<std::optional<PoseWithCovariance>> out(T_w_n_.size());
  const Eigen::MatrixXd of_node = columns(node);
  for (int b = 0; b < static_cast<int>(T_w_n_.size()); ++b)
    if (part_[b] == part_[node]) {
      const Matrix6d B = effectOfFirst(node, b), cross = of_node.middleRows<6>(6 * b) * B.transpose();
      out[b] = relative(node, b, P[b] + cross + cross.transpose() + B * P[node] * B.transpose());
    }
  out[node] = PoseWithCovariance{Eigen::Isometry3d::Identity(), Matrix6d::Zero()};
  return out;
}

}  // namespace facetloc::internal
