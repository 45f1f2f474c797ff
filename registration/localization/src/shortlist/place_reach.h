// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace facetloc::internal {

// How far one place is laid from another at most: about three standard deviations of the usual prior, which
// is 20 deg and 1 m.
constexpr float kReachTurnDeg = 60;  // between their headings [deg]
constexpr float kReachMove = 2.8f;   // along each axis [m]

}  // namespace facetloc::internal
