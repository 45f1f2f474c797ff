// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "nearby/view_alignment.h"

#include <facetloc/features/local_model.h>

#include <functional>
#include <memory>
#include <vector>

namespace facetloc::internal {

/** \brief Finds the local models of a map that stand near a place, without looking at all of them.
 *
 * Models without a pose stand nowhere. Never changes; all functions are thread-safe. */
class NearbyModels {
public:
  /** \param with_picture models without a depth picture are left out */
  explicit NearbyModels(std::shared_ptr<const Map> map, bool with_picture = false);
  bool empty() const { return places_.empty(); }
  /** \brief All but the absent ones. */
  NearbyModels without(const std::function<bool(int model)>& absent) const;

  /** \brief The at most n nearest of a part of the map by viewDistance() within reach, nearest first; ties by
   * index. */
  std::vector<int> bySight(int part, const Eigen::Isometry3d& T_w_c, const ViewReach& reach, int n) const;
  /** \brief The n of a part that are nearest to a place, nearest first; ties by index. */
  std::vector<int> byPlace(int part, const Eigen::Vector3d& place, int n) const;

private:
  struct Place {
    int part;
    Eigen::Vector3d t;
    int model;
  };
  template <class Visitor>
  void forEachWithin(int part, const Eigen::Vector3d& place, double distance, const Visitor& visit) const;

  std::shared_ptr<const Map> map_;
  std::vector<Place> places_;  // sorted by part, then by x
};

}  // namespace facetloc::internal
