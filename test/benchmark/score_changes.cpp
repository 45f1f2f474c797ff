// SPDX-License-Identifier: BSD-3-Clause
//
// Are the surfaces that facetloc_map changes lists those that have moved, and all of them?
//
//   score_changes SCENE SEED PLACE MAP.flmap CHANGES.csv
//
// PLACE is a folder with the runs map/ and query/ that facetloc_simulate makes of the scene, MAP the map of
// the first, CHANGES the list for the second one. A point of a moved surface can be known if one side has
// measured it (a local model, for surfaces that are gone; an image of the query, for new ones), and two or
// more images of the other side measure something behind it, and more of them than measure it.
#include "base/text.h"
#include "measured_points.h"
#include "programs.h"

#include <facetloc/io/map_database.h>
#include <facetloc/simulation/simulated_place.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace facetloc;
using namespace facetloc::benchmarks;

constexpr double kSpacing = 0.05;  // spacing of the examined points [m]
constexpr double kNear = 0.1;      // error of a listed surface [m]
constexpr PointComparison kComparison{0.5, 6, 0.1};

/** A line of the list. */
struct Change {
  std::string kind;
  double area = 0, probability = 0;
  std::vector<Eigen::Vector3d> outline;

  Eigen::Matrix3d axes() const {  // the last one is the normal
    Eigen::Matrix3d R;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (std::size_t i = 1; i + 1 < outline.size(); ++i)
      normal += (outline[i] - outline[0]).cross(outline[i + 1] - outline[0]);
    R.col(2) = normal.normalized();
    R.col(0) = R.col(2).unitOrthogonal();
    R.col(1) = R.col(2).cross(R.col(0));
    return R;
  }
  bool covers(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d n = axes().col(2);
    if (std::abs(n.dot(p - outline[0])) > kNear) return false;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector3d along = (outline[(i + 1) % outline.size()] - outline[i]).normalized();
      if (n.dot(along.cross(p - outline[i])) < -kSpacing) return false;
    }
    return true;
  }
  std::vector<Eigen::Vector3d> points() const {
    const Eigen::Matrix3d R = axes();
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector3d& p : outline) box.extend((R.transpose() * (p - outline[0])).head<2>());
    std::vector<Eigen::Vector3d> all;
    for (double x = box.min().x() + kSpacing / 2; x < box.max().x(); x += kSpacing)
      for (double y = box.min().y() + kSpacing / 2; y < box.max().y(); y += kSpacing)
        if (const Eigen::Vector3d p = outline[0] + R.col(0) * x + R.col(1) * y; covers(p)) all.push_back(p);
    return all;
  }
};

std::vector<Change> changesOf(const fs::path& path) {
  std::ifstream in(path);
  std::vector<Change> changes;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    Change change;
    const auto cells = text::split(line, ',');
    change.kind = cells[0];
    change.area = text::to<double>(cells.at(1)).value();
    change.probability = text::to<double>(cells.at(2)).value();
    for (const std::string_view corner : text::split(cells.back(), ';')) {
      Eigen::Vector3d p;
      std::istringstream(std::string(corner)) >> p.x() >> p.y() >> p.z();
      change.outline.push_back(p);
    }
    if (change.outline.size() > 2) changes.push_back(change);
  }
  return changes;
}

/** The things that only the first of two worlds has. */
SimulatedWorld onlyIn(const SimulatedWorld& world, const SimulatedWorld& other) {
  SimulatedWorld only;
  for (const Rectangle& r : world.rectangles)
    if (std::none_of(other.rectangles.begin(), other.rectangles.end(),
                     [&](const Rectangle& o) { return o.plane_id == r.plane_id; }))
      only.rectangles.push_back(r);
  for (const RoundBody& b : world.bodies)
    if (std::none_of(other.bodies.begin(), other.bodies.end(),
                     [&](const RoundBody& o) { return o.T_w_b.isApprox(b.T_w_b); }))
      only.bodies.push_back(b);
  return only;
}

