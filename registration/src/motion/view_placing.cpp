// SPDX-License-Identifier: BSD-3-Clause
#include "motion/view_placing.h"

#include "depth/depth_fit.h"
#include "pairs/joint_refinement.h"
#include "poses/pose_fusion.h"

#include <facetloc/registration/pose_prior.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace facetloc::internal {
namespace {

constexpr std::size_t kMostFound = 4;  // places of a search that are refined
constexpr int kDenseIterations = 10;
constexpr double kMostDoubt =
    11;  // that a prior can raise: beyond its 99.9 % ellipsoid it may be wrong [nats]
constexpr double kTellingDrop =
    2;  // significant drop of the pixels' log likelihood below the best place [nats]
constexpr double kLeastShare = 0.6;     // share of the pixels, relative to the place that compares most
constexpr double kMetresPerRadian = 2;  // typical distance of the points that a rotation moves
constexpr double kStep = 0.15;          // step of a walk along the cost, some pixels [m]
constexpr double kWalkedStd = 2.5;      // range of the walk in standard deviations of the prior
constexpr double kLongestWalk = 3;      // to either side [m]
constexpr double kHopeless = 8;         // log likelihood behind the best, of no use as a start [nats]
constexpr double kImprobable = 7;       // drop of the log likelihood of a discarded mode [nats]

// Information that an alignment has added to its prior. A tiny amount along some motion is set to zero: it
// comes from noise, and many of them would hold the camera where the alignment happened to begin.
Matrix6d added(const Matrix6d& posterior, const Matrix6d& prior) {
  constexpr double kTellingStd = 0.3;  // [m]
  Vector6d scale;
  scale << Eigen::Vector3d::Constant(kMetresPerRadian), Eigen::Vector3d::Ones();
  const Matrix6d in_metres = scale.cwiseInverse().asDiagonal() *
                             (symmetricInverse(posterior) - symmetricInverse(prior)) *
                             scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eig(in_metres);
  const Vector6d kept = (eig.eigenvalues().array() > 1 / (kTellingStd * kTellingStd))
                            .select(eig.eigenvalues(), Vector6d::Zero());
  return scale.asDiagonal() * eig.eigenvectors() * kept.asDiagonal() * eig.eigenvectors().transpose() *
         scale.asDiagonal();
}

// Step along the least certain motion, so far that the camera moves by some pixels.
Vector6d freeStep(Matrix6d information) {
  constexpr double kLeastPart = 0.1;  // share of the translation in a direction that counts as one
  information.diagonal().array() += 1;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eig(information);
  const Vector6d free = eig.eigenvectors().col(0);
  return kStep / std::max(kLeastPart, free.tail<3>().norm()) * free;
}

/** The criteria to rank poses of two views: the likelihood of their pixels, which is higher where pixels are
 * predicted more precisely, or its drop from an exact fit, which is fair to poses that compare other pixels.
 */
enum class Cost { likelihood, misfit };

/** Two views, and the prior of their relative pose. */
class ViewPair {
public:
  ViewPair(const View& view, const View& other, const PoseWithCovariance& prior,
           const ViewAlignmentParams& alignment, const DepthComparison& comparison, Cost cost)
      : view_(view),
        prior_(prior),
        alignment_(alignment),
        cost_(cost),
        fit_(view.depth, {{&other.depth, Eigen::Isometry3d::Identity()}}, comparison) {
    surroundings_.add(0, unowned(other), Eigen::Isometry3d::Identity());
    for (const SidePicture& side : view.sides)
      fit_.add(side, surroundings_.picturesNear(prior.T * side.T_v_c));
    prior_factor_.compute(prior.P);
  }

