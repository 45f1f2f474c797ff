// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/registration/depth_consistency.h>

#include <cmath>

namespace facetloc {
namespace {

// Bounded log likelihoods of METHOD_MEASURED 10.5, 11.4: a contradiction is as bad as ln 0.02, an occlusion
// as ln 0.25.
constexpr double kContradicting = -3.912;
constexpr double kOccluded = -1.386;
constexpr double kUnitError = 1.673;  // error at which an exact agreement counts 0 [absolute errors]
constexpr double kNearest = 0.5;      // points nearer than this are outside the sensor's range [m]

}  // namespace

DepthComparison::DepthComparison(const DepthConsistencyParams& params, double noise_std)
    : params_(params), absolute_error_(params.absolute_error * noise_std) {}

DepthAgreement DepthComparison::compare(const DepthPicture& a, const DepthPicture& b,
                                        const Eigen::Isometry3d& T_b_a, int columns) const {
  DepthAgreement sum;
  if (a.empty() || b.empty()) return sum;
  const DepthJudge judge(*this, a, b, T_b_a);
  const int step = gridStep(a, columns);
  for (int v = step / 2; v < a.camera.height; v += step)
    for (int u = step / 2; u < a.camera.width; u += step) switch (judge.judge(u, v, sum.likelihood)) {
      case DepthVerdict::agree:
        ++sum.agree;
        break;
      case DepthVerdict::contradict:
        ++sum.contradict;
        break;
      case DepthVerdict::occluded:
        ++sum.occluded;
        break;
      case DepthVerdict::outside:
        break;
      }
  return sum;
}

DepthAgreement DepthComparison::compareBoth(const DepthPicture& a, const DepthPicture& b,
                                            const Eigen::Isometry3d& T_b_a, int columns) const {
  DepthAgreement sum = compare(a, b, T_b_a, columns);
  sum += compare(b, a, T_b_a.inverse(), columns);
  return sum;
}

DepthJudge::DepthJudge(const DepthComparison& comparison, const DepthPicture& a, const DepthPicture& b,
                       const Eigen::Isometry3d& T_b_a)
    : comparison_(comparison), a_(a), b_(b), t_(T_b_a.translation()) {
  const Eigen::Matrix3d R = T_b_a.linear();
  across_ = R.col(0) / a.camera.fx;
  down_ = R.col(1) / a.camera.fy;
  origin_ = R.col(2) - a.camera.cx * across_ - a.camera.cy * down_;
}

DepthVerdict DepthJudge::judge(int u, int v, double& likelihood) const {
  const double rho =
      DepthPicture::kQuantum * a_.inverse_depth[static_cast<std::size_t>(v) * a_.camera.width + u];
  if (rho < comparison_.farthest()) return DepthVerdict::outside;

  // The point of inverse depth rho on a ray b is (R b + t rho) / rho; everything stays in inverse depth.
  const Eigen::Vector3d p = across_ * u + down_ * v + origin_ + t_ * rho;
  if (!(p.z() > kNearest * rho)) return DepthVerdict::outside;
  const double inverse = 1 / p.z();
  const Intrinsics& c = b_.camera;
  const double x = c.fx * p.x() * inverse + c.cx + 0.5, y = c.fy * p.y() * inverse + c.cy + 0.5;
  if (!(x >= 1 && y >= 1 && x < c.width - 1 && y < c.height - 1)) return DepthVerdict::outside;
  const std::size_t i = static_cast<std::size_t>(static_cast<int>(y) * c.width + static_cast<int>(x));
  if (b_.highest[i] == 0) return DepthVerdict::outside;

  const double predicted = rho * inverse;
  const double low = DepthPicture::kQuantum * b_.lowest[i], high = DepthPicture::kQuantum * b_.highest[i];
  const double difference = predicted < low ? predicted - low : predicted > high ? predicted - high : 0;
  const double error = comparison_.error(predicted);
  const double ratio = difference / error;
  if (ratio > comparison_.gate()) {
    likelihood += kContradicting;
    return DepthVerdict::contradict;
  }
  if (ratio < -comparison_.gate()) {
    likelihood += kOccluded;
    return DepthVerdict::occluded;
  }
  const double gaussian = std::log(kUnitError * comparison_.absoluteError() / error) - 0.5 * ratio * ratio;
  likelihood += std::max(kContradicting, gaussian);
  return DepthVerdict::agree;
}

}  // namespace facetloc
