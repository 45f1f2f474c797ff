// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/features/params.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/gravity_record.h>

#include <optional>
#include <string>

namespace facetloc {

/** \brief How well a given direction of gravity is known. */
struct GravityParams {
  static constexpr const char* kTitle = "Error of a given gravity";
  double std_deg = 1;
  int up = 3;  ///< axis of the world of poses: 1 = x, 2 = y, 3 = z; negative: the other direction

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("std_deg", p.std_deg, 0.001, 90.0,
          "Error of a given direction of gravity about each horizontal axis, standard deviation [deg].",
          kForUsers);
    visit("up", p.up, -3, 3,
          "Upward axis of the world, for poses in place of gravity: 1 = x, 2 = y, 3 = z, negative = down.",
          kForUsers);
  }
};

/** \brief The options --gravity ... of tools that read images whose camera knows which way is down. */
class GravityOption {
public:
  void addOptions(CommandLine& line);
  /** \brief Reads the file, or else the IMU in the recording, with remarks on where gravity is from and on
   * images that have none. Throws IoError. */
  void read(const DepthSequence& sequence, const Console& console);
  /** \brief At the time of an image [s]; nothing without a source, or where it has a gap. */
  std::optional<Gravity> at(double stamp) const { return record_.at(stamp); }
  /** \brief As they are recorded beside maps and results; empty without gravity. */
  std::string toIni() const;

private:
  void readFile(const DepthSequence& sequence);

  std::string file_;
  GravityParams params_;
  GravityRecord record_;
};

}  // namespace facetloc
