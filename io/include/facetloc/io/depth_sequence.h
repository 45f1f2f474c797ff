// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/segment.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/trajectory.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

namespace internal {
class ImageContainer;
class SequenceReader;
}  // namespace internal

/** \brief One image of a sequence, not yet read. */
struct FrameFile {
  std::string name;            ///< file name without its extension; unique within a sequence
  std::filesystem::path path;  ///< 16-bit PNG, organized PCD, or the recording that it is in
  double stamp = 0;            ///< [s], or the index if nothing says when the images were taken
};

/** \brief What a user knows of a recording, where it counts more than what the recording's files say. */
struct RecordingHints {
  /** The file of a camera (camera_file.h) or a CameraPreset's name; empty: as the recording says. Of a
   * preset, noise and largest depth hold; its intrinsics, of a typical device, only if the recording has
   * none. */
  std::string camera{};
  double depth_scale = 0;  ///< PNG values per metre; 0: as the recording says
  double time_offset = 0;  ///< added to the time of an image, it is the time of its pose [s]
  /** Of a bag: the topic of its images; empty = of several, the one called depth that has the most. */
  std::string topic{};
  bool segments = false;  ///< take files of segments, too
};

/** \brief A sequence of depth images on disk, in the order of their stamps.
 *
 * Accepted: a folder with depth/ in it; a folder of PNGs or organized PCDs; a single PNG or PCD
 * file; an .oni recording; a ROS 1 .bag, if the build has rosbag_storage; a text file (.txt, .lst) with one
 * path per line, relative to the list, with or without a time stamp before it; # starts a comment line. Where
 * names are no times, folders are in the order of the names and lists in their own.
 *
 * Layouts of public recordings are known as they are downloaded: TUM RGB-D (depth.txt or associations.txt are
 * read where names are no stamps), 7-Scenes and 3DMatch (frame-000000.depth.png, .pose.txt), ScanNet
 * (depth/0.png, pose/0.txt), ICL-NUIM (depth/0.png, *.gt.freiburg), PCL's recorders
 * (frame_20121214T142255.814212.pcd). Images that are numbered are 1/30 s apart. Frames that have no stamps
 * as their names, those of recordings among them, are named by their times, in seconds with 6 decimals.
 *
 * What facetloc_segment has made of images, NAME.segments.pcd, is a sequence as well for those who ask for
 * it (RecordingHints::segments): a file, a folder, or a list of them. In a folder, they alone count then.
 *
 * camera.ini is looked for in the folder, in its parent, and beside the file; so are the matrices of 3DMatch
 * (camera-intrinsics.txt) and ScanNet (intrinsic/intrinsic_depth.txt). PNGs need one, or a data set's layout
 * whose camera is known; PCDs fall back to the intrinsics in their points, recordings to their field of view.
 * groundtruth.txt is looked for in the same places, and read if the frames have time stamps. */
class DepthSequence {
public:
  /** \brief Lists the frames; reads no image. Throws IoError if there is nothing to read, or if nothing says
   * which camera took PNG images. */
  static DepthSequence open(const std::filesystem::path& path, const RecordingHints& hints = {});

  /** \brief The true poses alone, at the times of the images: of a recording, whose camera needs not be
   * known, or of a file in the TUM format. Throws IoError. */
  static Trajectory readTruth(const std::filesystem::path& path, double time_offset = 0);

  const std::vector<FrameFile>& frames() const { return frames_; }
  const std::optional<CameraFile>& camera() const { return camera_; }
  /** \brief The poses that came with the recording, at the times of its images. Empty if there are none.
   * Throws IoError if there are some that cannot be read. */
  const Trajectory& groundTruth() const;
  /** \brief Poses in a file of the TUM format, or the odometry of a bag, as poses of this recording's camera,
   * at the times of its images: with its offset in time, and with the y axis of its camera downwards. Throws
   * IoError. */
  Trajectory readPoses(const std::filesystem::path& path) const;
  /** \brief How the recording is laid out, in words. */
  const std::string& layout() const { return layout_; }
  /** \brief What its user should know of it, a sentence without full stop; empty if there is nothing. */
  std::string remark() const;
  /** \brief Are the stamps times, rather than indices? Without times no poses can be matched. */
  bool stamped() const { return stamped_; }

  /** \brief Are its frames files of segments? Then it has no images. */
  bool ofSegments() const { return of_segments_; }
  /** \brief Reads the segments of such a frame. Throws what readSegments() throws, and std::out_of_range. */
  std::vector<Segment> segments(std::size_t index) const;

  /** \brief Reads a frame, subsampled so that at least working_width columns remain (0 = full size).
   * Thread-safe. Throws IoError for unreadable, truncated, unorganized or wrongly sized files
   * and for segments, std::out_of_range for the index. */
  DepthImage load(std::size_t index, int working_width = 0) const;

private:
  friend class internal::SequenceReader;
  DepthSequence() = default;
  Trajectory asOfImages(const Trajectory& poses) const;
  std::optional<Intrinsics> knownIntrinsics() const;

  std::vector<FrameFile> frames_;
  std::shared_ptr<const internal::ImageContainer> container_;  // that all frames are in, if they are
  std::string layout_;
  std::optional<CameraFile> camera_;
  std::string camera_remark_;  // where the camera is from, if not from the user
  double time_offset_ = 0;
  Trajectory ground_truth_;
  std::exception_ptr ground_truth_fault_;  // why it could not be read, if it could not
  bool stamped_ = false;
  bool of_segments_ = false;
};

/** \brief Reads one 16-bit depth PNG; value / depth_scale = metres, 0 and 65535 = not measured. */
DepthImage readDepthPng(const std::filesystem::path& path, const CameraFile& file);
/** \brief Writes depth as a 16-bit PNG at the given scale; what does not fit below 65535 becomes 0. */
void writeDepthPng(const std::filesystem::path& path, const DepthImage& image, double depth_scale);
/** \brief Reads one organized PCD; intrinsics from the points unless given. Throws IoError for unorganized
 * clouds. */
DepthImage readDepthPcd(const std::filesystem::path& path, const std::optional<Intrinsics>& camera = {});

}  // namespace facetloc
