// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/trajectory.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

class OniFile;

/** \brief One image of a sequence, not yet read. */
struct FrameFile {
  std::string name;            ///< file name without its extension; unique within a sequence
  std::filesystem::path path;  ///< 16-bit PNG, organized PCD, or the recording that it is in
  double stamp = 0;            ///< [s]: the name if all names are numbers (TUM), else the index
};

/** \brief A sequence of depth images on disk, in the order of their stamps.
 *
 * Accepted: a folder with depth/ in it; a folder of PNGs or organized PCDs; a single PNG or PCD
 * file; an .oni recording, whose frames are named by their time stamps, in seconds with 6 decimals; a text
 * file (.txt, .lst) with one path per line, relative to the list; # starts a comment line. Where
 * names are no numbers, folders are in the order of the names and lists in their own. camera.ini is looked
 * for in the folder, in its parent, and beside the file; PNGs need one, PCDs fall back to the intrinsics in
 * their points, recordings to their field of view. groundtruth.txt is looked for in the same places, and read
 * if the names are time stamps. */
class DepthSequence {
public:
  /** \brief Lists the frames; reads no image. Throws IoError if there is nothing to read. */
  static DepthSequence open(const std::filesystem::path& path);

  const std::vector<FrameFile>& frames() const { return frames_; }
  const std::optional<CameraFile>& camera() const { return camera_; }
  /** \brief Empty if there is none. Throws IoError if there is one that cannot be read. */
  const Trajectory& groundTruth() const;
  /** \brief What its user should know of it, a sentence without full stop; empty if there is nothing. */
  std::string remark() const;
  /** \brief Are the stamps times, rather than indices? Without times no poses can be matched. */
  bool stamped() const { return stamped_; }

  /** \brief Reads a frame, subsampled so that at least working_width columns remain (0 = full size).
   * Thread-safe. Throws IoError for unreadable, truncated, unorganized or wrongly sized files,
   * std::out_of_range for the index. */
  DepthImage load(std::size_t index, int working_width = 0) const;

private:
  void openRecording(const std::filesystem::path& path);

  std::vector<FrameFile> frames_;
  std::shared_ptr<const OniFile> recording_;  // that all frames are in, if they are
  std::optional<CameraFile> camera_;
  Trajectory ground_truth_;
  std::exception_ptr ground_truth_fault_;  // why it could not be read, if it could not
  bool stamped_ = false;
};

/** \brief Reads one 16-bit depth PNG; value / depth_scale = metres, 0 = not measured. */
DepthImage readDepthPng(const std::filesystem::path& path, const CameraFile& file);
/** \brief Writes depth as a 16-bit PNG at the given scale; what does not fit 16 bits becomes 0. */
void writeDepthPng(const std::filesystem::path& path, const DepthImage& image, double depth_scale);
/** \brief Reads one organized PCD; intrinsics from the points unless given. Throws IoError for unorganized
 * clouds. */
DepthImage readDepthPcd(const std::filesystem::path& path, const std::optional<Intrinsics>& camera = {});

}  // namespace facetloc
