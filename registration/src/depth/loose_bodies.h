// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "depth/depth_consistency.h"

#include <facetloc/features/local_model.h>

#include <cstdint>
#include <vector>

namespace facetloc::internal {

/** \brief The bodies of a view that may move: connected surfaces not larger than a person that stand before
 * their surroundings in the image (METHOD 8.5). Planes larger than a person separate them. */
class LooseBodies {
public:
  /** \param view must outlive it */
  explicit LooseBodies(const View& view);
  bool empty() const { return count_ == 0; }

  /** \brief One flag for each body. */
  using Chosen = std::vector<char>;
  /** \brief Bodies most of whose pixels lie before the surfaces that the pictures show there, other than
   * furniture. */
  Chosen before(const Eigen::Isometry3d& T_w_c, const std::vector<PosedPicture>& pictures,
                const DepthComparison& comparison) const;
  /** \brief Bodies most of whose pixels the pictures show where they are: furniture of that place. */
  Chosen shown(const Eigen::Isometry3d& T_w_c, const std::vector<PosedPicture>& pictures,
               const DepthComparison& comparison) const {
    return labelled(DepthLabel::agree, T_w_c, pictures, comparison);
  }

  /** \brief Takes bodies for furniture from now on. */
  void keep(const Chosen& furniture) { furniture_ = furniture; }
  /** \brief Those of these bodies that were not taken for furniture. */
  Chosen otherThanFurniture(Chosen bodies) const;

  /** \brief The depth of the view, unknown where these bodies are. */
  DepthPicture pictureWithout(const Chosen& bodies) const;

private:
  Chosen labelled(DepthLabel label, const Eigen::Isometry3d& T_w_c, const std::vector<PosedPicture>& pictures,
                  const DepthComparison& comparison) const;

  const View& view_;
  int count_ = 0;
  Chosen furniture_;                // one flag for each body, or empty
  std::vector<std::uint8_t> body_;  // number of the body at each pixel of the picture, 0 = none
};

/** \brief Is any flag set? */
bool anyOf(const LooseBodies::Chosen& bodies);

}  // namespace facetloc::internal
