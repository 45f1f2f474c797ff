// SPDX-License-Identifier: BSD-3-Clause
// Bytes as poses, in all forms. Those that are read are found by their stamps,
// and can be written.
#include "fuzz_file.h"
#include "recordings/pose_table.h"

#include <facetloc/io/error.h>
#include <facetloc/io/trajectory.h>

namespace {

using namespace facetloc;

void requireWritable(const Trajectory& poses, const fuzz::Folder& folder) {
  const auto path = folder.path() / "written.txt";
  writeTumTrajectory(path, poses.poses());
  fuzz::require(readTrajectory(path).poses().size() == poses.poses().size(),
                "a trajectory differs from the one written");
}

/** Matches poses with images that are numbered, and with images with times. */
void match(const internal::PoseTable& table) {
  internal::ImageTimes images;
  for (int i = 0; i < 3; ++i) images.numbers.push_back(i), images.stamps.push_back(i / 30.0);
  for (const bool counted : {true, false}) {
    images.unit = {1, counted};
    fuzz::accepts<IoError>([&] {
      const internal::ReadPoses read = internal::matched(table, images, "poses");
      for (const StampedPose& pose : read.poses.poses())
        fuzz::require(pose.T_w_c.matrix().allFinite(), "a pose is not finite");
    });
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  const auto path = folder.put("groundtruth.txt", fuzz::asText(data, size));
  internal::PoseTable table;
  if (!fuzz::accepts<IoError>([&] { table = internal::readPoseTable(path); })) return 0;
  match(table);
  Trajectory read;
  if (!fuzz::accepts<IoError>([&] { read = readTrajectory(path); })) return 0;
  for (const StampedPose& pose : read.poses())
    fuzz::require(read.at(pose.stamp).has_value(), "a pose is not found by its stamp");
  requireWritable(read, folder);
  return 0;
}
