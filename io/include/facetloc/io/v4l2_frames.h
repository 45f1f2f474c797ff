// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/frame_source.h>

#include <filesystem>
#include <memory>
#include <string>

namespace facetloc {

namespace internal {
class Z16Buffers;
}  // namespace internal

/** \brief Frames of a depth camera whose driver is in the Linux kernel: the video device of its depth stream
 * (Z16), for a RealSense without its SDK, say. Only the kernel's interface is used, Video4Linux2.
 *
 * Such a driver knows neither intrinsics nor scale: the camera is given. The path of a file has the frames of
 * that device one after the other, as `v4l2-ctl --stream-mmap --stream-to=FILE` writes them; they are read by
 * the same code, each when it is asked for, 1/30 s apart. */
class V4l2Frames : public FrameSource {
public:
  /** \param camera with intrinsics, whose size the device is asked for, or with the name of a preset, whose
   * typical ones hold for the size that the device has
   * Throws IoError if there is no such device, or none that sends Z16. */
  V4l2Frames(const std::filesystem::path& device, const CameraFile& camera);
  ~V4l2Frames() override;

  /** \brief Is it such a device, or a file of its frames (*.z16)? */
  static bool reads(const std::filesystem::path& path);

  const std::string& name() const override { return name_; }
  std::shared_ptr<const CameraFile> camera(Patience) override { return camera_; }
  DepthFrame::ConstPtr next(Patience patience) override;
  bool atEnd() const override;
  bool isLive() const override;

private:
  const std::string name_;
  std::unique_ptr<internal::Z16Buffers> buffers_;
  std::shared_ptr<const CameraFile> camera_;
};

}  // namespace facetloc
