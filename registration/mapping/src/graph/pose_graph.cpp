// SPDX-License-Identifier: BSD-3-Clause
#include "graph/pose_graph.h"

#include "graph/graph_covariance.h"
#include "graph/pose_problem.h"

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

/** Poses between all alternatives, from where the likeliest in view of all edges is near. */
std::vector<Eigen::Isometry3d> startOf(const PoseGraph& graph, const std::vector<int>& part) {
  const auto isOpen = [](const PoseEdge& e) { return !e.others.empty(); };
  if (std::none_of(graph.edges.begin(), graph.edges.end(), isOpen)) return graph.T_w_n;
  PoseGraph all = graph;
  for (PoseEdge& e : all.edges) e = spanned(e, e.T_from_to.T, oddsOf(e));
  PoseProblem problem(all, part);
  problem.solve();
  for (std::size_t i = 0; i < all.T_w_n.size(); ++i) all.T_w_n[i] = problem.pose(i);
  return all.T_w_n;
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

}  // namespace facetloc::internal
