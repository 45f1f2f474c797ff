// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a trajectory. One that is read is found by its stamps, and can be written.
#include "fuzz_file.h"

#include <facetloc/io/error.h>
#include <facetloc/io/trajectory.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto path = folder.put("groundtruth.txt", fuzz::asText(data, size));
  Trajectory read;
  if (!fuzz::accepts<IoError>([&] { read = readTumTrajectory(path); })) return 0;
  for (const StampedPose& pose : read.poses())
    fuzz::require(read.at(pose.stamp).has_value(), "a pose is not found by its stamp");
  writeTumTrajectory(path, read.poses());
  fuzz::require(readTumTrajectory(path).poses().size() == read.poses().size(),
                "a trajectory is not what was written");
  return 0;
}
