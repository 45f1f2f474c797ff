// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/depth_image.h>
#include <facetloc/features/segment.h>
#include <facetloc/io/trajectory.h>

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace facetloc {

/** \brief True planar segments of a frame, by the id of their plane. */
using TrueSegments = std::map<int, Segment>;

/** \brief The segments of exact depth and true labels; a segment has at least min_pixels [px at 320x240,
 * scaled with the image area]. */
TrueSegments trueSegments(const DepthImage& exact_depth, const LabelImage& labels, double min_pixels);

/** \brief Do the planes that both see fix the pose of the one relative to the other to these standard
 * deviations, position [m] in every direction and orientation [rad] about every axis? */
bool sharedPlanesSuffice(const TrueSegments& query, const TrueSegments& model, double position_std,
                         double rotation_std);

/** \brief A plane of the world, n . p = d. */
struct WorldPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit vector
  double offset = 0;                                  ///< d [m]
};

/** \brief Reads planes.csv: `plane,nx,ny,nz,d`, one plane per line. Throws IoError with the line for
 * malformed text, an id below 1 or twice, or a normal that is no unit vector. */
std::map<int, WorldPlane> readPlanes(const std::filesystem::path& path);

/** \brief Writes such a file, atomically. Throws IoError. */
void writePlanes(const std::filesystem::path& path, const std::map<int, WorldPlane>& planes);

/** \brief The exact depth of labelled pixels: where the ray of the pixel meets its plane; 0 without a label.
 * Throws std::invalid_argument for a label that is no plane. */
DepthImage exactDepth(const LabelImage& labels, const Intrinsics& camera,
                      const std::map<int, WorldPlane>& planes, const Eigen::Isometry3d& T_w_c);

/** \brief The truth about the frames of a simulated sequence: the planes in view, and the frames outside of
 * the map.
 *
 * Read from its folder: camera.ini, labels/NAME.png (the plane id of each pixel), planes.csv and, if it is
 * there, unmapped.txt (the names of frames taken where the map has nothing, one per line, # starts a
 * comment). */
class RenderedTruth {
public:
  /** \brief Nothing if the folder has no labels or no planes. Throws IoError for malformed files. */
  static std::optional<RenderedTruth> open(const std::filesystem::path& folder);

  bool has(const std::string& name) const;
  /** \brief The true segments of a frame, at 320x240. Throws IoError if its labels cannot be read or name a
   * plane that there is not. */
  TrueSegments segments(const std::string& name, const Eigen::Isometry3d& T_w_c, double min_pixels) const;

private:
  std::filesystem::path labels_;
  Intrinsics camera_;
  std::map<int, WorldPlane> planes_;
};

/** \brief All that is known to be true of one or several runs through a place. */
class PlaceTruth {
public:
  /** \brief A run whose images are there. */
  struct Sequence {
    std::filesystem::path folder;  ///< or file
    Trajectory poses;
    std::optional<RenderedTruth> rendered;
    std::set<std::string> unmapped;
  };

  PlaceTruth() = default;
  /** \brief Poses alone. */
  explicit PlaceTruth(Trajectory poses) : poses_(std::move(poses)) {}
  /** \brief A trajectory in the TUM format, a recording that has poses (DepthSequence), or the folder of a
   * simulated place, which has sequences map, query and drive. Throws IoError.
   * \param time_offset added to the time of an image, it is the time of its pose [s] */
  static PlaceTruth open(const std::filesystem::path& path, double time_offset = 0);
  /** \brief The truth of one run: of the sequence in the folder of this name, or of all without such a
   * folder. Throws IoError if their stamps overlap then: a frame could be of either. */
  PlaceTruth of(const std::string& run) const;

  const Trajectory& poses() const { return poses_; }  ///< poses of all runs
  /** \brief Was a frame taken where the map has nothing? */
  bool unmapped(const std::string& name) const;
  /** \brief The true segments of a frame of any run; nothing if its labels are not there. */
  std::optional<TrueSegments> segments(const std::string& name, const Eigen::Isometry3d& T_w_c,
                                       double min_pixels) const;
  /** \brief None for a trajectory alone. */
  const std::vector<Sequence>& sequences() const { return sequences_; }

private:
  void add(const Sequence& sequence);

  Trajectory poses_;
  std::vector<Sequence> sequences_;
};

}  // namespace facetloc
