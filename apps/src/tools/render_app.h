// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "evaluation/evaluation.h"
#include "inputs/depth_input.h"

#include <facetloc/localization/localization_params.h>

#include <string>

namespace facetloc {

/** \brief facetloc_render: pictures of images, maps, answers and failures. */
class RenderApp : public App {
public:
  RenderApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;

  int renderMap(const Console& console) const;
  int renderMapPage(const Console& console) const;
  int renderAnswerPage(const CommandLine& line, const Console& console) const;
  int renderBeliefs(const Console& console) const;
  int renderImages(const CommandLine& line, const Console& console) const;
  int renderFailures(const CommandLine& line, const Console& console) const;

  std::string input_;
  std::string output_;
  std::string map_;
  std::string frame_;
  std::string trajectory_;
  std::string marks_;
  std::string sequence_;
  int max_hypotheses_ = 1;
  int most_ = 20;
  DepthInput depth_;
  EvaluationParams evaluation_;
  GlobalLocalizationParams localization_;
};

}  // namespace facetloc
