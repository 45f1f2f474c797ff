// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/local_model.h>
#include <facetloc/features/params.h>
#include <facetloc/mapping/map_image.h>
#include <facetloc/mapping/surface.h>
#include <facetloc/segmentation/view_builder.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Where a surface is looked at from, and how well it is known. */
struct ModelMapParams {
  static constexpr const char* kTitle = "Views of a scan, mesh or plan";
  double spacing = 1;
  double turn_deg = 20;
  double overlap = 0.7;
  double clearance = 0.25;
  int most_models = 3000;
  double surface_std = 0;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("spacing", p.spacing, 0.1, 10.0,
          "Maximum distance from a camera to a local model with a similar view [m].", kForUsers);
    visit("turn_deg", p.turn_deg, 1.0, 90.0,
          "Maximum angle between a camera and a local model with a similar view [deg].");
    visit("overlap", p.overlap, 0.0, 1.0,
          "Minimum share of the surface in a camera's view that a local model shows.");
    visit("clearance", p.clearance, 0.0, 10.0, "Distance that cameras keep from all surfaces [m].",
          kForUsers);
    visit("most_models", p.most_models, 1, 1000000,
          "Maximum number of local models; overlap is reduced until it holds.", kForUsers);
    visit(
        "surface_std", p.surface_std, 0.0, DepthNoise::kLargestDepthStd,
        "Error of the surface's position, standard deviation [m], in addition to the roughness that views of "
        "it show.",
        kForUsers);
  }
};

/** \brief Findings of ModelMap beside its map. */
struct ModelFindings {
  std::vector<Eigen::Isometry3d> viewpoints;  ///< T_w_c of the local models, in their order
  std::size_t places = 0;                     ///< positions where a camera can be, if they were looked for
  bool too_many = false;     ///< there are more places than are looked from: their number is an estimate
  std::size_t outdoors = 0;  ///< positions that were left out, in an area around all others
  bool is_open = false;      ///< the surface shows no whole room: positions are beside it
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< the upward direction that viewpoints rest on
  double overlap = 0;                             ///< with which viewpoints were chosen
  std::size_t without_segments = 0;               ///< viewpoints that became no local models
  std::string problem;                            ///< reason for an empty map, in words
};

/** \brief A surface to a map: depth images rendered from viewpoints become local models.
 *
 *     facetloc::ModelMap making(std::make_shared<facetloc::MeshSurface>(mesh), camera);
 *     const facetloc::Map map = making.finish();
 *
 * The world of the map is the frame of the surface, in metres. The camera is the one whose images are to be
 * localized: views have its intrinsics, range and noise, and its mounting, if it is known, is where they are
 * taken from; a camera in the hand is expected at several heights. */
class ModelMap {
public:
  static constexpr std::size_t kMostPlaces = 20000;

  /** \brief \param camera without valid intrinsics, a Kinect's are taken. Throws std::invalid_argument for a
   * parameter out of its range or no surface. */
  ModelMap(std::shared_ptr<const Surface> surface, const Camera& camera, const ModelMapParams& params = {},
           const ViewParams& view = {});
  ModelMap(ModelMap&&) noexcept;
  ModelMap& operator=(ModelMap&&) noexcept;
  ~ModelMap();

  void setNumberOfThreads(int n);  ///< 0 = all cores; 1 unless set
  void setProgress(MapProgressCallback progress);
  /** \brief Columns of the rendered images, at least; kWorkingWidth unless set. */
  void setWorkingWidth(int width);
  /** \brief Takes these viewpoints, T_w_c, each a local model, instead of looking for some. Throws
   * std::invalid_argument for one that is not finite. */
  void setViewpoints(std::vector<Eigen::Isometry3d> viewpoints);
  /** \brief The upward direction in the frame of the surface; its z axis unless set. Only where viewpoints
   * are looked for. Throws std::invalid_argument for no direction. */
  void setUp(const Eigen::Vector3d& up);
  /** \brief Takes the upward direction from the surface itself, as orientationOf() finds it. */
  void setUpBySurface();
  /** \brief The upward direction by convention, which orientation() takes into account. */
  void setUsualUp(const Eigen::Vector3d& up);
  /** \brief Which way is up, as the surface itself shows it; measured at the first call. */
  const SurfaceOrientation& orientation();
  /** \brief Places in the frame of the surface: viewpoints are looked for in the areas that hold one of them.
   * Unless set, in all areas but one around all others, which is taken for outdoors. */
  void setInside(std::vector<Eigen::Vector3d> places);
  /** \brief Heights of the optical centre above the floor, instead of the mounting's [m]. */
  void setHeights(std::vector<double> heights);
  /** \brief Makes no map if a camera can be at more places than this, which takes hours, as for a model in
   * another unit; kMostPlaces unless set. \param n 0 = any number */
  void setMostPlaces(std::size_t n);

  /** \brief The map with its ambiguity; empty, with findings().problem, if no view shows segments. Local
   * models are named "view-00001" and so on, in an order that does not depend on the number of threads.
   * Throws the exceptions of the callback. */
  Map finish();
  const ModelFindings& findings() const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace facetloc
