// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/pose.h>
#include <facetloc/localization/sure_calibration.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>

namespace facetloc {
namespace {

/** Probability of at most k of n, summed term by term. */
double sumOfBinomial(std::size_t k, std::size_t n, double p) {
  double sum = 0;
  for (std::size_t i = 0; i <= k; ++i)
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) +
                    static_cast<double>(i) * std::log(p) + static_cast<double>(n - i) * std::log1p(-p));
  return sum;
}

/** A localizer of which all is known: how its probabilities are distributed, and how often it is wrong. */
struct KnownLocalizer {
  std::function<double(std::mt19937&)> probability;
  std::function<double(double)> wrong;  // share of wrong ones, of a probability

  SureCalibration calibration(std::size_t images, double alpha, double confidence,
                              std::mt19937& random) const {
    SureCalibration out(alpha, confidence);
    std::uniform_real_distribution<double> uniform;
    for (std::size_t i = 0; i < images; ++i) {
      const double p = probability(random);
      out.add(p, uniform(random) >= wrong(p));
    }
    return out;
  }
  /** The true share of wrong ones of the sure answers. */
  double risk(double threshold) const {
    std::mt19937 random(99);
    double sure = 0, sum = 0;
    for (int i = 0; i < 200000; ++i) {
      const double p = probability(random);
      if (p < threshold) continue;
      ++sure;
      sum += wrong(p);
    }
    return sum / std::max(sure, 1.0);
  }
};

/** Most probabilities are near 1, as real ones. */
double mostlySure(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform;
  return 1 - std::pow(10, -5 * uniform(random));
}

/** \return the share of trials in which the true risk is above alpha; counts those with a threshold. */
double shareBroken(const KnownLocalizer& localizer, std::size_t images, double alpha, double confidence,
                   int& with_threshold) {
  constexpr int kTrials = 1500;
  std::mt19937 random(1);
  std::map<double, double> risks;
  int broken = 0;
  for (int i = 0; i < kTrials; ++i) {
    const auto threshold = localizer.calibration(images, alpha, confidence, random).threshold();
    if (!threshold) continue;
    ++with_threshold;
    if (!risks.count(*threshold)) risks[*threshold] = localizer.risk(*threshold);
    broken += risks[*threshold] > alpha;
  }
  return static_cast<double>(broken) / kTrials;
}

constexpr double kThreeStd = 0.017;  // three standard deviations of a share of 5 % of 1500 trials

TEST(SureCalibration, BoundHoldsForProbabilitiesThatAreRight) {
  const KnownLocalizer honest{mostlySure, [](double p) { return 1 - p; }};
  int found = 0;
  EXPECT_LE(shareBroken(honest, 800, 0.02, 0.95, found), 0.05 + kThreeStd);
  EXPECT_GT(found, 1400) << "it is not only never sure";
}

TEST(SureCalibration, BoundHoldsForProbabilitiesThatPromiseTooMuch) {
  for (const double factor : {3.0, 20.0, 200.0}) {
    const KnownLocalizer boastful{mostlySure, [=](double p) { return std::min(1.0, factor * (1 - p)); }};
    int found = 0;
    EXPECT_LE(shareBroken(boastful, 1000, 0.02, 0.95, found), 0.05 + kThreeStd) << factor;
    EXPECT_LE(shareBroken(boastful, 1000, 0.02, 0.8, found), 0.2 + 2 * kThreeStd) << factor;
  }
}

/** The hardest case: each threshold is just not good enough, and each is tested. */
TEST(SureCalibration, BoundHoldsWhereProbabilitiesMeanNothing) {
  for (const double risk : {0.0201, 0.03}) {
    const KnownLocalizer blind{mostlySure, [=](double) { return risk; }};
    for (const std::size_t images : {300u, 3000u}) {
      int found = 0;
      EXPECT_LE(shareBroken(blind, images, 0.02, 0.95, found), 0.05 + kThreeStd) << risk << " " << images;
    }
  }
}

/** Surer answers may be worse ones. */
TEST(SureCalibration, BoundHoldsWhereProbabilitiesAreTheWrongWayRound) {
  const KnownLocalizer reversed{mostlySure, [](double p) { return p > 0.999 ? 0.05 : 0.001; }};
  int found = 0;
  EXPECT_LE(shareBroken(reversed, 2000, 0.02, 0.95, found), 0.05 + kThreeStd);
}

TEST(SureCalibration, ThresholdFallsAsImagesGrowMore) {
  const KnownLocalizer honest{mostlySure, [](double p) { return 1 - p; }};
  std::mt19937 random(3);
  double last = 2;
  for (const std::size_t images : {1000u, 8000u, 64000u}) {
    const auto threshold = honest.calibration(images, 0.02, 0.95, random).threshold();
    ASSERT_TRUE(threshold) << images;
    EXPECT_LE(*threshold, last);
    last = *threshold;
  }
  EXPECT_LE(last, 0.95);
}

