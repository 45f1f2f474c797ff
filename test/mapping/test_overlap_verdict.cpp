// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory/overlap_verdict.h"

#include <gtest/gtest.h>

namespace facetloc {

using namespace internal;

namespace {

constexpr int kLeast = 2;

TEST(PieceBonds, AConfirmedBondStays) {
  EXPECT_FALSE(weakestBond({{{0, 0}, {100, 2}}, {{0, 5}, {40, 1}}}, {{{0, 5}, 2}}, kLeast));
  EXPECT_FALSE(weakestBond({}, {}, kLeast));
}

TEST(PieceBonds, ABondOfOneTieIsCut) {
  EXPECT_EQ(weakestBond({{{0, 5}, {40, 0}}}, {{{0, 5}, 1}}, kLeast), PiecePair(0, 5));
}

TEST(PieceBonds, AContradictedBondIsCut) {
  EXPECT_EQ(weakestBond({{{0, 5}, {40, 0}}, {{0, 9}, {60, 20}}}, {{{0, 5}, 3}, {{0, 9}, 7}}, kLeast),
            PiecePair(0, 9));
}

TEST(PieceBonds, WhereTheEndsOfAChainContradictEachOtherItsWeakestBondIsCut) {
  const PieceBonds bonds{{{0, 3}, 4}, {{3, 5}, 2}, {{5, 9}, 6}};
  EXPECT_EQ(weakestBond({{{0, 9}, {1, 30}}}, bonds, kLeast), PiecePair(3, 5));
  EXPECT_EQ(weakestBond({{{0, 9}, {1, 30}}, {{5, 9}, {50, 2}}}, bonds, kLeast), PiecePair(5, 9));
}

TEST(PieceBonds, ContradictionsWithinAPieceCutNothing) {
  EXPECT_FALSE(weakestBond({{{0, 0}, {10, 10}}}, {{{0, 5}, 3}}, kLeast));
}

}  // namespace
}  // namespace facetloc
