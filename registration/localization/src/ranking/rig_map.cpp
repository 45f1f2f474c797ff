// SPDX-License-Identifier: BSD-3-Clause
#include "poses/pose_fusion.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/localization/localizer.h>

#include <algorithm>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace facetloc {

using namespace internal;
namespace {

constexpr double kAhead = 2.5;  // distance of the surfaces in view [m]
constexpr double kTurned = 1;   // distance that counts as much as a turn by 60 deg [m]

Eigen::Vector3d lookedAt(const Eigen::Isometry3d& T_w_c) { return T_w_c * Eigen::Vector3d(0, 0, kAhead); }

/** The views of a map, each joined with those of the rig's other directions when it is first asked for. */
class RigViews : public MapStore {
public:
  RigViews(std::shared_ptr<const Map> map, std::vector<Eigen::Isometry3d> sides)
      : map_(std::move(map)), sides_(std::move(sides)), views_(map_->models.size()) {
    const ConsideredErrors errors = consideredErrorsOf(*map_);
    error_ = withSharedErrors(Matrix6d::Zero(), errors.rotation_std, errors.translation_std);
  }

  std::string name() const override { return map_->store() ? map_->store()->name() : MapStore::name(); }
  bool hasPicture(int i) const override { return map_->models[static_cast<std::size_t>(i)].hasPicture(); }
  std::shared_ptr<const View> view(int i) const override {
    const auto index = static_cast<std::size_t>(i);
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (views_[index]) return views_[index];
    }
    auto all = std::make_shared<const View>(joined(*map_->view(i), around(i)));
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!views_[index]) views_[index] = std::move(all);
    return views_[index];
  }

private:
  std::vector<PosedView> around(int i) const {
    const LocalModel& model = map_->models[static_cast<std::size_t>(i)];
    if (!model.T_w_m) return {};
    std::vector<int> taken{i};
    std::vector<PosedView> found;
    for (const Eigen::Isometry3d& T_m_side : sides_) {
      const std::optional<int> k = showing(model.part, *model.T_w_m * T_m_side);
      if (!k || std::find(taken.begin(), taken.end(), *k) != taken.end()) continue;
      taken.push_back(*k);
      const Eigen::Isometry3d& T_w_k = *map_->models[static_cast<std::size_t>(*k)].T_w_m;
      found.push_back({map_->view(*k), {model.T_w_m->inverse() * T_w_k, error_}});
    }
    return found;
  }

  // The local model whose surfaces a camera there would see: one that looks the same way, if there is one.
  std::optional<int> showing(int part, const Eigen::Isometry3d& T_w_c) const {
    std::optional<int> best;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < map_->models.size(); ++k) {
      const LocalModel& other = map_->models[k];
      if (!other.T_w_m || other.part != part) continue;
      const double away = (lookedAt(*other.T_w_m) - lookedAt(T_w_c)).norm(),
                   turned = (other.T_w_m->linear().col(2) - T_w_c.linear().col(2)).norm();
      if (away < kAhead && away + kTurned * turned < least)
        least = away + kTurned * turned, best = static_cast<int>(k);
    }
    return best;
  }

  std::shared_ptr<const Map> map_;
  std::vector<Eigen::Isometry3d> sides_;  // T_v_c
  Matrix6d error_;                        // covariance of T_m_k of two local models
  mutable std::mutex mutex_;
  mutable std::vector<std::shared_ptr<const View>> views_;
};

}  // namespace

std::shared_ptr<const Map> mapForRig(std::shared_ptr<const Map> map, std::vector<Eigen::Isometry3d> sides) {
  auto joined = std::make_shared<Map>(*map);
  joined->setStore(std::make_shared<RigViews>(std::move(map), std::move(sides)));
  return joined;
}

}  // namespace facetloc
