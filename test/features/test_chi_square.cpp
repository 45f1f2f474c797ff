// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <gtest/gtest.h>

namespace facetloc {
namespace {

TEST(ChiSquareQuantile, IsThatOfTheDistributionToFourDigits) {
  constexpr struct {
    int n;
    double p;
  } kKnown[] = {{3, 0.95}, {3, 0.99}, {6, 0.95}, {6, 0.99}, {6, 0.999}};
  for (const auto& [n, p] : kKnown) {
    const double exact = boost::math::quantile(boost::math::chi_squared(n), p);
    EXPECT_NEAR(chiSquareQuantile(n, p), exact, 0.005) << n << " degrees of freedom, " << p;
  }
}

TEST(ChiSquareQuantile, IsAConstantOfTheCompiler) {
  constexpr double kGate = chiSquareQuantile(3, 0.99);
  static_assert(kGate > 11 && kGate < 12);
  EXPECT_THROW(chiSquareQuantile(4, 0.99), std::invalid_argument);
  EXPECT_THROW(chiSquareQuantile(3, 0.5), std::invalid_argument);
}

}  // namespace
}  // namespace facetloc
