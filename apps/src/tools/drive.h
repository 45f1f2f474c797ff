// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/app.h"

#include <facetloc/localization/localizer.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief Images of one drive, which are localized by each other, in their order. */
class Drive {
public:
  /** \param smoothing the images are kept, since what comes later is to tell of them too. */
  Drive(Localizer localizer, bool smoothing) : localizer_(std::move(localizer)), smoothing_(smoothing) {}

  /** \brief What the images up to this one say. */
  LocalizerAnswer add(std::size_t index, const View& view, double stamp);

  /** \brief Receives the answer for an image. */
  using Take = std::function<void(std::size_t index, const LocalizerAnswer& answer)>;
  /** \brief What all of its images say of each of them.
   * \param backward with the same map and parameters, has seen nothing yet
   * \param name of an image, for messages; throws Stopped at Ctrl-C */
  void smooth(Localizer& backward, const std::function<std::string(std::size_t index)>& name,
              const Console& console, const Take& take) const;

private:
  struct Image {
    std::size_t index;
    double stamp;
    View view;
    LocalizerAnswer until_now;
  };

  Localizer localizer_;
  bool smoothing_;
  std::vector<Image> images_;
};

}  // namespace facetloc
