// SPDX-License-Identifier: BSD-3-Clause
#include "depth/depth_consistency.h"
#include "depth/depth_fit.h"
#include "facts.h"
#include "motion/camera_motion.h"

#include <facetloc/testing/synthetic_views.h>

#include <memory>

namespace facetloc::figures {
namespace {

using namespace internal;

/** Labels of all pixels of the fine grid, row by row: "a", "c", "o", or "." where nothing is compared. */
Json::Value labelRows(const DepthComparator& comparator, const DepthPicture& a) {
  constexpr const char kLetters[] = ".aco";
  Json::Value lines(Json::arrayValue);
  const int step = gridStep(a, kFineColumns);
  for (int v = step / 2; v < a.camera.height; v += step) {
    std::string line;
    for (int u = step / 2; u < a.camera.width; u += step)
      line += kLetters[static_cast<int>(comparator(u, v))];
    lines.append(line);
  }
  return lines;
}

/** The surface that a picture shows at the height of its level camera, seen from above: x, y and the pixel.
 */
Json::Value slice(const DepthPicture& picture, const Eigen::Isometry3d& T_w_c,
                  const DepthComparator* comparator) {
  constexpr const char* kLetters[] = {".", "a", "c", "o"};
  Json::Value points(Json::arrayValue);
  const int v = static_cast<int>(std::lround(picture.camera.cy));
  for (int u = 2; u < picture.camera.width; u += comparator ? 3 : 1) {
    const double inverse = picture.inverse_depth[static_cast<std::size_t>(v * picture.camera.width + u)] *
                           DepthPicture::kQuantum;
    if (inverse <= 0) continue;
    const Eigen::Vector3d p = T_w_c * (picture.camera.ray(u, v) / inverse);
    Json::Value point = numbers(Eigen::Vector2d(p.head<2>()), 3);
    if (comparator) point.append(kLetters[static_cast<int>((*comparator)(u, v))]);
    points.append(point);
  }
  return points;
}

Json::Value judged(const View& a, const View& b, const Eigen::Isometry3d& T_w_a,
                   const Eigen::Isometry3d& T_w_b) {
  const DepthComparison comparison{DepthCalibration{}};
  const Eigen::Isometry3d T_b_a = T_w_b.inverse() * T_w_a;
  const DepthComparator comparator(comparison, a.depth, b.depth, T_b_a);
  const DepthAgreement sum = comparison.count(a.depth, b.depth, T_b_a, kFineColumns);
  Json::Value out;
  out["rows"] = labelRows(comparator, a.depth);
  out["slice"] = slice(a.depth, T_w_a, &comparator);
  out["camera"] = numbers(Eigen::Vector2d(T_w_a.translation().head<2>()), 3);
  out["axis"] = numbers(Eigen::Vector2d(T_w_a.linear().col(2).head<2>()), 3);
  out["agree"] = sum.agree, out["contradict"] = sum.contradict, out["occluded"] = sum.occluded;
  return out;
}

Json::Value alongAxis(bool niches) {
  constexpr double kMoved = 0.8, kSeconds = 2;
  const auto at = [&](double y, unsigned seed) {
    return std::make_shared<const View>(test::viewFrom(
        niches ? test::corridorWithNiches() : test::endlessCorridor(), test::alongCorridor(y), seed, 6));
  };
  const auto before = at(0, 1), now = at(kMoved, 2);
  const DepthComparison comparison{DepthCalibration{}};
  const DepthFit fit(now->depth, {PosedPicture{&before->depth, test::alongCorridor(0)}}, comparison);
  Json::Value out;
  out["truth"] = kMoved;
  for (int i = -75; i <= 75; ++i) {
    Json::Value point(Json::arrayValue);
    const auto value = fit(test::alongCorridor(0.04 * i), kFineColumns);
    if (!value) continue;
    point.append(rounded(0.04 * i, 2)), point.append(rounded(*value, 2));
    out["curve"].append(point);
  }
  CameraMotion motion{ViewOdometryParams{}};
  motion.next(before, 0);
  for (const MotionMode& mode : motion.next(now, kSeconds).modes) {
    Json::Value one;
    const Eigen::Isometry3d T_w_c = test::alongCorridor(0) * mode.T_a_b.T;
    const Eigen::Vector3d along = test::alongCorridor(0).linear().transpose() * Eigen::Vector3d::UnitY();
    one["y"] = rounded(T_w_c.translation().y(), 2), one["probability"] = rounded(mode.probability, 3);
    one["std"] = rounded(std::sqrt(along.dot(mode.T_a_b.P.bottomRightCorner<3, 3>() * along)), 3);
    out["modes"].append(one);
  }
  return out;
}

}  // namespace

Json::Value verdictFacts() {
  const test::Scene mapped = test::largeRoom(), later = mapped + test::box({3.4, 2.1, 0}, {3.9, 2.6, 1.2});
  const Eigen::Isometry3d T_w_b = test::lookingAlong({1.0, 2.3, 0.7}, {1, 0.25, 0}),
                          T_w_a = test::lookingAlong({1.7, 1.6, 0.7}, {1, 0.55, 0});
  Eigen::Isometry3d wrong = T_w_a;
  wrong.translation() += Eigen::Vector3d(0.45, -0.1, 0);
  const View b = test::viewFrom(mapped, T_w_b, 1), a = test::viewFrom(later, T_w_a, 2);
  Json::Value out;
  out["surface"] = slice(b.depth, T_w_b, nullptr);
  out["camera"] = numbers(Eigen::Vector2d(T_w_b.translation().head<2>()), 3);
  out["right"] = judged(a, b, T_w_a, T_w_b), out["wrong"] = judged(a, b, wrong, T_w_b);
  return out;
}

Json::Value directionFacts() {
  Json::Value out;
  out["doors"] = alongAxis(true), out["bare"] = alongAxis(false);
  return out;
}

}  // namespace facetloc::figures
