// SPDX-License-Identifier: BSD-3-Clause
#include "facts.h"

#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/testing/synthetic_depth.h>

#include <stdexcept>

namespace facetloc::figures {
namespace {

constexpr int kCameras = 60;

/** The segment of a view that is nearest to a given one. */
const Segment* sameSurface(const View& view, const Segment& segment) {
  const Segment* nearest = nullptr;
  for (const Segment& s : view.segments)
    if (s.normal().dot(segment.normal()) > 0.98 && std::abs(s.offset() - segment.offset()) < 0.1 &&
        (s.t - segment.t).norm() < 0.15 && s.num_points > segment.num_points / 2 &&
        (!nearest || (s.t - segment.t).norm() < (nearest->t - segment.t).norm()))
      nearest = &s;
  return nearest;
}

/** How far a plane lies beyond another one, along the other's x axis at the distances x [m]. */
Json::Value beyond(const Segment& plane, const Segment& other, const Eigen::VectorXd& x) {
  Json::Value out(Json::arrayValue);
  for (const double at : x) {
    const Eigen::Vector3d point = other.t + at * other.R.col(0);
    out.append(rounded((plane.offset() - plane.normal().dot(point)) / plane.normal().dot(other.normal()), 6));
  }
  return out;
}

}  // namespace

Json::Value segmentFacts() {
  const SimulatedWorld room = furnishedRoom(3);
  const Eigen::Isometry3d T = test::lookingAlong({0, 0, 1}, {0.9, 0.5, -0.15});
  const Intrinsics intrinsics = kinectIntrinsics().subsampled(2);
  ViewBuilder builder;
  ViewParams of_paper;
  of_paper.features.paper_uncertainty = true;
  ViewBuilder paper_builder({}, of_paper);
  const DepthImage exact = SimulatedCamera(intrinsics, {}, 1).renderExact(room, T).depth;
  const View truth = builder.build(exact);

  // The surface that most cameras see as one, of those that are not the largest.
  Json::Value best;
  std::size_t most = 0;
  for (std::size_t k = 0; k < truth.segments.size(); ++k) {
    const Segment& segment = truth.segments[k];
    if (segment.num_points < 3000 || segment.num_points > 14000) continue;
    const double reach = 1.2 * std::sqrt(3 * segment.lambda[0]);
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(41, -reach, reach);
    Json::Value planes(Json::arrayValue), out;
    const Segment *shown = nullptr, *by_paper = nullptr;
    View first, first_of_paper;
    DepthImage image;
    for (int i = 1; i <= kCameras; ++i) {
      const DepthImage seen = SimulatedCamera(intrinsics, {}, i).render(room, T, 0).depth;
      const View view = builder.build(seen);
      const Segment* same = sameSurface(view, segment);
      if (!same) continue;
      planes.append(beyond(*same, segment, x));
      if (shown) continue;
      first = view, first_of_paper = paper_builder.build(seen), image = seen;
      shown = sameSurface(first, segment), by_paper = sameSurface(first_of_paper, segment);
    }
    if (planes.size() <= most || !by_paper) continue;
    most = planes.size();
    out["cameras"] = kCameras, out["planes"] = planes, out["x"] = numbers(x);
    out["Sigma_q"] = rows(shown->Sigma_q), out["Sigma_q_paper"] = rows(by_paper->Sigma_q);
    out["lambda"] = numbers(shown->lambda, 6), out["support"] = shown->num_points;
    out["R"] = rows(shown->R), out["t"] = numbers(shown->t), out["offset"] = rounded(shown->offset());
    out["depth"] = smallDepth(image), out["outlines"] = outlines(first);
    out["segment"] = static_cast<int>(shown - first.segments.data());
    Json::Value& axes = out["axes"];  // ends of 0.5 m, and the centroid
    axes.append(numbers(pixelOf(intrinsics, shown->t), 1));
    for (int axis = 0; axis < 3; ++axis)
      axes.append(numbers(pixelOf(intrinsics, shown->t + (axis == 2 ? -0.5 : 0.5) * shown->R.col(axis)), 1));
    Json::Value& ellipse = out["ellipse"];
    for (int i = 0; i < 40; ++i) {
      const double angle = i * 2 * M_PI / 40;
      const Eigen::Vector2d at =
          shown->lambda.cwiseSqrt().cwiseProduct(Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      ellipse.append(numbers(pixelOf(intrinsics, shown->t + shown->R.leftCols<2>() * at), 1));
    }
    best = out;
  }
  if (best.isNull()) throw std::runtime_error("the room has no surface to show");
  return best;
}

}  // namespace facetloc::figures
