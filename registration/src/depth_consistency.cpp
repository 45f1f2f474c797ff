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

// A pixel of one picture moved into another, everything in inverse depth.
struct Projection {
  double predicted = 0;  // [1/m]
  std::size_t index = 0;
};

class Mover {
public:
  Mover(const DepthPicture& a, const DepthPicture& b, const Eigen::Isometry3d& T_b_a)
      : b_(b.camera), t_(T_b_a.translation()) {
    // R ray(u, v) = across u + down v + origin
    const Eigen::Matrix3d R = T_b_a.linear();
    across_ = R.col(0) / a.camera.fx;
    down_ = R.col(1) / a.camera.fy;
    origin_ = R.col(2) - a.camera.cx * across_ - a.camera.cy * down_;
  }

  // The point of inverse depth rho on ray (u, v) is (R b + t rho) / rho.
  bool move(int u, int v, double rho, Projection& out) const {
    const Eigen::Vector3d p = across_ * u + down_ * v + origin_ + t_ * rho;
    if (!(p.z() > kNearest * rho)) return false;
    const double inverse = 1 / p.z();
    const double x = b_.fx * p.x() * inverse + b_.cx + 0.5, y = b_.fy * p.y() * inverse + b_.cy + 0.5;
    if (!(x >= 1 && y >= 1 && x < b_.width - 1 && y < b_.height - 1)) return false;
    out.predicted = rho * inverse;
    out.index = static_cast<std::size_t>(static_cast<int>(y) * b_.width + static_cast<int>(x));
    return true;
  }

private:
  static constexpr double kNearest = 0.5;  // points nearer than this are outside the sensor's range [m]
  const Intrinsics& b_;
  const Eigen::Vector3d t_;
  Eigen::Vector3d across_, down_, origin_;
};

}  // namespace

DepthComparison::DepthComparison(const DepthConsistencyParams& params, double noise_std)
    : params_(params), absolute_error_(params.absolute_error * noise_std) {}

DepthAgreement DepthComparison::compare(const DepthPicture& a, const DepthPicture& b,
                                        const Eigen::Isometry3d& T_b_a, int columns) const {
  DepthAgreement sum;
  if (a.empty() || b.empty()) return sum;
  const Mover mover(a, b, T_b_a);
  const int step = gridStep(a, columns);
  const double farthest = 1 / params_.max_depth;
  for (int v = step / 2; v < a.camera.height; v += step)
    for (int u = step / 2; u < a.camera.width; u += step) {
      const double rho =
          DepthPicture::kQuantum * a.inverse_depth[static_cast<std::size_t>(v) * a.camera.width + u];
      Projection p;
      if (rho < farthest || !mover.move(u, v, rho, p) || b.highest[p.index] == 0) continue;
      const double low = DepthPicture::kQuantum * b.lowest[p.index],
                   high = DepthPicture::kQuantum * b.highest[p.index];
      const double error = p.predicted < low    ? p.predicted - low
                           : p.predicted > high ? p.predicted - high
                                                : 0;
      const double scale = absolute_error_ + params_.relative_error * p.predicted;
      const double ratio = error / scale;
      if (ratio > params_.gate) {
        ++sum.contradict;
        sum.likelihood += kContradicting;
      } else if (ratio < -params_.gate) {
        ++sum.occluded;
        sum.likelihood += kOccluded;
      } else {
        ++sum.agree;
        sum.likelihood +=
            std::max(kContradicting, std::log(kUnitError * absolute_error_ / scale) - 0.5 * ratio * ratio);
      }
    }
  return sum;
}

DepthAgreement DepthComparison::compareBoth(const DepthPicture& a, const DepthPicture& b,
                                            const Eigen::Isometry3d& T_b_a, int columns) const {
  DepthAgreement sum = compare(a, b, T_b_a, columns);
  sum += compare(b, a, T_b_a.inverse(), columns);
  return sum;
}

DepthVerdict DepthComparison::judge(const DepthPicture& a, int u, int v, const DepthPicture& b,
                                    const Eigen::Isometry3d& T_b_a) const {
  const double rho =
      DepthPicture::kQuantum * a.inverse_depth[static_cast<std::size_t>(v) * a.camera.width + u];
  Projection p;
  if (rho < 1 / params_.max_depth || !Mover(a, b, T_b_a).move(u, v, rho, p) || b.highest[p.index] == 0)
    return DepthVerdict::outside;
  const double slack = tolerance(p.predicted);
  if (p.predicted > DepthPicture::kQuantum * b.highest[p.index] + slack) return DepthVerdict::contradict;
  if (p.predicted < DepthPicture::kQuantum * b.lowest[p.index] - slack) return DepthVerdict::occluded;
  return DepthVerdict::agree;
}

}  // namespace facetloc
