// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/registration/hypothesis.h>
#include <facetloc/registration/registration_params.h>

#include <memory>
#include <vector>

namespace facetloc {

/** \brief Registers views with one other view, the target: a ranked list of poses, or the reason why it is
 * empty. The PCL classes are faces of it.
 *
 * Floor information counts where the cameras of both views have equal mountings. Never changes; thread-safe.
 */
class PairRegistration {
public:
  /** \brief Throws std::invalid_argument for a parameter out of its range. */
  explicit PairRegistration(View target, const RegistrationParams& params = {});
  PairRegistration(PairRegistration&&) noexcept;
  PairRegistration& operator=(PairRegistration&&) noexcept;
  ~PairRegistration();

  const View& target() const;

  /** \brief Poses of a view in the target's camera frame (Hypothesis::T_m_c, which T_w_c repeats).
   * \param prior T_target_view with its covariance, order (phi, t); if that is not positive definite, the
   * answer is empty with a reason \param chosen if not null, the only pairs (scene = view, model = target)
   * whose planes take part in a pose, in place of candidatePairs(); depth counts all the same. Throws
   * std::invalid_argument for a pair that names no segment \param doubt log odds against the evidence of
   * planes, as where views show so small surfaces that some fit by chance [nats] */
  Localization align(const View& view, const PoseWithCovariance& prior,
                     const std::vector<SegmentPair>* chosen = nullptr, double doubt = 0) const;
  /** \brief The same for a camera that is turned about its optical axis by one to three quarters: the most
   * probable of these, at odds of one to ten. */
  Localization alignTurned(const View& view, const PoseWithCovariance& prior) const;
  /** \brief The same with the prior of RegistrationParams for the mounting of the target's camera. */
  Localization align(const View& view) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facetloc
