// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/answer_state.h>
#include <facetloc/features/pose.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/localization/sure_calibration.h>

#include <boost/math/special_functions/beta.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace facetloc {
namespace {

/** Thresholds, and the share of the error that each may spend: most of it the one that is used without
 * a calibration, which then takes the fewest images. */
struct Level {
  double min_probability, share;
};
constexpr std::array<Level, 11> kLevels = {{{0.9999, 0.025},
                                            {0.999, 0.05},
                                            {0.998, 0.025},
                                            {0.995, 0.05},
                                            {0.99, 0.15},
                                            {0.98, 0.05},
                                            {0.95, 0.1},
                                            {kMinProbability, 0.5},
                                            {0.8, 0.025},
                                            {0.7, 0.0125},
                                            {0.5, 0.0125}}};
constexpr std::size_t kMostImages = 1000000;  // that anybody is asked for

/** Probability of at most k of n, of a binomial distribution. */
double atMost(std::size_t k, std::size_t n, double share) {
  if (k >= n) return 1;
  return boost::math::ibetac(static_cast<double>(k + 1), static_cast<double>(n - k), share);
}

std::size_t scaled(std::size_t n, double factor) {
  return static_cast<std::size_t>(std::llround(static_cast<double>(n) * factor));
}

}  // namespace

bool RightPose::operator()(const Eigen::Isometry3d& estimated, const Eigen::Isometry3d& truth) const {
  return (estimated.translation() - truth.translation()).norm() <= max_translation &&
         rotationAngle(truth.linear().transpose() * estimated.linear()) <= max_rotation_deg * kDegree;
}

double upperLimitOfShare(std::size_t k, std::size_t n, double confidence) {
  if (k > n) throw std::invalid_argument("no more can be found than there are");
  if (!(confidence > 0 && confidence < 1)) throw std::invalid_argument("confidence must be in (0, 1)");
  if (k == n) return 1;
  return boost::math::ibeta_inv(static_cast<double>(k + 1), static_cast<double>(n - k), confidence);
}

SureCalibration::SureCalibration(double alpha, double confidence) : alpha_(alpha), confidence_(confidence) {
  for (const double share : {alpha, confidence})
    if (!(share > 0 && share < 1))
      throw std::invalid_argument("alpha and confidence must be above 0 and below 1");
}

void SureCalibration::add(double probability, bool right) {
  if (!(probability >= 0 && probability <= 1))
    throw std::invalid_argument("a probability must be between 0 and 1");
  answers_.push_back({probability, right});
}

std::vector<SureCalibration::Candidate> SureCalibration::candidates() const {
  std::vector<Candidate> all;
  double passed_on =
      0;  // error passed on by the threshold above, once it is accepted: Wiens' fallback procedure
  for (const Level& level : kLevels) {
    Candidate c;
    c.min_probability = level.min_probability;
    for (const Answer& answer : answers_) {
      if (answer.probability < level.min_probability) continue;
      ++c.sure;
      c.wrong += !answer.right;
    }
    c.bound = upperLimitOfShare(c.wrong, c.sure, confidence_);
    c.error = level.share * (1 - confidence_) + passed_on;
    c.accepted = atMost(c.wrong, c.sure, alpha_) <= c.error;
    passed_on = c.accepted ? c.error : 0;
    all.push_back(c);
  }
  return all;
}

std::optional<double> SureCalibration::threshold() const {
  const std::optional<SureThreshold> found = threshold(std::string());
  return found ? std::optional(found->min_probability) : std::nullopt;
}

std::optional<SureThreshold> SureCalibration::threshold(const std::string& source) const {
  const std::vector<Candidate> all = candidates();
  const auto lowest = std::find_if(all.rbegin(), all.rend(), [](const Candidate& c) { return c.accepted; });
  if (lowest == all.rend()) return {};
  SureThreshold t;
  t.min_probability = lowest->min_probability;
  t.alpha = alpha_;
  t.confidence = confidence_;
  t.images = static_cast<int>(answers_.size());
  t.sure = static_cast<int>(lowest->sure);
  t.wrong = static_cast<int>(lowest->wrong);
  t.source = source;
  return t;
}

std::size_t SureCalibration::leastSure() const {
  double most = 0;
  for (const Level& level : kLevels) most = std::max(most, level.share);
  return static_cast<std::size_t>(std::ceil(std::log(most * (1 - confidence_)) / std::log1p(-alpha_)));
}

std::optional<std::size_t> SureCalibration::imagesNeeded() const {
  std::optional<std::size_t> least;
  for (const Candidate& c : candidates()) {
    if (c.sure == 0 || static_cast<double>(c.wrong) >= alpha_ * static_cast<double>(c.sure)) continue;
    const auto accepts = [&](double factor) {
      return atMost(scaled(c.wrong, factor), scaled(c.sure, factor), alpha_) <= c.error;
    };
    double factor = 1;
    const double most = static_cast<double>(kMostImages) / static_cast<double>(answers_.size());
    while (factor < most && !accepts(factor)) factor *= 1.05;
    if (factor >= most) continue;
    const std::size_t images = std::max(scaled(answers_.size(), factor), answers_.size());
    least = std::min(images, least.value_or(images));
  }
  return least;
}

std::vector<std::size_t> independentImages(const std::vector<Eigen::Isometry3d>& T_w_c) {
  const LocalizerParams looks;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < T_w_c.size(); ++i) {
    if (!chosen.empty()) {
      const Eigen::Isometry3d moved = T_w_c[chosen.back()].inverse() * T_w_c[i];
      if (moved.translation().norm() < looks.look_distance &&
          rotationAngle(moved.linear()) < looks.look_rotation_deg * kDegree)
        continue;
    }
    chosen.push_back(i);
  }
  return chosen;
}

}  // namespace facetloc
