// SPDX-License-Identifier: BSD-3-Clause
//
// Wrong readings of recordings: which of them does facetloc_check name?
//
//   facetloc_simulate room -o room --runs map --frames 60 --width 320
//   score_readings room/map ...
//
// Each RECORDING is a folder with depth/*.png, camera.ini and groundtruth.txt, read rightly. About fifty
// copies of it are made, each wrong in one way, and shown to facetloc_check: refused if it fails, named if it
// has a note that it lacks for the recording itself, else silent. A note on the recording itself is
// also printed, as far as it doubts how the recording is read.
#include "../include/facetloc/testing/own_folder.h"
#include "cli/tools.h"
#include "programs.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>
#include <facetloc/io/trajectory.h>

#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fmt/core.h>
#include <functional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace facetloc;

using Image = Raster<std::uint16_t>;
using Poses = std::vector<StampedPose>;

/** A recording in memory, to be made wrong. */
struct Recording {
  CameraFile camera;
  std::vector<std::string> names;
  std::vector<Image> images;
  Poses poses;
};

struct WrongReading {
  std::string name;
  std::function<void(Recording&)> make;
};

Recording readRecording(const fs::path& folder) {
  const DepthSequence sequence = DepthSequence::open(folder);
  Recording recording;
  recording.camera = sequence.camera().value();
  recording.camera.camera.mounting.reset();
  constexpr int kBits = 16;
  for (const FrameFile& frame : sequence.frames()) {
    recording.names.push_back(frame.path.filename().string());
    recording.images.push_back(readGreyPng(frame.path, kBits));
  }
  recording.poses = sequence.groundTruth().poses();
  return recording;
}

void writeRecording(const Recording& recording, const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder / "depth");
  writeCameraFile(folder / "camera.ini", recording.camera);
  for (std::size_t i = 0; i < recording.images.size(); ++i)
    writePng(folder / "depth" / recording.names[i], recording.images[i]);
  if (!recording.poses.empty()) writeTumTrajectory(folder / "groundtruth.txt", recording.poses);
}

/** \name Ways to be wrong */
/// @{
void forEachValue(Recording& r, const std::function<std::uint16_t(std::uint16_t)>& change) {
  for (Image& image : r.images)
    for (std::uint16_t& value : image.data) value = value == 0 || value == 65535 ? 0 : change(value);
}

void forEachPose(Recording& r, const std::function<Eigen::Isometry3d(const Eigen::Isometry3d&)>& change) {
  for (StampedPose& pose : r.poses) pose.T_w_c = change(pose.T_w_c);
}

/** Each pixel as another one of the image; whatever lies outside is not measured. */
void move(Recording& r, const std::function<Eigen::Vector2d(int, int)>& from) {
  for (Image& image : r.images) {
    const Image before = image;
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u) {
        const Eigen::Vector2d p = from(u, v);
        const auto x = static_cast<int>(std::lround(p.x())), y = static_cast<int>(std::lround(p.y()));
        const bool inside = x >= 0 && y >= 0 && x < image.width && y < image.height;
        image.data[static_cast<std::size_t>(v) * image.width + u] =
            inside ? before.data[static_cast<std::size_t>(y) * image.width + x] : 0;
      }
  }
}

Intrinsics& intrinsics(Recording& r) { return r.camera.camera.intrinsics; }

WrongReading focal(double fx, double fy) {
  return {fmt::format("fx x {}, fy x {}", fx, fy), [=](Recording& r) {
            intrinsics(r).fx *= fx;
            intrinsics(r).fy *= fy;
          }};
}

/** Shares of the width. */
WrongReading centre(double cx, double cy) {
  return {fmt::format("centre off by {}, {} of the width", cx, cy), [=](Recording& r) {
            intrinsics(r).cx += cx * intrinsics(r).width;
            intrinsics(r).cy += cy * intrinsics(r).width;
          }};
}

WrongReading scale(double factor) {
  return {fmt::format("depth_scale x {}", factor), [=](Recording& r) { r.camera.depth_scale *= factor; }};
}

WrongReading lens(double k1) {
  return {fmt::format("lens of k1 = {}", k1), [=](Recording& r) {
            const Intrinsics k = intrinsics(r);
            move(r, [=](int u, int v) {  // a pixel of the distorted image shows the point on its true ray
              const Eigen::Vector2d distorted = k.ray(u, v).head<2>();
              Eigen::Vector2d ray = distorted;
              for (int i = 0; i < 20; ++i) ray = distorted / (1 + k1 * ray.squaredNorm());
              return Eigen::Vector2d(k.fx * ray.x() + k.cx, k.fy * ray.y() + k.cy);
            });
          }};
}

