// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/io/camera_file.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_map_poses.h>
#include <facetloc/simulation/simulated_odometry.h>
#include <facetloc/simulation/simulated_place.h>

#include <string>
#include <vector>

namespace facetloc {

/** \brief facetloc_simulate: depth sequences of a simulated place, with the truth. */
class SimulateApp : public App {
public:
  SimulateApp();

private:
  struct Run;    // a sequence to be: folder, poses, stamps
  struct Place;  // the runs through a place

  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  void checkOptions() const;
  SimulatedPlace makeScenes() const;
  void writeModels(const SimulatedPlace& made, const Console& console) const;
  Place makePlace(SimulatedPlace made) const;
  void setStamps(std::vector<Run>& runs) const;
  void prepareFolder(const Run& run, const CameraFile& camera) const;
  void writeUnmapped(const Run& query, const std::vector<char>& unmapped) const;
  std::vector<std::string> wantedRuns() const;

  std::string scene_;
  std::string folder_;
  std::string model_, grid_;  // files of the building; may be empty
  std::string runs_;
  std::string preset_;  // camera
  int seed_ = 1;
  int width_ = 640;
  int frames_ = 0;
  int map_frames_ = 444;    // the paper's
  int query_frames_ = 348;  // the paper's
  int rounds_ = 1;          // rounds of the mapping run
  double map_step_ = 0.25;
  double seconds_ = 60;  // duration of the continuous drive
  PaceParams pace_;
  DriveParams drive_;
  SimulatedNoise noise_;
  bool shared_errors_ = false;
  double surface_error_ = 0;  // [m]
  MapPoseErrors map_poses_;
  bool with_odometry_ = false;
  double gravity_error_deg_ = -1;  // negative: no file
  WheelOdometryParams odometry_;
};

/** \brief The depth camera of a Kinect with images of another width, same field of view. */
Intrinsics scaledKinect(int width);

}  // namespace facetloc
