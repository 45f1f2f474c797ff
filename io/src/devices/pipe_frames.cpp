// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "bytes/files.h"
#include "bytes/plausible.h"

#include <facetloc/io/pipe_frames.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <json/json.h>
#include <poll.h>
#include <stdexcept>
#include <unistd.h>

namespace facetloc {

/** The header of a frame: one line of JSON. */
struct internal::FrameHeader {
  double stamp = 0;           // [s]
  int width = 0, height = 0;  // [px]
  std::optional<Gravity> gravity;
  CameraKeys camera;  // numbers as text
};

namespace {

using internal::FrameHeader;

constexpr int kLargestSide = 1 << 14;  // [px]
constexpr int kMostPixels = 1 << 24;   // more than any depth camera has
constexpr double kUsualGravityStdDeg = 1;

/** Null unless the line is a JSON object. */
Json::Value objectIn(const std::string& line) {
  Json::CharReaderBuilder builder;
  Json::CharReaderBuilder::strictMode(&builder.settings_);
  const std::unique_ptr<Json::CharReader> reader(builder.newCharReader());
  Json::Value value;
  std::string ignored;
  try {
    if (reader->parse(line.data(), line.data() + line.size(), &value, &ignored) && value.isObject())
      return value;
  } catch (const std::exception&) {  // nested too deeply
  }
  return {};
}

double numberOf(const Json::Value& value, const char* key) {
  if (!value.isNumeric() || !std::isfinite(value.asDouble()))
    throw std::invalid_argument(fmt::format("its {} is no number", key));
  return value.asDouble();
}

int sideOf(const Json::Value& header, const char* key) {
  if (!header.isMember(key)) throw std::invalid_argument(fmt::format("it has no {}", key));
  const double side = numberOf(header[key], key);
  if (!(side >= 1 && side <= kLargestSide && side == std::floor(side)))
    throw std::invalid_argument(fmt::format("its {} of {} is impossible: it is a whole number up to {}", key,
                                            text::shortest(side), kLargestSide));
  return static_cast<int>(side);
}

std::optional<Gravity> gravityOf(const Json::Value& header) {
  const Json::Value& vector = header["gravity"];
  if (vector.isNull()) return {};
  if (!vector.isArray() || vector.size() != 3)
    throw std::invalid_argument("its gravity has not three numbers");
  const Eigen::Vector3d down(numberOf(vector[0], "gravity"), numberOf(vector[1], "gravity"),
                             numberOf(vector[2], "gravity"));
  const Json::Value& std = header["gravity_std_deg"];
  return gravityAlong(down,
                      (std.isNull() ? kUsualGravityStdDeg : numberOf(std, "gravity_std_deg")) * kDegree);
}

/** A value of a camera.ini, as it is written there. */
std::string wordOf(const Json::Value& value, const std::string& key) {
  if (value.isNumeric()) return text::shortest(numberOf(value, key.c_str()));
  if (!value.isString()) throw std::invalid_argument(fmt::format("its {} is neither number nor name", key));
  return value.asString();
}

using Clock = std::chrono::steady_clock;

constexpr std::size_t kChunk = 1 << 18;        // bytes read at a time
constexpr std::size_t kLongestLine = 1 << 16;  // bytes
constexpr std::size_t kMostEarlyLines = 1000;
constexpr std::size_t kMostSkipped = std::size_t(1) << 25;  // bytes, of the largest frame
constexpr int kPipeSize = 1 << 20;                          // a frame of 640x480 without a change of context

const std::string* find(const CameraKeys& keys, const std::string& key) {
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const auto& p) { return p.first == key; });
  return found == keys.end() ? nullptr : &found->second;
}

/** Intrinsics for the n-th pixels of the camera's full image. */
Intrinsics scaledTo(const Intrinsics& camera, const FrameHeader& header) {
  if (camera.width % header.width != 0 || camera.width / header.width * header.height != camera.height)
    throw std::invalid_argument(fmt::format("it is of {}x{} pixels, the camera of --camera has {}x{}",
                                            header.width, header.height, camera.width, camera.height));
  return camera.subsampled(camera.width / header.width);
}

