// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/depth_input.h"

#include <facetloc/features/noise_over_range.h>
#include <facetloc/mapping/map_making.h>

#include <string>
#include <vector>

namespace facetloc {

/** \brief facetloc_check: the content of a recording, and the results to expect of it. */
class CheckApp : public App {
public:
  CheckApp();

private:
  /** Findings about one image. */
  struct ImageReport;
  /** Faults and missing items. */
  struct Findings;

  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;

  void reportImages(const DepthSequence& sequence, const std::vector<ImageReport>& images,
                    const Console& console, Findings& findings) const;
  void reportCamera(const DepthSequence& sequence, const std::vector<ImageReport>& images,
                    const Console& console) const;
  void reportValues(const DepthSequence& sequence, Findings& findings) const;
  void reportSurfaces(const DepthSequence& sequence, MapMaking& making, const Console& console,
                      Findings& findings) const;
  void reportPoses(const DepthSequence& sequence, const Trajectory& poses, MapMaking& making,
                   const Console& console, Findings& findings) const;
  void reportNoise(std::vector<ImageReport>& images, const Console& console, const Findings& findings) const;
  void reportFloor(std::vector<ImageReport>& images, const Camera& camera, const Trajectory& poses,
                   const Console& console, Findings& findings) const;
  Trajectory posesOf(const DepthSequence& sequence, const Console& console, Findings& findings) const;
  MapMaking makingOf(const DepthSequence& sequence, const Camera& camera, const Trajectory& poses) const;

  std::string input_, poses_;
  DepthInput depth_;
  double pose_tolerance_ = 0.02;
};

}  // namespace facetloc
