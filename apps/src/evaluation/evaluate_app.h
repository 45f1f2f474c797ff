// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "evaluation/evaluation_report.h"

#include <facetloc/mapping/map_builder.h>

namespace facetloc {

/** \brief facetloc_evaluate: results against the truth, as the paper does it and beyond. */
class EvaluateApp : public App {
public:
  EvaluateApp();

private:
  struct Input;

  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  std::vector<ModelPose> modelPoses(const std::optional<Map>& map) const;
  TrueModelPoses trueModelPoses(const Input& input) const;
  std::optional<ResultsAlignment> align(Input& input) const;
  int evaluateTrajectory(const Console& console) const;
  void requireWorldPoses(const std::vector<RunResults>& runs, const std::optional<Map>& map) const;
  EvaluationReport reportOf(const Input& input) const;
  int reportWithoutTruth(const Input& input, const Console& console);
  void addMap(const EvaluationReport& report, const Input& input, ReportFigures& figures) const;
  std::vector<ReportPicture> drawPictures(const EvaluationReport& report, const Input& input,
                                          const Console& console) const;
  ReportFigures figuresOf(const EvaluationReport& report, const Input& input, const Console& console) const;

  std::string results_;
  std::string truth_;
  std::string folder_;
  std::string map_;
  std::string map_truth_;
  bool align_ = false;
  double pose_tolerance_ = 0.02;
  double time_offset_ = 0;
  EvaluationParams params_;
  MapBuilderParams builder_;
};

/** \brief The local models that the paper's rule makes of a run. */
std::vector<ModelPose> modelPosesOf(const Trajectory& run, const MapBuilderParams& params);

}  // namespace facetloc
