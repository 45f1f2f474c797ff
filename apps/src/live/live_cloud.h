// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drawing/plan_view.h"
#include "drawing/segment_scene.h"
#include "drawing/vtk_shapes.h"
#include "live/live_look.h"
#include "live/live_result.h"

#include <facetloc/features/local_model.h>

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <vector>

namespace facetloc {

/** \brief The colours of the segments of a view, stable from frame to frame: the colour of the
 * matched segment of the local model; without a pose, one by the direction of the normal. */
struct LiveColours {
  std::vector<Colour> of_view;                  ///< indexed by segment
  std::vector<std::optional<Colour>> of_model;  ///< indexed by segment; empty = not matched
  std::size_t matched = 0;                      ///< segments of the view

  LiveColours(const LiveResult& result, const Map* map) {
    constexpr Colour kNoMatch = {160, 160, 160};  // mixed into segments without a match in the local model
    const View& seen = result.image.view;
    const Hypothesis* match = map ? result.match() : nullptr;
    const Eigen::Vector3d up = upInView(seen, map ? map->camera.mounting : std::optional<CameraMounting>());
    for (const Segment& segment : seen.segments)
      of_view.push_back(mixed(directionColour(segment.normal(), up), kNoMatch, match ? 0.5 : 0));
    if (!match) return;
    const std::shared_ptr<const View> model = map->view(match->model);
    of_model.resize(model->segments.size());
    for (const SegmentPair& pair : matchedSegments(seen, *model, match->T_m_c.T)) {
      const Colour colour = segmentColour(static_cast<std::size_t>(pair.model));
      of_view[pair.scene] = colour;
      of_model[pair.model] = colour;
      ++matched;
    }
  }
};

/** \brief The cloud in its colours, segment frames, and the segments of the local model, all in the frame of
 * the camera and seen from behind it. */
class LiveCloud {
public:
  LiveCloud() : model_(3), unmatched_model_(1), frames_(1.8), outlines_(1.5) {
    ground_->SetBackground(1, 1, 1);
    overlay_->SetActiveCamera(ground_->GetActiveCamera());
    overlay_->SetLayer(1);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(cloud_);
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    actor->GetProperty()->SetPointSize(4);
    actor->GetProperty()->SetLighting(false);
    ground_->AddActor(actor);
    for (Shapes* shapes : {&unmatched_model_, &model_, &outlines_}) ground_->AddActor(shapes->actor());
    overlay_->AddActor(frames_.actor());
  }

  /** \brief The cloud, and an overlay always in front of it. Both share their camera. */
  vtkRenderer* ground() { return ground_; }
  vtkRenderer* overlay() { return overlay_; }

  /** \param pixel of the window, from its lower left corner, whose segment is outlined in black
   * \return that segment of the view, if there is one */
  std::optional<std::size_t> show(const LiveResult& result, const LiveColours& colours, const Map* map,
                                  const PanelLook& look, const std::optional<Eigen::Vector2d>& pixel) {
    showPoints(result.image, colours);
    const auto& segments = result.image.view.segments;
    for (std::size_t k = 0; k < segments.size(); ++k)
      outlines_.line(cornersOf(segments[k], Eigen::Isometry3d::Identity()),
                     mixed(colours.of_view[k], kBlack, 0.25), true);
    const double reach = reachOf(result.image.depth);
    addFrames({segments.begin(), segments.begin() + std::min(segments.size(), kMostFrames)}, kAxis * reach);
    if (const Hypothesis* match = map ? result.match() : nullptr) {
      const Eigen::Isometry3d T_c_m = match->T_m_c.T.inverse();
      const std::shared_ptr<const View> view = map->view(match->model);
      const std::vector<Segment>& model = view->segments;
      for (std::size_t k = 0; k < model.size(); ++k) {
        const auto& colour = colours.of_model[k];
        Shapes& shapes = colour ? model_ : unmatched_model_;
        shapes.line(cornersOf(model[k], T_c_m), colour ? mixed(*colour, kBlack, 0.35) : kModelOnly, true);
      }
    }
    constexpr double kPyramid = 0.1;  // size of the camera itself, as a share of the reach
    const Shapes::Points base = frustum(result.image.depth.camera, kPyramid * reach);
    for (const Eigen::Vector3d& corner : base) frames_.line({Eigen::Vector3d::Zero(), corner}, kBlack);
    frames_.line(base, kBlack, true);
    lookFromBehind(map ? map->camera.mounting : std::nullopt, frustum(result.image.depth.camera, reach));
    look.applyTo(ground_->GetActiveCamera());
    const auto picked = pixel ? segmentAt(result.image.view, *pixel) : std::nullopt;
    if (picked) frames_.line(cornersOf(segments[*picked], Eigen::Isometry3d::Identity()), kBlack, true);
    for (Shapes* shapes : {&model_, &unmatched_model_, &outlines_, &frames_}) shapes->show();
    ground_->ResetCameraClippingRange();
    return picked;
  }

