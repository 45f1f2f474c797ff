// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "inputs/depth_input.h"
#include "tools/image_trajectory.h"

#include <facetloc/mapping/map_session.h>

namespace facetloc {

class DrawnMap;

/** \brief facetloc_map extend: a later session is found in a map, and brings it up to date. */
class MapExtendApp : public App {
public:
  MapExtendApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  MapSession sessionIn(const std::shared_ptr<const Map>& map, const DepthSequence& sequence,
                       const Camera& camera, const Console& console) const;
  const SessionPlace& find(MapSession& session) const;
  void writeTrajectory(const MapSession& session) const;
  static void drawChanges(const std::string& map, const MapSession& session, const MapChanges& changes,
                          DrawnMap& picture);

  std::string map_;
  std::string sequence_;
  std::string output_;
  std::string poses_;
  std::string trajectory_;
  std::string changes_;
  double pose_tolerance_ = 0.02;
  bool overwrite_ = false;
  bool without_poses_ = false;
  DepthInput input_;
  MapBuilderParams builder_;
  MapSessionParams session_;
  ImageTrajectory by_images_;
};

}  // namespace facetloc
