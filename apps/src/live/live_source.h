// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/finding.h>
#include <facetloc/features/gravity.h>
#include <facetloc/io/camera_file.h>
#include <facetloc/io/frame_grabber.h>
#include <facetloc/io/pipe_frames.h>

#include <pcl/io/grabber.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace facetloc {

class FilePlayer;
class OpenNIGrabber;

/** \brief A frame of a camera, unprocessed: a pointer to the image of the grabber. */
struct LiveFrame {
  double stamp = 0;                   ///< [s] of the source; may start again when a recording is repeated
  std::function<DepthImage()> image;  ///< converts it; to be called on one thread at a time
  std::optional<Gravity> gravity{};   ///< if the camera has measured it
};
using FrameSink = std::function<void(LiveFrame)>;

/** \brief Makes a grabber hand its depth images to a sink, which is called by a thread of the grabber and
 * must not wait. To be called before start(). Throws std::runtime_error for a grabber without depth images.
 * \param camera intrinsics of the full image, which go before those of the frames */
void connectFrames(pcl::Grabber& grabber, const std::optional<Intrinsics>& camera, const FrameSink& sink);

/** \brief The device or recording to play, and how. */
struct LiveSourceOptions {
  std::string device;  ///< as OpenNIGrabber or V4l2Frames, a path that DepthSequence reads, or "-": frames on
                       ///< standard input (PipeFrames)
  /** A file of the device, a map made with it, or a CameraPreset; empty = the camera.ini beside its files. */
  std::string camera;
  std::string topic;         ///< topic of the messages to play; empty = RecordingHints::topic
  bool repeat = false;       ///< files and recordings begin again at their end
  bool every_frame = false;  ///< a file plays its next frame when the one before it has been processed
  double speed = 1;          ///< at which files and recordings play, times real time
};

/** \brief A depth camera, or its substitute: a recording, or a folder of depth images that is played. */
class LiveSource {
public:
  /** \brief Standard input, if it is the device; else null. Throws IoError. */
  static std::shared_ptr<PipeFrames> pipeOf(const LiveSourceOptions& options);

  /** \brief Opens it. Throws IoError if there is no such device or file, or nothing in it.
   * \param pipe for the device "-", with the part of it that is already read (pipeOf()) */
  explicit LiveSource(const LiveSourceOptions& options, std::shared_ptr<PipeFrames> pipe = {});
  /** \brief Stops it. */
  ~LiveSource();

  /** \brief Frames go to the sink from now on; once. */
  void start(const FrameSink& sink);
  /** \brief When it returns, the sink is not called any more. */
  void stop();
  /** \brief With every_frame: the frame before has been processed. No effect otherwise. */
  void next();

  const std::string& name() const { return name_; }
  const std::optional<CameraFile>& camera() const { return camera_; }
  /** \brief Is it played from files, and no camera? */
  bool isFile() const;
  /** \brief Were all files delivered, or did the recording end? Never with repeat. */
  bool atEnd() const;
  /** \brief False when a device has been unplugged. */
  bool connected() const;
  /** \brief Is it another program that sends frames, whose silence is no fault and whose faults stay? */
  bool isPipe() const { return pipe_ != nullptr; }
  /** \brief The driver's message about that, or about an image that it could not read; may be empty. */
  std::string lastError() const;
  /** \brief Findings of how it is read, before any frame: of its files as facetloc_check has them, else of
   * its calibration. */
  Findings findings() const;
  /** \brief The device of OpenNI2; nothing for files that are played without it. */
  const OpenNIGrabber* device() const { return device_; }

private:
  void openDevice(const LiveSourceOptions& options);
  void openFrames(std::shared_ptr<FrameSource> frames);
  void useNoiseOf(const Camera& usual);

  const bool every_frame_;
  std::string name_;
  std::optional<CameraFile> camera_;
  std::optional<CameraFile> lens_camera_;  // its lens corrects frames; served files are corrected already
  std::optional<Intrinsics> calibration_;  // without a camera file
  std::unique_ptr<FilePlayer> player_;
  std::unique_ptr<pcl::Grabber> grabber_;  // null if there is a player
  OpenNIGrabber* device_ = nullptr;        // the same, if it is one
  FrameGrabber* frames_ = nullptr;         // the same, if it is one
  std::shared_ptr<PipeFrames> pipe_;       // its frames come through this pipe
};

}  // namespace facetloc