TEST(SureCalibration, SaysHowManyImagesAreNeeded) {
  SureCalibration calibration(0.01, 0.95);
  EXPECT_FALSE(calibration.threshold());
  EXPECT_FALSE(calibration.imagesNeeded()) << "without images, the share of sure ones is unknown";
  for (int i = 0; i < 100; ++i) calibration.add(i % 2 ? 0.99999 : 0, true);
  ASSERT_FALSE(calibration.threshold());
  const auto needed = calibration.imagesNeeded();
  ASSERT_TRUE(needed);
  EXPECT_GT(*needed, 600u);  // half of them sure; 299 would do with all of the error
  EXPECT_LT(*needed, 1000u);
  while (calibration.images() < *needed + *needed / 20)
    calibration.add(calibration.images() % 2 ? 0.99999 : 0, true);
  EXPECT_TRUE(calibration.threshold());
  EXPECT_FALSE(calibration.imagesNeeded() > calibration.images());
}

TEST(SureCalibration, NoNumberOfImagesHelpsAgainstWrongOnes) {
  SureCalibration calibration(0.01, 0.95);
  for (int i = 0; i < 1000; ++i) calibration.add(0.99999, i % 20 != 0);
  EXPECT_FALSE(calibration.threshold());
  EXPECT_FALSE(calibration.imagesNeeded());
}

TEST(SureCalibration, LeastSureIsEnough) {
  for (const double alpha : {0.01, 0.05, 0.2}) {
    SureCalibration calibration(alpha, 0.95);
    const std::size_t least = calibration.leastSure();
    for (std::size_t i = 0; i + 1 < least; ++i) calibration.add(0.995, true);
    EXPECT_FALSE(calibration.threshold()) << alpha;
    calibration.add(0.995, true);
    EXPECT_TRUE(calibration.threshold()) << alpha;
  }
}

TEST(SureCalibration, UpperLimitIsClopperAndPearsons) {
  for (const auto& [k, n] : {std::pair<std::size_t, std::size_t>{0, 100}, {3, 100}, {50, 120}, {99, 100}}) {
    const double limit = upperLimitOfShare(k, n, 0.95);
    EXPECT_NEAR(sumOfBinomial(k, n, limit), 0.05, 1e-6) << k << " of " << n;
  }
  EXPECT_NEAR(upperLimitOfShare(0, 299, 0.95), 0.01, 1e-4);
  EXPECT_EQ(upperLimitOfShare(0, 0, 0.95), 1);
  EXPECT_EQ(upperLimitOfShare(7, 7, 0.95), 1);
  EXPECT_THROW(upperLimitOfShare(8, 7, 0.95), std::invalid_argument);
}

TEST(SureCalibration, RefusesInvalidShares) {
  for (const double share : {0.0, 1.0, -1.0, std::nan("")}) {
    EXPECT_THROW(SureCalibration(share, 0.95), std::invalid_argument) << share;
    EXPECT_THROW(SureCalibration(0.01, share), std::invalid_argument) << share;
  }
  SureCalibration calibration;
  EXPECT_THROW(calibration.add(1.1, true), std::invalid_argument);
  EXPECT_THROW(calibration.add(std::nan(""), true), std::invalid_argument);
}

TEST(SureCalibration, ImagesOfOneViewCountOnce) {
  std::vector<Eigen::Isometry3d> T_w_c;
  for (int i = 0; i < 100; ++i) T_w_c.emplace_back(Eigen::Translation3d(0.02 * i, 0, 0));
  EXPECT_NEAR(static_cast<double>(independentImages(T_w_c).size()), 100 * 0.02 / 0.15, 2);
  T_w_c.assign(50, Eigen::Isometry3d::Identity());
  EXPECT_THAT(independentImages(T_w_c), testing::ElementsAre(0));
  for (int i = 0; i < 50; ++i)
    T_w_c[i].linear() = Eigen::AngleAxisd(i * kDegree, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_NEAR(static_cast<double>(independentImages(T_w_c).size()), 10, 1);
  EXPECT_THAT(independentImages({}), testing::IsEmpty());
}

TEST(SureCalibration, RightIsNearTheTruth) {
  const Eigen::Isometry3d truth(Eigen::Translation3d(1, 2, 3));
  const RightPose is_right;
  EXPECT_TRUE(is_right(truth, truth));
  EXPECT_TRUE(is_right(truth * Eigen::Translation3d(0.19, 0, 0), truth));
  EXPECT_FALSE(is_right(truth * Eigen::Translation3d(0.21, 0, 0), truth));
  const auto turned = [&](double deg) {
    return Eigen::Isometry3d(truth * Eigen::AngleAxisd(deg * kDegree, Eigen::Vector3d::UnitX()));
  };
  EXPECT_TRUE(is_right(turned(1.9), truth));
  EXPECT_FALSE(is_right(turned(2.1), truth));
}

}  // namespace
}  // namespace facetloc