/** Nothing for an object with neither width nor height, which is a line of another kind. Throws
 * std::invalid_argument, with a sentence, for a header that is impossible, and for text that is no JSON
 * object. */
std::optional<FrameHeader> parseFrameHeader(const std::string& line) {
  const Json::Value json = objectIn(line);
  if (json.isNull())
    throw std::invalid_argument("it is no JSON object; is the frame before it longer than it says?");
  if (!(json.isMember("width") || json.isMember("height"))) return {};
  FrameHeader header;
  header.width = sideOf(json, "width"), header.height = sideOf(json, "height");
  if (header.width > kMostPixels / header.height)
    throw std::invalid_argument(fmt::format("its {} x {} pixels are more than any depth camera has ({})",
                                            header.width, header.height, kMostPixels));
  if (!json.isMember("stamp")) throw std::invalid_argument("it has no stamp");
  header.stamp = numberOf(json["stamp"], "stamp");
  if (!plausible::isStamp(header.stamp))
    throw std::invalid_argument(fmt::format("its stamp of {} is impossible: it is a time in seconds up to {}",
                                            text::shortest(header.stamp),
                                            text::shortest(plausible::kLatest)));
  header.gravity = gravityOf(json);
  for (const std::string& key : json.getMemberNames())
    if (isCameraKey(key)) header.camera.emplace_back(key, wordOf(json[key], key));
  return header;
}

}  // namespace

PipeFrames::PipeFrames(int file, std::string name, std::optional<CameraFile> known)
    : file_(file), name_(std::move(name)), known_(std::move(known)) {
  if (::isatty(file_)) throw IoError(name_, "is a terminal: frames come from a program, through a pipe");
  ::fcntl(file_, F_SETPIPE_SZ, kPipeSize);  // as far as the system allows
}

void PipeFrames::fail(const std::string& cause) {
  failed_ = true;
  throw IoError(name_, fmt::format("frame {}: {}", frames_ + 1, cause));
}

void PipeFrames::setLines(OnLine on_line) {
  on_line_ = std::move(on_line);
  for (const std::string& line : early_lines_) on_line_(line);
  early_lines_.clear();
}

std::shared_ptr<const CameraFile> PipeFrames::camera(Patience patience) {
  const Clock::time_point end = Clock::now() + patience;
  while (!camera_ && fill(end)) {
  }
  return camera_;
}

DepthFrame::ConstPtr PipeFrames::next(Patience patience) {
  const Clock::time_point end = Clock::now() + patience;
  while (!hasFrame())
    if (!fill(end)) return {};
  ++frames_;
  return std::exchange(pending_, nullptr);
}

bool PipeFrames::hasFrame() const { return pending_ && missing_ == 0; }

/** Goes on until a header or the rest of a frame has come. \return false if nothing came until then, or
 * never will. */
bool PipeFrames::fill(Clock::time_point end) {
  if (used_ == bytes_.size()) {
    if (ended_) return false;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    pollfd waits{file_, POLLIN, 0};
    if (::poll(&waits, 1, static_cast<int>(std::clamp<long long>(left, 0, 1000))) <= 0)
      return Clock::now() < end;
    bytes_.resize(kChunk);
    const ssize_t n = ::read(file_, bytes_.data(), bytes_.size());
    bytes_.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    used_ = 0;
    if (n < 0 && errno != EINTR && errno != EAGAIN) fail("cannot be read: " + files::lastError());
    if (n == 0) {
      if (pending_) fail(fmt::format("is torn: the pipe ends {} bytes before its last pixel", missing_));
      if (!text_.empty()) fail("is torn: the pipe ends within its header");
      ended_ = true;
      return false;
    }
  }
  const std::size_t available = bytes_.size() - used_;
  if (pending_) {
    readPixels(available);
    return true;
  }
  const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(used_);
  const auto newline = std::find(begin, bytes_.end(), '\n');
  text_.append(begin, newline);
  used_ = static_cast<std::size_t>(newline - bytes_.begin()) + (newline != bytes_.end());
  if (text_.size() > kLongestLine) {
    if (camera_)
      fail(fmt::format("a line of more than {} bytes is no header: is the frame before longer than it says?",
                       kLongestLine));
    skip(text_.size() - kLongestLine);
    text_.erase(0, text_.size() - kLongestLine);
  }
  if (newline != bytes_.end()) takeLine(std::exchange(text_, {}));
  return true;
}

