// SPDX-License-Identifier: BSD-3-Clause
#include "live/remembered_pose.h"

#include "base/pose_stream.h"
#include "base/robot_line.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <fstream>
#include <json/json.h>
#include <ostream>
#include <utility>

namespace facetloc {
namespace {

constexpr std::chrono::seconds kInterval(1);  // between writings
constexpr std::size_t kLongest = 1 << 16;     // bytes of a file that holds a line

std::string firstBytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text(kLongest, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

/** The line without the keys that only held then. */
std::string poseLine(const std::string& text) {
  Json::CharReaderBuilder builder;
  Json::CharReaderBuilder::strictMode(&builder.settings_);
  const std::unique_ptr<Json::CharReader> reader(builder.newCharReader());
  Json::Value line, pose;
  std::string ignored;
  if (!reader->parse(text.data(), text.data() + text.size(), &line, &ignored) || !line.isObject())
    throw std::invalid_argument("it must be a line of the stream");
  pose["pose"]["T_w_c"] = line["T_w_c"];
  pose["pose"]["part"] = line["part"];
  Json::StreamWriterBuilder writer;
  writer["indentation"] = "";
  return Json::writeString(writer, pose);
}

}  // namespace

RememberedPose::RememberedPose(std::filesystem::path file, const std::optional<CameraMounting>& mounting)
    : file_(std::move(file)), mounting_(mounting) {}

RememberedPose::~RememberedPose() try {
  write();
} catch (const std::exception&) {  // as much as possible was written
}

std::string RememberedPose::start() const {
  if (!std::filesystem::exists(file_)) return {};
  try {
    std::string line = poseLine(firstBytes(file_));
    parseRobotLine(line, mounting_);
    return line;
  } catch (const std::exception& e) {
    throw IoError(file_.string(), std::string("holds no pose of an earlier run: ") + e.what());
  }
}

void RememberedPose::put(const FrameResult& frame) {
  const ResultRow& best = frame.rows.front();
  if (best.state != AnswerState::sure || !best.T_w_c) return;
  unwritten_ = toJson(frame, mounting_) + "\n";
  const auto now = std::chrono::steady_clock::now();
  if (written_ && now - *written_ < kInterval) return;
  write();
  written_ = now;
}

void RememberedPose::write() {
  if (unwritten_.empty()) return;
  writeTextAtomically(file_, [this](std::ostream& out) { out << unwritten_; });
  unwritten_.clear();
}

}  // namespace facetloc