  /** \brief How many times larger than they are the ellipses are drawn. */
  double magnification() const { return magnification_; }

private:
  static constexpr Colour kNoSegment = {205, 205, 205};  // points that belong to none
  static constexpr Colour kModelOnly = {120, 120, 120};  // segments that the view does not match
  static constexpr std::size_t kMostFrames = 6;          // segment frames drawn, the most useful first
  static constexpr double kAxis = 0.06;                  // length of an axis, as a share of the reach

  /** Depth up to which nearly all pixels are, in steps of a half, so that the view keeps still [m]. */
  static double reachOf(const DepthImage& image) {
    constexpr double kNearlyAll = 0.98;
    std::vector<float> depths;
    std::copy_if(image.depth.begin(), image.depth.end(), std::back_inserter(depths), isMeasured);
    if (depths.empty()) return 1;
    const auto last = depths.begin() + static_cast<std::ptrdiff_t>(kNearlyAll * (depths.size() - 1));
    std::nth_element(depths.begin(), last, depths.end());
    return std::exp2(std::ceil(2 * std::log2(*last)) / 2);
  }

  /** The segment of a view that a ray through a pixel meets first. */
  std::optional<std::size_t> segmentAt(const View& view, const Eigen::Vector2d& pixel) {
    const auto pointAt = [&](double depth) {
      ground_->SetDisplayPoint(pixel.x(), pixel.y(), depth);
      ground_->DisplayToWorld();
      const double* p = ground_->GetWorldPoint();
      return Eigen::Vector3d(p[0] / p[3], p[1] / p[3], p[2] / p[3]);
    };
    const Eigen::Vector3d eye = pointAt(0), ray = pointAt(1) - eye;
    std::optional<std::size_t> found;
    double nearest = 1;
    for (std::size_t k = 0; k < view.segments.size(); ++k) {
      const Segment& s = view.segments[k];
      const double share = s.normal().dot(s.t - eye) / s.normal().dot(ray);
      const Eigen::Vector3d in_plane = s.R.transpose() * (eye + share * ray - s.t);
      if (!(share > 0) || share >= nearest || !s.hull.contains(in_plane.head<2>().cast<float>())) continue;
      nearest = share;
      found = k;
    }
    return found;
  }

