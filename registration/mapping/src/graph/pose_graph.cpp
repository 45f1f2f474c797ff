// SPDX-License-Identifier: BSD-3-Clause
#include "graph/pose_graph.h"

#include "graph/graph_covariance.h"
#include "graph/pose_problem.h"

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
  PoseProblem problem(graph, out.part);
  out.converged = graph.edges.empty() || problem.solve();
  for (std::size_t i = 0; i < graph.T_w_n.size(); ++i)
    out.nodes.push_back({problem.pose(i), Matrix6d::Zero()});
  if (with_covariances) {
    PoseGraph at_solution = graph;
    for (std::size_t i = 0; i < out.nodes.size(); ++i) at_solution.T_w_n[i] = out.nodes[i].T;
    const std::vector<Matrix6d> P = GraphCovariance(at_solution).ofNodes();
    for (std::size_t i = 0; i < out.nodes.size(); ++i) out.nodes[i].P = P[i];
  }
  for (const PoseEdge& e : graph.edges) {
    const Eigen::Isometry3d T_from_to = out.nodes[e.from].T.inverse() * out.nodes[e.to].T;
    out.mismatch.push_back(squaredMahalanobis(e.T_from_to, T_from_to));
  }
  return out;
}

}  // namespace facetloc::internal
