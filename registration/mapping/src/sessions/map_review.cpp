// SPDX-License-Identifier: BSD-3-Clause
#include "sessions/map_review.h"

#include "base/polygon.h"
#include "nearby/view_alignment.h"
#include "poses/pose_fusion.h"
#include "threads/in_parallel.h"

#include <boost/math/special_functions/beta.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr int kLooks = 2;               // places that must look through a surface before it counts as gone
constexpr std::size_t kMostLooks = 16;  // nearest images that one local model is judged by
constexpr double kLoose = 0.1, kLooseRotation = 2 * kDegree;  // errors of an image's place in the map [m]
constexpr double kTrustedAgreement = 0.6;  // agreement with the map around, below which an image is misplaced
constexpr double kConvincingAgreement = 0.92;   // agreement of an image whose place nothing else confirms
constexpr int kFewestPixels = 60;               // that two views must have in common
constexpr double kOneSurface = 0.1;             // largest distance between two views' planes of a surface [m]
constexpr double kOneDirection = 15 * kDegree;  // largest angle between these
constexpr double kCell = 0.05;                  // side of the cells by which surfaces are the same [m]
constexpr double kReported = 0.5;               // least probability of a change
constexpr std::size_t kCorners = 24;            // most that an outline has

/** Aligned images are off by their noise, and errors of one surface are correlated: many pixels together
 * reveal smaller differences than one does. */
DepthCalibration narrowComparison() {
  DepthCalibration errors;
  errors.absolute_error /= 2;
  errors.relative_error /= 2;
  return errors;
}

/** The votes of views on a surface: for each view, the share of its pixels that it looks through. */
struct Votes {
  struct Vote {
    double through = 0, all = 0;  // weighed by area [m^2]
  };
  std::map<std::size_t, Vote> of;

  void add(std::size_t view, double through, double area) {
    of[view].through += through * area, of[view].all += area;
  }
  void add(const Votes& other) {
    for (const auto& [view, vote] : other.of) of[view].through += vote.through, of[view].all += vote.all;
  }
  /** Probability that most views look through it, if any share of them may, with equal prior probability. */
  double isLookedThrough() const {
    double through = 1, at_it = 1;
    for (const auto& [view, vote] : of)
      through += vote.through / vote.all, at_it += 1 - vote.through / vote.all;
    return boost::math::ibetac(through, at_it, 0.5);
  }
};

}  // namespace

/** A changed surface as one view shows it. */
struct ChangedPiece {
  SurfaceChange::Kind kind;
  int part;
  const std::string* seen_by;
  Segment plane{};                                           // frame: the part
  std::vector<std::pair<Eigen::Vector3d, double>> points{};  // that have changed, each with its area [m^2]
  double area = 0;                                           // sum over all points [m^2]
  // whether its place is free in the other time, and does not stay in its own
  Votes free{}, stands{};
};

/** Views that vote on changed surfaces. */
struct Voters {
  std::vector<std::size_t> numbers{};
  std::vector<PosedPicture> pictures{};  // frame: the view that shows the surfaces

  void add(std::size_t number, const DepthPicture& picture, const Eigen::Isometry3d& T) {
    numbers.push_back(number);
    pictures.push_back({&picture, T});
  }
};

namespace {

/** The changed segments of a view. \param of kind, part and name of all \param T_w_c its pose in the part */
std::vector<ChangedPiece> piecesOf(const ChangedPiece& of, const Eigen::Isometry3d& T_w_c, const View& view,
                                   const SurfaceReview& review, const Voters& free, const Voters& stands,
                                   const DepthComparison& comparison) {
  const Intrinsics& k = view.depth.camera;
  std::vector<ChangedPiece> pieces(review.gone_segments.size(), of);
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    ChangedPiece& piece = pieces[n];
    const Segment& s = view.segments[review.gone_segments[n]];
    const std::vector<std::size_t>& pixels = review.gone_pixels_of[n];
    piece.plane = transformed(s, T_w_c);
    for (const std::size_t i : pixels) {
      const auto u = static_cast<int>(i % static_cast<std::size_t>(k.width)),
                 v = static_cast<int>(i / static_cast<std::size_t>(k.width));
      const Eigen::Vector3d ray = k.ray(u, v);
      const double depth = s.offset() / s.normal().dot(ray);
      const double of_pixel = depth * depth * depth / (k.fx * k.fy * s.offset());
      piece.points.emplace_back(T_w_c * (depth * ray), of_pixel);
      piece.area += of_pixel;
    }
    const auto vote = [&](const Voters& voters, Votes& votes) {
      const auto shares = sharesLookedThrough(view.depth, pixels, voters.pictures, comparison);
      for (std::size_t i = 0; i < shares.size(); ++i)
        if (shares[i]) votes.add(voters.numbers[i], *shares[i], piece.area);
    };
    vote(free, piece.free);
    vote(stands, piece.stands);
  }
  return pieces;
}

