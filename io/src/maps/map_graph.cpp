// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"
#include "results/pose_columns.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/features/map_parts.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/segment_file.h>
#include <facetloc/io/trajectory.h>

#include <Eigen/Cholesky>

#include <cctype>
#include <fmt/format.h>
#include <optional>
#include <ostream>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

constexpr std::string_view kVertex = "VERTEX_SE3:QUAT", kEdge = "EDGE_SE3:QUAT";
constexpr double kQuaternionTolerance = 1e-2;  // tolerance of |q|^2: g2o writes six digits
constexpr double kVarianceFloor =
    1e-12;  // [rad^2, m^2] of links that are known exactly: g2o wants finite information

void printPose(std::ostream& out, const Eigen::Isometry3d& T) {
  for (const double value : toColumns(T)) out << ' ' << text::significant(value);
}

/** Information of a link in g2o's terms.
 *
 * g2o's error of an edge Z between poses of relative pose X is e = (translation, quaternion vector) of Z^-1
 * X. With our left, decoupled perturbation X = (Exp(dphi) R, t + dt) of Z = (R, t) that is e = (R^T dt, R^T
 * dphi / 2), hence (dphi, dt) = A e with A = [0 2R; R 0], and the information of e is A^T P^-1 A. */
Matrix6d g2oInformation(const PoseWithCovariance& link) {
  const Eigen::Matrix3d R = link.T.linear();
  Matrix6d A = Matrix6d::Zero();
  A.topRightCorner<3, 3>() = 2 * R;
  A.bottomLeftCorner<3, 3>() = R;
  Eigen::LLT<Matrix6d> P(link.P);
  if (P.info() != Eigen::Success) P.compute(link.P + kVarianceFloor * Matrix6d::Identity());
  if (P.info() != Eigen::Success)
    throw std::invalid_argument("writeGraph: the covariance of a link is negative");
  return A.transpose() * P.solve(A);
}

/** Warnings about the pose of a vertex for its user. */
std::string commentOf(const Map& map, int model) {
  const LocalModel& m = map.models[static_cast<std::size_t>(model)];
  if (!m.T_w_m) return "# the pose of the next vertex is unknown\n";
  if (!m.by_links) return {};
  const std::string part = map.partOf(model).empty() ? "" : fmt::format(", in the frame of part {}", m.part);
  return fmt::format("# the pose of the next vertex follows from links{}\n", part);
}

/** The id and the pose of a line. Throws std::invalid_argument. */
std::pair<int, Eigen::Isometry3d> vertexOf(const std::vector<std::string_view>& words) {
  constexpr std::size_t kWords = 2 + std::tuple_size<PoseColumns>::value;
  if (words.size() != kWords)
    throw std::invalid_argument(fmt::format("has {} words instead of {}", words.size(), kWords));
  const auto id = text::to<int>(words[1]);
  if (!id) throw std::invalid_argument(text::quoted(words[1]) + " is no index of a local model");
  PoseColumns columns;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto value = text::to<double>(words[2 + i]);
    if (!value) throw std::invalid_argument(text::quoted(words[2 + i]) + " is not a number");
    columns[i] = *value;
  }
  return {*id, fromColumns(columns, kQuaternionTolerance)};
}

/** Poses by index of the local model. */
std::vector<std::optional<Eigen::Isometry3d>> verticesOf(const fs::path& path, std::size_t models) {
  std::vector<std::optional<Eigen::Isometry3d>> poses(models);
  files::forEachLine(files::readText(path), path.string(), [&](std::string_view line) {
    const auto words = text::words(text::withoutComment(line));
    if (words.empty() || words[0] != kVertex) return;
    const auto [id, T] = vertexOf(words);
    if (id < 0 || static_cast<std::size_t>(id) >= models)
      throw std::invalid_argument(fmt::format("the map has no local model {}", id));
    auto& pose = poses[static_cast<std::size_t>(id)];
    if (pose) throw std::invalid_argument(fmt::format("local model {} has a vertex already", id));
    pose = T;
  });
  return poses;
}

constexpr const char* kGraph = "graph.g2o";

/** A name that is a file name everywhere, and no other model's. */
std::string fileName(const std::string& name, std::set<std::string>& taken) {
  std::string safe = name;
  for (char& c : safe)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-' && c != '_') c = '_';
  if (safe.empty() || safe.front() == '.') safe.insert(0, "_");
  while (!taken.insert(safe).second) safe += "_";
  return safe;
}

std::vector<StampedPose> posesOf(const Map& map) {
  std::vector<StampedPose> poses;
  for (const LocalModel& model : map.models)
    if (const auto T_w_m = model.givenPose()) poses.push_back({model.stamp, *T_w_m});
  return poses;
}

}  // namespace

void writeGraph(const fs::path& path, const Map& map) {
  writeTextAtomically(path, [&map](std::ostream& out) {
    for (std::size_t i = 0; i < map.models.size(); ++i) {
      out << commentOf(map, static_cast<int>(i)) << kVertex << ' ' << i;
      printPose(out, map.models[i].T_w_m.value_or(Eigen::Isometry3d::Identity()));
      out << '\n';
    }
    for (const Link& link : map.links) {
      out << kEdge << ' ' << link.from << ' ' << link.to;
      printPose(out, link.T_from_to.T);
      const Matrix6d information = g2oInformation(link.T_from_to);
      for (int row = 0; row < 6; ++row)
        for (int col = row; col < 6; ++col) out << ' ' << text::significant(information(row, col));
      out << '\n';
    }
  });
}

void readGraphPoses(const fs::path& path, Map& map) {
  const auto poses = verticesOf(path, map.models.size());
  bool any = false;
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const int model = static_cast<int>(i);
    if (!map.partOf(model).empty()) continue;
    if (!poses[i])
      throw IoError(path.string(),
                    fmt::format("has no vertex of local model {} ('{}')", i, map.models[i].name));
    any = true;
  }
  if (!any) throw IoError(path.string(), "cannot give the map a world: its parts are not joined by links");
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    if (!map.partOf(static_cast<int>(i)).empty()) continue;
    map.models[i].T_w_m = poses[i];
    map.models[i].by_links = false;
  }
  placeByLinks(map);
  map.meta.erase(kSureKey);
}

void exportMap(const Map& map, const fs::path& folder) {
  createFolders(folder / "models");
  if (fs::exists(folder / kGraph))  // left by an earlier export
    for (const auto& entry : fs::directory_iterator(folder / "models"))
      if (entry.path().extension() == ".pcd") fs::remove(entry.path());
  std::set<std::string> taken;
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const std::string name = fileName(map.models[i].name, taken);
    const auto view = map.view(static_cast<int>(i));
    if (view->segments.empty()) continue;  // PCL writes no empty clouds
    writeSegments(folder / "models" / (name + ".pcd"), view->segments);
  }
  writeTumTrajectory(folder / "poses_tum.txt", posesOf(map));
  writeGraph(folder / kGraph, map);
}

}  // namespace facetloc
