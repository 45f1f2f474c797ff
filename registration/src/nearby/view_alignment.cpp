// SPDX-License-Identifier: BSD-3-Clause
#include "nearby/view_alignment.h"

#include "depth/depth_fit.h"
#include "pairs/joint_refinement.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace facetloc::internal {

void LocalMap::add(int index, std::shared_ptr<const View> view, const Eigen::Isometry3d& T_w_c) {
  for (std::size_t i = 0; i < view->segments.size(); ++i) {
    segments.push_back(transformed(view->segments[i], T_w_c));
    origins.push_back({index, static_cast<int>(i)});
  }
  if (!view->depth.empty()) pictures.push_back({&view->depth, T_w_c});
  for (const SidePicture& side : view->sides) {
    const auto isIt = [&](const PosedPicture& known) { return known.picture == side.picture.get(); };
    if (std::none_of(sides.begin(), sides.end(), isIt))
      sides.push_back({side.picture.get(), T_w_c * side.T_v_c});
  }
  views.push_back(std::move(view));
}

std::vector<PosedPicture> LocalMap::picturesNear(const Eigen::Isometry3d& T_w_c) const {
  std::vector<PosedPicture> all = pictures, near;
  all.insert(all.end(), sides.begin(), sides.end());
  std::copy_if(all.begin(), all.end(), std::back_inserter(near), [&](const PosedPicture& p) {
    return std::isfinite(viewDistance(p.T_w_c, T_w_c, kEvidenceReach));
  });
  return near.empty() ? all : near;
}

Matrix6d aboutStart() {
  constexpr double kLooseRotation = 3 * kDegree, kLooseTranslation = 0.1;  // [rad, m]
  Vector6d std;
  std << Eigen::Vector3d::Constant(kLooseRotation), Eigen::Vector3d::Constant(kLooseTranslation);
  return std.cwiseAbs2().asDiagonal();
}

ViewAlignmentParams alignmentWithCovariance(bool as_shown, const MatchingParams& matching) {
  ViewAlignmentParams params;
  params.matching = matching;
  params.as_shown = as_shown;
  params.dense.correlated_pixels = kCorrelatedPixels;
  params.dense.significance = kSignificance;
  return params;
}

ViewAlignment alignView(const View& view, const LocalMap& surroundings, const PoseWithCovariance& prior,
                        const ViewAlignmentParams& params) {
  ViewAlignment out;
  out.T_w_c = prior;
  Hypothesis h;
  h.T_m_c = prior;
  if (refineJointly(view.segments, surroundings.segments, prior, params.matching, {}, h)) {
    out.T_w_c = h.T_m_c;
    out.pairs = std::move(h.pairs);
  }
  Matrix6d information;
  out.dense = refineByDepth(view.depth, surroundings.pictures, params.dense, out.T_w_c, &information);
  if (out.dense) {
    const Matrix6d of_planes = out.T_w_c.P.ldlt().solve(Matrix6d::Identity());
    out.T_w_c.P = symmetricInverse(of_planes + information);
  }
  static const DepthComparison comparison(DepthCalibration{});
  if (params.as_shown && !view.depth.empty()) {
    DepthFit fit(view.depth, surroundings.pictures, comparison);
    for (const SidePicture& side : view.sides)
      fit.add(side, surroundings.picturesNear(out.T_w_c.T * side.T_v_c));
    out.T_w_c = asShown(out.T_w_c, prior, fit, kCoarseColumns);
  }
  return out;
}

DepthAgreement compareWithAll(const DepthPicture& scene, const Eigen::Isometry3d& T_w_c,
                              const std::vector<PosedPicture>& others, const DepthComparison& comparison,
                              int columns) {
  DepthAgreement sum;
  if (scene.empty()) return sum;
  std::vector<DepthComparator> judges;
  for (const PosedPicture& other : others)
    if (!other.picture->empty())
      judges.emplace_back(comparison, scene, *other.picture, other.T_w_c.inverse() * T_w_c);
  const int step = gridStep(scene, columns);
  std::vector<DepthLabels> verdicts(judges.size());  // verdicts of each picture on a row
  for (int v = step / 2; v < scene.camera.height; v += step) {
    for (std::size_t k = 0; k < judges.size(); ++k) judges[k].row(v, step, verdicts[k]);
    for (std::size_t i = 0; !verdicts.empty() && i < verdicts.front().size(); ++i) {
      int agree = 0, contradict = 0, judged = 0;
      for (const DepthLabels& of_picture : verdicts) {
        judged += of_picture[i] != DepthLabel::outside;
        agree += of_picture[i] == DepthLabel::agree;
        contradict += of_picture[i] == DepthLabel::contradict;
      }
      if (judged == 0) continue;
      ++(contradict > agree ? sum.contradict : agree > 0 ? sum.agree : sum.occluded);
    }
  }
  return sum;
}

double viewDistance(const Eigen::Isometry3d& T_w_a, const Eigen::Isometry3d& T_w_b, const ViewReach& reach) {
  constexpr double kMetresPerRadian = 1.5;
  const double distance = (T_w_a.translation() - T_w_b.translation()).norm();
  const Eigen::Vector3d a = T_w_a.linear().col(2), b = T_w_b.linear().col(2);
  const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
  if (!(distance < reach.distance && angle < reach.angle)) return std::numeric_limits<double>::infinity();
  return distance + kMetresPerRadian * angle;
}

}  // namespace facetloc::internal
