// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/camera_model.h>
#include <facetloc/features/local_model.h>
#include <facetloc/io/results.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace facetloc {

/** \brief The last sure pose of a run, in a file that outlives it: a line of the stream, written anew each
 * second at most, with the local models around the pose. By these a later run knows the map again, also after
 * it has been extended. */
class RememberedPose {
public:
  RememberedPose(std::filesystem::path file, std::shared_ptr<const Map> map,
                 const std::optional<CameraMounting>& mounting);
  /** \brief Writes the rest, as far as that is possible. */
  ~RememberedPose();
  RememberedPose(const RememberedPose&) = delete;
  RememberedPose& operator=(const RememberedPose&) = delete;

  /** \brief Where the run before was at last, as a line of a robot: {"pose": ...} without a covariance, since
   * the camera may have been moved since; empty if there is no file. Throws IoError for one that holds no
   * pose, or one of another map. */
  std::string start() const;
  /** \brief A frame of the run. Throws IoError if the file cannot be written. */
  void put(const FrameResult& frame);

private:
  void write();

  const std::filesystem::path file_;
  const std::shared_ptr<const Map> map_;
  const std::optional<CameraMounting> mounting_;
  std::optional<FrameResult> unwritten_;
  std::optional<std::chrono::steady_clock::time_point> written_;
};

}  // namespace facetloc
