// SPDX-License-Identifier: BSD-3-Clause
#include "belief/next_look.h"

#include "nearby/nearby_models.h"
#include "ranking/place_ranking.h"

#include <facetloc/registration/observability.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace facetloc::internal {
namespace {

constexpr double kStep = 30 * kDegree;  // between looks, half of a usual field of view
constexpr int kHalfTurn = 6;            // steps
constexpr double kAhead = 1.5;          // drive that shows as much as a turn by a radian (viewDistance()) [m]
constexpr double kPossible = 0.01;      // probability of a place that counts
constexpr std::size_t kMostPlaces = 6;  // a limit of time
constexpr int kModels = 6;              // nearest ones by which a view is expected
constexpr double kMostOfOneLook = 5;    // log odds that one look adds [nats]
constexpr double kWorthwhile = 0.05;    // least gain of an advice [nats]
constexpr double kLikely = 0.5;         // probability to be sure by a turn, beyond which no drive is advised

/** T_b_c of the robot, or of a base in the camera that looks ahead and whose z axis is upwards. */
Eigen::Isometry3d baseOf(const View& view, const Camera& of_map) {
  const auto& mounting = view.camera ? view.camera->mounting : of_map.mounting;
  if (mounting) return mounting->T_b_c();
  const Eigen::Vector3d up = view.gravity ? Eigen::Vector3d(-view.gravity->down) : -Eigen::Vector3d::UnitY();
  Eigen::Isometry3d T_b_c = CameraMounting{}.T_b_c();
  T_b_c.linear() = rotationBetween(T_b_c.linear() * up, Eigen::Vector3d::UnitZ()) * T_b_c.linear();
  return T_b_c;
}

Eigen::Isometry3d motionBy(double yaw, double ahead, const Eigen::Isometry3d& T_b_c) {
  return T_b_c.inverse() * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
         Eigen::Translation3d(ahead, 0, 0) * T_b_c;
}

/** Index of the pixel in which a camera sees a point, if it does. */
std::optional<std::size_t> pixelOf(const Eigen::Vector3d& p, const Intrinsics& camera) {
  if (!(p.z() > 1e-3)) return {};
  const Eigen::Vector2d at = camera.project(p) + Eigen::Vector2d::Constant(0.5);
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < camera.width && at.y() < camera.height)) return {};
  return static_cast<std::size_t>(at.y()) * camera.width + static_cast<std::size_t>(at.x());
}

/** Calls visit(ray, inverse depth in quanta) for the known pixels on a grid. */
template <class Visitor>
void forEachPixel(const DepthPicture& picture, int step, const Visitor& visit) {
  const Intrinsics& k = picture.camera;
  for (int v = 0; v < k.height; v += step)
    for (int u = 0; u < k.width; u += step)
      if (const int rho = picture.inverse_depth[static_cast<std::size_t>(v) * k.width + u])
        visit(k.ray(u, v), static_cast<double>(rho));
}

/** Adds the pixels of a picture to the inverse depths of another camera, where they are the nearest. */
void splat(const DepthPicture& picture, const Eigen::Isometry3d& T_c_m, const Intrinsics& camera,
           std::vector<std::uint16_t>& into) {
  constexpr int kEvery = 2;  // pixels of the source, which still leaves no gaps
  forEachPixel(picture, kEvery, [&](const Eigen::Vector3d& ray, double rho) {
    const Eigen::Vector3d p = T_c_m.linear() * ray + T_c_m.translation() * rho * DepthPicture::kQuantum;
    if (const auto pixel = pixelOf(p, camera))
      into[*pixel] = std::max(into[*pixel], static_cast<std::uint16_t>(std::min(rho / p.z() + 0.5, 65535.0)));
  });
}

/** True if a picture shows nothing at the height of the camera for kAhead, but something farther away. */
bool isFree(const DepthPicture& picture, const Eigen::Isometry3d& T_b_c) {
  constexpr double kBody = 0.3, kLevel = 0.3;  // half width of the robot, height about the camera [m]
  double nearest = std::numeric_limits<double>::infinity();
  forEachPixel(picture, 1, [&](const Eigen::Vector3d& ray, double rho) {
    const Eigen::Vector3d p = T_b_c.linear() * ray / (rho * DepthPicture::kQuantum);
    if (std::abs(p.z()) <= kLevel && std::abs(p.y()) <= kBody) nearest = std::min(nearest, p.x());
  });
  return std::isfinite(nearest) && nearest >= kAhead + kBody;
}

/** Mean inverse depth of the left or the right half of a picture [quanta]; 0 where nothing is measured. */
double meanOfSide(const DepthPicture& picture, const Eigen::Isometry3d& T_b_c, int side) {
  double sum = 0, pixels = 0;
  forEachPixel(picture, 4, [&](const Eigen::Vector3d& ray, double rho) {
    if (side * (T_b_c.linear() * ray).y() > 0) sum += rho, ++pixels;
  });
  return pixels > 0 ? sum / pixels : 0;
}

/** A place where the camera may be. */
struct Place {
  Eigen::Isometry3d T_w_c;
  int part;
  double probability;
  Matrix6d information;  // information of its pose, in world axes
};

