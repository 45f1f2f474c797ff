// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/evaluation.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/segmentation/view_builder.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace facetloc::benchmarks {

constexpr double kPoseTolerance = 0.02;  // [s]

/** \brief The views of some images of a run. */
struct SeenRun {
  DepthSequence sequence;
  std::vector<std::size_t> frames;
  std::vector<View> views;

  void see(const Camera& camera, const ViewParams& params);
};

/** \brief The map without the local models of which gone(number) is true. */
template <class Gone>
Map without(const Map& whole, const Gone& gone) {
  Map map;
  map.camera = whole.camera, map.meta = whole.meta, map.ambiguity = whole.ambiguity;
  for (std::size_t i = 0; i < whole.models.size(); ++i)
    if (!gone(static_cast<int>(i))) map.models.push_back(whole.models[i]);
  return map;
}

/** \brief Lets a map know how ambiguous its places are. */
void findAmbiguity(Map& map, const GlobalLocalizationParams& params);

/** \brief The images of a run that have a true pose, in the order of time. */
struct PosedRun {
  std::vector<std::size_t> frames;  ///< indices in the sequence
  std::vector<View> views;
  std::vector<double> stamps;            ///< [s]
  std::vector<Eigen::Isometry3d> truth;  ///< T_w_c
  std::vector<char> covered;             ///< near a local model
};

/** \brief A folder with the runs map/ and query/: the one makes the map, by the paper's rule, the other asks.
 */
class MappedPlace {
public:
  /** \param every Only each N-th image of the query is asked. \param query the run that asks
   * Throws IoError. */
  MappedPlace(const std::filesystem::path& folder, std::size_t every, const std::string& query = "query");

  /** \brief Builds the map as facetloc_map does, and sees the query with the map's camera. */
  Map see(const ViewParams& params, bool calibrated = true);

  /** \brief Sees the query with the camera of a map that is there already, whose local models, which have
   * poses in the world, take the place of those of the run map/. */
  void use(const Map& map, const ViewParams& params);

  /** \brief Does a local model show what a camera sees from there? */
  bool covers(const Eigen::Isometry3d& T_w_c) const;

  /** \brief The images of the query that were seen and have a true pose. */
  PosedRun posedQuery() const;

  const PlaceTruth& truth() const { return truth_; }
  const std::vector<ModelPose>& models() const { return models_; }
  const SeenRun& mapping() const { return mapping_; }
  const SeenRun& query() const { return query_; }

private:
  void seeQuery(const Map& map, const ViewParams& params);
  Map map(const Camera& camera) const;

  PlaceTruth truth_;
  std::string query_name_;
  SeenRun mapping_, query_;
  std::vector<ModelPose> models_;
};

}  // namespace facetloc::benchmarks
