// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/map_metadata.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief When a pose counts as right. */
struct RightPose {
  double max_translation = 0.2;  ///< largest error of the position [m]
  double max_rotation_deg = 2;   ///< largest error of the orientation

  bool operator()(const Eigen::Isometry3d& estimated, const Eigen::Isometry3d& truth) const;
};

/** \brief Sets the probability from which on answers are sure, so that at most a share alpha of them is
 * wrong: Learn then Test (Angelopoulos, Bates, Candes, Jordan, Lei, 2021; METHOD 1.6).
 *
 *     facetloc::SureCalibration calibration(0.01);
 *     for (...) calibration.add(answer.hypotheses.front().probability, isRight(answer));
 *     if (const auto threshold = calibration.threshold()) localizer.setMinProbability(*threshold);
 *
 * The lowest of some thresholds that are fixed beforehand is taken for which the images rule out that more
 * than alpha of the sure answers are wrong. With the given confidence, that bound holds for further images of
 * the same kind, whatever the probabilities that were added are worth. Images are to be independent of each
 * other, not many of one view (independentImages()). */
class SureCalibration {
public:
  /** \brief The images' statistics of one threshold. */
  struct Candidate {
    double min_probability = 0;
    std::size_t sure = 0, wrong = 0;  ///< images whose answer is sure with it; those of them that are wrong
    double bound = 1;                 ///< upper bound on the share of wrong ones, from these images alone
    double error = 0;                 ///< probability that it may be accepted with although it does not hold
    bool accepted = false;
  };

  /** \brief Throws std::invalid_argument unless both are above 0 and below 1. \param alpha largest share of
   * wrong answers among the sure ones \param confidence of that bound */
  explicit SureCalibration(double alpha = 0.01, double confidence = 0.95);

  /** \brief The answer for an image. \param probability of its first hypothesis; 0 if it has none. Throws
   * std::invalid_argument outside of [0, 1]. */
  void add(double probability, bool right);

  std::size_t images() const { return answers_.size(); }
  /** \brief All thresholds, the highest first. */
  std::vector<Candidate> candidates() const;
  /** \brief The lowest threshold that is accepted; nothing if none is. */
  std::optional<double> threshold() const;
  /** \brief The same for a map. \param source of the images, in words */
  std::optional<SureThreshold> threshold(const std::string& source) const;
  /** \brief About how many images like these it takes until a threshold is accepted; nothing if no number
   * would do, because too many answers are wrong or none is right. */
  std::optional<std::size_t> imagesNeeded() const;

  /** \brief Number of sure answers, none of them wrong, that the best threshold takes to be accepted. */
  std::size_t leastSure() const;
  double alpha() const { return alpha_; }
  double confidence() const { return confidence_; }

private:
  struct Answer {
    double probability;
    bool right;
  };
  double alpha_, confidence_;
  std::vector<Answer> answers_;
};

/** \brief Upper limit of a share, of which k of n were found, with a confidence: Clopper and Pearson's. 1 for
 * n = 0. Throws std::invalid_argument for k > n. */
double upperLimitOfShare(std::size_t k, std::size_t n, double confidence);

/** \brief Indices of images that show something new, in the order of time: 0.15 m or 5 deg after the one
 * before, in a sequence of their poses T_w_c. */
std::vector<std::size_t> independentImages(const std::vector<Eigen::Isometry3d>& T_w_c);

}  // namespace facetloc
