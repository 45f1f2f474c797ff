// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>

#include <pcl/io/openni2_grabber.h>

#include <memory>
#include <optional>
#include <string>

namespace facetloc {

/** \brief PCL's grabber for OpenNI2 depth cameras and recordings, made safe to stop, to destroy and to use.
 *
 * The base class waits for ever, or frees a stream twice, when it is stopped or destroyed while frames
 * arrive; an exception of a user's callback ends the process; its frame rate is a colour stream's that
 * need not be there; its frames must not outlive it. Here one thread reads frames, if there are any, and
 * nothing else starts or stops streams meanwhile. All else is as in PCL: register callbacks, such as
 * `void(const pcl::PointCloud<pcl::PointXYZ>::ConstPtr&)`, before start(). They run one at a time on that
 * thread; OpenNI2 keeps only the newest frame meanwhile: take the pointer and return.
 *
 * OpenNI2 is initialized when the first device is opened, with the drivers in OpenNI2/Drivers beside the
 * loaded libOpenNI2.so.0 (io/README.md). It changes the working directory while it does so, for a moment. */
class OpenNIGrabber : public pcl::io::OpenNI2Grabber {
public:
  /** \brief Opens a device.
   * \param device_id "" (the first device), "#1" (by number), a URI, or a path that a driver accepts as a
   * device: an .oni recording, all of which is read first, since OpenNI2 crashes on a corrupt one; with our
   * driver a depth sequence folder or a .scene file.
   * \param depth_mode for recordings the default, which is the recorded one.
   * Throws IoError: no device, a file that no driver understands, a mode that the device does not have, ...
   */
  explicit OpenNIGrabber(const std::string& device_id = "", Mode depth_mode = OpenNI_Default_Mode);
  /** \brief Stops, and waits for a callback that runs. Not to be called by a callback. To construct and
   * destroy grabbers on threads that come and go makes OpenNI2 crash in the end; everything else may be
   * called there. */
  ~OpenNIGrabber() noexcept override;
  OpenNIGrabber(const OpenNIGrabber&) = delete;
  OpenNIGrabber& operator=(const OpenNIGrabber&) = delete;

  /** \brief Starts the streams that the callbacks need, for the first time or again. Throws IoError. */
  void start() override;
  /** \brief When it returns, no callback runs and none will, but the one that called it, if any did. From any
   * thread, any number of times. */
  void stop() override;
  /** \brief Has it been started, and not been stopped, nor the recording ended? */
  bool isRunning() const override;

  /** \brief How a recording is played; by default once, at the speed of its time stamps.
   * \param speed a multiple of that; 0 = as fast as possible, which loses frames.
   * \param repeat start again at the end, with time stamps that go back.
   * No effect on a camera. Throws IoError if the driver refuses. */
  void setPlayback(double speed, bool repeat);
  /** \brief Makes our virtual camera deliver this number of frames, without regard to time, and after that
   * none until it is called again: with one call after each frame received, no frame is lost. Throws IoError
   * if the device is another one. */
  void trigger(int frames);
  /** \brief Is it a recording (or a virtual camera), rather than a camera? */
  bool isFile() const;
  /** \brief Has a recording ended, and the last callback returned? The grabber has stopped then; to play it
   * again, open it again. */
  bool isEndOfFile() const;
  /** \brief False when the device has been unplugged or has reported an error; no frame comes then. */
  bool isConnected() const;
  /** \brief The last fault: an exception of a callback, or the driver's message about its device; empty
   * without a fault. */
  std::string lastError() const;

  /** \brief Frames per second of the depth stream, nominal. */
  float getFramesPerSecond() const override;
  /** \brief Focal length of the depth stream and of the clouds [px]. Their centre is the image's, but
   * for our virtual camera, whose clouds have the camera of the sequence (getDepthCameraIntrinsics). */
  double focalLength() const;
  /** \brief How the camera sits on its robot; only our virtual camera tells. */
  const std::optional<CameraMounting>& mounting() const;
  /** \brief The URI of the device, as OpenNI2 knows it. */
  const std::string& uri() const;

private:
  struct State;

  void startStreams();
  void stopStreams();
  void readFrames();
  bool readFrame();
  void readDepth(openni::VideoStream& stream);

  std::unique_ptr<State> state_;
};

}  // namespace facetloc
