// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "motion/view_placing.h"
#include "sessions/free_space_violations.h"

#include <facetloc/mapping/map_session.h>

#include <memory>
#include <string>
#include <vector>

namespace facetloc::internal {

/** \brief An image of a session that has its place in the map. */
struct SessionImage {
  std::string name;
  double stamp = 0;  ///< [s]
  std::shared_ptr<const View> view;
  Eigen::Isometry3d T_w_c = Eigen::Isometry3d::Identity();
  bool confirmed = true;  ///< otherwise it must agree with the map around it almost everywhere to count
};

struct ChangedPiece;
struct Voters;

/** \brief A session's evidence about the local models of a map, which stay as they are. The same for any
 * number of threads. */
class MapReview {
public:
  /** \brief All parameters must outlive it; the map may change once it is made, but for changes(). */
  MapReview(const Map& map, const std::vector<SessionImage>& session, int threads = 1);

  const SurfaceReview& of(std::size_t model) const { return reviews_[model]; }
  bool trusts(std::size_t image) const { return trusted_[image]; }
  /** \brief MapSession::changes(). */
  std::vector<SurfaceChange> changes() const;

private:
  /** An image of the session as one local model has it. */
  struct Look {
    std::size_t image;
    Eigen::Isometry3d T_m_c;
    DepthAgreement seen;
  };

  std::vector<Look> looksAt(int m) const;
  DepthAgreement agreement(int m, std::size_t image, const Eigen::Isometry3d& T_m_c) const;
  std::vector<char> trustedImages() const;
  Voters trustedImagesOf(std::size_t model) const;
  std::vector<ChangedPiece> removedFrom(std::size_t model) const;
  std::vector<ChangedPiece> addedIn(std::size_t image) const;

  const Map& map_;
  const std::vector<SessionImage>& session_;
  int threads_;
  DepthComparison comparison_, narrow_;
  ViewPlacing placing_;
  std::vector<std::vector<Look>> looks_;
  std::vector<char> trusted_;  // for each image: its pose is trusted
  std::vector<SurfaceReview> reviews_;
};

/** \brief Removes local models from a map, and the links that lead to them. */
void removeModels(const std::vector<char>& removed, Map& map);

/** \brief MapSession::update() with images in their places. \param review of the map as it is */
MapChanges updateMap(Map& map, const std::vector<SessionImage>& session, const MapReview& review,
                     const MapBuilderParams& builder = {}, const MapSessionParams& params = {});

}  // namespace facetloc::internal