bool isOn(const SimulatedWorld& world, const Eigen::Vector3d& p) {
  const auto on = [&](const Rectangle& r) {
    const Eigen::Vector3d d = p - r.centre;
    return std::abs(r.normal().dot(d)) < kNear && std::abs(r.axis_u.dot(d)) < r.half_u + kNear &&
           std::abs(r.axis_v.dot(d)) < r.half_v + kNear;
  };
  const auto beside = [&](const RoundBody& b) {
    const Eigen::Vector3d half = b.half_size.array() + kNear;
    return ((b.T_w_b.inverse() * p).cwiseAbs().array() < half.array()).all();
  };
  return std::any_of(world.rectangles.begin(), world.rectangles.end(), on) ||
         std::any_of(world.bodies.begin(), world.bodies.end(), beside);
}

void score(const std::string& kind, const SimulatedWorld& moved, const std::vector<Look>& own,
           const std::vector<Look>& others, const std::vector<Change>& changes) {
  double knowable = 0, known = 0, listed = 0, right = 0;
  for (const Rectangle& r : moved.rectangles) {
    if (r.material == Material::glass) continue;
    for (double u = kSpacing / 2 - r.half_u; u < r.half_u; u += kSpacing)
      for (double v = kSpacing / 2 - r.half_v; v < r.half_v; v += kSpacing) {
        const Eigen::Vector3d p = r.centre + r.axis_u * u + r.axis_v * v;
        if (measured(p, own, kComparison).at_it == 0) continue;
        if (!measured(p, others, kComparison).isLookedThrough()) continue;
        knowable += kSpacing * kSpacing;
        known += kSpacing * kSpacing * std::any_of(changes.begin(), changes.end(), [&](const Change& c) {
                   return c.kind == kind && c.covers(p);
                 });
      }
  }
  constexpr double kLevels[] = {0.5, 0.8, 0.9, 0.95, 0.99, 1.01};
  std::vector<double> areas(std::size(kLevels) - 1, 0), rights(areas.size(), 0);
  for (const Change& c : changes) {
    if (c.kind != kind) continue;
    const std::vector<Eigen::Vector3d> points = c.points();
    const auto on =
        std::count_if(points.begin(), points.end(), [&](const Eigen::Vector3d& p) { return isOn(moved, p); });
    const double share = points.empty() ? 0 : static_cast<double>(on) / static_cast<double>(points.size());
    listed += c.area, right += share * c.area;
    for (std::size_t i = 0; i < areas.size(); ++i)
      if (c.probability >= kLevels[i] && c.probability < kLevels[i + 1])
        areas[i] += c.area, rights[i] += share * c.area;
  }
  std::printf("%-8s knowable %7.2f m2, recall %5.1f %%; listed %7.2f m2, precision %5.1f %%; by probability",
              kind.c_str(), knowable, 100 * known / std::max(1e-9, knowable), listed,
              100 * right / std::max(1e-9, listed));
  for (std::size_t i = 0; i < areas.size(); ++i)
    std::printf("  %.2f: %.2f of %.2f", kLevels[i], rights[i], areas[i]);
  std::printf("\n");
}

void score(const std::string& scene, std::uint64_t seed, const fs::path& place, const fs::path& map,
           const fs::path& list) {
  const SimulatedPlace truth = simulatedPlace(scene, seed);
  std::set<std::string> names;
  for (const LocalModel& model : readMap(map).models) names.insert(model.name);
  const std::vector<Look> models = looksOf(place / "map", names), images = looksOf(place / "query", {});
  const std::vector<Change> changes = changesOf(list);
  score("removed", onlyIn(truth.mapped, truth.later), models, images, changes);
  score("new", onlyIn(truth.later, truth.mapped), images, models, changes);
}

}  // namespace

int main(int argc, char** argv) {
  return runProgram("score_changes", [&] {
    if (argc != 6) throw Usage{"score_changes SCENE SEED PLACE MAP.flmap CHANGES.csv"};
    score(argv[1], std::stoull(argv[2]), argv[3], argv[4], argv[5]);
  });
}
