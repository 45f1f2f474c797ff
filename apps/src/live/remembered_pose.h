// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/robot_line.h"
#include "outputs/pose_stream.h"

#include <facetloc/features/camera_model.h>
#include <facetloc/features/local_model.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/results.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <json/json.h>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {

/** \brief The last sure pose of a run, in a file that outlives it: a line of the stream, written anew each
 * second at most, with the local models around the pose. By these a later run knows the map again, also after
 * it has been extended. */
class RememberedPose {
public:
  RememberedPose(std::filesystem::path file, std::shared_ptr<const Map> map,
                 const std::optional<CameraMounting>& mounting)
      : file_(std::move(file)), map_(std::move(map)), mounting_(mounting) {}
  /** \brief Writes the rest, as far as that is possible. */
  ~RememberedPose() try { write(); } catch (const std::exception&) {  // as much as possible was written
  }

  RememberedPose(const RememberedPose&) = delete;
  RememberedPose& operator=(const RememberedPose&) = delete;

  /** \brief Where the run before was at last, as a line of a robot: {"pose": ...} without a covariance, since
   * the camera may have been moved since; empty if there is no file. Throws IoError for one that holds no
   * pose, or one of another map. */
  std::string start() const {
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

  /** \brief A frame of the run. Throws IoError if the file cannot be written. */
  void put(const FrameResult& frame) {
    const ResultRow& best = frame.rows.front();
    if (best.state != AnswerState::sure || !best.T_w_c) return;
    unwritten_ = frame;
    const auto now = std::chrono::steady_clock::now();
    if (written_ && now - *written_ < kInterval) return;
    write();
    written_ = now;
  }

private:
  static constexpr std::chrono::seconds kInterval{1};  // between writings
  static constexpr std::size_t kLongest = 1 << 16;     // bytes of a file that holds a line
  static constexpr std::size_t kKeptModels = 16;       // local models that a later run knows the map by
  static constexpr double kSamePlace = 0.1;            // an extension may correct a pose by so much [m]
  static constexpr const char* kModelsKey = "near";

  static std::string firstBytes(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string text(kLongest, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    return text;
  }

  static std::string oneLine(const Json::Value& value) {
    Json::StreamWriterBuilder writer;
    writer["indentation"] = "";
    return Json::writeString(writer, value);
  }

  /** The line without the keys that only held then. */
  static std::string poseLine(const Json::Value& line) {
    Json::Value pose;
    pose["pose"]["T_w_c"] = line["T_w_c"];
    pose["pose"]["part"] = line["part"];
    return oneLine(pose);
  }

  /** The local models nearest to a pose in a part of the map, and where they are. */
  static Json::Value modelsNear(const Eigen::Vector3d& place, const std::string& part, const Map& map) {
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

  static bool isAt(const Json::Value& place, const LocalModel& model) {
    if (!model.T_w_m || !place.isArray() || place.size() != 3) return false;
    Eigen::Vector3d t;
    for (int k = 0; k < 3; ++k) {
      if (!place[k].isNumeric()) return false;
      t[k] = place[k].asDouble();
    }
    return (model.T_w_m->translation() - t).norm() <= kSamePlace;
  }

  /** Most of the local models are where they were: some may have been replaced. */
  static bool isOf(const Json::Value& models, const Map& map) {
    if (!models.isObject()) return false;
    std::size_t same = 0;
    for (const LocalModel& model : map.models)
      same += models.isMember(model.name) && isAt(models[model.name], model);
    return same > 0 && 2 * same >= models.size();
  }

  void write() {
    if (!unwritten_) return;
    const ResultRow& best = unwritten_->rows.front();
    Json::Value line = jsonOf(toJson(*unwritten_, mounting_));
    line[kModelsKey] = modelsNear(best.T_w_c->translation(), best.part, *map_);
    writeTextAtomically(file_, [&line](std::ostream& out) { out << oneLine(line) << "\n"; });
    unwritten_.reset();
  }

  const std::filesystem::path file_;
  const std::shared_ptr<const Map> map_;
  const std::optional<CameraMounting> mounting_;
  std::optional<FrameResult> unwritten_;
  std::optional<std::chrono::steady_clock::time_point> written_;
};

}  // namespace facetloc
