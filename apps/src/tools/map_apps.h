// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "batch/shared_batch.h"
#include "cli/app.h"
#include "inputs/depth_input.h"
#include "inputs/gravity_option.h"
#include "tools/image_trajectory.h"

#include <facetloc/io/map_database.h>
#include <facetloc/mapping/floor_plan.h>
#include <facetloc/mapping/map_making.h>

#include <memory>

namespace facetloc {

class MapFile;
struct MapBuildChecks;

/** \brief facetloc_map build: one run of depth images -> a map. */
class MapBuildApp : public App {
public:
  MapBuildApp();

private:
  struct Seen;
  using ModelBatch = SharedBatch<ModelsOrder, PackedModel>;

  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  bool dealsOut() const override { return true; }
  MapMaking makingOf(const DepthSequence& sequence, const Camera& camera, const Console& console);
  int findTrajectory(const MapBuildChecks& checks, MapMaking& making) const;
  void writeTrajectory(const DepthSequence& sequence, const MapMaking& making) const;
  std::vector<MapPlace> placesOf(const DepthSequence& sequence, const MapMaking& making) const;
  int build(const std::filesystem::path& path, const MapBuildChecks& checks,
            const std::vector<MapPlace>& places, MapMaking& making, ModelBatch& batch) const;
  ModelBatch::Work modelWork(const DepthSequence& sequence, Camera camera, const ModelsOrder& order,
                             int workers) const;
  std::vector<int> addModels(const DepthSequence& sequence, const std::vector<MapPlace>& places,
                             const Camera& camera, ModelBatch& batch, MapFile& file, Seen& seen) const;

  std::string disagreement_;  // between poses and images, as text
  Trajectory given_;          // poses of the images; empty if none are given

  std::string sequence_;
  std::string map_;
  std::string poses_;
  std::string trajectory_;
  int every_ = 0;
  double pose_tolerance_ = 0.02;
  bool overwrite_ = false;
  bool resume_ = false;
  bool raw_depth_ = false;
  bool force_ = false;
  bool without_poses_ = false;
  ImageTrajectory by_images_;
  GravityOption gravity_;
  DepthInput input_;
  MapBuilderParams builder_;
};

/** \brief facetloc_map info: the content of a map, for people. */
class MapInfoApp : public App {
public:
  MapInfoApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  std::string map_;
  bool all_ = false;
};

/** \brief facetloc_map check: proves a map sound, or lists its faults. */
class MapCheckApp : public App {
public:
  MapCheckApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  std::string map_;
};

/** \brief facetloc_map export: a map for other programs. */
class MapExportApp : public App {
public:
  MapExportApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  std::string map_;
  std::string folder_;
  std::string graph_;
  void writeGrid(const Map& map, const Console& console) const;
  std::string polygons_;
  std::string grid_;
  MapGridParams grid_params_;
};

/** \brief facetloc_map import: a copy of a map with the poses that another program has found. */
class MapImportApp : public App {
public:
  MapImportApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  std::string map_;
  std::string graph_;
  std::string output_;
  bool overwrite_ = false;
};

/** \brief facetloc_map merge: the local models of several maps in one, in one world. */
class MapMergeApp : public App {
public:
  MapMergeApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  void align(std::vector<Map>& maps, const Console& console) const;
  Map merge(const Console& console) const;
  std::vector<std::string> maps_;
  std::string output_;
  bool same_coordinates_ = false;
  bool overwrite_ = false;
};

/** \brief facetloc_map: hands over to the tool that its first argument names. \return the exit code. */
int runMapTool(const std::vector<std::string>& arguments, Console console);

}  // namespace facetloc