void readAsDistances(Recording& r) {
  const Intrinsics k = intrinsics(r);
  for (Image& image : r.images)
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u) {
        std::uint16_t& value = image.data[static_cast<std::size_t>(v) * image.width + u];
        const double distance = value * k.ray(u, v).norm();
        value = distance < 65535 ? static_cast<std::uint16_t>(std::lround(distance)) : 0;
      }
}

WrongReading bits(const std::string& name, double scale, std::function<int(int)> change) {
  return {name, [scale, change = std::move(change)](Recording& r) {
            const double of_file = r.camera.depth_scale;
            forEachValue(r, [&](std::uint16_t value) {
              const int changed = change(static_cast<int>(std::lround(value / of_file * scale)));
              return static_cast<std::uint16_t>(changed & 0xffff);
            });
            r.camera.depth_scale = scale;
          }};
}

WrongReading delay(double seconds) {
  return {fmt::format("stamps of the poses off by {} s", seconds), [=](Recording& r) {
            for (StampedPose& pose : r.poses) pose.stamp += seconds;
          }};
}

WrongReading poses(const std::string& name,
                   const std::function<Eigen::Isometry3d(const Eigen::Isometry3d&)>& change) {
  return {name, [=](Recording& r) { forEachPose(r, change); }};
}

/** Poses in other axes of the camera. */
WrongReading axes(const std::string& name, const Eigen::Matrix3d& R) {
  return poses(name, [R](Eigen::Isometry3d T) {
    T.linear() = T.linear() * R;
    return T;
  });
}

Eigen::Isometry3d withQuaternion(Eigen::Isometry3d T,
                                 const std::function<Eigen::Quaterniond(const Eigen::Quaterniond&)>& change) {
  T.linear() = change(Eigen::Quaterniond(T.linear())).normalized().toRotationMatrix();
  return T;
}
/// @}

std::vector<WrongReading> wrongReadings() {
  std::vector<WrongReading> all;
  for (const double factor : {0.5, 0.67, 0.8, 0.9, 1.11, 1.25, 1.5, 2.0, 3.0, 5.0})
    all.push_back(scale(factor));
  for (const double factor : {0.6, 0.8, 0.9, 0.95, 1.05, 1.1, 1.25, 1.6})
    all.push_back(focal(factor, factor));
  for (const double factor : {0.8, 1.25, 1.6}) {
    all.push_back(focal(factor, 1));
    all.push_back(focal(1, factor));
  }
  all.push_back(centre(0.06, 0)), all.push_back(centre(0.12, 0)), all.push_back(centre(0, 0.08));
  all.push_back(centre(-0.1, 0.1));
  all.push_back({"distances along the rays", readAsDistances});
  all.push_back({"distances along the rays, fx and fy x 1.2", [](Recording& r) {
                   readAsDistances(r);
                   intrinsics(r).fx *= 1.2, intrinsics(r).fy *= 1.2;
                 }});
  for (const double k1 : {-0.3, -0.1, 0.2}) all.push_back(lens(k1));
  all.push_back({"disparities in place of depths", [](Recording& r) {
                   const double z2 = 4 * r.camera.depth_scale * r.camera.depth_scale;
                   forEachValue(r, [z2](std::uint16_t v) {
                     return static_cast<std::uint16_t>(std::min(65534.0, z2 / v));
                   });
                 }});
  all.push_back(bits("bytes swapped", 1000, [](int v) { return (v >> 8) | (v << 8); }));
  all.push_back(bits("bytes swapped, of 5000 per metre", 5000, [](int v) { return (v >> 8) | (v << 8); }));
  all.push_back(bits("bits rotated by 3", 1000, [](int v) { return (v << 3) | (v >> 13); }));
  all.push_back(bits("bits shifted by 1", 1000, [](int v) { return v << 1; }));
  all.push_back(bits("bits shifted by 4", 1000, [](int v) { return v << 4; }));
  all.push_back(bits("bits shifted down by 3", 1000, [](int v) { return v >> 3; }));
  all.push_back(bits("8 bits in 16", 1000, [](int v) { return 257 * std::min(255, v / 32); }));
  all.push_back({"image upside down", [](Recording& r) {
                   const Intrinsics k = intrinsics(r);
                   move(r, [k](int u, int v) { return Eigen::Vector2d(u, k.height - 1 - v); });
                 }});
  all.push_back({"image mirrored", [](Recording& r) {
                   const Intrinsics k = intrinsics(r);
                   move(r, [k](int u, int v) { return Eigen::Vector2d(k.width - 1 - u, v); });
                 }});
  all.push_back({"image turned by 180 deg", [](Recording& r) {
                   const Intrinsics k = intrinsics(r);
                   move(r, [k](int u, int v) { return Eigen::Vector2d(k.width - 1 - u, k.height - 1 - v); });
                 }});
  for (const double seconds : {0.5, -0.7, 3.0}) all.push_back(delay(seconds));
  all.push_back({"poses in another order", [](Recording& r) {
                   Poses reversed = r.poses;
                   for (std::size_t i = 0; i < reversed.size(); ++i)
                     reversed[i].T_w_c = r.poses[reversed.size() - 1 - i].T_w_c;
                   r.poses = reversed;
                 }});
  all.push_back(poses("quaternions w x y z", [](const Eigen::Isometry3d& T) {
    return withQuaternion(T, [](const auto& q) { return Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()); });
  }));
  all.push_back(poses("quaternions conjugated", [](const Eigen::Isometry3d& T) {
    return withQuaternion(T, [](const auto& q) { return q.conjugate(); });
  }));
  all.push_back(poses("poses inverted", [](const Eigen::Isometry3d& T) { return T.inverse(); }));
  all.push_back(poses("poses in millimetres", [](Eigen::Isometry3d T) {
    T.translation() *= 1000;
    return T;
  }));
  Eigen::Matrix3d body, opengl, swapped;
  body << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  opengl = Eigen::Vector3d(1, -1, -1).asDiagonal();
  swapped << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  all.push_back(axes("poses of a body (x forward, z up)", body));
  all.push_back(axes("poses of OpenGL (y up, z backward)", opengl));
  all.push_back(axes("poses with x and y swapped", swapped));
  all.push_back(poses("world of the left hand", [](Eigen::Isometry3d T) {
    const Eigen::Matrix3d S = Eigen::Vector3d(1, 1, -1).asDiagonal();
    T.linear() = S * T.linear() * S;
    T.translation() = S * T.translation();
    return T;
  }));
  return all;
}