  void showPoints(const SeenImage& image, const LiveColours& colours) {
    const Intrinsics& camera = image.depth.camera;
    vtkNew<vtkFloatArray> xyz;
    vtkNew<vtkUnsignedCharArray> rgb;
    xyz->SetNumberOfComponents(3);
    rgb->SetNumberOfComponents(3);
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u) {
        const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
        const float z = image.depth.depth[i];
        if (!isMeasured(z)) continue;
        const Eigen::Vector3d p = z * camera.ray(u, v);
        xyz->InsertNextTuple3(p.x(), p.y(), p.z());
        const std::size_t label = image.labels.label[i];
        const Colour c =
            label > 0 && label <= colours.of_view.size() ? colours.of_view[label - 1] : kNoSegment;
        const Colour pale = label > 0 ? mixed(c, kWhite, 0.3) : c;  // so that lines stand out
        rgb->InsertNextTuple3(pale.red, pale.green, pale.blue);
      }
    vtkNew<vtkPoints> points;
    points->SetData(xyz);
    vtkNew<vtkCellArray> cells;
    cells->InsertNextCell(static_cast<int>(points->GetNumberOfPoints()));
    for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) cells->InsertCellPoint(i);
    cloud_->Initialize();
    cloud_->SetPoints(points);
    cloud_->SetVerts(cells);
    cloud_->GetPointData()->SetScalars(rgb);
  }

  /** Axes x red, y green, and the normal blue, around whose tip the true one lies, so magnified that half of
   * the ellipses are at least a fifth to half of an axis wide. Eq. (2). \param length of an axis [m] */
  void addFrames(const std::vector<Segment>& segments, double length) {
    constexpr Colour kX = {200, 30, 30}, kY = {20, 140, 20}, kNormal = {20, 40, 200};
    constexpr double kHalf = 0.4, kMost = 1.5;  // radii of ellipses, in axes
    std::vector<Eigen::Matrix2d> roots;         // two standard deviations of the normals
    std::vector<double> radii;
    for (const Segment& segment : segments) {
      roots.push_back(2 * Eigen::Matrix2d(segment.Sigma_q.topLeftCorner<2, 2>().llt().matrixL()));
      radii.push_back(roots.back().norm());
    }
    if (radii.empty()) return;
    std::nth_element(radii.begin(), radii.begin() + radii.size() / 2, radii.end());
    magnification_ = roundLength(kHalf / std::max(radii[radii.size() / 2], 1e-6));
    for (std::size_t k = 0; k < segments.size(); ++k) {
      const Segment& segment = segments[k];
      frames_.line({segment.t, segment.t + length * segment.R.col(0)}, kX);
      frames_.line({segment.t, segment.t + length * segment.R.col(1)}, kY);
      const Eigen::Vector3d tip = segment.t + length * segment.R.col(2);
      frames_.line({segment.t, tip}, kNormal);
      const Eigen::Matrix2d root = magnification_ * roots[k];
      if (root.norm() > kMost) continue;  // it would cover the others
      Shapes::Points ellipse;
      for (const Eigen::Vector2d& unit : unitCircle(24))
        ellipse.push_back(tip + length * (segment.R.leftCols<2>() * (root * unit)));
      frames_.line(ellipse, kBlack, true);
    }
  }

  /** So that the camera and all that it can see down to the far corners just fit. */
  void lookFromBehind(const std::optional<CameraMounting>& mounting, Shapes::Points corners) {
    constexpr double kViewAngle = 42, kMargin = 1.04;
    const Eigen::Vector3d up =
        mounting ? Eigen::Vector3d(mounting->T_b_c().linear().row(2).transpose()) : Eigen::Vector3d(0, -1, 0);
    const Eigen::Vector3d ahead = fromBehindAndAbove(up), right = ahead.cross(up).normalized();
    Eigen::Matrix3d axes;
    axes << right.transpose(), right.cross(ahead).transpose(), ahead.transpose();
    corners.emplace_back(0, 0, 0);
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& p : corners) box.extend(axes * p);
    const double slope = std::tan(kViewAngle / 2 * kDegree), aspect = ground_->GetTiledAspectRatio();
    double distance = 0;
    for (const Eigen::Vector3d& p : corners) {
      const Eigen::Vector3d q = axes * p - box.center();
      distance =
          std::max(distance, kMargin * std::max(std::abs(q.x()) / aspect, std::abs(q.y())) / slope - q.z());
    }
    const Eigen::Vector3d focus = axes.transpose() * box.center(), eye = focus - distance * ahead;
    vtkCamera* camera = ground_->GetActiveCamera();
    camera->SetPosition(eye.x(), eye.y(), eye.z());
    camera->SetFocalPoint(focus.x(), focus.y(), focus.z());
    camera->SetViewUp(up.x(), up.y(), up.z());
    camera->SetViewAngle(kViewAngle);
  }

  double magnification_ = 1;
  vtkNew<vtkRenderer> ground_, overlay_;
  vtkNew<vtkPolyData> cloud_;
  Shapes model_, unmatched_model_, frames_, outlines_;
};

}  // namespace facetloc
