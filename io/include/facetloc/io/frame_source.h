// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/depth_image.h>
#include <facetloc/features/gravity.h>
#include <facetloc/features/lens_distortion.h>
#include <facetloc/io/camera_file.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief A depth image as a program or a driver delivers it: 16-bit values, row-major. */
struct DepthFrame {
  using ConstPtr = std::shared_ptr<const DepthFrame>;

  std::uint64_t number = 0;  ///< position in its stream, counted from 1
  double stamp = 0;          ///< [s], of the clock of whoever sends it
  /** Camera of the image as it is stored: size, optics, lens, scale, mounting and noise. Frames share it. */
  std::shared_ptr<const CameraFile> camera;
  std::optional<Gravity> gravity;     ///< if the camera has measured it
  std::vector<std::uint16_t> values;  ///< depth_scale times the depth [m]; 0 and 65535 = not measured
};

/** \brief Frames -> depth images of a pinhole camera, in metres, as DepthSequence reads them: scale, lens
 * and distances along rays are taken out, and the grid of holes of an aligned image is filled. Keeps the
 * tables of a lens while the camera stays the same; one per thread. */
class FrameConverter {
public:
  /** \brief An image that is not of its camera's size is empty. */
  DepthImage operator()(const DepthFrame& frame);
  /** \brief The same for an image in metres, as its camera stores it. */
  DepthImage operator()(DepthImage stored, const std::shared_ptr<const CameraFile>& camera);

private:
  std::shared_ptr<const CameraFile> camera_;  // whose lens it is
  std::optional<LensCorrection> lens_;
};

/** \brief Where frames come from one by one: a pipe (PipeFrames) or a driver (V4l2Frames). To be called on
 * one thread at a time. */
class FrameSource {
public:
  using Patience = std::chrono::milliseconds;

  virtual ~FrameSource() = default;
  /** \brief As messages call it. */
  virtual const std::string& name() const = 0;
  /** \brief The camera of its frames, as soon as that is known; null if that takes longer. No frame is lost.
   * Throws as next(). */
  virtual std::shared_ptr<const CameraFile> camera(Patience patience) = 0;
  /** \brief The next frame; null if none came in that time, and at the end. The part of a frame received by
   * then is kept for the next call. Throws IoError, with the number of the frame, for one that is torn or
   * impossible: no frame can be read after it. */
  virtual DepthFrame::ConstPtr next(Patience patience) = 0;
  /** \brief Has it ended as it should? */
  virtual bool atEnd() const = 0;
  /** \brief Are its frames those of now, so that only the newest one matters? */
  virtual bool isLive() const = 0;
};

}  // namespace facetloc