/** Pieces that are one surface. */
class ChangedSurface {
public:
  explicit ChangedSurface(const ChangedPiece& first) : first_(first) { add(first); }

  /** Adds a piece if it is of this surface. */
  bool take(const ChangedPiece& piece) {
    const Segment &a = first_.plane, &b = piece.plane;
    if (piece.kind != first_.kind || piece.part != first_.part ||
        a.normal().dot(b.normal()) < std::cos(kOneDirection))
      return false;
    double off = 0;
    bool overlaps = false;
    for (const auto& [p, area] : piece.points) {
      off += a.normal().dot(p - a.t) * area;
      overlaps = overlaps || cells_.count(cellOf(p));
    }
    if (!overlaps || std::abs(off) > kOneSurface * piece.area) return false;
    add(piece);
    return true;
  }

  SurfaceChange change() const {
    SurfaceChange out;
    out.kind = first_.kind, out.part = first_.part, out.seen_by = *first_.seen_by;
    out.normal = -first_.plane.normal();
    out.looks = free_.of.size();
    out.probability = free_.isLookedThrough();
    if (out.kind == SurfaceChange::Kind::added) out.probability *= 1 - stands_.isLookedThrough();
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Polygon middles, hull;
    for (const auto& [cell, area] : cells_) {
      out.area += area;
      middles.push_back(kCell * Eigen::Vector2d(cell.first + 0.5, cell.second + 0.5));
      sum += area * middles.back();
    }
    out.centre = at(sum / out.area);
    convexHull(middles, hull);
    simplify(hull, kCorners);
    for (const Eigen::Vector2d& corner : hull) out.outline.push_back(at(corner));
    return out;
  }

private:
  using Cell = std::pair<int, int>;

  Cell cellOf(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d in_plane = first_.plane.R.transpose() * (p - first_.plane.t) / kCell;
    return {static_cast<int>(std::floor(in_plane.x())), static_cast<int>(std::floor(in_plane.y()))};
  }
  Eigen::Vector3d at(const Eigen::Vector2d& in_plane) const {
    return first_.plane.t + first_.plane.R.leftCols<2>() * in_plane;
  }
  /** A cell has the largest area that one piece shows in it. */
  void add(const ChangedPiece& piece) {
    std::map<Cell, double> seen;
    for (const auto& [p, area] : piece.points) seen[cellOf(p)] += area;
    for (const auto& [cell, area] : seen)
      cells_[cell] = std::max(cells_[cell], std::min(area, kCell * kCell));
    free_.add(piece.free);
    stands_.add(piece.stands);
  }

  const ChangedPiece& first_;  // the largest
  std::map<Cell, double> cells_;
  Votes free_, stands_;
};

/** Surfaces of pieces in a fixed order, the largest first. */
std::vector<SurfaceChange> joined(std::vector<ChangedPiece> pieces) {
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const ChangedPiece& a, const ChangedPiece& b) { return a.area > b.area; });
  std::vector<ChangedSurface> surfaces;
  for (const ChangedPiece& piece : pieces)
    if (std::none_of(surfaces.begin(), surfaces.end(), [&](auto& surface) { return surface.take(piece); }))
      surfaces.emplace_back(piece);
  std::vector<SurfaceChange> changes;
  for (const auto& surface : surfaces)
    if (SurfaceChange change = surface.change(); change.probability >= kReported)
      changes.push_back(std::move(change));
  std::stable_sort(changes.begin(), changes.end(), [](const SurfaceChange& a, const SurfaceChange& b) {
    return std::pair(a.kind, -a.area) < std::pair(b.kind, -b.area);
  });
  return changes;
}

}  // namespace

MapReview::MapReview(const Map& map, const std::vector<SessionImage>& session, int threads)
    : map_(map),
      session_(session),
      threads_(threads),
      comparison_(DepthCalibration{}),
      narrow_(narrowComparison()),
      looks_(map.models.size()),
      reviews_(map.models.size()) {
  const int n = static_cast<int>(map.models.size());
  forEachInParallel(n, threads, [&](int m) { looks_[m] = looksAt(m); });
  trusted_ = trustedImages();
  forEachInParallel(n, threads, [&](int m) {
    reviews_[m] = reviewSurfaces(*map_.view(m), trustedImagesOf(m).pictures, narrow_, kLooks);
  });
}

