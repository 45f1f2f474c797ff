// SPDX-License-Identifier: BSD-3-Clause
#include "bytes/files.h"
#include "bytes/temporary_file.h"
#include "devices/openni_handle.h"

#include <facetloc/io/oni_file.h>

#include <OpenNI.h>

#include <array>
#include <chrono>
#include <fmt/format.h>
#include <thread>

namespace facetloc {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 2s;               // for the thread that writes
constexpr std::uintmax_t kLeastRoom = 4096;  // for one frame, if none tells how much it takes [bytes]

/** Is the record that says that data will follow the last one in the file? */
bool awaitsData(const fs::path& path) {
  constexpr long kSize = 40;
  constexpr std::uint32_t kMark = 0x0052494E, kDataBegin = 0x08;
  const auto file = files::open(path);
  std::array<std::uint32_t, 2> record{};  // its mark and its type
  return std::fseek(file.get(), -kSize, SEEK_END) == 0 &&
         std::fread(record.data(), sizeof record, 1, file.get()) == 1 && record[0] == kMark &&
         record[1] == kDataBegin;
}

/** Its name is random, so that no link can be put in its place; the file left by a killed recorder can be
 * read. */
fs::path partOf(const fs::path& file) {
  return file.parent_path() / fmt::format("{}.part-{}.oni", file.stem().string(), randomDigits());
}

/** The recorder starts on a thread of its own, and lets go all frames that come before that. */
bool waitForStart(const fs::path& path) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!awaitsData(path)) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(1ms);
  }
  std::this_thread::sleep_for(5ms);  // time from the record to the next line of that thread
  return true;
}

}  // namespace

/** Handles of our own, which share the device with those of others. */
struct OniRecorder::Recording {
  bool initialized = openni::OpenNI::initialize() == openni::STATUS_OK;
  openni::Device device;
  openni::VideoStream depth;
  openni::Recorder recorder;

  ~Recording() {
    if (recorder.isValid()) recorder.stop(), recorder.destroy();
    if (depth.isValid()) depth.stop(), depth.destroy();
    device.close();
    if (initialized) openni::OpenNI::shutdown();
  }
};

OniRecorder::OniRecorder(const std::string& device_uri, const fs::path& file)
    : file_(fs::absolute(file)), part_(partOf(file_)) {
  files::requireFolderOf(file_);
  if (!createNew(part_)) throw WriteError(file_.string(), files::lastError());  // OpenNI2 would not say why
  callOnPersistentThread([&] {
    try {
      recording_ = std::make_unique<Recording>();
      start(device_uri);
    } catch (const IoError&) {
      recording_.reset();
      fs::remove(part_);
      throw;
    }
  });
}

void OniRecorder::start(const std::string& device_uri) {
  Recording& r = *recording_;
  const auto require = [](bool done, const std::string& path, const char* what) {
    if (!done) throw IoError(path, fmt::format("{}: {}", what, openniError()));
  };
  const auto ok = openni::STATUS_OK;
  require(r.initialized, device_uri, "OpenNI2 does not work");
  require(r.device.open(device_uri.c_str()) == ok, device_uri, "cannot be opened");
  require(r.depth.create(r.device, openni::SENSOR_DEPTH) == ok, device_uri, "has no depth to record");
  require(r.recorder.create(part_.c_str()) == ok, part_, "cannot be recorded to");
  require(r.recorder.attach(r.depth) == ok, device_uri, "cannot be recorded");
  require(r.recorder.start() == ok, part_, "cannot be recorded to");
  require(waitForStart(part_), part_, "cannot be recorded to");
  require(r.depth.start() == ok, device_uri, "cannot be started");
  const openni::VideoMode mode = r.depth.getVideoMode();
  frame_size_ = sizeof(std::uint16_t) * static_cast<std::uintmax_t>(mode.getResolutionX()) *
                static_cast<std::uintmax_t>(mode.getResolutionY());
}

bool OniRecorder::hasRoom() const {
  std::error_code error;
  const auto space = fs::space(part_, error);
  return error || space.available >= frame_size_;
}

OniRecorder::~OniRecorder() noexcept {
  try {
    stop();
  } catch (const std::exception&) {  // who wants to know calls stop()
  }
}

std::size_t OniRecorder::stop() {
  if (!recording_) return frames_;
  callOnPersistentThread([this] { recording_.reset(); });  // which waits until all is written
  std::uint64_t bytes = 0;
  try {
    const OniFile whole = OniFile::open(part_);
    if (!whole.finished()) throw IoError(part_, "is truncated");
    frames_ = whole.size();
    bytes = whole.bytes();
  } catch (const IoError& e) {
    if (std::string(e.what()).find("has no depth frames") == std::string::npos) throw;
  }
  // OpenNI2 does not say that it could not write; the next frame then had no room.
  std::error_code error;
  const auto space = fs::space(part_, error);
  const bool full = !error && space.available < (frames_ > 0 ? bytes / frames_ : kLeastRoom);
  if (frames_ > 0) {
    fs::resize_file(part_, bytes);
    fs::rename(part_, file_);
  } else {
    fs::remove(part_);
  }
  if (full) throw IoError(file_.string(), fmt::format("the disk is full: it has {} frames only", frames_));
  return frames_;
}

}  // namespace facetloc
