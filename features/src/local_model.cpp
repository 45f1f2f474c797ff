// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/local_model.h>
#include <facetloc/features/segment_estimation.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

namespace facetloc {
namespace {

using Matrix36d = Eigen::Matrix<double, 3, 6>;

/** The disturbance q of a segment by a left, decoupled perturbation of the pose that moved it here. */
Matrix36d disturbanceBy(const Segment& s, const Eigen::Vector3d& origin) {
  Matrix36d J = Matrix36d::Zero();
  J.block<1, 3>(0, 0) = s.R.col(1).transpose();
  J.block<1, 3>(1, 0) = -s.R.col(0).transpose();
  J.block<1, 3>(2, 0) = (s.t - origin).cross(s.normal()).transpose();
  J.block<1, 3>(2, 3) = s.normal().transpose();
  return J;
}

/** Adds an error of their pose that segments have in common. Each takes a share of it, so that all together
 * know no more than the pose allows, though they count as independent (METHOD 12). */
void addCommonError(const PoseWithCovariance& T_v_c, std::vector<Segment>& segments) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eig(T_v_c.P);
  const Matrix6d errors = eig.eigenvectors() * eig.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  std::vector<Matrix36d> by_errors;
  std::vector<Vector6d> weights;
  Vector6d sum = Vector6d::Zero();
  for (const Segment& s : segments) {
    by_errors.push_back(disturbanceBy(s, T_v_c.T.translation()) * errors);
    const Matrix36d& J = by_errors.back();
    weights.push_back((J.transpose() * s.Sigma_q.inverse() * J).diagonal().cwiseMax(0).cwiseSqrt());
    sum += weights.back();
  }
  for (std::size_t i = 0; i < segments.size(); ++i)
    for (int k = 0; k < 6; ++k)
      if (weights[i][k] > 0)
        segments[i].Sigma_q += sum[k] / weights[i][k] * by_errors[i].col(k) * by_errors[i].col(k).transpose();
}

}  // namespace

View viewOfSegments(std::vector<Segment> segments, const DepthNoise& usual) {
  View view;
  view.segments = std::move(segments);
  view.depth.noise = usual;
  double noise = 0;
  for (const Segment& s : view.segments) noise = std::max(noise, s.noise);
  if (noise > 0) view.depth.noise = usual.scaledTo(noise, DepthNoise::kUsualDepth);
  return view;
}

View joined(const View& first, const std::vector<PosedView>& others) {
  View all = first;
  for (const auto& [view, T_v_c] : others) {
    std::vector<Segment> segments;
    for (const Segment& s : view->segments) segments.push_back(transformed(s, T_v_c.T));
    addCommonError(T_v_c, segments);
    all.segments.insert(all.segments.end(), segments.begin(), segments.end());
    if (!view->depth.empty())
      all.sides.push_back({std::shared_ptr<const DepthPicture>(view, &view->depth), T_v_c.T});
    for (const SidePicture& side : view->sides) all.sides.push_back({side.picture, T_v_c.T * side.T_v_c});
  }
  std::vector<Segment> sorted;
  for (const int i : rankByInformation(all.segments)) sorted.push_back(all.segments[i]);
  all.segments = std::move(sorted);
  return all;
}

LocalModel::LocalModel(std::string model_name, double model_stamp,
                       const std::optional<Eigen::Isometry3d>& pose)
    : name(std::move(model_name)), stamp(model_stamp), T_w_m(pose) {}

LocalModel::LocalModel(std::string model_name, double model_stamp,
                       const std::optional<Eigen::Isometry3d>& pose, View view)
    : LocalModel(std::move(model_name), model_stamp, pose) {
  setView(std::move(view));
}

void LocalModel::setView(View view) { setView(std::make_shared<const View>(std::move(view))); }

bool LocalModel::hasPicture() const {
  return view_ ? view_->hasPicture() : store_ && store_->hasPicture(index_);
}

std::shared_ptr<const View> Map::view(int i) const {
  const LocalModel& model = models[static_cast<std::size_t>(i)];
  if (model.view_) return model.view_;
  if (!model.store_) throw std::logic_error(fmt::format("local model {} of the map has no view", i));
  return model.store_->view(model.index_);
}

void Map::setStore(std::shared_ptr<const MapStore> store) {
  store_ = std::move(store);
  for (std::size_t i = 0; i < models.size(); ++i) {
    models[i].view_.reset();
    models[i].store_ = store_;
    models[i].index_ = static_cast<int>(i);
  }
}

std::string Map::partOf(int i) const {
  const auto part = static_cast<std::size_t>(models[static_cast<std::size_t>(i)].part);
  return part < parts.size() ? parts[part] : std::string();
}

const JoinedMap* Map::joinedMap(int part) const {
  const JoinedMap* found = nullptr;
  for (const JoinedMap& one : joined)
    if (!found || one.first_part <= part) found = &one;
  return found;
}

Camera Map::calibrated(Camera of_images) const {
  const bool fits =
      !of_images.intrinsics.valid() || !camera.distortion || camera.distortion->fits(of_images.intrinsics);
  if (!of_images.distortion && fits) of_images.distortion = camera.distortion;
  return of_images;
}

}  // namespace facetloc
