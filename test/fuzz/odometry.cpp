// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a line of wheel odometry, for a camera in the hand and on a robot, and as a starting pose.
#include "fuzz_file.h"
#include "inputs/localization_options.h"
#include "live/odometry_input.h"

#include <stdexcept>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  const std::string text(fuzz::asText(data, size));
  const std::optional<CameraMounting> hand, robot = CameraMounting{1.2, 10};
  for (const auto& mounting : {hand, robot}) {
    fuzz::accepts<std::invalid_argument>([&] {
      fuzz::require(parseOdometry(text, mounting).T_o_c.matrix().allFinite(), "a pose is not finite");
    });
    fuzz::accepts<UsageError>([&] {
      const auto start = startPose(text, mounting);
      fuzz::require(!start || start->P.allFinite(), "a covariance is not finite");
    });
  }
  return 0;
}