/** A view that the map expects. */
struct Expected {
  View seen, mapped;  // each by every second local model: they differ by the map's errors
  double known = 0;   // share of the pixels that one of them has
  Matrix6d information = Matrix6d::Zero();  // about the pose, in world axes
};

/** Knowledge after some looks, for each place that may be the right one. */
class Outlook {
public:
  Outlook(const PlaceRanking& ranking, const PoseLimits& limits, const std::vector<Place>& places)
      : ranking_(ranking), limits_(limits), places_(places) {
    const auto n = static_cast<Eigen::Index>(places.size());
    log_odds_ = Eigen::MatrixXd::Zero(n, n + 1);
  }

  /** Adds a look. \param expected at each place \param weight share of it that no earlier look has shown */
  void add(const std::vector<Expected>& expected, double weight) {
    const std::size_t n = expected.size();
    if (weight == 0) return;
    for (std::size_t right = 0; right < n; ++right) {
      const Expected& here = expected[right];
      for (std::size_t other = 0; other < n; ++other) {
        if (other == right) continue;
        const double odds = ranking_.oddsOfOther(here.seen, here.mapped, expected[other].mapped);
        log_odds_(right, other) += weight * std::max(-2 * kMostOfOneLook, odds);
      }
      places_[right].information += weight * here.information;
      if (isFixed(places_[right])) log_odds_(right, n) -= weight * kMostOfOneLook * here.known;
    }
  }

  /** Expected entropy of the places and of the cells of PoseLimits in which a pose may be [nats]. */
  double entropy() const {
    double sum = 0;
    for (std::size_t right = 0; right < places_.size(); ++right) {
      const Eigen::VectorXd p = probabilities(right);
      for (Eigen::Index i = 0; i < p.size(); ++i)
        if (p[i] > 0) sum += places_[right].probability * p[i] * (logCells(i) - std::log(p[i]));
    }
    return sum;
  }

  /** Probability that the answer is sure. */
  double sure(double min_probability) const {
    double sum = 0;
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (probabilities(i)[i] >= min_probability && isFixed(places_[i])) sum += places_[i].probability;
    return sum;
  }

private:
  /** Probabilities of all places, and of none of them, if one is the right one. */
  Eigen::VectorXd probabilities(std::size_t right) const {
    Eigen::VectorXd p(log_odds_.cols());
    double left = 1;
    for (std::size_t i = 0; i < places_.size(); ++i) left -= p[i] = places_[i].probability;
    p[p.size() - 1] = std::max(0.0, left);
    p.array() *= log_odds_.row(right).transpose().array().exp();
    return p / p.sum();
  }

  bool isFixed(const Place& place) const { return limits_.hold(symmetricInverse(place.information)); }

  /** Log of the number of cells that the errors of a pose cover; 0 for none of the places. */
  double logCells(Eigen::Index i) const {
    if (i == log_odds_.rows()) return 0;
    const PrincipalStd known = principalStd(symmetricInverse(places_[i].information));
    const Eigen::Array3d cells = (2 / limits_.max_translation * known.translation.array()).max(1) *
                                 (2 / (limits_.max_rotation_deg * kDegree) * known.rotation.array()).max(1);
    return cells.log().sum();
  }

  const PlaceRanking& ranking_;
  const PoseLimits& limits_;
  std::vector<Place> places_;  // with the information of all looks, if they are the right ones
  Eigen::MatrixXd log_odds_;   // rows: the right place; columns: all places, and none
};

/** The looks in a map that an answer may need. */
class NextLooks {
public:
  NextLooks(const std::shared_ptr<const Map>& map, const GlobalLocalizationParams& params,
            const std::vector<Eigen::Isometry3d>& looked)
      : map_(*map),
        limits_(params.sure),
        calibration_(params.calibration.sequence),
        looked_(looked),
        ranking_(map, params),
        near_(map, true) {}

  /** The advice by the places of the answer; nothing if no motion is worthwhile. */
  std::optional<NextLook> byPlaces(const View& view, const Localization& answer,
                                   double min_probability) const {
    const std::vector<Place> places = placesOf(answer);
    if (places.empty() || near_.empty()) return {};
    const Intrinsics seen_by =
        view.intrinsics.valid() ? view.intrinsics : map_.view(answer.hypotheses.front().model)->intrinsics;
    const Intrinsics camera = seen_by.subsampled(std::max(1, seen_by.width / kFineColumns));
    const Eigen::Isometry3d T_b_c = baseOf(view, map_.camera);

    std::vector<Expected> expected;  // at each place, by the latest look
    const auto look = [&](double yaw, double ahead, Outlook& outlook) {
      const Eigen::Isometry3d T_now_then = motionBy(yaw, ahead, T_b_c);
      expected.clear();
      for (const Place& place : places)
        expected.push_back(expectedAt(place.part, place.T_w_c * T_now_then, camera));
      outlook.add(expected, novelty(T_now_then));
    };
    const Outlook now(ranking_, limits_, places);
    const double entropy = now.entropy();
    std::optional<NextLook> best;
    double most = 0;  // gain per radian
    const auto consider = [&](double yaw, double ahead, const Outlook& then) {
      const NextLook found{yaw, ahead, entropy - then.entropy(), then.sure(min_probability)};
      const double per_radian = found.gain / (std::abs(yaw) + ahead / kAhead);
      if (found.gain > kWorthwhile && per_radian > most) best = found, most = per_radian;
    };
    std::vector<std::pair<double, Outlook>> ways;  // turns after which the way ahead is free
    for (const int side : {1, -1}) {               // a turn passes all looks on its way
      Outlook then = now;
      for (int k = side > 0 ? 0 : 1; k <= kHalfTurn - (side < 0); ++k) {
        const double yaw = side * k * kStep;
        look(yaw, 0, then);
        if (k > 0) consider(yaw, 0, then);
        if (std::all_of(expected.begin(), expected.end(),
                        [&](const Expected& there) { return isFree(there.seen.depth, T_b_c); }))
          ways.emplace_back(yaw, then);
      }
    }
    if (best && best->sure >= kLikely) return best;
    for (auto& [yaw, then] : ways) {
      look(yaw, kAhead, then);
      consider(yaw, kAhead, then);
    }
    return best;
  }

