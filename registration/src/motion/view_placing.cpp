// SPDX-License-Identifier: BSD-3-Clause
#include "motion/view_placing.h"

#include <facetloc/registration/pose_prior.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>

namespace facetloc::internal {
namespace {

constexpr int kFewestPixels = 60;      // that must be compared before their agreement says anything
constexpr std::size_t kMostFound = 4;  // places of a search that are refined
constexpr double kLooseRotation = 3 * kDegree, kLooseTranslation = 0.1;  // about a start [rad, m]
constexpr int kDenseIterations = 10;
constexpr double kMostDoubt =
    11;  // that a prior can raise: beyond its 99.9 % ellipsoid it may be wrong [nats]
constexpr double kIndependentPixels = 240;  // that the pixels of two views are worth
constexpr double kTellingDrop = 2;          // of what pixels say, beside the place that they like best [nats]
constexpr double kLeastShare = 0.6;         // of the pixels that the place with most compares

// What an alignment has added to its prior. Hardly anything along some motion is nothing: it comes from
// noise, and many of them would hold the camera where the alignment happened to begin.
Matrix6d added(const Matrix6d& posterior, const Matrix6d& prior) {
  constexpr double kMetresPerRadian = 2, kTellingStd = 0.3;  // [m]
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

// Along what is known least, so far that the camera moves by some pixels.
Vector6d freeStep(Matrix6d information) {
  constexpr double kStep = 0.15, kLeastPart = 0.1;  // [m], and of a direction that is a translation
  information.diagonal().array() += 1;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eig(information);
  const Vector6d free = eig.eigenvectors().col(0);
  return kStep / std::max(kLeastPart, free.tail<3>().norm()) * free;
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
  Surroundings surroundings;
  surroundings.add(0, borrowed(other), Eigen::Isometry3d::Identity());
  Vector6d loose;
  loose << Eigen::Vector3d::Constant(kLooseRotation), Eigen::Vector3d::Constant(kLooseTranslation);
  const Matrix6d about_start = loose.cwiseAbs2().asDiagonal();
  const Eigen::LDLT<Matrix6d> prior_factor(prior.P);

  struct Place {
    PlacedView view;
    int judged;
    double score;
  };
  const double both = 2.0 * gridPoints(view.depth.camera.width, gridStep(view.depth, kFineColumns)) *
                      gridPoints(view.depth.camera.height, gridStep(view.depth, kFineColumns));
  const auto judgedAt = [&](const Eigen::Isometry3d& T) -> std::optional<Place> {
    const DepthAgreement seen = comparison_.compareBoth(view.depth, other.depth, T, kFineColumns);
    if (seen.judged() < kFewestPixels) return {};
    const double compared = seen.agree + seen.contradict;
    PlacedView placed{T, Matrix6d::Zero(), seen.agree / std::max(1.0, compared), compared / both};
    return Place{placed, seen.judged(), kIndependentPixels * seen.likelihood / seen.judged()};
  };
  std::vector<Place> places;
  int most_judged = 0;
  const auto tryFrom = [&](const Eigen::Isometry3d& start, const Matrix6d& about) {
    PoseWithCovariance T{start, about};
    T.T = alignView(view, surroundings, T, alignment_).T_w_c.T;
    T = alignView(view, surroundings, {T.T, about_start}, alignment_).T_w_c;  // with the pairs of its end
    auto place = judgedAt(T.T);
    if (!place) return;
    place->view.information = added(T.P, about_start);
    const Vector6d off = perturbation(prior.T, T.T);
    place->score -= std::min(kMostDoubt, 0.5 * off.dot(prior_factor.solve(off)));
    places.push_back(*place);
    most_judged = std::max(most_judged, place->judged);
  };
  // Where little of the views is compared, little can be wrong.
  const auto best = [&]() -> std::optional<PlacedView> {
    const Place* of_all = nullptr;
    for (const Place& place : places)
      if (place.judged >= kLeastShare * most_judged && (!of_all || place.score > of_all->score))
        of_all = &place;
    return of_all ? std::optional(of_all->view) : std::nullopt;
  };
  if (search) tryFrom(prior.T, prior.P);
  for (const Eigen::Isometry3d& start : starts(view, other, prior, search)) tryFrom(start, about_start);
  std::optional<PlacedView> found = best();
  if (!found) return found;
  // Few planes may leave a way free, along which pixels see no farther than an edge is wide.
  if (search) {
    const Vector6d step = freeStep(found->information);
    for (const double shift : {-2, -1, 1, 2}) tryFrom(perturbed(found->T_a_b, shift * step), about_start);
    found = best();
  }
  const Vector6d step = freeStep(found->information);
  const auto here = judgedAt(found->T_a_b), there = judgedAt(perturbed(found->T_a_b, step)),
             back = judgedAt(perturbed(found->T_a_b, -step));
  if (here && there && back) {
    const double drop = here->score - std::max(there->score, back->score);
    const double squared = step.squaredNorm();
    if (drop > kTellingDrop) found->information += 2 * drop / (squared * squared) * step * step.transpose();
  }
  return found;
}

}  // namespace facetloc::internal