struct Outcome {
  int code = 0;
  std::vector<std::string> notes;
};

Outcome check(const fs::path& folder) {
  std::ostringstream out, err;
  const int code = checkApp()->run({folder.string()}, Console{out, err, false, true, {}});
  Outcome outcome{code, {}};
  std::istringstream lines(out.str() + err.str());
  for (std::string line; std::getline(lines, line);)
    if (line.rfind("- ", 0) == 0 || line.rfind("facetloc_check:", 0) == 0)
      outcome.notes.push_back(line.substr(2));
  return outcome;
}

std::string withoutNumbers(const std::string& text) {
  std::string words;
  for (const char c : text)
    if (!std::isdigit(static_cast<unsigned char>(c)) && c != '.') words += c;
  return words;
}

struct Counts {
  int refused = 0, named = 0, silent = 0;
};

void score(const fs::path& folder, Counts& counts) {
  const Recording right = readRecording(folder);
  const test::OwnFolder work;
  const fs::path path = work.path() / "walk";
  writeRecording(right, path);
  const Outcome usual = check(path);
  std::set<std::string> known;
  for (const std::string& note : usual.notes) known.insert(withoutNumbers(note));
  fmt::print("{}: {}\n", folder.string(), usual.code == 0 ? "accepted" : "REFUSED");
  for (const std::string& note : usual.notes) fmt::print("    {}\n", note);
  for (const WrongReading& wrong : wrongReadings()) {
    Recording recording = right;
    wrong.make(recording);
    writeRecording(recording, path);
    const Outcome outcome = check(path);
    std::string first;
    for (const std::string& note : outcome.notes)
      if (first.empty() && !known.count(withoutNumbers(note))) first = note;
    const bool refused = outcome.code != 0, named = !first.empty();
    ++(refused ? counts.refused : named ? counts.named : counts.silent);
    fmt::print("  {:44} {:8} {}\n", wrong.name,
               refused ? "refused"
               : named ? "named"
                       : "SILENT",
               first.substr(0, 150));
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "Usage: score_readings RECORDING...\n");
    return 2;
  }
  return benchmarks::runProgram("score_readings", [&] {
    Counts all;
    for (int i = 1; i < argc; ++i) score(argv[i], all);
    fmt::print("{} refused, {} named, {} silent\n", all.refused, all.named, all.silent);
    return 0;
  });
}
