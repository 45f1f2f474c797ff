// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/io/results.h>

#include <cstddef>
#include <map>
#include <optional>
#include <ostream>
#include <string>

namespace facetloc {

/** \brief The best answer to a frame as one line of JSON, without a line feed (ROBOT.md): stamp, frame,
 * state, probability, model, part, T_w_c and T_w_b as position [m] and quaternion (x y z w), the covariance
 * of T_w_c as 21 numbers (its upper triangle, rotation first), reason, next_look; null for a missing value.
 * \param mounting of the camera on its robot, without which there is no T_w_b */
std::string toJson(const FrameResult& frame, const std::optional<CameraMounting>& mounting);

/** \brief Answers as lines of JSON, in the order of the frames, whatever the order in which they are found.
 * Each line is out when its frame is and those before it are; findings stand between them as they come. */
class PoseStream {
public:
  PoseStream(std::ostream& out, const std::optional<CameraMounting>& mounting)
      : out_(out), mounting_(mounting) {}
  /** \brief Takes the answer to the frame of an index, each once. Thread-safe. */
  void put(std::size_t index, const FrameResult& frame);

private:
  std::ostream& out_;
  std::optional<CameraMounting> mounting_;
  std::size_t next_ = 0;
  std::map<std::size_t, std::string> waiting_;
};

/** \brief --stream. */
void addStreamOption(CommandLine& line, bool& streams);

/** \brief The console of a tool whose standard output is a stream: findings have lines of their own there,
 * all else goes to standard error. */
Console besideStream(const Console& console);

}  // namespace facetloc
