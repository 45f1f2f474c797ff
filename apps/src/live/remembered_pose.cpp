// SPDX-License-Identifier: BSD-3-Clause
#include "live/remembered_pose.h"

#include "inputs/robot_line.h"
#include "outputs/pose_stream.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <fstream>
#include <json/json.h>
#include <ostream>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

constexpr std::chrono::seconds kInterval(1);  // between writings
constexpr std::size_t kLongest = 1 << 16;     // bytes of a file that holds a line
constexpr std::size_t kKeptModels = 16;       // local models that a later run knows the map by
constexpr double kSamePlace = 0.1;  // tolerance: an extension may correct the pose of a local model [m]
constexpr const char* kModelsKey = "near";

std::string firstBytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text(kLongest, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

std::string oneLine(const Json::Value& value) {
  Json::StreamWriterBuilder writer;
  writer["indentation"] = "";
  return Json::writeString(writer, value);
}

/** The line without the keys that only held then. */
std::string poseLine(const Json::Value& line) {
  Json::Value pose;
  pose["pose"]["T_w_c"] = line["T_w_c"];
  pose["pose"]["part"] = line["part"];
  return oneLine(pose);
}

/** The local models nearest to a pose in a part of the map, and where they are. */
Json::Value modelsNear(const Eigen::Vector3d& place, const std::string& part, const Map& map) {
  std::vector<std::pair<double, int>> found;
  for (int i = 0; i < static_cast<int>(map.models.size()); ++i)
    if (const auto& T = map.models[static_cast<std::size_t>(i)].T_w_m; T && map.partOf(i) == part)
      found.emplace_back((T->translation() - place).norm(), i);
  const std::size_t n = std::min(found.size(), kKeptModels);
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(n), found.end());
  Json::Value models(Json::objectValue);
  for (std::size_t k = 0; k < n; ++k) {
    const LocalModel& model = map.models[static_cast<std::size_t>(found[k].second)];
    for (const double coordinate : Eigen::Vector3d(model.T_w_m->translation()))
      models[model.name].append(coordinate);
  }
  return models;
}

bool isAt(const Json::Value& place, const LocalModel& model) {
  if (!model.T_w_m || !place.isArray() || place.size() != 3) return false;
  Eigen::Vector3d t;
  for (int k = 0; k < 3; ++k) {
    if (!place[k].isNumeric()) return false;
    t[k] = place[k].asDouble();
  }
  return (model.T_w_m->translation() - t).norm() <= kSamePlace;
}

/** Most of the local models are where they were: some may have been replaced. */
bool isOf(const Json::Value& models, const Map& map) {
  if (!models.isObject()) return false;
  std::size_t same = 0;
  for (const LocalModel& model : map.models)
    same += models.isMember(model.name) && isAt(models[model.name], model);
  return same > 0 && 2 * same >= models.size();
}

}  // namespace

RememberedPose::RememberedPose(std::filesystem::path file, std::shared_ptr<const Map> map,
                               const std::optional<CameraMounting>& mounting)
    : file_(std::move(file)), map_(std::move(map)), mounting_(mounting) {}

RememberedPose::~RememberedPose() try {
  write();
} catch (const std::exception&) {  // as much as possible was written
}

std::string RememberedPose::start() const {
  if (!std::filesystem::exists(file_)) return {};
  Json::Value text;
  std::string line;
  try {
    text = jsonOf(firstBytes(file_));
    line = poseLine(text);
    parseRobotLine(line, mounting_);
  } catch (const std::exception& e) {
    throw IoError(file_.string(), std::string("holds no pose of an earlier run: ") + e.what());
  }
  if (!isOf(text[kModelsKey], *map_))
    throw IoError(file_.string(), "holds a pose in another map, which is ignored");
  return line;
}

void RememberedPose::put(const FrameResult& frame) {
  const ResultRow& best = frame.rows.front();
  if (best.state != AnswerState::sure || !best.T_w_c) return;
  unwritten_ = frame;
  const auto now = std::chrono::steady_clock::now();
  if (written_ && now - *written_ < kInterval) return;
  write();
  written_ = now;
}

void RememberedPose::write() {
  if (!unwritten_) return;
  const ResultRow& best = unwritten_->rows.front();
  Json::Value line = jsonOf(toJson(*unwritten_, mounting_));
  line[kModelsKey] = modelsNear(best.T_w_c->translation(), best.part, *map_);
  writeTextAtomically(file_, [&line](std::ostream& out) { out << oneLine(line) << "\n"; });
  unwritten_.reset();
}

}  // namespace facetloc
