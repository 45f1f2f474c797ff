// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/rtabmap_database.h"

#include "bytes/files.h"
#include "bytes/plausible.h"
#include "bytes/sqlite.h"
#include "recordings/depth_messages.h"
#include "recordings/rtabmap_blobs.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <mutex>
#include <vector>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

constexpr double kMillimetres = 1000;  // values per metre

ByteView viewOf(const sqlite::Blob& blob) { return {blob.data(), blob.size()}; }

/** A node of the graph with a depth image. */
struct Node {
  int id = 0;
  double stamp = 0;
  std::optional<Eigen::Isometry3d> T_w_c;
};

class RtabmapDatabase : public ImageContainer {
public:
  explicit RtabmapDatabase(const fs::path& path) : path_(path), db_(opened(path)) {
    guarded([this] {
      const auto graph = readGraph();
      has_graph_ = !graph.empty();
      listNodes(graph);
    });
    if (nodes_.empty()) fail("has no depth images");
    separateTimes();
    scaleCamera();
  }

  std::size_t size() const override { return nodes_.size(); }
  double stamp(std::size_t index) const override { return nodes_.at(index).stamp; }
  fs::path path(std::size_t) const override { return path_; }
  std::optional<Eigen::Isometry3d> pose(std::size_t index) const override { return nodes_.at(index).T_w_c; }

  CameraFile camera() const override {
    const CameraPreset& preset = cameraPresets().front();
    CameraFile camera;
    camera.camera = preset.camera();
    camera.preset = preset.name;
    camera.camera.intrinsics = intrinsics_;
    camera.depth_scale = kMillimetres;
    return camera;
  }

  DepthImage read(std::size_t index) const override {
    return depthImageOf(values(nodes_.at(index)), kMillimetres);
  }

  std::string remark() const override {
    const auto posed = std::count_if(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.T_w_c; });
    std::string words = fmt::format("{}: a database of RTAB-Map; {} of its {} images have poses, of its {}",
                                    path_.string(), posed, nodes_.size(),
                                    has_graph_ ? "optimised graph" : "odometry, since no graph was saved");
    if (numbered_) words += "; its images have no times and are taken to be 1 s apart";
    if (other_focal_length_ > kSameFocalLength)
      words +=
          fmt::format("; the camera of the first image is used; others differ by up to {:.1f} % in focal "
                      "length",
                      100 * other_focal_length_);
    return words;
  }

private:
  static constexpr double kSameFocalLength = 1e-3;  // relative

  [[noreturn]] void fail(const std::string& cause) const { throw IoError(path_.string(), cause); }

  static sqlite::Connection opened(const fs::path& path) {
    files::requireRegularFile(path);
    return {path, SQLITE_OPEN_READONLY};
  }

  /** A file that SQLite rejects is no database of RTAB-Map. */
  template <typename Work>
  auto guarded(const Work& work) const -> decltype(work()) {
    try {
      return work();
    } catch (const sqlite::BadCell& e) {
      fail(std::string("is no sound database of RTAB-Map: ") + e.what());
    } catch (const IoError&) {
      if ((db_.lastCode() & 0xFF) != SQLITE_ERROR) throw;
      fail("is no database of RTAB-Map, or of a version before 0.12: it lacks Node or Data as these are now; "
           "export it with rtabmap-export --images --poses_camera, whose folder can be read");
    }
  }

  /** Graph of the last row that has one. */
  std::map<int, Eigen::Isometry3d> readGraph() {
    sqlite::Statement has(db_, "SELECT count(*) FROM pragma_table_info('Admin') WHERE name = 'opt_poses'");
    if (!has.step() || has.integer() == 0) return {};  // older than 0.17
    sqlite::Statement row(db_, "SELECT opt_ids, opt_poses FROM Admin WHERE length(opt_ids) > 0 AND "
                               "length(opt_poses) > 0 ORDER BY rowid DESC LIMIT 1");
    if (!row.step()) return {};
    const sqlite::Blob ids = row.blob(), poses = row.blob();
    return readRtabmapGraph(viewOf(ids), viewOf(poses), path_.string());
  }

  void listNodes(const std::map<int, Eigen::Isometry3d>& graph) {
    sqlite::Statement row(db_, "SELECT Node.id, Node.stamp, Node.pose, Data.calibration FROM Node "
                               "JOIN Data ON Data.id = Node.id WHERE length(Data.depth) > 0 "
                               "ORDER BY Node.stamp, Node.id");
    while (row.step()) {
      Node node;
      node.id = row.integer();
      node.stamp = row.realOrNull().value_or(0);
      if (!plausible::isStamp(node.stamp)) fail(fmt::format("node {} has an impossible time", node.id));
      const sqlite::Blob pose = row.isNull() ? row.skip(1), sqlite::Blob() : row.blob();
      const sqlite::Blob calibration = row.isNull() ? sqlite::Blob() : row.blob();
      const std::string name = fmt::format("{}: node {}", path_.string(), node.id);
      const RtabmapCamera camera = readRtabmapCamera(viewOf(calibration), name);
      note(camera.intrinsics);
      std::optional<Eigen::Isometry3d> T_w_b;
      if (!has_graph_)
        T_w_b = readRtabmapPose(viewOf(pose), name);
      else if (const auto found = graph.find(node.id); found != graph.end())
        T_w_b = found->second;
      if (T_w_b) node.T_w_c = *T_w_b * camera.T_b_c;
      nodes_.push_back(node);
    }
  }

  void note(const Intrinsics& of_node) {
    if (!intrinsics_.valid()) intrinsics_ = of_node;
    other_focal_length_ = std::max(other_focal_length_, std::abs(of_node.fx / intrinsics_.fx - 1));
  }

  /** Images without times are in the order of their nodes. */
  void separateTimes() {
    const auto later = [](const Node& a, const Node& b) { return a.stamp >= b.stamp; };
    numbered_ = std::adjacent_find(nodes_.begin(), nodes_.end(), later) != nodes_.end();
    if (!numbered_) return;
    std::sort(nodes_.begin(), nodes_.end(), [](const Node& a, const Node& b) { return a.id < b.id; });
    for (Node& node : nodes_) node.stamp = node.id;
  }

  /** The calibration is of the colour images; those of depth may be smaller. */
  void scaleCamera() {
    const StoredDepth first = values(nodes_.front());
    Intrinsics& k = intrinsics_;
    const double x = double(first.width) / k.width, y = double(first.height) / k.height;
    k = {first.width, first.height, x * k.fx, y * k.fy, x * k.cx, y * k.cy};
  }

  StoredDepth values(const Node& node) const {
    const sqlite::Blob depth = guarded([&] {
      const std::lock_guard lock(mutex_);
      sqlite::Statement row(db_, fmt::format("SELECT depth FROM Data WHERE id = {}", node.id));
      if (!row.step()) throw sqlite::BadCell("an image has been deleted since the file was opened");
      return row.blob();
    });
    return readRtabmapDepth(viewOf(depth), fmt::format("{}: node {}", path_.string(), node.id));
  }

  fs::path path_;
  mutable sqlite::Connection db_;
  mutable std::mutex mutex_;  // a connection is for one thread at a time
  bool has_graph_ = false, numbered_ = false;
  double other_focal_length_ = 0;  // largest relative difference to the first
  Intrinsics intrinsics_;
  std::vector<Node> nodes_;
};

}  // namespace

std::shared_ptr<const ImageContainer> openRtabmapDatabase(const fs::path& path) {
  return std::make_shared<const RtabmapDatabase>(path);
}

}  // namespace facetloc::internal
