// SPDX-License-Identifier: BSD-3-Clause
#include "tools/drive.h"

#include "batch/batch.h"

namespace facetloc {

std::optional<PoseWithCovariance> MeasuredMotion::until(double stamp) {
  if (!odometry_) return {};
  const std::optional<Eigen::Isometry3d> now = odometry_(stamp), before = std::exchange(T_o_before_, now);
  if (!before || !now) return {};
  return motionByOdometry(before->inverse() * *now, mounting_, error_);
}

LocalizerAnswer Drive::add(std::size_t index, const View& view, double stamp) {
  const std::optional<PoseWithCovariance> motion = motion_.until(stamp);
  LocalizerAnswer answer = localizer_.update(view, stamp, motion);
  if (smoothing_) images_.push_back({index, stamp, view, motion, answer});
  return answer;
}

void Drive::smooth(Localizer& backward, const std::function<std::string(std::size_t)>& name,
                   const Console& console, const Take& take) const {
  const std::size_t n = images_.size();
  std::vector<LocalizerAnswer> from_here(n);
  const auto inReverse = [n](std::size_t i) { return n - 1 - i; };
  Batch(1, n, console)
      .run([&](std::size_t i) { return name(images_[inReverse(i)].index); },
           [&](std::size_t i, int) {
             const Image& image = images_[inReverse(i)];
             std::optional<PoseWithCovariance> motion;  // back from the next image
             if (i > 0 && images_[inReverse(i - 1)].T_before_now)
               motion = inverse(*images_[inReverse(i - 1)].T_before_now);
             from_here[inReverse(i)] = backward.update(image.view, -image.stamp, motion);
           });
  for (std::size_t i = 0; i < n; ++i) {
    const bool is_cut_off = i + 1 == n || images_[i + 1].until_now.began_anew;
    take(images_[i].index, is_cut_off ? images_[i].until_now
                                      : localizer_.smoothed(images_[i].until_now, from_here[i + 1],
                                                            images_[i + 1].until_now.T_before_now));
  }
}

}  // namespace facetloc
