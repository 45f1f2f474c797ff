// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/params.h>

namespace facetloc {

/** \brief How depth pictures are compared (METHOD 8.1). */
struct DepthConsistencyParams {
  static constexpr const char* kTitle = "Comparison of depth pictures";
  double absolute_error = 3.0;   ///< of a predicted inverse depth [noise std]
  double relative_error = 0.01;  ///< of a predicted inverse depth
  double gate = 3.0;             ///< times the error: beyond it, pixels do not agree
  double max_depth = 6.0;        ///< farther pixels are not compared [m]

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit(
        "absolute_error", p.absolute_error, 0.01, 1e3,
        "Error of a predicted inverse depth that is the same at all distances [noise standard deviations].");
    visit("relative_error", p.relative_error, 0.0, 1.0,
          "Error of a predicted inverse depth that grows with it, as a share of it.");
    visit("gate", p.gate, 0.1, 100.0,
          "Largest difference of two inverse depths that agree [standard deviations of the error].");
    visit("max_depth", p.max_depth, 0.1, 1e3, "Distance beyond which pixels are not compared [m].");
  }
  void validate() const { checkRanges(*this); }
};

/** \brief How a pose that planes have found is refined by all pixels. */
struct DenseRefinementParams {
  static constexpr const char* kTitle = "Refinement of poses by all depth pixels";
  int iterations = 6;
  double pixel_error = 1.6;  ///< of a difference of two inverse depths [noise std]: sqrt 2 and the distortion
  double robust_gate = 3.0;  ///< differences beyond so many errors lose their weight

  /** \name For tracking, which has parameters of its own for them */
  /// @{
  double correlated_pixels = 1;  ///< so many pixels tell as much as one: neighbours err alike
  double significance =
      0;  ///< least information of a direction [in terms of the gradients' noise]; 0 = no test
  /// @}

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("iterations", p.iterations, 1, 100, "Largest number of Gauss-Newton steps of a dense refinement.");
    visit("pixel_error", p.pixel_error, 0.1, 1e3,
          "Error of a difference of two measured inverse depths [noise standard deviations].");
    visit(
        "robust_gate", p.robust_gate, 0.1, 100.0,
        "Difference of inverse depths at which a pixel loses its weight [standard deviations of the error].");
  }
  void validate() const { checkRanges(*this); }
};

}  // namespace facetloc