  /** The pose with its pixels compared; without information. */
  std::optional<PlacedView> at(const Eigen::Isometry3d& T, int columns = kFineColumns) const {
    const DepthPicture& a = view_.depth;
    const DepthAgreement seen = fit_.compare(T, columns);
    const auto log_likelihood = logLikelihood(seen, columns);
    if (!log_likelihood) return {};
    const double both = 2.0 * static_cast<double>(fit_.size()) *
                        gridPoints(a.camera.width, gridStep(a, columns)) *
                        gridPoints(a.camera.height, gridStep(a, columns));
    const double compared = seen.agree + seen.contradict;
    PlacedView placed;
    placed.T_a_b = T;
    placed.agreement = seen.agree / std::max(1.0, compared);
    placed.overlap = compared / both;
    placed.log_likelihood =
        cost_ == Cost::misfit ? *log_likelihood : kIndependentPixels * seen.likelihood / seen.judged();
    placed.judged = seen.judged();
    return placed;
  }
  /** Information of a pose at an end of an alignment, as far as the cost shows it. */
  Matrix6d shown(const PlacedView& mode) const {
    return shownInformation(mode.information, mode.T_a_b, fit_, kFineColumns).information;
  }
  /** How far the prior is from a pose, bounded [nats]. */
  double doubt(const Eigen::Isometry3d& T) const {
    const Vector6d off = boxminus(T, prior_.T);
    return std::min(kMostDoubt, 0.5 * off.dot(prior_factor_.solve(off)));
  }
  /** Adds the end of an alignment, if enough is compared there. */
  void addFrom(const Eigen::Isometry3d& start, const Matrix6d& about, std::vector<PlacedView>& ends) const {
    PoseWithCovariance T{start, about};
    T.T = alignView(view_, surroundings_, T, alignment_).T_w_c.T;
    T = alignView(view_, surroundings_, {T.T, aboutStart()}, alignment_).T_w_c;  // with the pairs of its end
    auto placed = at(T.T);
    if (!placed) return;
    placed->information = added(T.P, aboutStart());
    placed->log_likelihood -= doubt(T.T);
    ends.push_back(*placed);
  }
  /** The motions that the planes leave uncertain, as principal motions with their standard deviations. */
  std::array<Vector6d, 4> openMotions(const Eigen::Isometry3d& T) const;

private:
  const View& view_;
  const PoseWithCovariance& prior_;
  const ViewAlignmentParams& alignment_;
  Cost cost_;
  DepthFit fit_;
  LocalMap surroundings_;
  Eigen::LDLT<Matrix6d> prior_factor_;
};

// The three axes of the position and the one of the orientation that the planes tell least of, each as long
// as the standard deviation of the prior.
std::array<Vector6d, 4> ViewPair::openMotions(const Eigen::Isometry3d& T) const {
  Hypothesis h;
  h.T_m_c = {T, prior_.P};
  refineJointly(view_.segments, surroundings_.segments, h.T_m_c, alignment_.matching, {}, h);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> turns(h.T_m_c.P.topLeftCorner<3, 3>());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> ways(h.T_m_c.P.bottomRightCorner<3, 3>());
  std::array<Vector6d, 4> motions;
  motions.fill(Vector6d::Zero());
  for (int k = 0; k < 3; ++k) motions[k].tail<3>() = ways.eigenvectors().col(k);
  motions[3].head<3>() = turns.eigenvectors().col(2);
  for (Vector6d& motion : motions) motion *= std::sqrt(motion.dot(prior_.P * motion));
  return motions;
}

// Poses along an open motion where the cost has a minimum of its own.
std::vector<Eigen::Isometry3d> walked(const ViewPair& pair, const PlacedView& from, const Vector6d& motion) {
  const double std = kMetresPerRadian * motion.head<3>().norm() + motion.tail<3>().norm();
  const int n = static_cast<int>(std::min(kLongestWalk, kWalkedStd * std) / kStep);
  std::vector<double> log_likelihood;
  double best = -std::numeric_limits<double>::infinity();
  for (int i = -n - 1; i <= n + 1; ++i) {
    const Eigen::Isometry3d T = boxplus(from.T_a_b, i * kStep / std * motion);
    const auto here = pair.at(T, kCoarseColumns);
    const bool counts = here && here->judged * kFineColumns * kFineColumns >=
                                    kLeastShare * from.judged * kCoarseColumns * kCoarseColumns;
    log_likelihood.push_back(counts ? here->log_likelihood - pair.doubt(T)
                                    : -std::numeric_limits<double>::infinity());
    best = std::max(best, log_likelihood.back());
  }
  std::vector<Eigen::Isometry3d> minima;
  for (int i = -n; i <= n; ++i) {
    const double* here = &log_likelihood[static_cast<std::size_t>(i + n + 1)];
    if (std::abs(i) > 1 && here[0] >= here[-1] && here[0] > here[1] && here[0] > best - kHopeless)
      minima.push_back(boxplus(from.T_a_b, i * kStep / std * motion));
  }
  return minima;
}

// Poses where enough of the views is compared, the likeliest first: where little is, little can be wrong.
std::vector<PlacedView> tested(const std::vector<PlacedView>& all) {
  int most = 0;
  for (const PlacedView& placed : all) most = std::max(most, placed.judged);
  std::vector<PlacedView> kept;
  for (const PlacedView& placed : all)
    if (placed.judged >= kLeastShare * most) kept.push_back(placed);
  std::stable_sort(kept.begin(), kept.end(), [](const PlacedView& a, const PlacedView& b) {
    return a.log_likelihood > b.log_likelihood;
  });
  return kept;
}

}  // namespace

