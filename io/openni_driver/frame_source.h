// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace facetloc {

/** \brief Depth beyond this is not measured, in the sense of OpenNI2's MAX_VALUE [mm]. */
constexpr int kMaxDepthMillimetres = 20000;

/** \brief The images that a virtual camera sees, in their order. */
class FrameSource {
public:
  virtual ~FrameSource() = default;
  /** \brief Camera of all images. */
  const Intrinsics& camera() const { return camera_; }
  /** \brief On its robot, if that is known. */
  const std::optional<CameraMounting>& mounting() const { return mounting_; }
  /** \brief Images per second, nominal. */
  int rate() const { return rate_; }
  virtual std::size_t size() const = 0;
  /** \brief When an image was taken [us]. */
  virtual std::uint64_t stamp(std::size_t index) const = 0;
  /** \brief Depth in mm, row-major, 0 = not measured, below kMaxDepthMillimetres. Throws IoError. */
  virtual void read(std::size_t index, std::uint16_t* depth) const = 0;

protected:
  Intrinsics camera_;
  std::optional<CameraMounting> mounting_;
  int rate_ = 0;
};

/** \brief May there be images for us: is it a folder or a .scene file? */
bool isFrameSource(const std::string& path);
/** \brief Opens a depth sequence folder or a .scene file. Throws IoError. */
std::unique_ptr<FrameSource> openFrameSource(const std::string& path);

}  // namespace facetloc
