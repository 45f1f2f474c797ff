// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "opened_map.h"
#include "pairs/consensus.h"
#include "shortlist/shortlist.h"

#include <facetloc/localization/place_index.h>
#include <facetloc/testing/pose_matchers.h>
#include <facetloc/testing/synthetic_views.h>

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <vector>

namespace facetloc::test {

constexpr CameraMounting kMounting{1.0, 10.0};

inline Eigen::Isometry3d robotCamera(double x, double y, double heading) {
  return Eigen::Translation3d(x, y, 0) * Eigen::Isometry3d(expSO3({0, 0, heading})) * kMounting.T_b_c();
}

/** \brief Segments of a view that look this way. */
inline View facing(View view, const std::function<bool(const Eigen::Vector3d&)>& keep) {
  std::vector<Segment> kept;
  for (const Segment& s : view.segments)
    if (keep(kMounting.T_b_c().linear() * s.normal())) kept.push_back(s);
  view.segments = kept;
  return view;
}

/** \brief The query of global localization to a shortlist, for a view that is mounted so. */
inline internal::Query onFloor(const View& view, const PosePriorParams& params = {}) {
  PoseWithCovariance prior{Eigen::Isometry3d::Identity(), posePrior(kMounting, params)};
  return internal::Query(view, prior, floorInformation(kMounting, params));
}

/** \brief The batches as they are made if no model has anything to say of the view. */
inline std::vector<internal::Batch> allBatches(const internal::Shortlist& shortlist,
                                               const internal::Query& query, bool on_floor, int threads,
                                               const std::function<bool(int)>& excluded = {},
                                               double reached = std::numeric_limits<double>::lowest()) {
  std::vector<internal::Batch> made;
  for (const internal::NextBatch& next : shortlist.batches(query, on_floor, threads, excluded))
    made.push_back(next(reached));
  return made;
}

/** \brief Views of the room all around from two places; four rooms in a row, each with one more cupboard
 * (defined in test_place_index.cpp). */
class PlaceIndexOfRooms : public testing::Test {
protected:
  static constexpr int kRooms = 4, kViews = 24;
  static Scene room(int i) {
    Scene scene = largeRoom();
    if (i & 1) scene = scene + box({3.4, 0, 0}, {4.3, 0.4, 2.1});
    if (i & 2) scene = scene + box({5.5, 2.6, 0}, {6, 3.0, 2.0});
    return scene;
  }
  static void SetUpTestSuite();
  static void TearDownTestSuite() { map.reset(); }
  static View query(int r, double heading, unsigned seed) {
    return mounted(viewFrom(room(r), robotCamera(2.3, 2.2, heading), seed), kMounting);
  }
  /** \brief The view of a local model, as an image of the map's camera. */
  static View viewOf(int model) { return mounted(*map->view(model), kMounting); }
  static ShortlistParams few() {
    ShortlistParams params;
    params.aligned_models = 30, params.gap = 1e6;
    return params;
  }
  static inline std::shared_ptr<const Map> map;
};

}  // namespace facetloc::test
