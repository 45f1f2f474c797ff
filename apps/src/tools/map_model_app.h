// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/mapping/floor_plan.h>
#include <facetloc/mapping/model_map.h>

#include <memory>
#include <string>

namespace facetloc {

/** \brief facetloc_map from-model: a scan or mesh of a building -> a map. */
class MapModelApp : public App {
public:
  MapModelApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  std::shared_ptr<const Surface> surface(const Console& console) const;
  bool isFloorPlan() const;
  void checkFloorPlan(const CommandLine& line) const;
  std::shared_ptr<const FloorPlanSurface> floorPlan(const Console& console) const;
  ModelMap making(const Console& console) const;
  Map make(const Console& console) const;
  void noteOrientation(const SurfaceOrientation& orientation, const Eigen::AlignedBox3d& bounds,
                       const Console& console) const;
  std::string parameters(const Camera& camera, const ModelFindings& found) const;

  std::string model_;
  std::string map_;
  std::string camera_;
  std::string viewpoints_;
  std::string inside_;
  std::string plan_;
  std::string units_ = "m";
  std::string up_ = "z";
  double height_ = 0;
  int width_ = 0;
  bool overwrite_ = false;
  FloorPlanParams floor_plan_;
  ModelMapParams params_;
  ViewParams view_;
};

}  // namespace facetloc
