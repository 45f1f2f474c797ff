// SPDX-License-Identifier: BSD-3-Clause
#include "nearby/view_alignment.h"
#include "poses/pose_fusion.h"
#include "sessions/map_review.h"

#include <facetloc/features/map_metadata.h>

#include <fmt/format.h>
#include <set>
#include <stdexcept>
#include <utility>

namespace facetloc {

using namespace internal;

namespace {

constexpr ViewReach kKnownReach{1, 30 * kDegree};  // reach of local models that make a place known [m]
constexpr double kKnownShare = 0.8;  // confirmed share of the pixels of an image of a known place

/** Number of the pose that is nearest to another one; nothing if none has much in common with a view from
 * there. \param poseOf gives null for a pose that does not count */
template <class PoseOf>
std::optional<std::size_t> nearestOf(std::size_t n, const Eigen::Isometry3d& T, const PoseOf& poseOf) {
  std::optional<std::size_t> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Isometry3d* pose = poseOf(i);
    if (!pose) continue;
    const double distance = viewDistance(*pose, T);
    if (distance < least) least = distance, nearest = i;
  }
  return nearest;
}

class Update {
public:
  Update(Map& map, const std::vector<SessionImage>& session, const MapBuilderParams& builder,
         const MapSessionParams& params, const MapReview& review)
      : map_(map),
        session_(session),
        near_(builder),
        builder_(builder),
        params_(params),
        review_(review),
        comparison_(DepthCalibration{}),
        removed_(map.models.size(), false),
        fresh_(map.models.size(), false),
        edited_(map.models.size(), false) {
    for (const LocalModel& model : map.models) names_.insert(model.name);
    for (std::size_t i = 0; i < session.size(); ++i) used_.push_back(!review.trusts(i));
  }

  /** Removes models that are gone; one that has lost much is replaced by the image nearest to it, if one is
   * near. */
  void retire() {
    for (std::size_t m = 0; m < removed_.size(); ++m) {
      const SurfaceReview& of_model = review_.of(m);
      if (of_model.judged == 0) continue;
      ++changes_.seen;
      changes_.surfaces += of_model.gone_segments.size();
      changes_.of_surfaces += static_cast<std::size_t>(of_model.judged_segments);
      const bool much = of_model.goneShare() > params_.changed_share;
      if (of_model.gone_segments.empty() && !much) continue;
      LocalModel& model = map_.models[m];
      const auto image = much ? nearestImage(*model.T_w_m) : std::nullopt;
      if (image) {
        replace(m, *image);
        continue;
      }
      View left = withoutGone(*map_.view(static_cast<int>(m)), of_model);
      if (left.segments.empty()) {
        removed_[m] = true;
        changes_.retired.push_back(model.name);
      } else {
        model.setView(std::move(left));
        edited_[m] = true;
      }
    }
  }

  /** Images become local models where they show surfaces that the map lacks. Where one is already, an image
   * takes its place, if other images of the session confirm the new surfaces. */
  void add() {
    for (std::size_t i = 0; i < session_.size(); ++i) {
      if (used_[i] || session_[i].view->segments.empty()) continue;
      if (isKnown(session_[i], {}, kKnownShare)) continue;
      if (const auto beside = nearestModel(session_[i].T_w_c, true)) {
        const bool is_old = *beside < fresh_.size() && !fresh_[*beside];
        if (is_old && !isKnown(session_[i], {}, 1 - params_.changed_share) &&
            isKnown(session_[i], otherLooks(i), kKnownShare))
          replace(*beside, i);
        continue;
      }
      const auto nearest = nearestModel(session_[i].T_w_c, false);
      map_.models.push_back(modelOf(i));
      changes_.added.push_back(map_.models.back().name);
      removed_.push_back(false);
      if (nearest)
        map_.links.push_back(builder_.link(static_cast<int>(*nearest),
                                           static_cast<int>(map_.models.size()) - 1,
                                           *map_.models[*nearest].T_w_m, session_[i].T_w_c));
    }
  }

  MapChanges finish() {
    for (std::size_t m = 0; m < edited_.size(); ++m)
      if (edited_[m] && !fresh_[m]) changes_.edited.push_back(map_.models[m].name);
    removeModels(removed_, map_);
    if (changes_.any()) {
      map_.ambiguity.reset();
      map_.meta.erase(kSureKey);
      if (consideredErrorsOf(map_).views > 0) map_.meta.erase(kConsideredErrorsKey);
      // Objects in an image need not stay.
      if (surfacesOf(map_) == MapSurfaces::fixed) setSurfaces(MapSurfaces::seen, map_);
    }
    return std::move(changes_);
  }

private:
  bool isBeside(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
    return isNear(a, b, near_.distance, near_.rotation_deg);
  }
  /** The images of the session that have seen the place of one of them from elsewhere. */
  std::vector<PosedPicture> otherLooks(std::size_t image) const {
    std::vector<PosedPicture> looks;
    const Eigen::Isometry3d& T_w_c = session_[image].T_w_c;
    for (std::size_t i = 0; i < session_.size(); ++i)
      if (review_.trusts(i) && !kSameLook.joins(session_[i].T_w_c, T_w_c) &&
          std::isfinite(viewDistance(session_[i].T_w_c, T_w_c, kKnownReach)))
        looks.push_back({&session_[i].view->depth, session_[i].T_w_c});
    return looks;
  }

