// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/segment_scene.h"

#include "drawing/plan_view.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>

#include <algorithm>
#include <cmath>

namespace facetloc {
namespace {

constexpr double kViewAngle = 35 * kDegree;  // vertical field of view of the eye

vtkNew<vtkCellArray> oneCell(std::size_t points, bool closed) {
  vtkNew<vtkCellArray> cells;
  const auto n = static_cast<vtkIdType>(points);
  cells->InsertNextCell(static_cast<int>(n + closed));
  for (vtkIdType i = 0; i < n + closed; ++i) cells->InsertCellPoint(i % n);
  return cells;
}

/** Corners in a scene, still without cells. */
struct Drawn {
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPolyDataMapper> mapper;
  vtkNew<vtkActor> actor;

  Drawn(const std::vector<Eigen::Vector3d>& corners, const Colour& colour, vtkRenderer* renderer) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    for (const Eigen::Vector3d& p : corners) points->InsertNextPoint(p.data());
    data->SetPoints(points);
    mapper->SetInputData(data);
    mapper->SetResolveCoincidentTopologyToPolygonOffset();
    actor->SetMapper(mapper);
    actor->GetProperty()->SetColor(colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0);
    renderer->AddActor(actor);
  }
};

/** Smallest distance of the eye from the origin of rotated content, z away from the eye, that shows all of
 * it. \param tangent of half the angle of view. */
double fittingDistance(const std::vector<Eigen::Vector3d>& seen, const Eigen::Vector2d& centre,
                       const Eigen::Vector2d& tangent) {
  double distance = -1e9;
  for (const Eigen::Vector3d& p : seen) {
    const Eigen::Vector2d needed = (p.head<2>() - centre).cwiseAbs().cwiseQuotient(tangent);
    distance = std::max(distance, needed.maxCoeff() - p.z());
  }
  return distance;
}

/** Where the eye has to be aside of the origin so that content is in the middle of the picture. */
Eigen::Vector2d centring(const std::vector<Eigen::Vector3d>& seen, Eigen::Vector2d centre,
                         const Eigen::Vector2d& tangent) {
  constexpr int kRounds = 10;
  for (int i = 0; i < kRounds; ++i) {
    const double distance = fittingDistance(seen, centre, tangent);
    Eigen::AlignedBox2d picture;  // at depth 1
    for (const Eigen::Vector3d& p : seen)
      picture.extend(Eigen::Vector2d((p.head<2>() - centre) / (p.z() + distance)));
    centre += picture.center() * distance;
  }
  return centre;
}

}  // namespace

void SegmentScene::add(const Segment& segment, const Eigen::Isometry3d& T, const SegmentLook& look) {
  if (segment.hull.size < 3) return;
  const Polygon corners = cornersOf(segment, T);
  content_.insert(content_.end(), corners.begin(), corners.end());
  if (look.fill) addFill(corners, *look.fill);
  addLine(corners, true, look.outline, look.outline_width);
}

void SegmentScene::addCamera(const Intrinsics& camera, const Eigen::Isometry3d& T, double size,
                             const Colour& colour, double width) {
  Polygon base = frustum(camera, size);
  for (Eigen::Vector3d& corner : base) corner = T * corner;
  addLine(base, true, colour, width);
  for (const Eigen::Vector3d& corner : base) addLine({T.translation(), corner}, false, colour, width);
  content_.push_back(T.translation());
}

void SegmentScene::addFill(const Polygon& corners, const Colour& colour) {
  const Drawn fill(corners, colour, renderer_);
  fill.data->SetPolys(oneCell(corners.size(), false));
  fill.actor->GetProperty()->SetAmbient(0.55);
  fill.actor->GetProperty()->SetDiffuse(0.45);
  fill.actor->GetProperty()->SetInterpolationToFlat();
  // Behind the lines of the same plane.
  fill.mapper->SetRelativeCoincidentTopologyPolygonOffsetParameters(1, 1);
}

void SegmentScene::addLine(const Polygon& points, bool closed, const Colour& colour, double width) {
  const Drawn line(points, colour, renderer_);
  line.data->SetLines(oneCell(points.size(), closed));
  line.actor->GetProperty()->SetLineWidth(static_cast<float>(width));
  // The thicker one of lines in the same place is in front.
  line.mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0, -2 * width);
  line.actor->GetProperty()->SetLighting(false);
}

void SegmentScene::lookAlong(const Eigen::Vector3d& direction, const Eigen::Vector3d& up) {
  constexpr double kBorder = 0.96;  // share of the picture that is used
  if (content_.empty()) return;
  Eigen::Matrix3d R;  // rows: the eye's axes, right, up, away
  R.row(2) = direction.normalized();
  R.row(0) = direction.cross(up).normalized();
  R.row(1) = R.row(0).cross(R.row(2));
  std::vector<Eigen::Vector3d> seen;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : content_) seen.push_back(R * p), middle += seen.back();
  middle /= static_cast<double>(seen.size());
  for (Eigen::Vector3d& p : seen) p -= middle;

  const double aspect = renderer_->GetTiledAspectRatio();
  const Eigen::Vector2d tangent = kBorder * std::tan(kViewAngle / 2) * Eigen::Vector2d(aspect, 1);
  const Eigen::Vector2d centre = centring(seen, Eigen::Vector2d::Zero(), tangent);
  const double distance = fittingDistance(seen, centre, tangent);
  const Eigen::Vector3d eye = R.transpose() * (middle + Eigen::Vector3d(centre.x(), centre.y(), -distance));
  const Eigen::Vector3d focus = eye + R.row(2).transpose();

  vtkCamera* camera = renderer_->GetActiveCamera();
  camera->SetPosition(eye.x(), eye.y(), eye.z());
  camera->SetFocalPoint(focus.x(), focus.y(), focus.z());
  camera->SetViewUp(up.x(), up.y(), up.z());
  camera->SetViewAngle(kViewAngle / kDegree);
  renderer_->ResetCameraClippingRange();
}

std::vector<Eigen::Vector3d> frustum(const Intrinsics& camera, double depth) {
  std::vector<Eigen::Vector3d> corners;
  for (const auto& [u, v] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)})
    corners.push_back(depth * camera.ray(u * camera.width, v * camera.height));
  return corners;
}

Eigen::Vector3d fromBehindAndAbove(const Eigen::Vector3d& up) {
  constexpr double kElevation = 32 * kDegree, kAside = 18 * kDegree;
  Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ() - up.z() * up;
  if (ahead.norm() < 1e-3) ahead = Eigen::Vector3d::UnitY() - up.y() * up;  // it looks straight down
  const Eigen::Vector3d level = Eigen::AngleAxisd(kAside, up) * ahead.normalized();
  return std::cos(kElevation) * level - std::sin(kElevation) * up;
}

}  // namespace facetloc
