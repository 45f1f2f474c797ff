// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/depth_input.h"

#include <facetloc/features/noise_over_range.h>
#include <facetloc/mapping/map_builder.h>

#include <string>
#include <vector>

namespace facetloc {

/** \brief facetloc_check: what a recording is, and what to expect of it. */
class CheckApp : public App {
public:
  CheckApp();

private:
  /** What one image shows. */
  struct ImageReport;
  /** What is wrong or missing, in the order in which it is found. */
  using Advice = std::vector<std::string>;

  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;

  void reportImages(const DepthSequence& sequence, const std::vector<ImageReport>& images,
                    const Console& console, Advice& advice) const;
  void reportCamera(const DepthSequence& sequence, const std::vector<ImageReport>& images,
                    const Console& console) const;
  void reportNoise(std::vector<ImageReport>& images, const Camera& camera, const Console& console,
                   Advice& advice) const;
  void reportFloor(std::vector<ImageReport>& images, const Camera& camera, const Console& console,
                   Advice& advice) const;
  void reportPoses(const DepthSequence& sequence, const Camera& camera, const Console& console,
                   Advice& advice) const;

  std::string input_;
  DepthInput depth_;
  double pose_tolerance_ = 0.02;
};

}  // namespace facetloc