  std::optional<std::size_t> nearestImage(const Eigen::Isometry3d& T_w_m) const {
    return nearestOf(session_.size(), T_w_m, [&](std::size_t i) {
      const SessionImage& image = session_[i];
      const bool counts = !used_[i] && !image.view->segments.empty() && isBeside(T_w_m, image.T_w_c);
      return counts ? &image.T_w_c : nullptr;
    });
  }
  /** \param beside only those at the same place count */
  std::optional<std::size_t> nearestModel(const Eigen::Isometry3d& T_w_c, bool beside) const {
    return nearestOf(map_.models.size(), T_w_c, [&](std::size_t m) {
      const auto& T_w_m = map_.models[m].T_w_m;
      const bool counts = !removed_[m] && T_w_m && (!beside || isBeside(*T_w_m, T_w_c));
      return counts ? &*T_w_m : nullptr;
    });
  }

  /** Do local models, and others, agree with such a share of an image? */
  bool isKnown(const SessionImage& image, std::vector<PosedPicture> others, double share) const {
    for (std::size_t m = 0; m < map_.models.size(); ++m)
      if (!removed_[m] && map_.models[m].T_w_m &&
          std::isfinite(viewDistance(*map_.models[m].T_w_m, image.T_w_c, kKnownReach)))
        others.push_back({&map_.view(static_cast<int>(m))->depth, *map_.models[m].T_w_m});
    const DepthPicture& picture = image.view->depth;
    const DepthAgreement seen = compareWithAll(picture, image.T_w_c, others, comparison_, kFineColumns);
    return !others.empty() && seen.agree >= share * comparison_.pixelsInReach(picture, kFineColumns);
  }

  LocalModel modelOf(std::size_t i) {
    const SessionImage& image = session_[i];
    used_[i] = true;
    std::string name = image.name;
    for (int k = 2; !names_.insert(name).second; ++k) name = fmt::format("{}_{}", image.name, k);
    View view = *image.view;
    view.camera.reset();  // the map's
    return {name, image.stamp, image.T_w_c, std::move(view)};
  }
  void replace(std::size_t m, std::size_t i) {
    fresh_[m] = true;
    LocalModel model = modelOf(i);
    changes_.replaced.push_back({map_.models[m].name, model.name});
    map_.models[m] = std::move(model);
    for (Link& link : map_.links) {
      if (link.from != static_cast<int>(m) && link.to != static_cast<int>(m)) continue;
      const auto &from = map_.models[link.from].T_w_m, &to = map_.models[link.to].T_w_m;
      if (from && to) link = builder_.link(link.from, link.to, *from, *to);
    }
  }

  Map& map_;
  const std::vector<SessionImage>& session_;
  MapBuilderParams near_;
  MapBuilder builder_;
  MapSessionParams params_;
  const MapReview& review_;  // made before any change
  DepthComparison comparison_;
  std::vector<bool> used_;     // images that become no local model any more
  std::vector<char> removed_;  // local models
  std::vector<bool> fresh_;    // local models of the map that an image has replaced
  std::vector<bool> edited_;   // those that have lost surfaces
  std::set<std::string> names_;
  MapChanges changes_;
};

}  // namespace

void internal::removeModels(const std::vector<char>& removed, Map& map) {
  std::vector<int> index(map.models.size(), -1);
  std::vector<LocalModel> models;
  for (std::size_t m = 0; m < map.models.size(); ++m) {
    if (removed[m]) continue;
    index[m] = static_cast<int>(models.size());
    models.push_back(std::move(map.models[m]));
  }
  std::vector<Link> links;
  for (Link link : map.links) {
    link.from = index[link.from], link.to = index[link.to];
    if (link.from >= 0 && link.to >= 0) links.push_back(link);
  }
  map.models = std::move(models);
  map.links = std::move(links);
}

MapChanges internal::updateMap(Map& map, const std::vector<SessionImage>& session, const MapReview& review,
                               const MapBuilderParams& builder, const MapSessionParams& params) {
  checkRanges(params);
  if (map.store()) throw std::invalid_argument("a map is updated in memory: read it with readMap()");
  Update update(map, session, builder, params, review);
  update.retire();
  update.add();
  return update.finish();
}

}  // namespace facetloc
