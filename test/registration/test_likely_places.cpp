// SPDX-License-Identifier: BSD-3-Clause
#include "tracking/likely_places.h"

#include <gtest/gtest.h>

namespace facetloc {

using namespace internal;
namespace {

constexpr int kModels = 100;

LikelyPlace at(double x, double probability, double degrees = 0) {
  LikelyPlace place;
  place.T_w_c.T.translation().x() = x;
  place.T_w_c.T.linear() = expSO3({0, 0, degrees * kDegree});
  place.probability = probability;
  return place;
}

double sum(const std::vector<LikelyPlace>& places) {
  double sum = 0;
  for (const LikelyPlace& p : places) sum += p.probability;
  return sum;
}

TEST(LikelyPlaces, ThoseThatNoViewConfirmsAreForgotten) {
  std::vector<LikelyPlace> places;
  for (int view = 0; view < 100; ++view) {
    std::vector<LikelyPlace> now;
    for (int i = 0; i < 20; ++i) now.push_back(at(20 * view + i, 0.04));
    places = placesOfBoth(places, now, kModels);
    EXPECT_LE(places.size(), 100u) << view;
    for (const LikelyPlace& p : places) EXPECT_GE(p.probability, 1e-6);
  }
  EXPECT_GE(places.size(), 20u);  // those of the last view
}

TEST(LikelyPlaces, APlaceInBothListsWinsOverThoseInOne) {
  // Two views between two equal corners each, of which only one fits both.
  const auto both = placesOfBoth({at(0, 0.5), at(5, 0.5)}, {at(9, 0.5), at(5.1, 0.45)}, kModels);
  ASSERT_EQ(both.size(), 2u);  // the view before was sure that it is not 9
  EXPECT_GT(both[0].probability, 0.9);
  EXPECT_DOUBLE_EQ(both[0].T_w_c.T.translation().x(), 5.1);  // as the last view saw it
  EXPECT_LT(both[1].probability, 0.05);
}

TEST(LikelyPlaces, PlacesInTwoPartsOfAMapAreTwo) {
  LikelyPlace elsewhere = at(0, 0.4);
  elsewhere.part = 1;
  const auto both = placesOfBoth({at(0, 0.4), at(5, 0.4)}, {elsewhere, at(5, 0.4)}, kModels);
  ASSERT_EQ(both.size(), 3u);
  EXPECT_EQ(both[0].part, 1);
  EXPECT_LT(both[0].probability, 0.05) << "the view before has not seen it";
  EXPECT_GT(both[1].probability, 0.9);
  EXPECT_EQ(both[2].part, 0);
}

TEST(LikelyPlaces, OfEqualCornersInBothViewsNoneWins) {
  const auto both = placesOfBoth({at(0, 0.5), at(5, 0.5)}, {at(0, 0.5), at(5, 0.5)}, kModels);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_NEAR(both[0].probability, 0.5, 1e-12);
  EXPECT_NEAR(both[1].probability, 0.5, 1e-12);
}

TEST(LikelyPlaces, TwoViewsThatAreHalfSureOfOnePlaceAreSurer) {
  const double p = placesOfBoth({at(0, 0.5)}, {at(0, 0.5)}, kModels).front().probability;
  EXPECT_GT(p, 0.7);
  EXPECT_LT(p, 0.9);  // they look alike: less than independent views would say
}

TEST(LikelyPlaces, TwoViewsThatContradictEachOtherAreSureOfNothing) {
  for (const LikelyPlace& p : placesOfBoth({at(0, 0.6)}, {at(5, 0.6)}, kModels))
    EXPECT_LT(p.probability, 0.1);
}

TEST(LikelyPlaces, AnUnsureViewTakesLittleFromASureOne) {
  const auto both = placesOfBoth({at(0, 0.95)}, {at(0, 0.3), at(5, 0.3), at(9, 0.3)}, kModels);
  EXPECT_GT(both[0].probability, 0.95);
}

TEST(LikelyPlaces, NeverExceedOneInAll) {
  EXPECT_TRUE(placesOfBoth({}, {}, kModels).empty());
  EXPECT_LE(sum(placesOfBoth({at(0, 1)}, {at(0, 1)}, kModels)), 1);
  EXPECT_LE(sum(placesOfBoth({at(0, 1)}, {at(5, 1)}, kModels)), 1);
  EXPECT_LE(sum(placesOfBoth({at(0, 0)}, {at(0, 0)}, 1)), 1);
  EXPECT_LE(sum(placesOfBoth({}, {at(0, 0.7), at(3, 0.3)}, 1)), 1);
}

}  // namespace
}  // namespace facetloc
