// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recordings/image_list.h"
#include "recordings/pose_table.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/depth_sequence.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/** \file
 * The layouts in which people have recordings, which the names of their files tell from each other, and the
 * camera that took a recording. Private to io. */

namespace facetloc::internal {

/** \brief The content of a recording by the names of its files. */
struct RecordingLayout {
  enum class Kind {
    plain,         ///< TUM's, where names are stamps, or images in the order of their names
    listed,        ///< a list gives the stamps
    seven_scenes,  ///< frame-000000.depth.png, frame-000000.pose.txt
    scannet,       ///< depth/0.png, pose/0.txt
    icl_nuim,      ///< depth/0.png, *.gt.freiburg
  };
  Kind kind = Kind::plain;
  std::vector<FrameFile> frames;  ///< sorted by stamp
  bool stamped = false;           ///< are the stamps times, rather than indices?
  bool assumed = false;           ///< are they those of an assumed rate?
  std::vector<double> numbers;    ///< numbers in the names of the frames, or before these in a list; or empty
  TimeUnit unit;                  ///< unit of the numbers
  RecordedPoses poses;
  std::string remark;  ///< assumptions made, a sentence without full stop, or nothing

  /** \brief "7-Scenes", "images named by their times". */
  std::string toString() const;
  ImageTimes times() const;
};

/** \brief Where images have no stamps by their names, those are in a list beside them, or they are numbered,
 * or else only their order is known. Images without names of their own that are stamps
 * are named by their stamps, with 6 decimals. Images that are numbered take the stamps of poses beside them
 * that are the same numbers, or as many. Throws IoError for a name without a stamp among stamps.
 * \param beside folders to look for lists and poses in \param within those of them that are the
 * recording's own, where poses may have any name */
RecordingLayout layoutOf(const std::vector<ListedImage>& images,
                         const std::vector<std::filesystem::path>& beside,
                         const std::vector<std::filesystem::path>& within);

/** \brief A camera, and how it was found. */
struct RecordedCamera {
  CameraFile file;
  std::string remark{};  ///< where it is from, if not from a camera.ini or the user
};

constexpr double kMillimetres = 1000;  ///< image values per metre

/** \brief A camera with the noise and largest depth of a preset. */
CameraFile cameraFileOf(const Intrinsics& intrinsics, double depth_scale, const CameraPreset& preset);

/** \brief The camera by the files of a recording: camera.ini, else a matrix of intrinsics as 3DMatch
 * and ScanNet have it, the .xml of PCL's recorders, the camera of a phone, or a calibration in YAML or JSON
 * of the size of the images; else, in a public data set's layout, the known camera of that data set. Empty if
 * none of these is there. Throws IoError. \param beside folders to look in; \param within those of them that
 * are the recording's own; \param asked the folder of the recording */
std::optional<RecordedCamera> cameraOf(const RecordingLayout& layout,
                                       const std::vector<std::filesystem::path>& beside,
                                       const std::vector<std::filesystem::path>& within,
                                       const std::filesystem::path& asked);

/** \brief The camera of which a user names the CameraPreset: its noise and largest depth count more than
 * those of the recording, and its intrinsics are a typical device's if the recording has none. Throws
 * IoError. \param recorded by the files of the recording, if they say it */
RecordedCamera withPreset(const std::string& name, const std::optional<RecordedCamera>& recorded,
                          const RecordingLayout& layout);

/** \brief Advice on images with an unknown camera, with the lines of a camera.ini to paste. */
std::string adviceOnCamera(const RecordingLayout& layout, const std::filesystem::path& asked);

/** \brief A calibration of a depth camera. */
struct Calibration {
  Intrinsics intrinsics;  ///< width and height are 0 where the file does not say them
  LensDistortion lens;
  std::optional<double> depth_scale{};  ///< image values per metre
  bool of_scanner = false;              ///< depth images show the same view with other numbers of pixels
};

/** \brief A calibration of ROS (camera_info), OpenCV (FileStorage, as RTAB-Map's), Kalibr (pinhole),
 * ORB-SLAM, Open3D, Replica, NeRF (transforms.json) or scanner apps of phones: matrices or fx, fy, cx, cy,
 * with the distortion of a pinhole camera's lens. Empty if the text has no intrinsics. Of several cameras the
 * first. Throws IoError for a lens of another model. \param source named in errors */
std::optional<Calibration> parseCalibration(std::string_view text, const std::string& source);

/** \brief The lens of the coefficients k1 k2 p1 p2 [k3 [k4 k5 k6]], as ROS and OpenCV have them, by the name
 * of their model: empty, plumb_bob, radtan, rational_polynomial and the like. Throws std::invalid_argument
 * with a sentence for other models, unless all coefficients are zero, and for numbers that are not finite. */
LensDistortion lensOf(const std::string& model, const std::vector<double>& coefficients);

}  // namespace facetloc::internal
