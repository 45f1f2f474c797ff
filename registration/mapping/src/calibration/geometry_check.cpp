// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/flat_surfaces.h"

#include <facetloc/mapping/map_findings.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>

namespace facetloc {

using namespace internal;
namespace {

constexpr std::size_t kLeastSurfaces = 10;
constexpr double kCertain = 5;           // standard deviations
constexpr double kLeastExponent = 0.35;  // least exponent of rays; real cameras and clutter stay below 0.13
constexpr double kFlatter = 1.3;         // surfaces that are larger by as much tell one reading from another
constexpr double kHardlyFlat = 0.03;     // share of the image
constexpr double kLeastDisplacement = 0.015, kLeastGain = 1.08;  // least effects of a lens, in the corner

bool isCertain(double value, double std) { return std::abs(value) > kCertain * std; }

/** Square of the longest ray's part across the optical axis. */
double widestRay(const Intrinsics& k) {
  double widest = 0;
  for (const double u : {0.0, k.width - 1.0})
    for (const double v : {0.0, k.height - 1.0})
      widest = std::max(widest, k.ray(u, v).head<2>().squaredNorm());
  return widest;
}

/** Adds the fault if depths are distances along the rays, or are taken for such. \return the surfaces as
 * they are to be read. */
FlatSurfaces checkRays(const std::vector<DepthImage>& images, const Camera& camera, GeometryCheck& check) {
  FlatSurfaces as_read = flatSurfaces(images, camera, DepthIs::z);
  check.surfaces = as_read.surfaces.size();
  check.bend = bendOf(as_read);
  const SurfaceBend& bend = check.bend;
  if (check.surfaces < kLeastSurfaces || !(std::abs(bend.ray_exponent) > kLeastExponent) ||
      !isCertain(bend.ray_exponent, bend.ray_exponent_std))
    return as_read;
  const bool are_distances = bend.ray_exponent > 0;
  FlatSurfaces otherwise = flatSurfaces(images, camera, are_distances ? DepthIs::distance : DepthIs::product);
  if (!(otherwise.flat_share > kFlatter * as_read.flat_share)) return as_read;
  const char* const reading =
      are_distances ? "flat surfaces are bent like bowls: depths are distances along the rays, not z; "
                      "depth_is = distance in camera.ini reads them"
                    : "flat surfaces bulge, as if z were read as distances along the rays: depth_is = z in "
                      "camera.ini reads them";
  const std::string words = fmt::format("{} (so read, flat surfaces are {:.1f} times as large)", reading,
                                        otherwise.flat_share / as_read.flat_share);
  const Evidence exponent{"ray_exponent", bend.ray_exponent, bend.ray_exponent_std};
  check.findings.push_back({"geometry.rays", Severity::refusal, words, "", {exponent}});
  return otherwise;
}

/** Images of disparities, as stereo and learned depth have them. */
bool checkInverse(const std::vector<DepthImage>& images, const Camera& camera, const FlatSurfaces& as_read,
                  GeometryCheck& check) {
  constexpr double kMuchFlatter = 1.6;  // frontal surfaces are flat in both; 1.4 of a much distorted camera
  const FlatSurfaces inverse = flatSurfaces(images, camera, DepthIs::inverse);
  if (inverse.surfaces.size() < kLeastSurfaces ||
      !(inverse.flat_share > kMuchFlatter * std::max(as_read.flat_share, kHardlyFlat)))
    return false;
  const std::string words = fmt::format(
      "flat surfaces are bent, and are {:.1f} times as large if the numbers are inverse depths: they "
      "seem to be disparities, of which depths are to be made first",
      inverse.flat_share / as_read.flat_share);
  const Evidence share{"flat_share", as_read.flat_share},
      by_inverse{"flat_share_inverse", inverse.flat_share};
  check.findings.push_back({"geometry.inverse", Severity::refusal, words, "", {share, by_inverse}});
  return true;
}

void checkLens(const FlatSurfaces& flat, const Intrinsics& k, GeometryCheck& check) {
  const SurfaceBend bend = bendOf(flat);
  const double displacement = std::abs(bend.lens) * widestRay(k);
  if (flat.surfaces.size() < kLeastSurfaces || !isCertain(bend.lens, bend.lens_std) ||
      displacement < kLeastDisplacement || bend.residual_ratio < kLeastGain)
    return;
  const std::string words =
      fmt::format("flat surfaces are bent as behind a lens: in the corners of the image by {:.0f} % of the "
                  "distance from the centre; the camera's calibration in camera.ini takes it out (k1 is "
                  "about {:.2f})",
                  100 * displacement, bend.lens);
  check.findings.push_back({"geometry.lens", Severity::doubt, words, "", {{"k1", bend.lens, bend.lens_std}}});
}

/** "fx=525 fy=525 cx=319.5 cy=239.5", or factors where the images say their intrinsics. */
std::string linesFor(const SurfaceAngles& found, const Intrinsics& worked_on, const Intrinsics& full) {
  if (!full.valid()) return fmt::format("{:.2f} times fx and {:.2f} times fy", found.fx, found.fy);
  const double step = static_cast<double>(full.width) / worked_on.width;
  return fmt::format("about fx={:.4g} fy={:.4g} cx={:.4g} cy={:.4g}", found.fx * full.fx, found.fy * full.fy,
                     full.cx + step * found.cx, full.cy + step * found.cy);
}

/** A doubt at most: the same surfaces in all images are few witnesses. MapFindings::list() asks the poses. */
void checkAngles(const FlatSurfaces& flat, const Intrinsics& worked_on, const Camera& camera,
                 GeometryCheck& check) {
  check.angles = surfaceAngles(flat, worked_on);
  if (!check.angles || !check.angles->contradicts()) return;
  const SurfaceAngles& a = *check.angles;
  const std::string words = fmt::format(
      "the angles between the same surfaces differ from image to image: the {} pairs in {} images "
      "agree better with {}",
      a.pairs, a.images, linesFor(a, worked_on, camera.intrinsics));
  const std::vector<Evidence> evidence = {{"gain_nats", a.gain, a.gain_std},
                                          {"images", static_cast<double>(a.images)},
                                          {"fx_factor", a.fx},
                                          {"fy_factor", a.fy}};
  check.findings.push_back(
      {"geometry.angles", Severity::doubt, words, "look at fx, fy, cx and cy of camera.ini", evidence});
}

void checkPixels(const Intrinsics& k, GeometryCheck& check) {
  constexpr double kMostOblong = 1.08;  // pixels are square; calibrations err by a few per cent
  const double oblong = std::max(k.fx / k.fy, k.fy / k.fx);
  if (oblong < kMostOblong) return;
  const std::string words = fmt::format(
      "fx and fy differ by a factor of {:.2f}, though the pixels of depth cameras are square: look at "
      "fx and fy of camera.ini",
      oblong);
  check.findings.push_back({"geometry.pixels", Severity::doubt, words, "", {{"fx_by_fy", k.fx / k.fy}}});
}

}  // namespace

bool SurfaceAngles::contradicts() const {
  constexpr double kOdds = 20, kTwice = 2;  // standard deviations
  return gain > std::log(kOdds) && gain > kTwice * gain_std;
}

GeometryCheck checkGeometry(const std::vector<DepthImage>& images, const Camera& camera) {
  GeometryCheck check;
  check.images = images.size();
  if (images.empty()) return check;
  const FlatSurfaces flat = checkRays(images, camera, check);
  if (check.findings.empty() && checkInverse(images, camera, flat, check)) return check;
  const Intrinsics& worked_on = images.front().camera;
  checkLens(flat, worked_on, check);
  checkAngles(flat, worked_on, camera, check);
  checkPixels(worked_on, check);
  return check;
}

}  // namespace facetloc
