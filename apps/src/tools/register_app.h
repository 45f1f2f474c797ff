// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "inputs/depth_input.h"

#include <facetloc/features/answer_state.h>
#include <facetloc/localization/localization_params.h>

#include <filesystem>

namespace facetloc {

/** \brief facetloc_register: the pose of one depth image relative to another. */
class RegisterApp : public App {
public:
  RegisterApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  void writeAligned(const DepthSequence& source, const Eigen::Isometry3d& T_target_source) const;

  std::string source_;
  std::string target_;
  std::string folder_;
  std::string aligned_;
  double min_probability_ = kMinProbability;
  int max_hypotheses_ = 10;
  DepthInput input_;
  GlobalLocalizationParams localization_;
};

}  // namespace facetloc
