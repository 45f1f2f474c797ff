// SPDX-License-Identifier: BSD-3-Clause
#include "models/viewpoints.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/core.h>
#include <map>
#include <queue>

namespace facetloc::internal {
namespace {

constexpr double kBeside = 3;        // how far from a scan of a part of a room a camera may be [m]
constexpr double kKnownShare = 0.3;  // share of a view with a surface in range: less matches by chance
constexpr double kSlackDeg = 1e-6;   // neighbouring headings are just as far apart as the rule says

/** The camera in about 24 columns. */
Intrinsics smallCamera(const Intrinsics& camera) {
  constexpr double kColumns = 24;
  const double factor = kColumns / std::max(camera.width, camera.height);
  Intrinsics small = camera;
  small.width = std::max(1, static_cast<int>(std::lround(camera.width * factor)));
  small.height = std::max(1, static_cast<int>(std::lround(camera.height * factor)));
  small.fx = camera.fx * small.width / camera.width;
  small.fy = camera.fy * small.height / camera.height;
  small.cx = (camera.cx + 0.5) * small.width / camera.width - 0.5;
  small.cy = (camera.cy + 0.5) * small.height / camera.height - 0.5;
  return small;
}

class Candidates {
public:
  Candidates(const ViewpointSearch& search, const ModelMapParams& params)
      : search_(search), params_(params), camera_(smallCamera(search.camera.intrinsics)) {}

  /** Views at these positions, in the frame with z up, in all headings, as far as they show enough. */
  void look(const std::vector<Eigen::Vector3d>& positions) {
    const std::size_t headings = headingCount(), tilts = search_.tilts_deg.size();
    std::vector<SmallView> all(positions.size() * headings * tilts);
    search_.forEach(all.size(), [&](std::size_t i) {
      const double yaw = 2 * M_PI * static_cast<double>(i % headings) / static_cast<double>(headings);
      all[i] = viewAt(positions[i / headings / tilts], yaw, search_.tilts_deg[i / headings % tilts]);
    });
    for (SmallView& view : all)
      if (knownShare(view) >= kKnownShare) views_.push_back(std::move(view));
  }

  /** For each view the others that it may stand for. */
  Substitutes substitutes() const {
    std::map<Cell, std::vector<std::uint32_t>> cells;
    for (std::size_t i = 0; i < views_.size(); ++i)
      cells[cellOf(views_[i])].push_back(static_cast<std::uint32_t>(i));
    Substitutes found;
    found.of.resize(views_.size());
    search_.forEach(views_.size(), [&](std::size_t i) {
      const auto compare = [&](std::uint32_t j) {
        if (i == j ||
            !isNear(views_[i].T_w_c, views_[j].T_w_c, params_.spacing, params_.turn_deg + kSlackDeg))
          return;
        const double shared = sharedPart(views_[j], views_[i], camera_);
        if (shared > 0) found.of[i].push_back({j, static_cast<float>(shared)});
      };
      const Cell middle = cellOf(views_[i]);
      for (int k = 0; k < 27; ++k)
        if (const auto cell =
                cells.find({middle[0] + k % 3 - 1, middle[1] + k / 3 % 3 - 1, middle[2] + k / 9 - 1});
            cell != cells.end())
          for (const std::uint32_t j : cell->second) compare(j);
    });
    return found;
  }

  bool empty() const { return views_.empty(); }
  const Eigen::Isometry3d& pose(std::size_t i) const { return views_[i].T_w_c; }

private:
  using Cell = std::array<long, 3>;

  /** Views that may stand for each other lie in cells next to each other. */
  Cell cellOf(const SmallView& view) const {
    const Eigen::Array3d cell = (view.T_w_c.translation() / params_.spacing).array().floor();
    return {static_cast<long>(cell.x()), static_cast<long>(cell.y()), static_cast<long>(cell.z())};
  }
  std::size_t headingCount() const {
    return static_cast<std::size_t>(std::ceil(360 / params_.turn_deg - 1e-9));
  }
  SmallView viewAt(const Eigen::Vector3d& position, double yaw, double tilt_deg) const {
    CameraMounting mounting = search_.camera.mounting.value_or(CameraMounting());
    mounting.tilt_deg = tilt_deg;
    Eigen::Isometry3d T_up_c = Eigen::Isometry3d::Identity();
    T_up_c.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * mounting.T_b_c().linear();
    T_up_c.translation() = position;
    const Eigen::Isometry3d T_w_c = search_.T_w_up * T_up_c;
    DepthImage image = search_.surface->render(camera_, T_w_c);
    dropBeyond(search_.camera.max_depth, image);
    return {T_w_c, std::move(image.depth)};
  }
  static double knownShare(const SmallView& view) {
    const auto known = std::count_if(view.depth.begin(), view.depth.end(), [](float z) { return z > 0; });
    return static_cast<double>(known) / static_cast<double>(view.depth.size());
  }

