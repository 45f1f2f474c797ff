// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/camera.h>

#include <fmt/format.h>
#include <string>
#include <vector>

namespace facetloc {
namespace {

constexpr double kMuchNoisier = 1.3;  // a Kinect's images have up to 1.2 times its specified noise

}  // namespace

CameraDifference differenceOf(const Camera& of_view, const Camera& of_map, double noise_std) {
  using Mounting = CameraDifference::Mounting;
  CameraDifference d;
  if (of_map.mounting) {
    if (!of_view.mounting)
      d.mounting = Mounting::unknown;
    else
      d.mounting = of_view.mounting->agreesWith(*of_map.mounting) ? Mounting::same : Mounting::other;
  }
  if (of_map.distortion && of_view.intrinsics.valid()) {
    d.same_optics = of_map.distortion->fits(of_view.intrinsics);
    d.distortion_is_left_in = d.same_optics && !of_view.distortion;
  }
  d.noise_ratio = (noise_std > 0 ? noise_std : of_view.noise.ofInverseDepth(DepthNoise::kUsualDepth)) /
                  of_map.noise.ofInverseDepth(DepthNoise::kUsualDepth);
  return d;
}

std::vector<std::string> toString(const CameraDifference& d, const Camera& of_view, const Camera& of_map) {
  using Mounting = CameraDifference::Mounting;
  std::vector<std::string> words;
  if (d.mounting == Mounting::other)
    words.push_back(
        fmt::format("the cameras are mounted differently, {}, and in the map {}: the prior is isotropic, "
                    "about the difference of both mountings",
                    toString(*of_view.mounting), toString(*of_map.mounting)));
  if (d.mounting == Mounting::unknown)
    words.push_back("the mounting of the images' camera is unknown: where they do not show that it is the "
                    "map's, the prior is "
                    "isotropic");
  if (!d.same_optics)
    words.push_back(
        "the images are of other optics than the map's: the distortion that the map knows is left in them");
  if (d.distortion_is_left_in)
    words.push_back("the distortion that the map knows of this camera was not taken out of the images");
  if (d.noise_ratio > kMuchNoisier)
    words.push_back(fmt::format(
        "the images are {:.1f} times as noisy as the map's camera: fewer answers are sure", d.noise_ratio));
  return words;
}

std::string toString(const CameraMounting& mounting) {
  std::string words =
      fmt::format("{:.3f} m above the floor, {:.1f} deg down", mounting.height, mounting.tilt_deg);
  const auto add = [&words](double value, int digits, const char* unit) {
    if (value != 0) words += fmt::format(", {:.{}f}{}", value, digits, unit);
  };
  add(mounting.roll_deg, 1, " deg rolled to the right");
  add(mounting.pan_deg, 1, " deg to the left");
  add(mounting.x, 3, " m ahead of the base");
  add(mounting.y, 3, " m left of it");
  return words;
}

}  // namespace facetloc