/** The nearest images from different places, each aligned with the local model by their common surfaces. */
std::vector<MapReview::Look> MapReview::looksAt(int m) const {
  const LocalModel& model = map_.models[m];
  const std::shared_ptr<const View> view = map_.view(m);
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t i = 0; model.T_w_m && i < session_.size(); ++i) {
    const double distance = viewDistance(*model.T_w_m, session_[i].T_w_c);
    if (std::isfinite(distance)) near.emplace_back(distance, i);
  }
  std::sort(near.begin(), near.end());
  Vector6d loose;
  loose << Eigen::Vector3d::Constant(kLooseRotation), Eigen::Vector3d::Constant(kLoose);
  const Matrix6d P = loose.cwiseAbs2().asDiagonal();
  std::vector<Look> looks;
  for (const auto& by_distance : near) {
    if (looks.size() == kMostLooks) break;
    const auto i = by_distance.second;
    const Eigen::Isometry3d T_m_c = model.T_w_m->inverse() * session_[i].T_w_c;
    const bool same = std::any_of(looks.begin(), looks.end(), [&](const Look& look) {
      return kSameLook.joins(session_[look.image].T_w_c, session_[i].T_w_c);
    });
    if (same) continue;
    Look look{i, T_m_c, agreement(m, i, T_m_c)};
    const auto placed = placing_.place(*session_[i].view, *view, {T_m_c, P}, false);
    if (placed && isNear(placed->T_a_b, T_m_c, 2 * kLoose, 2 * kLooseRotation / kDegree)) {
      const DepthAgreement aligned = agreement(m, i, placed->T_a_b);
      if (aligned.likelihood > look.seen.likelihood || look.seen.judged() < kFewestPixels)
        look.T_m_c = placed->T_a_b, look.seen = aligned;
    }
    if (look.seen.judged() >= kFewestPixels) looks.push_back(look);
  }
  return looks;
}
DepthAgreement MapReview::agreement(int m, std::size_t image, const Eigen::Isometry3d& T_m_c) const {
  return comparison_.compareBoth(session_[image].view->depth, map_.view(m)->depth, T_m_c, kFineColumns);
}

/** An image that contradicts most of the map around it is in the wrong place, and does not count. */
std::vector<char> MapReview::trustedImages() const {
  std::vector<DepthAgreement> sums(session_.size());
  for (const auto& of_model : looks_)
    for (const Look& look : of_model) sums[look.image] += look.seen;
  std::vector<char> trusted;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double least = session_[i].confirmed ? kTrustedAgreement : kConvincingAgreement;
    trusted.push_back(sums[i].agree >= least * (sums[i].agree + sums[i].contradict));
  }
  return trusted;
}

Voters MapReview::trustedImagesOf(std::size_t model) const {
  Voters images;
  for (const Look& look : looks_[model])
    if (trusted_[look.image]) images.add(look.image, session_[look.image].view->depth, look.T_m_c);
  return images;
}

std::vector<ChangedPiece> MapReview::removedFrom(std::size_t model) const {
  if (reviews_[model].gone_segments.empty()) return {};
  const std::shared_ptr<const View> view = map_.view(static_cast<int>(model));
  const LocalModel& of = map_.models[model];
  return piecesOf({SurfaceChange::Kind::removed, of.part, &of.name}, *of.T_w_m, *view, reviews_[model],
                  trustedImagesOf(model), {}, narrow_);
}

/** Surfaces of an image where the local models around it look through, and that other images of the session
 * see as well: who passes by has gone in these. */
std::vector<ChangedPiece> MapReview::addedIn(std::size_t image) const {
  if (!trusted_[image]) return {};
  const SessionImage& of = session_[image];
  Voters models, images;
  std::vector<std::shared_ptr<const View>> views;  // keeps pictures in memory
  for (std::size_t m = 0; m < looks_.size(); ++m)
    for (const Look& look : looks_[m]) {
      if (look.image != image) continue;
      views.push_back(map_.view(static_cast<int>(m)));
      models.add(m, views.back()->depth, look.T_m_c.inverse());
    }
  const SurfaceReview review = reviewSurfaces(*of.view, models.pictures, narrow_, kLooks);
  if (review.gone_segments.empty()) return {};
  for (std::size_t i = 0; i < session_.size(); ++i)
    if (trusted_[i] && !kSameLook.joins(session_[i].T_w_c, of.T_w_c) &&
        std::isfinite(viewDistance(session_[i].T_w_c, of.T_w_c)))
      images.add(i, session_[i].view->depth, of.T_w_c.inverse() * session_[i].T_w_c);
  const int part = map_.models[models.numbers.front()].part;
  return piecesOf({SurfaceChange::Kind::added, part, &of.name}, of.T_w_c, *of.view, review, models, images,
                  narrow_);
}

std::vector<SurfaceChange> MapReview::changes() const {
  const std::size_t n = map_.models.size();
  std::vector<std::vector<ChangedPiece>> of_view(n + session_.size());
  forEachInParallel(static_cast<int>(of_view.size()), threads_, [&](int i) {
    const auto view = static_cast<std::size_t>(i);
    of_view[view] = view < n ? removedFrom(view) : addedIn(view - n);
  });
  std::vector<ChangedPiece> pieces;
  for (std::vector<ChangedPiece>& some : of_view)
    pieces.insert(pieces.end(), std::make_move_iterator(some.begin()), std::make_move_iterator(some.end()));
  return joined(std::move(pieces));
}

}  // namespace facetloc::internal
