// SPDX-License-Identifier: BSD-3-Clause
// Bytes as poses for a recording without any, as facetloc_check --poses compares them with its images. The
// first byte says how the images are named, and how the poses are to be read.
#include "fuzz_file.h"
#include "tools/image_trajectory.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/mapping/map_making.h>

#include <cmath>
#include <iterator>

namespace {

using namespace facetloc;

/** Images of a wall, named by these names. */
std::filesystem::path putImages(const std::filesystem::path& folder, const std::vector<const char*>& names) {
  std::filesystem::create_directories(folder);
  CameraFile camera;
  camera.camera.intrinsics = {32, 24, 28, 28, 15.5, 11.5};
  camera.camera.mounting = CameraMounting{1.2, 10};
  writeCameraFile(folder / "camera.ini", camera);
  for (const char* name : names)
    writeDepthPng(folder / name, {camera.camera.intrinsics, std::vector<float>(32 * 24, 1.5f)}, 1000);
  return folder;
}

void check(const DepthSequence& sequence, const Trajectory& poses) {
  for (const StampedPose& pose : poses.poses())
    fuzz::require(pose.T_w_c.matrix().allFinite(), "a pose is not finite");
  MapMaking making(sequence.camera()->camera);
  making.setPosesByTime([&poses](double stamp) { return poses.interpolated(stamp); });
  for (std::size_t i = 0; i < sequence.frames().size(); ++i)
    making.add(mapImage(sequence, i, 0, poses.at(sequence.frames()[i].stamp)));
  making.checkPoses();
  making.places();
  for (const Finding& finding : making.findings().list())
    for (const Evidence& evidence : finding.evidence)
      fuzz::require(std::isfinite(evidence.value), "a finding rests on a number that is not finite");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  static const std::filesystem::path recordings[] = {
      putImages(folder.path() / "timed", {"1.00.png", "1.03.png", "1.07.png", "1.10.png"}),
      putImages(folder.path() / "counted", {"depth_0.png", "depth_1.png", "depth_2.png", "depth_3.png"})};
  constexpr const char* kReadings[] = {"auto", "wxyz", "inverse", "base", "opengl", "wxyz,inverse,base"};
  if (size == 0) return 0;
  RecordingHints hints;
  hints.poses_are = kReadings[data[0] / 2 % std::size(kReadings)];
  const auto path = folder.put("poses.csv", fuzz::asText(data + 1, size - 1));
  fuzz::accepts<IoError>([&] {
    const DepthSequence sequence = DepthSequence::open(recordings[data[0] % 2], hints);
    check(sequence, sequence.readPoses(path));
  });
  return 0;
}