  const ViewpointSearch& search_;
  const ModelMapParams& params_;
  Intrinsics camera_;
  std::vector<SmallView> views_;
};

/** Why no places are looked for on a surface of this extent; empty if they can be. */
std::string problemOfSize(const Eigen::AlignedBox3d& bounds, double step) {
  constexpr double kMostColumns = 1e7;  // more than a square kilometre in the usual steps
  if (bounds.isEmpty()) return {};
  const Eigen::Vector3d size = bounds.sizes();
  if (size.x() / step * (size.y() / step) <= kMostColumns) return {};
  return fmt::format(
      "it is {:.0f} x {:.0f} m wide, too much to look for viewpoints everywhere; check the unit, "
      "cut off far surfaces, increase spacing, or give viewpoints",
      size.x(), size.y());
}

/** Places in a whole room, or else beside a scan of a part of one. */
std::vector<Eigen::Vector3d> placesFor(const ViewpointSearch& search, ModelFindings& findings) {
  const SpaceProbe probe(*search.surface, search.T_w_up);
  PlaceRules rules = search.places;
  if (const std::string problem = problemOfSize(probe.bounds(), rules.step); !problem.empty()) {
    findings.problem = problem;
    return {};
  }
  FreePlaces found = freePlaces(probe, rules, search.forEach);
  if (found.positions.empty() && found.too_many == 0 && rules.inside.empty()) {
    rules.beside = kBeside;
    found = freePlaces(probe, rules, search.forEach);
    findings.is_open = true;
  }
  findings.too_many = found.too_many > 0;
  findings.places = findings.too_many ? found.too_many : found.positions.size();
  findings.outdoors = found.outdoors;
  if (findings.too_many)
    findings.problem =
        fmt::format("a camera can be at about {} places in it, more than {}; check the unit, or "
                    "increase spacing",
                    findings.places, rules.most);
  return found.positions;
}

/** Does a picture show this depth at a pixel or between it and its neighbours? */
bool shows(const SmallView& view, const Intrinsics& camera, const Eigen::Vector2d& pixel, double z) {
  constexpr double kSlack = 0.05;  // share of depth
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) return false;
  float least = 0, most = 0;
  for (int y = std::max(0, v - 1); y <= std::min(v + 1, camera.height - 1); ++y)
    for (int x = std::max(0, u - 1); x <= std::min(u + 1, camera.width - 1); ++x) {
      const float d = view.depth[static_cast<std::size_t>(y) * camera.width + x];
      if (d <= 0) continue;
      least = least > 0 ? std::min(least, d) : d;
      most = std::max(most, d);
    }
  return z >= least * (1 - kSlack) && z <= most * (1 + kSlack);
}

}  // namespace

std::vector<Eigen::Isometry3d> findViewpoints(const ViewpointSearch& search, const ModelMapParams& params,
                                              ModelFindings& findings) {
  Candidates candidates(search, params);
  candidates.look(placesFor(search, findings));
  if (!findings.problem.empty()) return {};
  if (candidates.empty()) {
    findings.problem = findings.places == 0 ? "there is no floor in it with room for a camera above"
                                            : "no view from above its floor shows enough of it";
    return {};
  }
  const Substitutes substitutes = candidates.substitutes();
  constexpr double kStep = 0.05;
  std::vector<std::size_t> chosen;
  for (findings.overlap = params.overlap;; findings.overlap = std::max(0.0, findings.overlap - kStep)) {
    chosen = coveringViews(substitutes, findings.overlap);
    if (chosen.size() <= static_cast<std::size_t>(params.most_models) || findings.overlap <= 0) break;
  }
  if (chosen.size() > static_cast<std::size_t>(params.most_models)) {
    findings.problem = fmt::format("it needs {} views; increase most_models or spacing", chosen.size());
    return {};
  }
  std::vector<Eigen::Isometry3d> viewpoints;
  for (const std::size_t i : chosen) viewpoints.push_back(candidates.pose(i));
  return viewpoints;
}

double sharedPart(const SmallView& of, const SmallView& in, const Intrinsics& camera) {
  const Eigen::Isometry3d T = in.T_w_c.inverse() * of.T_w_c;
  int known = 0, shared = 0;
  for (int v = 0; v < camera.height; v += 2)
    for (int u = 0; u < camera.width; u += 2) {
      const double z = of.depth[static_cast<std::size_t>(v) * camera.width + u];
      if (z <= 0) continue;
      ++known;
      const Eigen::Vector3d p = T * Eigen::Vector3d(camera.ray(u, v) * z);
      shared += p.z() > 0 && shows(in, camera, camera.project(p), p.z());
    }
  return known > 0 ? static_cast<double>(shared) / known : 0;
}

std::vector<std::size_t> coveringViews(const Substitutes& substitutes, double shared) {
  const std::size_t n = substitutes.of.size();
  std::vector<std::uint8_t> covered(n);
  const auto gain = [&](std::size_t i) {  // the view itself is covered by nothing better
    int count = covered[i] ? 0 : 1;
    for (const Substitutes::Entry& entry : substitutes.of[i])
      count += !covered[entry.view] && entry.shared >= shared;
    return count;
  };
  using Choice = std::pair<int, std::ptrdiff_t>;  // gain, and minus the view: the first of equals wins
  std::priority_queue<Choice> queue;
  for (std::size_t i = 0; i < n; ++i) queue.emplace(gain(i), -static_cast<std::ptrdiff_t>(i));
  std::vector<std::size_t> chosen;
  while (!queue.empty()) {
    const auto [expected, minus] = queue.top();
    queue.pop();
    const auto view = static_cast<std::size_t>(-minus);
    const int now = gain(view);  // gains only fall
    if (now == 0) continue;
    if (now < expected) {
      queue.emplace(now, minus);
      continue;
    }
    chosen.push_back(view);
    covered[view] = 1;
    for (const Substitutes::Entry& entry : substitutes.of[view])
      if (entry.shared >= shared) covered[entry.view] = 1;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace facetloc::internal
