// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "inputs/depth_input.h"

#include <facetloc/localization/localization_params.h>
#include <facetloc/localization/sure_calibration.h>

#include <memory>
#include <string>
#include <vector>

namespace facetloc {

/** \brief facetloc_map calibrate: sets from which probability on answers in a map are sure. */
class MapCalibrateApp : public App {
public:
  MapCalibrateApp();

private:
  /** An image whose place is known. */
  struct Asked {
    std::size_t frame;
    Eigen::Isometry3d T_w_c;
  };

  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  std::vector<Asked> askedOf(const DepthSequence& sequence, const Map& map, const Console& console) const;
  int ask(const std::shared_ptr<const Map>& map, const CommandLine& line, SureCalibration& calibration,
          const Console& console);
  [[noreturn]] void refuse(const SureCalibration& calibration) const;

  std::vector<std::string> inputs_;  // map, and the recording if one is given
  std::string poses_;
  double pose_tolerance_ = 0.02;
  double alpha_ = 0.01;
  double confidence_ = 0.95;
  RightPose is_right_;
  DepthInput input_;
  GlobalLocalizationParams localization_;
};

}  // namespace facetloc
