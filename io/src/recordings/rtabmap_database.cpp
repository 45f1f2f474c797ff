// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "bytes/plausible.h"
#include "bytes/sqlite.h"
#include "images/depth_blob.h"
#include "recordings/depth_messages.h"
#include "recordings/image_container.h"
#include "recordings/pose_table.h"
#include "recordings/recording_layout.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/features/depth_image.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <vector>

namespace facetloc::internal {
namespace {

constexpr std::size_t kPoseNumbers = 12;

std::optional<Eigen::Isometry3d> poseOf(const float* numbers, const std::string& name) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  for (int k = 0; k < static_cast<int>(kPoseNumbers); ++k) m(k / 4, k % 4) = numbers[k];
  if (!m.allFinite() || m.topLeftCorner<3, 3>().isZero()) return {};
  try {
    return poseOfMatrix(m, "has a pose that ");
  } catch (const std::invalid_argument& e) {
    throw IoError(name, e.what());
  }
}

/** A matrix of OpenCV with numbers of 4 bytes. */
template <typename Number>
std::vector<Number> unpacked(ByteView packed, const std::string& name) {
  constexpr std::size_t kSizes = 3 * sizeof(std::int32_t);
  constexpr std::uint64_t kMostTimes = 1032;  // that zlib makes of one byte
  std::int32_t sizes[3] = {};                 // rows, columns, type
  if (packed.size > kSizes) std::memcpy(sizes, packed.data + packed.size - kSizes, kSizes);
  const std::uint64_t n = std::uint64_t(std::max(sizes[0], 0)) * std::uint64_t(std::max(sizes[1], 0));
  if (n == 0 || n > kMostTimes * packed.size) throw IoError(name, "has a corrupt graph");
  std::vector<Number> numbers(n);
  if (!depth_blob::unpack(packed.data, packed.size - kSizes, numbers.data(), n * sizeof(Number)))
    throw IoError(name, "has a corrupt graph");
  return numbers;
}

RtabmapCamera cameraOf(MessageReader& fields) {
  fields.skip<std::int32_t>(3);  // version
  if (fields.number<std::int32_t>() != 0) throw BadMessage("is a stereo camera's, whose depth is not stored");
  RtabmapCamera camera;
  Intrinsics& k = camera.intrinsics;
  k.width = fields.number<std::int32_t>(), k.height = fields.number<std::int32_t>();
  std::array<std::int32_t, 5> sizes;  // sizes of K, D, R, P and the local transform
  for (std::int32_t& size : sizes) size = fields.number<std::int32_t>();
  if ((sizes[0] != 0 && sizes[0] != 9) || sizes[1] < 0 || sizes[2] < 0 || (sizes[3] != 0 && sizes[3] != 12) ||
      (sizes[4] != 0 && sizes[4] != static_cast<std::int32_t>(kPoseNumbers)))
    throw BadMessage("is corrupt, or was written by a version before 0.12");
  if (sizes[0] > 0) {
    const auto K = fields.reals<9>();
    k.fx = K[0], k.fy = K[4], k.cx = K[2], k.cy = K[5];
  }
  fields.skip<double>(static_cast<std::size_t>(sizes[1]) + static_cast<std::size_t>(sizes[2]));
  if (sizes[3] > 0) {  // its images are rectified
    const auto P = fields.reals<12>();
    if (P[0] > 0) k.fx = P[0], k.fy = P[5], k.cx = P[2], k.cy = P[6];
  }
  if (!k.valid()) throw BadMessage("has no intrinsics");
  if (sizes[4] > 0) {
    float numbers[kPoseNumbers];
    for (float& number : numbers) number = fields.number<float>();
    if (const auto T = poseOf(numbers, "")) camera.T_b_c = *T;
  }
  return camera;
}

}  // namespace

RtabmapCamera readRtabmapCamera(ByteView bytes, const std::string& name) {
  try {
    MessageReader fields(bytes, WireFormat::ros1);  // packed the same way
    const RtabmapCamera camera = cameraOf(fields);
    if (!fields.atEnd()) throw BadMessage("has several cameras, and facetloc takes one");
    return camera;
  } catch (const BadMessage& e) {
    throw IoError(name, std::string("its calibration ") + e.what());
  } catch (const IoError&) {
    throw IoError(name, "its calibration has a local transform that is not a pose");
  }
}

std::optional<Eigen::Isometry3d> readRtabmapPose(ByteView bytes, const std::string& name) {
  float numbers[kPoseNumbers];
  if (bytes.size == 0) return {};
  if (bytes.size != sizeof numbers)
    throw IoError(name, fmt::format("has a pose of {} bytes instead of {}", bytes.size, sizeof numbers));
  std::memcpy(numbers, bytes.data, sizeof numbers);
  return poseOf(numbers, name);
}

std::map<int, Eigen::Isometry3d> readRtabmapGraph(ByteView ids, ByteView poses, const std::string& name) {
  const auto nodes = unpacked<std::int32_t>(ids, name);
  const auto numbers = unpacked<float>(poses, name);
  if (numbers.size() != kPoseNumbers * nodes.size())
    throw IoError(name, "has a graph of other nodes than poses");
  std::map<int, Eigen::Isometry3d> graph;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (const auto T = poseOf(numbers.data() + kPoseNumbers * i, name)) graph.emplace(nodes[i], *T);
  return graph;
}

StoredDepth readRtabmapDepth(ByteView bytes, const std::string& name) {
  constexpr char kRvl[] = "DEPTHRVL";
  constexpr std::size_t kRvlSize = sizeof kRvl - 1;
  if (bytes.size > kRvlSize && std::memcmp(bytes.data, kRvl, kRvlSize) == 0)
    return readRvl({bytes.data + kRvlSize, bytes.size - kRvlSize}, name);
  if (!isRgbaPng(bytes.data, bytes.size)) return readPngValues(bytes, name);
  const Raster<std::uint8_t> raster = readRgbaPng(bytes.data, bytes.size, name);
  StoredDepth image{raster.width, raster.height, {}, {}};
  image.metres.resize(raster.data.size() / sizeof(float));
  for (std::size_t i = 0; i < image.metres.size(); ++i) {
    const std::uint8_t* rgba = raster.data.data() + sizeof(float) * i;
    const std::uint8_t bytes_of_float[] = {rgba[2], rgba[1], rgba[0], rgba[3]};  // OpenCV's order
    float z = 0;
    std::memcpy(&z, bytes_of_float, sizeof z);
    image.metres[i] = isMeasured(z) ? z : 0;
  }
  return image;
}

namespace {

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
    return cameraFileOf(intrinsics_, kMillimetres, cameraPresets().front());
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
    return readRtabmapGraph(ids, poses, path_.string());
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
      const RtabmapCamera camera = readRtabmapCamera(calibration, name);
      note(camera.intrinsics);
      std::optional<Eigen::Isometry3d> T_w_b;
      if (!has_graph_)
        T_w_b = readRtabmapPose(pose, name);
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
    return readRtabmapDepth(depth, fmt::format("{}: node {}", path_.string(), node.id));
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
