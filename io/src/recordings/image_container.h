// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/pose_table.h"

#include <facetloc/features/depth_image.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/gravity_record.h>
#include <facetloc/io/trajectory.h>

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc::internal {

class MessageLog;

/** \brief A pose of a message. Throws IoError. \param columns tx ty tz qx qy qz qw \param name of the file */
StampedPose poseOf(double stamp, const std::array<double, 7>& columns, const std::string& name);

/** \brief The odometry of a recording: nav_msgs/Odometry, or else the poses of the frame odom in tf, or of
 * the only frame that moves above the camera. Throws IoError without one. \param camera_frame the frame of
 * the depth images; where tf has it fixed below the frame that moves, the poses are the camera's, and else
 * those of that frame, as of the robot's base. Empty: they are the latter */
ReadPoses readMessageOdometry(const std::filesystem::path& path, const std::string& camera_frame);

/** \brief Gravity, and a remark on its source: a sentence without full stop, or nothing. */
struct ReadGravity {
  GravityRecord gravity;
  std::string remark{};
};

/** \brief Gravity in the optical frame of the camera at the times of images, by the accelerometer of an IMU
 * (sensor_msgs/Imu) whose orientation is known by tf, or the names of the frames: the mean of its
 * measurements half a second before and after. Where the mean is longer or shorter than gravity, the camera
 * is accelerated: the standard deviation grows by their difference, and beyond a fifth there is no gravity.
 * Empty without an IMU. Throws IoError for corrupt messages. \param std of its direction [rad] */
ReadGravity readImuGravity(const MessageLog& log, const std::string& camera_frame,
                           const std::vector<double>& stamps, double std);

/** \brief A file, or some, that have all depth images of a recording. All calls are thread-safe and throw
 * IoError. */
class ImageContainer {
public:
  virtual ~ImageContainer() = default;

  virtual std::size_t size() const = 0;
  virtual double stamp(std::size_t index) const = 0;                ///< [s]
  virtual std::filesystem::path path(std::size_t index) const = 0;  ///< the file that an image is in
  /** \brief The pose of the camera, if it is stored with the images. */
  virtual std::optional<Eigen::Isometry3d> pose(std::size_t) const { return {}; }
  /** \brief The frame of the images, as tf calls it; or empty. */
  virtual std::string frame() const { return {}; }
  /** \brief Gravity at the times of the images. \param std [rad] */
  virtual ReadGravity gravity(double) const { return {}; }
  /** \brief The camera by its own data. */
  virtual CameraFile camera() const = 0;
  /** \brief An image, with the size that it has and whatever intrinsics. */
  virtual DepthImage read(std::size_t index) const = 0;
  /** \brief A remark for the user, a sentence without full stop; may be empty. */
  virtual std::string remark() const = 0;
};

/** \brief Is it one, by its name or, of a folder, by what is in it? */
bool isContainer(const std::filesystem::path& path);
/** \brief Throws IoError. \param topic of messages: which of their images (openMessageRecording()) */
std::shared_ptr<const ImageContainer> openContainer(const std::filesystem::path& path,
                                                    const std::string& topic);
/** \brief The depth images of a recording of messages: sensor_msgs/Image with 16UC1, mono16 [mm] or 32FC1
 * [m], or CompressedImage of the format compressedDepth, and the CameraInfo that belongs to them, as ROS's
 * drivers and RealSense's own recorder have them.
 * \param topic empty = of several, the one that is called depth and has the most images, and of one that is
 * there plain and compressed, the plain one
 * Throws IoError. */
std::shared_ptr<const ImageContainer> openMessageRecording(const std::filesystem::path& path,
                                                           const std::string& topic);

/** \brief The depth images of a database of RTAB-Map (0.12 or newer), with the poses of its optimised graph,
 * or of its odometry where no graph was saved, and the camera of its first image. Throws IoError, also for
 * stereo images and for several cameras in one image. */
std::shared_ptr<const ImageContainer> openRtabmapDatabase(const std::filesystem::path& path);

/** \brief The poses in such a recording: those of its images, or an odometry (readMessageOdometry()). Throws
 * IoError. \param camera_frame as tf calls it; empty if poses are wanted as they are */
ReadPoses readContainerPoses(const std::filesystem::path& path, const std::string& camera_frame);
/** \brief Endings of the names of such recordings: ".oni, .bag, ...". */
std::string containerEndings();

}  // namespace facetloc::internal
