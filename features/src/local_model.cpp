// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/features/local_model.h>

#include <algorithm>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

namespace facetloc {

View viewOfSegments(std::vector<Segment> segments, const DepthNoise& usual) {
  View view;
  view.segments = std::move(segments);
  view.depth.noise = usual;
  double noise = 0;
  for (const Segment& s : view.segments) noise = std::max(noise, s.noise);
  if (noise > 0) view.depth.noise = usual.scaledTo(noise, DepthNoise::kUsualDepth);
  return view;
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
