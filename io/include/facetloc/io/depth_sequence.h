// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/segment.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/gravity_record.h>
#include <facetloc/io/trajectory.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

struct StoredDepth;

namespace internal {
struct CloudImage;
class ImageContainer;
struct ImageTimes;
class SequenceReader;
class ValueSample;
}  // namespace internal

/** \brief One image of a sequence, not yet read. */
struct FrameFile {
  std::string name;            ///< file name without its extension; unique within a sequence
  std::filesystem::path path;  ///< depth image, organized PCD, or the recording that it is in
  double stamp = 0;            ///< [s], or the index if nothing says when the images were taken
};

/** \brief A user's facts about a recording, which override its files. */
struct RecordingHints {
  /** The file of a camera (camera_file.h), a map that was made with it, or a CameraPreset's
   * name; empty: as the recording says. Of a preset, noise and largest depth hold; its intrinsics, of a
   * typical device, only if the recording has none. */
  std::string camera{};
  double depth_scale = 0;  ///< PNG values per metre; 0: as the recording says
  double time_offset = 0;  ///< added to the time of an image, it is the time of its pose [s]
  /** Topic of the images, for a recording of messages; empty = of several, the one called depth that has
   * the most. */
  std::string topic{};
  bool segments = false;  ///< take files of segments, too
  /** How the poses are written, of the recording and of files of poses that are read for it: the words of
   * PoseReading::of(). */
  std::string poses_are{"auto"};
};

/** \brief A sequence of depth images on disk, in the order of their stamps.
 *
 * Accepted: a folder of depth images, which are in it, in its folder depth/, or in the only folder below it
 * that has depth in its name and depth images in it; a single image; an .oni recording; messages of ROS 1 and
 * ROS 2, .bag, .db3, .mcap or a folder of rosbag2; a .db of RTAB-Map, with
 * the poses of its graph; a text file (.txt, .lst, .csv) with one path per line, relative to the list, with
 * or without a time stamp before it, and with images of other kinds and poses beside it; # starts a comment
 * line. Images are 16-bit PNG, PGM and TIFF, PCL's PCLZF, NPY arrays (whole numbers by depth_scale, or
 * metres), floating-point TIFF and PFM (metres), and organized PCD. Of images of several kinds in one folder,
 * those with the word depth in their names count.
 *
 * The numbers in the names of images are times, in seconds, or in milliseconds, microseconds or nanoseconds
 * by their size; whole numbers that count are counters, and the images 1/30 s apart, unless the stamps of the
 * poses are the same numbers, or poses are as many, which then are those of the images in their order. Where
 * names have no numbers, folders are in the order of the names and lists in their own. Frames that have no
 * stamps as their names are named by their times, in seconds with 6 decimals.
 *
 * Layouts of public recordings are known as they are downloaded: TUM RGB-D (depth.txt or associations.txt are
 * read where names are no stamps), 7-Scenes and 3DMatch (frame-000000.depth.png, .pose.txt), ScanNet
 * (depth/0.png, pose/0.txt), ICL-NUIM (depth/0.png, *.gt.freiburg), PCL's recorders
 * (frame_20121214T142255.814212.pcd and _depth.pclzf), Replica, RTAB-Map's export and Stray Scanner.
 *
 * The output of facetloc_segment for images, NAME.segments.pcd, is also a sequence for callers that ask for
 * it (RecordingHints::segments): a file, a folder, or a list of them. In a folder, they alone count then.
 *
 * camera.ini is looked for in the folder, in its parent, and beside the file; so are the matrices of 3DMatch
 * (camera-intrinsics.txt) and ScanNet (intrinsic/intrinsic_depth.txt), and in the recording itself
 * calibrations of the images' size in YAML or JSON, as ROS, OpenCV, Kalibr, RTAB-Map, ORB-SLAM, Open3D and
 * Replica write them. Images need one, or a data set's layout whose camera is known; PCDs fall back to the
 * intrinsics in their points, recordings to their field of view. groundtruth.txt is looked for in the same
 * places, and files of poses by other names in the recording, and read if the frames have time stamps.
 *
 * Images that are read are those of a pinhole camera: a lens (CameraFile::lens) and distances along rays
 * (CameraFile::depth_is) are taken out, clouds in other axes or in millimetres are turned and scaled, and
 * the grid of holes of depth that was aligned to a finer image is filled (depth_image.h). */
class DepthSequence {
public:
  /** \brief Lists the frames; reads no image. Throws IoError if there is nothing to read, or if nothing says
   * which camera took PNG images. */
  static DepthSequence open(const std::filesystem::path& path, const RecordingHints& hints = {});

  /** \brief The true poses alone, at the times of the images: of a recording, whose camera needs not be
   * known, or of a file as readTrajectory() reads it. Throws IoError. */
  static Trajectory readTruth(const std::filesystem::path& path, double time_offset = 0);

