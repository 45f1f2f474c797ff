// SPDX-License-Identifier: BSD-3-Clause
#include "graph/pose_graph.h"

#include "threads/in_parallel.h"

#include <Eigen/Cholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <stdexcept>

namespace facetloc::internal {
namespace {

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

/** A cost with blocks of parameters of these sizes. */
template <int kResiduals, int... kSizes, class Functor>
ceres::CostFunction* costOf(const Functor& functor) {
  return new ceres::AutoDiffCostFunction<Functor, kResiduals, kSizes...>(new Functor(functor));
}

// One problem for all parts: they do not see each other.
class PoseProblem {
public:
  PoseProblem(const PoseGraph& graph, const std::vector<int>& part) {
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
      ceres::CostFunction* cost = e.others.empty() ? costOf<6, 4, 3, 4, 3>(Mismatch(e.T_from_to))
                                                   : costOf<7, 4, 3, 4, 3>(LeastMismatch(e));
      problem_->AddResidualBlock(cost, e.may_be_wrong ? &loss_ : nullptr, from.q.coeffs().data(),
                                 from.t.data(), to.q.coeffs().data(), to.t.data());
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      Parameters& node = nodes_[i];
      double *const q = node.q.coeffs().data(), *const t = node.t.data();
      const bool is_first = part[i] == static_cast<int>(i);
      if (graph.floor) {
        problem_->AddResidualBlock(costOf<3, 4, 3>(Standing(*graph.floor)), &floor_loss_, q, t);
        if (is_first) problem_->AddResidualBlock(costOf<3, 4, 3>(Anchor(node)), nullptr, q, t);
      } else if (is_first) {
        problem_->SetParameterBlockConstant(q);
        problem_->SetParameterBlockConstant(t);
      }
    }
  }

  void solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 100;
    options.num_threads = 1;  // so that sums have one order
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem_.get(), &summary);
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
  static constexpr double kEllipsoid = chiSquareQuantile(6, 0.95);
  static constexpr double kFloorEllipsoid = chiSquareQuantile(3, 0.95);
  ceres::EigenQuaternionManifold manifold_;
  ceres::CauchyLoss loss_{std::sqrt(kEllipsoid)}, floor_loss_{std::sqrt(kFloorEllipsoid)};
  std::vector<Parameters> nodes_;
  std::unique_ptr<ceres::Problem> problem_;
};

void check(const PoseGraph& graph) {
  const int n = static_cast<int>(graph.T_w_n.size());
  for (const PoseEdge& e : graph.edges)
    if (e.from < 0 || e.to < 0 || e.from >= n || e.to >= n || e.from == e.to)
      throw std::invalid_argument(
          fmt::format("pose graph: an edge joins {} and {} of {} nodes", e.from, e.to, n));
}

bool isOpen(const PoseEdge& edge) { return !edge.others.empty(); }

/** Log odds of the motion, which are 0, and of its alternatives. */
std::vector<double> oddsOf(const PoseEdge& edge) {
  std::vector<double> out{0};
  for (const AlternativeMotion& other : edge.others) out.push_back(other.log_odds);
  return out;
}

/** An edge of one Gaussian about a motion, with the second moments of all modes of an edge. \param log_odds
 * as of oddsOf() */
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

GraphPoses optimized(const PoseGraph& graph, bool with_covariances) {
  GraphPoses out;
  out.part = partsOf(graph);
  PoseGraph from_start = graph;
  from_start.T_w_n = startOf(graph, out.part);
  PoseProblem problem(from_start, out.part);
  if (!graph.edges.empty()) problem.solve();
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
