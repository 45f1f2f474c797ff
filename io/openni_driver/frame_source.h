// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
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

/** \brief A .scene file: the camera of a robot that drives through a simulated place.
 *
 *     scene = office    # office, home, hall, or room: one room with random boxes
 *     seed = 1          # as facetloc_simulate: the same place and noise
 *     run = query       # query (later, when things have moved) or map
 *     width = 320       # width of the images [px], 4:3
 *     frames = 1800
 *     jump_at = 900     # the camera is carried away before this image ...
 *     jump = 600        # ... to where it would have been this number of images later
 *
 * and the parameters of facetloc_simulate in the groups drive, pace (rate, speed, turn_rate_deg) and sensor,
 * by their names without the group. All have defaults but scene. One `key = value` per line, # starts a
 * comment. */
struct SceneFile {
  std::string scene;
  std::string run = "query";
  std::uint64_t seed = 1;
  int width = 320;
  int frames = 1800;
  int jump_at = 0;  ///< 0 = never
  int jump = 0;
  DriveParams drive;
  PaceParams pace;
  SimulatedNoise noise;
};

/** \brief Throws IoError with the line for unknown keys and values that are impossible. */
SceneFile readSceneFile(const std::filesystem::path& path);

}  // namespace facetloc
