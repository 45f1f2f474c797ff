// SPDX-License-Identifier: BSD-3-Clause
#include "pose_columns.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/map_export.h>
#include <facetloc/io/segment_file.h>
#include <facetloc/io/text.h>
#include <facetloc/io/trajectory.h>

#include <Eigen/Cholesky>

#include <cctype>
#include <set>
#include <stdexcept>
#include <string>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGraph = "graph.g2o";
constexpr double kVarianceFloor =
    1e-12;  // [rad^2, m^2] of links that are known exactly: g2o wants finite information

/** A name that is a file name everywhere, and no other model's. */
std::string fileName(const std::string& name, std::set<std::string>& taken) {
  std::string safe = name;
  for (char& c : safe)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-' && c != '_') c = '_';
  if (safe.empty() || safe.front() == '.') safe.insert(0, "_");
  while (!taken.insert(safe).second) safe += "_";
  return safe;
}

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
    throw std::invalid_argument("exportMap: the covariance of a link is negative");
  return A.transpose() * P.solve(A);
}

void writeGraph(std::ostream& out, const Map& map) {
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const auto& T_w_m = map.models[i].T_w_m;
    if (!T_w_m) out << "# the pose of the next vertex is unknown\n";
    if (map.models[i].by_links) out << "# the pose of the next vertex follows from links\n";
    out << "VERTEX_SE3:QUAT " << i;
    printPose(out, T_w_m.value_or(Eigen::Isometry3d::Identity()));
    out << '\n';
  }
  for (const Link& link : map.links) {
    out << "EDGE_SE3:QUAT " << link.from << ' ' << link.to;
    printPose(out, link.T_from_to.T);
    const Matrix6d information = g2oInformation(link.T_from_to);
    for (int row = 0; row < 6; ++row)
      for (int col = row; col < 6; ++col) out << ' ' << text::significant(information(row, col));
    out << '\n';
  }
}

std::vector<StampedPose> posesOf(const Map& map) {
  std::vector<StampedPose> poses;
  for (const LocalModel& model : map.models)
    if (const auto T_w_m = model.givenPose()) poses.push_back({model.stamp, *T_w_m});
  return poses;
}

}  // namespace

void exportMap(const Map& map, const std::filesystem::path& folder) {
  createFolders(folder / "models");
  if (std::filesystem::exists(folder / kGraph))  // of an earlier export
    for (const auto& entry : std::filesystem::directory_iterator(folder / "models"))
      if (entry.path().extension() == ".pcd") std::filesystem::remove(entry.path());
  std::set<std::string> taken;
  for (std::size_t i = 0; i < map.models.size(); ++i) {
    const std::string name = fileName(map.models[i].name, taken);
    const auto view = map.view(static_cast<int>(i));
    if (view->segments.empty()) continue;  // PCL writes no empty clouds
    writeSegments(folder / "models" / (name + ".pcd"), view->segments);
  }
  writeTumTrajectory(folder / "poses_tum.txt", posesOf(map));
  writeTextAtomically(folder / kGraph, [&](std::ostream& out) { writeGraph(out, map); });
}

}  // namespace facetloc