  const std::vector<FrameFile>& frames() const { return frames_; }
  const std::optional<CameraFile>& camera() const { return camera_; }
  /** \brief The poses that came with the recording, at the times of its images. Empty if there are none.
   * Throws IoError if there are some that cannot be read. */
  const Trajectory& groundTruth() const;
  /** \brief Poses in a file, or those in a recording of messages or RTAB-Map, as poses of this recording's
   * camera, at the times of
   * its images: with its offset in time, read as RecordingHints::poses_are says, and with the y axis of its
   * camera downwards. Files are of the forms that readTrajectory() knows, and may have no stamps if it is
   * known which pose is whose: they are as many as images, in their order. Throws IoError. \param remark
   * receives remarks for the user, a sentence without full stop, or nothing */
  Trajectory readPoses(const std::filesystem::path& path, std::string* remark = nullptr) const;
  /** \brief The same of an odometry, whose poses are as they are written: of the camera, or of its robot.
   * Throws IoError. */
  Trajectory readOdometry(const std::filesystem::path& path, std::string* remark = nullptr) const;
  /** \brief Is it a recording of messages, which may have an odometry and an IMU? */
  static bool isOfMessages(const std::filesystem::path& path);
  /** \brief Gravity at the times of the images, by an IMU in a recording of messages whose axes are known
   * beside the camera's; else empty. Throws IoError. \param std of a direction, unless the camera is
   * accelerated [rad] \param remark receives where it is from, or why it is not used, a sentence without full
   * stop, or nothing */
  GravityRecord gravity(double std, std::string* remark = nullptr) const;
  /** \brief How the recording is laid out, in words. */
  const std::string& layout() const { return layout_; }
  /** \brief Remarks for the user, sentences without full stop. */
  const std::vector<std::string>& remarks() const { return remarks_; }
  /** \brief The remarks with semicolons between them. */
  std::string remark() const;
  /** \brief Are the stamps times, rather than indices? Without times no poses can be matched. */
  bool stamped() const { return stamped_; }
  /** \brief Are they times that the recording gives? A rate that is assumed for numbered images bounds no
   * motion. */
  bool timed() const { return timed_; }

  /** \brief Are its frames files of segments? Then it has no images. */
  bool ofSegments() const { return of_segments_; }
  /** \brief Reads the segments of such a frame. Throws the exceptions of readSegments(), and
   * std::out_of_range. */
  std::vector<Segment> segments(std::size_t index) const;

  /** \brief Reads a frame, subsampled so that at least working_width columns remain (0 = full size).
   * Thread-safe. Throws IoError for unreadable, truncated, unorganized or wrongly sized files
   * and for segments, std::out_of_range for the index. */
  DepthImage load(std::size_t index, int working_width = 0) const;
  /** \brief Of a frame that is stored as a cloud, the pixel of load(index) that each point of the file is at,
   * or one beyond the image; nothing of other frames. Throws the exceptions of load(). */
  std::optional<std::vector<std::uint32_t>> pixelsOfPoints(std::size_t index) const;

private:
  friend class internal::SequenceReader;
  friend class internal::ValueSample;
  DepthSequence() = default;
  Trajectory asOfImages(const Trajectory& poses, const PoseReading& reading) const;
  Trajectory readAs(const std::filesystem::path& path, const PoseReading& reading, std::string* remark) const;
  std::string frameOfPoses(const PoseReading& reading) const;
  std::optional<Intrinsics> knownIntrinsics() const;
  internal::CloudImage loadAsStored(std::size_t index) const;
  DepthImage imageOf(std::size_t index, StoredDepth values) const;
  DepthImage worked(DepthImage as_stored, std::size_t index, int working_width) const;
  bool isStoredAsCloud(std::size_t index) const;

  std::vector<FrameFile> frames_;
  std::shared_ptr<const internal::ImageContainer> container_;  // that all frames are in, if they are
  std::string layout_;
  std::optional<CameraFile> camera_;
  std::shared_ptr<const LensCorrection> lens_;  // null for images of a pinhole camera
  std::shared_ptr<const internal::ImageTimes> times_;
  std::vector<std::string> remarks_;
  double time_offset_ = 0;
  PoseReading poses_are_;
  Trajectory ground_truth_;
  std::exception_ptr ground_truth_fault_;  // why it could not be read, if it could not
  bool timed_ = false;
  bool stamped_ = false;
  bool of_segments_ = false;
};

/** \brief Reads one 16-bit depth PNG as it is stored; value / depth_scale = metres, 0 and 65535 = not
 * measured.
 */
DepthImage readDepthPng(const std::filesystem::path& path, const CameraFile& file);
/** \brief Writes depth as a 16-bit PNG at the given scale; values above 65534 become 0. */
void writeDepthPng(const std::filesystem::path& path, const DepthImage& image, double depth_scale);
/** \brief Reads one organized PCD; intrinsics from the points unless given. Points in other axes are turned
 * to x right, y down, z forward, millimetres become metres, and points on the grid of a lens are sorted into
 * a pinhole grid. Throws IoError for unorganized clouds. */
DepthImage readDepthPcd(const std::filesystem::path& path, const std::optional<Intrinsics>& camera = {});

}  // namespace facetloc
