// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>

#include <optional>
#include <string>

namespace facetloc {

/** \brief Key of a map's meta data: its SureThreshold, as toText() writes it. */
constexpr const char* kSureKey = "sure";

/** \brief Least probability of sure answers in a map, with a bound on the share of wrong ones among them,
 * as found by SureCalibration (localization/METHOD 11.6). Holds for single images like those that it was
 * found with. */
struct SureThreshold {
  double min_probability = 1;  ///< range (0, 1]
  double alpha = 0;            ///< largest share of wrong answers among the sure ones, in (0, 1)
  double confidence = 0;       ///< with which alpha holds, in (0, 1)
  int images = 0;              ///< that it was found with, each of another view
  int sure = 0;                ///< images with a sure answer at this threshold
  int wrong = 0;               ///< sure answers that are wrong
  std::string source{};        ///< description of the images, on one line

  /** \brief "p >= 0.95: at most 1 % of the sure answers are wrong, with 95 % confidence; 412 of 600 images of
   * walk are sure, 1 of these wrong". */
  std::string toString() const;
};

/** \brief For the meta data of a map: one line. */
std::string toText(const SureThreshold& threshold);
/** \brief The threshold in the meta data of a map; nothing if it was not calibrated. Throws
 * std::invalid_argument for one that is malformed or impossible. */
std::optional<SureThreshold> sureThresholdOf(const Map& map);
/** \brief Least probability of a sure answer in a map, unless the user says otherwise: from its
 * SureThreshold, else kMinProbability. Throws as sureThresholdOf(). */
double minProbabilityOf(const Map& map);

}  // namespace facetloc