/** Before the first header may be the rest of a frame, of which a program that was killed has read the
 * beginning. */
void PipeFrames::skip(std::size_t bytes) {
  skipped_ += bytes;
  if (skipped_ > kMostSkipped) fail(fmt::format("there is no header in {} bytes", skipped_));
}

/** A header at the end of skipped bytes. */
std::optional<FrameHeader> PipeFrames::headerAtEnd(const std::string& line) {
  for (std::size_t at = line.find("{\""); at != std::string::npos; at = line.find("{\"", at + 1)) try {
      if (auto header = parseFrameHeader(line.substr(at))) return header;
    } catch (const std::invalid_argument&) {
    }
  skip(line.size());
  return {};
}

void PipeFrames::takeLine(const std::string& line) {
  const std::string_view text = text::trimmed(line);
  if (text.empty()) return;
  const bool is_object = text.front() == '{' && text.back() == '}';
  std::optional<FrameHeader> header;
  try {
    header = is_object || camera_ ? parseFrameHeader(line) : headerAtEnd(line);
    if (header) begin(*header);
  } catch (const std::invalid_argument& e) {
    fail(std::string("its header cannot be used: ") + e.what());
  }
  if (header || !(is_object || camera_)) return;
  if (on_line_)
    on_line_(line);
  else if (early_lines_.size() < kMostEarlyLines)
    early_lines_.push_back(line);
}

/** Begins a frame whose pixels come next. */
void PipeFrames::begin(const FrameHeader& header) {
  if (!camera_) {
    camera_ = cameraOf(header);
    first_ = header.camera;
  }
  for (const auto& [key, value] : header.camera)
    if (const std::string* first = find(first_, key); !first || *first != value)
      throw std::invalid_argument(fmt::format("its {} is {}, unlike the first frame's", key, value));
  pending_ = std::make_shared<DepthFrame>();
  pending_->number = frames_ + 1;
  pending_->stamp = header.stamp;
  pending_->gravity = header.gravity;
  pending_->camera = camera_;
  missing_ = sizeof(std::uint16_t) * static_cast<std::size_t>(header.width) * header.height;
}

std::shared_ptr<const CameraFile> PipeFrames::cameraOf(const FrameHeader& header) const try {
  if (known_ && known_->camera.intrinsics.valid()) {
    auto camera = std::make_shared<CameraFile>(*known_);
    camera->camera.intrinsics = scaledTo(camera->camera.intrinsics, header);
    if (const std::string* word = find(header.camera, "depth_scale")) {
      camera->depth_scale = text::to<double>(*word).value_or(0);
      if (!(camera->depth_scale > 0)) throw std::invalid_argument("its depth_scale is not positive");
    }
    return camera;
  }
  CameraKeys keys = header.camera;
  if (known_ && !known_->preset.empty()) {
    keys.erase(
        std::remove_if(keys.begin(), keys.end(), [](const auto& key) { return key.first == "camera"; }),
        keys.end());
    keys.emplace_back("camera", known_->preset);
  }
  return std::make_shared<CameraFile>(cameraOfKeys(keys, name_));
} catch (const IoError& e) {
  throw std::invalid_argument(e.cause());
}

/** Memory grows with the bytes that are there, whatever the header says. */
void PipeFrames::readPixels(std::size_t available) {
  const std::size_t n = std::min(available, missing_);
  const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(used_);
  pixels_.insert(pixels_.end(), begin, begin + static_cast<std::ptrdiff_t>(n));
  used_ += n;
  missing_ -= n;
  if (missing_ > 0) return;
  pending_->values.resize(pixels_.size() / sizeof(std::uint16_t));
  std::memcpy(pending_->values.data(), pixels_.data(), pixels_.size());  // both little-endian
  pixels_.clear();
}

}  // namespace facetloc
