// SPDX-License-Identifier: BSD-3-Clause
//
// Does a later session take out of a map what has moved, and nothing else?
//
//   score_sessions PLACE BEFORE.flmap AFTER.flmap
//
// PLACE is a folder with the runs map/ and query/ and their labels, as facetloc_simulate makes them. BEFORE
// is the map of the first run, AFTER the same extended by the second one. Each segment of BEFORE is of the
// true plane that most of its pixels show, and has moved if that plane is not there in the second run. It is
// seen again if at least two images of the second run look at its place, and nothing hides it.
#include "measured_points.h"
#include "programs.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/png.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

namespace {

namespace fs = std::filesystem;
using namespace facetloc;
using namespace facetloc::benchmarks;

constexpr double kThick = 0.03;       // thickness of a segment [m]
constexpr double kSameNormal = 0.97;  // cosine between a segment's normal and its true plane's
constexpr double kOfPlane = 0.1;      // distance of a segment from its true plane [m]
constexpr PointComparison kComparison{0.3, 6, 0.05};
constexpr int kSpacing = 2;               // spacing of the examined pixels of a segment [px]
constexpr std::size_t kFewestPoints = 8;  // points of a true plane in a segment

/** The true planes of a run: normal and distance from the origin. */
std::map<int, Eigen::Vector4d> planesOf(const fs::path& run) {
  std::ifstream in(run / "planes.csv");
  std::map<int, Eigen::Vector4d> planes;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    int plane = 0;
    Eigen::Vector4d n;
    if (std::sscanf(line.c_str(), "%d,%lf,%lf,%lf,%lf", &plane, &n[0], &n[1], &n[2], &n[3]) == 5)
      planes[plane] = n;
  }
  return planes;
}

/** The truth about a segment. */
struct Truth {
  int plane = 0;                        // that most of its pixels show; 0 = none
  std::vector<Eigen::Vector3d> points;  // some of these pixels, in the camera's frame
};

Truth truthOf(const Segment& segment, const DepthImage& image, const Raster<std::uint16_t>& labels) {
  const int step = labels.width / image.camera.width;
  std::map<int, std::vector<Eigen::Vector3d>> points;
  for (int v = 0; v < image.camera.height; v += kSpacing)
    for (int u = 0; u < image.camera.width; u += kSpacing) {
      const float z = image.at(u, v);
      if (!isMeasured(z)) continue;
      const Eigen::Vector3d p = z * image.camera.ray(u, v);
      const Eigen::Vector3d in_plane = segment.R.transpose() * (p - segment.t);
      if (std::abs(in_plane.z()) < kThick && segment.hull.contains(in_plane.head<2>().cast<float>()))
        points[labels.data[static_cast<std::size_t>(v) * step * labels.width + u * step]].push_back(p);
    }
  points.erase(0);
  const auto most = std::max_element(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.second.size() < b.second.size();
  });
  if (most == points.end() || most->second.size() < kFewestPoints) return {};
  return {most->first, most->second};
}

/** Is most of a segment looked through? */
bool isLookedThrough(const std::vector<Eigen::Vector3d>& points, const std::vector<Look>& looks) {
  const auto through = std::count_if(points.begin(), points.end(), [&](const Eigen::Vector3d& p) {
    return measured(p, looks, kComparison).isLookedThrough();
  });
  return 2 * through > static_cast<std::ptrdiff_t>(points.size());
}

struct Count {
  int all = 0, gone = 0, through = 0, through_gone = 0, replaced = 0;
};

void print(const char* name, const Count& c) {
  std::printf("%-10s %6d %6d %6.1f %% %15d %9d %6.1f %% %9d\n", name, c.all, c.gone,
              100.0 * c.gone / std::max(1, c.all), c.through, c.through_gone,
              100.0 * c.through_gone / std::max(1, c.through), c.replaced);
}

void score(const fs::path& place, const fs::path& before_path, const fs::path& after_path) {
  const Map before = readMap(before_path), after = readMap(after_path);
  std::map<std::string, int> kept;
  for (std::size_t i = 0; i < after.models.size(); ++i) kept[after.models[i].name] = static_cast<int>(i);
  const std::vector<Look> looks = looksOf(place / "query", {});
  const DepthSequence run = DepthSequence::open(place / "map");
  std::map<std::string, std::size_t> frame;
  for (std::size_t i = 0; i < run.frames().size(); ++i) frame[run.frames()[i].name] = i;
  const auto planes = planesOf(place / "map"), later = planesOf(place / "query");

  Count moved, unmoved;
  for (std::size_t i = 0; i < before.models.size(); ++i) {
    const LocalModel& model = before.models[i];
    const DepthImage image = run.load(frame.at(model.name), kWorkingWidth);
    const auto labels = readGreyPng(place / "map/labels" / (model.name + ".png"));
    const auto found = kept.find(model.name);
    const std::vector<Segment> segments_kept =
        found == kept.end() ? std::vector<Segment>() : after.view(found->second)->segments;
    for (const Segment& s : before.view(static_cast<int>(i))->segments) {
      const Truth truth = truthOf(s, image, labels);
      const auto plane = planes.find(truth.plane);
      if (plane == planes.end()) continue;
      // A surface that is no plane, such as a bin, has no label, and the surface behind it has another place.
      const Eigen::Vector3d n = plane->second.head<3>();
      if (std::abs(n.dot(model.T_w_m->linear() * s.normal())) < kSameNormal ||
          std::abs(n.dot(*model.T_w_m * s.t) - plane->second[3]) > kOfPlane)
        continue;
      std::vector<Eigen::Vector3d> points;
      for (const Eigen::Vector3d& p : truth.points) points.push_back(*model.T_w_m * p);
      Count& count = later.count(truth.plane) ? unmoved : moved;
      const bool is_kept = found != kept.end() &&
                           std::any_of(segments_kept.begin(), segments_kept.end(), [&](const Segment& k) {
                             return (k.t - s.t).norm() < 1e-6 && k.num_points == s.num_points;
                           });
      // Surfaces replaced by a new view are gone, unless they have not moved, which the new view also shows.
      const bool is_replaced = found == kept.end();
      const bool is_gone = &count == &moved ? !is_kept : !is_kept && !is_replaced;
      const bool through = isLookedThrough(points, looks);
      ++count.all, count.gone += is_gone, count.through += through;
      count.through_gone += through && is_gone, count.replaced += is_replaced;
    }
  }
  std::printf("%zu local models before, %zu after\n", before.models.size(), after.models.size());
  std::printf("%-10s %6s %6s %8s %15s %9s %8s %9s\n", "segments", "all", "gone", "", "looked through",
              "and gone", "", "replaced");
  print("moved", moved);
  print("not moved", unmoved);
}

}  // namespace

int main(int argc, char** argv) {
  return runProgram("score_sessions", [&] {
    if (argc != 4) throw Usage{"score_sessions PLACE BEFORE.flmap AFTER.flmap"};
    score(argv[1], argv[2], argv[3]);
  });
}
