// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/localization_hints.h"

#include "base/median.h"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>

namespace facetloc {
namespace {

constexpr double kHardlyAny = 0.1;    // share of sure answers
constexpr int kEnoughImages = 5;      // to speak of a share
constexpr std::size_t kModels = 500;  // sampled to learn the typical number of segments

std::vector<double> allOf(const std::vector<ViewTraits>& views, double ViewTraits::*trait) {
  std::vector<double> values;
  for (const ViewTraits& view : views) values.push_back(view.*trait);
  return values;
}

std::vector<ViewTraits> traitsOf(const Map& map) {
  std::vector<ViewTraits> traits;
  const std::size_t step = std::max<std::size_t>(1, map.models.size() / kModels);
  for (std::size_t i = 0; i < map.models.size(); i += step)
    traits.push_back(ViewTraits::of(*map.view(static_cast<int>(i))));
  return traits;
}

/** "its images ..., those of the map ...", and how unlike they are. */
struct Comparison {
  Comparison(const std::vector<ViewTraits>& views, const std::vector<ViewTraits>& models,
             double ViewTraits::*trait)
      : of_images(medianOfKnown(allOf(views, trait))), of_map(medianOfKnown(allOf(models, trait))) {}

  bool isKnown() const { return of_images > 0 && of_map > 0; }
  double ratio() const { return isKnown() ? std::max(of_images / of_map, of_map / of_images) : 1; }
  std::string toString(int decimals, const std::string& unit) const {
    return fmt::format("{0:.{3}f}{2}, the map's images have {1:.{3}f}{2}", of_images, of_map, unit, decimals);
  }

  double of_images, of_map;
};

}  // namespace

ViewTraits ViewTraits::of(const View& view) {
  ViewTraits traits;
  const Intrinsics& k = view.intrinsics;
  if (k.valid()) traits.fov = 2 * std::atan2(k.width / 2.0, k.fx) / kDegree;
  std::vector<double> depths;
  for (const std::uint16_t inverse : view.depth.inverse_depth)
    if (inverse > 0) depths.push_back(1 / (inverse * DepthPicture::kQuantum));
  traits.depth = medianOfKnown(std::move(depths));
  return traits;
}

double medianOfKnown(std::vector<double> values) {
  values.erase(std::remove(values.begin(), values.end(), 0.0), values.end());
  if (values.empty()) return 0;
  return internal::median(values.begin(), values.end());
}

std::vector<std::string> whatToLookAt(const StateCounts& counts, const std::vector<ViewTraits>& views,
                                      const Map& map) {
  constexpr double kOtherOptics = 1.05, kOtherScale = 1.4;  // ratios that are hardly chance
  if (counts.all() < kEnoughImages || counts.sure >= kHardlyAny * counts.all()) return {};
  const std::vector<ViewTraits> models = traitsOf(map);
  const Comparison fov(views, models, &ViewTraits::fov), depth(views, models, &ViewTraits::depth);
  const std::string optics =
      fmt::format("Do fx and fy fit the images? Their field of view is {}.", fov.toString(0, " deg"));
  const std::string scale =
      fmt::format("Does depth_scale fit the images? Their median depth is {}.", depth.toString(2, " m"));
  std::vector<std::string> hints = {"Hardly any image is sure. Check the following:"};
  if (fov.ratio() > kOtherOptics) hints.push_back(optics);
  if (depth.ratio() > kOtherScale) hints.push_back(scale);
  if (map.parts.size() > 1)
    hints.push_back(fmt::format(
        "Do links join the local models of the map? It is in {} parts, and a place that two of them show may "
        "be either.",
        map.parts.size()));
  hints.push_back("Is it the map of this place?");
  hints.push_back("Is the camera turned about its optical axis against the map's, upright or upside down? "
                  "camera.ini tells "
                  "its mounting (mount_roll_deg), and --prior.rotation_std_deg 90 searches all attitudes.");
  if (fov.isKnown() && fov.ratio() <= kOtherOptics) hints.push_back(optics);
  if (depth.isKnown() && depth.ratio() <= kOtherScale) hints.push_back(scale);
  hints.push_back("Does the noise of camera.ini fit the camera, and does the map hold views of the same "
                  "directions? facetloc_segment --overlay and facetloc_render show what is seen.");
  return hints;
}

}  // namespace facetloc
