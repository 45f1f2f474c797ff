// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/map_metadata.h>
#include <facetloc/features/params.h>
#include <facetloc/mapping/map_image.h>
#include <facetloc/segmentation/view_builder.h>

#include <cstddef>

namespace facetloc {

/** \brief Where a map gets views that no image was taken of. */
struct DensifyParams {
  static constexpr const char* kTitle = "Views beside the drive";
  double reach = 1;
  double spacing = 0.7;
  double rotation_deg = 20;
  double known_share = 0.4;
  double growth = 1.5;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("reach", p.reach, 0.0, 10.0, "Maximum distance of rendered views from the drive [m].", kForUsers);
    visit("spacing", p.spacing, 0.05, 10.0, "Minimum distance of a rendered view from the nearest one [m].",
          kForUsers);
    visit("rotation_deg", p.rotation_deg, 5.0, 180.0,
          "Minimum rotation of a rendered view from the nearest one [deg].", kForUsers);
    visit("known_share", p.known_share, 0.05, 1.0,
          "Share of a rendered view's pixels that the map must show.", kForUsers);
    visit("growth", p.growth, 0.0, 100.0, "Maximum number of rendered views per view of the drive.",
          kForUsers);
  }
};

/** \brief The result of densify(). */
struct Densification {
  std::size_t driven = 0;    ///< local models with a pose and a depth picture, which the surface is made of
  std::size_t rendered = 0;  ///< new local models
  std::size_t removed = 0;   ///< local models of an earlier densify(), which these replace
  double contradicted_share = 0;  ///< share of the recorded pixels that other pictures look through
};

/** \brief Adds local models where no image was taken: beside the drive, and in other directions.
 *
 * The depth pictures of the map, fused, are a surface (METHOD 1.7), of which views are rendered at places
 * that the pictures have seen to be free. Those of which enough is known become local models, each with a
 * link to the view that it was rendered beside. Surfaces that no picture shows are unknown in them. Views of
 * an earlier call are removed first. The ambiguity of the map and the threshold of sure answers are unknown
 * afterwards. Same map, same result, for any number of threads.
 *
 * Throws std::invalid_argument for a map whose views are not in memory (readMap()), for a parameter out of
 * its range, and for poses too far apart.
 *
 * \param threads 0 = all cores */
Densification densify(Map& map, const DensifyParams& params = {}, const ViewParams& view = {},
                      int threads = 1, const MapProgressCallback& progress = {});

}  // namespace facetloc