  /** Where the map says nothing: towards the side that is new and has room. */
  NextLook byView(const View& view) const {
    const Eigen::Isometry3d T_b_c = baseOf(view, map_.camera);
    const auto promise = [&](int side) {
      return novelty(motionBy(side * kStep, 0, T_b_c)) / std::max(1.0, meanOfSide(view.depth, T_b_c, side));
    };
    return {promise(1) >= promise(-1) ? kStep : -kStep, 0, 0, 0};
  }

private:
  std::vector<Place> placesOf(const Localization& answer) const {
    std::vector<Place> places;
    for (const Hypothesis& h : answer.hypotheses) {
      const std::optional<Eigen::Isometry3d>& T_w_m = map_.models[h.model].T_w_m;
      if (!h.T_w_c || !T_w_m || h.probability < kPossible || places.size() == kMostPlaces) continue;
      places.push_back({*h.T_w_c, h.part, h.probability, symmetricInverse((*T_w_m * h.T_m_c).P)});
    }
    return places;
  }

  Expected expectedAt(int part, const Eigen::Isometry3d& T_w_c, const Intrinsics& camera) const {
    Expected expected;
    std::array<std::vector<std::uint16_t>, 2> pixels;
    pixels.fill(std::vector<std::uint16_t>(static_cast<std::size_t>(camera.width) * camera.height, 0));
    std::vector<Segment> segments;
    const std::vector<int> models = near_.bySight(part, T_w_c, kEvidenceReach, kModels);
    DepthNoise noise;
    for (std::size_t k = 0; k < models.size(); ++k) {
      const Eigen::Isometry3d T_c_m = T_w_c.inverse() * *map_.models[models[k]].T_w_m;
      const auto view = map_.view(models[k]);
      noise = view->depth.noise;
      splat(view->depth, T_c_m, camera, pixels[k % 2]);
      for (const Segment& segment : view->segments)
        if (pixelOf(T_c_m * segment.t, camera)) segments.push_back(transformed(segment, T_c_m));
    }
    for (std::size_t i = 0; i < pixels[0].size(); ++i)
      expected.known += (pixels[0][i] > 0 || pixels[1][i] > 0) / static_cast<double>(pixels[0].size());
    for (const std::size_t half : {0, 1}) {
      DepthPicture& depth = (half == 0 ? expected.seen : expected.mapped).depth;
      depth = DepthPicture::fromStored(camera, std::move(pixels[half]));
      depth.noise = noise;
    }
    if (!models.empty())  // most of them show the same planes
      expected.information =
          rotateCovariance(T_w_c.linear(), informationOf(segments)) / static_cast<double>(models.size());
    return expected;
  }

  /** Share of a view that is new, as of an observation of a belief. */
  double novelty(const Eigen::Isometry3d& T_now_then) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Eigen::Isometry3d& T_now_look : looked_)
      least = std::min(least, (T_now_look.translation() - T_now_then.translation()).norm() /
                                      calibration_.independent_distance +
                                  rotationAngle(T_now_look.linear().transpose() * T_now_then.linear()) /
                                      (calibration_.independent_rotation_deg * kDegree));
    return 1 - std::exp(-least);
  }

  const Map& map_;
  const PoseLimits& limits_;
  const SequenceCalibration& calibration_;
  const std::vector<Eigen::Isometry3d>& looked_;
  PlaceRanking ranking_;
  NearbyModels near_;
};

}  // namespace

std::optional<NextLook> nextLook(const std::shared_ptr<const Map>& map,
                                 const GlobalLocalizationParams& params, const View& view,
                                 const Localization& answer, const std::vector<Eigen::Isometry3d>& looked,
                                 double min_probability) {
  if (answer.state == AnswerState::sure || !answer.searched || !answer.not_in_map) return {};
  const NextLooks looks(map, params, looked);
  const std::optional<NextLook> known = looks.byPlaces(view, answer, min_probability);
  return known || view.depth.empty() ? known : looks.byView(view);
}

}  // namespace facetloc::internal