ViewPlacing::ViewPlacing() : alignment_(alignmentWithCovariance()), comparison_(DepthCalibration{}) {
  alignment_.dense.iterations = kDenseIterations;
}

std::vector<Eigen::Isometry3d> ViewPlacing::starts(const View& view, const View& other,
                                                   const PoseWithCovariance& prior, bool search) const {
  std::vector<Eigen::Isometry3d> out{prior.T};
  if (!search) return out;
  out.push_back(Eigen::Isometry3d::Identity());  // as a camera that has hardly moved
  const auto mounting = view.camera ? view.camera->mounting : std::nullopt;
  const Query query(view, prior, floorInformation(mounting));
  const std::vector<Hypothesis> found = registration_.align(query, other);
  for (std::size_t i = 0; i < std::min(kMostFound, found.size()); ++i) out.push_back(found[i].T_m_c.T);
  return out;
}

std::optional<PlacedView> ViewPlacing::place(const View& view, const View& other,
                                             const PoseWithCovariance& prior, bool search) const {
  const ViewPair pair(view, other, prior, alignment_, comparison_, Cost::likelihood);
  std::vector<PlacedView> places;
  if (search) pair.addFrom(prior.T, prior.P, places);
  for (const Eigen::Isometry3d& start : starts(view, other, prior, search))
    pair.addFrom(start, aboutStart(), places);
  if (places.empty()) return {};
  PlacedView found = tested(places).front();
  // Few planes may leave a way free, along which pixels see no farther than an edge is wide.
  if (search) {
    const Vector6d step = freeStep(found.information);
    for (const double shift : {-2, -1, 1, 2})
      pair.addFrom(boxplus(found.T_a_b, shift * step), aboutStart(), places);
    found = tested(places).front();
  }
  const Vector6d step = freeStep(found.information);
  const auto there = pair.at(boxplus(found.T_a_b, step)), back = pair.at(boxplus(found.T_a_b, -step)),
             here = pair.at(found.T_a_b);
  if (here && there && back) {
    const double drop = here->log_likelihood - std::max(there->log_likelihood, back->log_likelihood);
    const double squared = step.squaredNorm();
    if (drop > kTellingDrop) found.information += 2 * drop / (squared * squared) * step * step.transpose();
  }
  return found;
}

std::vector<PlacedView> ViewPlacing::modes(const View& view, const View& other,
                                           const PoseWithCovariance& prior) const {
  const ViewPair pair(view, other, prior, alignment_, comparison_, Cost::misfit);
  std::vector<PlacedView> all;
  pair.addFrom(prior.T, prior.P, all);
  for (const Eigen::Isometry3d& start : starts(view, other, prior, true))
    pair.addFrom(start, aboutStart(), all);
  if (all.empty()) return {};
  const PlacedView best = tested(all).front();
  for (const Vector6d& motion : pair.openMotions(best.T_a_b))
    for (const Eigen::Isometry3d& start : walked(pair, best, motion)) pair.addFrom(start, aboutStart(), all);

  std::vector<PlacedView> modes;
  for (PlacedView& placed : tested(all)) {
    const auto isKnown = [&](const PlacedView& mode) { return kSameMotion.joins(mode.T_a_b, placed.T_a_b); };
    if (!modes.empty() && (placed.log_likelihood < modes.front().log_likelihood - kImprobable ||
                           std::any_of(modes.begin(), modes.end(), isKnown)))
      continue;
    placed.information = pair.shown(placed);
    modes.push_back(std::move(placed));
  }
  return modes;
}

}  // namespace facetloc::internal
