// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/registration_params.h>

namespace facetloc {
namespace {

constexpr double kBound = 2;  // standard deviations, of 95 % of the errors

}  // namespace

bool PoseLimits::hold(const Matrix6d& P) const {
  return kBound * largestTranslationStd(P) <= max_translation &&
         kBound * largestRotationStd(P) <= max_rotation_deg * kDegree;
}

std::string PoseLimits::whyNotFixed(const Matrix6d& P, const Eigen::Matrix3d& R) const {
  return "nothing in view fixes " +
         freeMotions(principalStd(P), max_rotation_deg * kDegree / kBound, max_translation / kBound, R);
}

}  // namespace facetloc
