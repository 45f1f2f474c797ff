// SPDX-License-Identifier: BSD-3-Clause
//
// Right and wrong readings of recordings: which of them does facetloc_check name, and by which witness?
//
//   facetloc_simulate room -o room --runs map --frames 60 --width 320
//   score_readings [--images N]... [--map MAP.flmap] [--csv FILE] room/map ...
//
// Each RECORDING is a folder with depth/*.png, camera.ini and groundtruth.txt, read rightly. About fifty
// copies of it are made, each wrong in one way, and shown to facetloc_check; so is the recording itself and,
// with --images, each of its parts of N neighbouring images. With --map, facetloc_localize is asked as well.
// Printed in Markdown: refusals and doubts of each reading, and how many readings each witness refuses,
// doubts or is silent about.
#include "../include/facetloc/testing/own_folder.h"
#include "base/text.h"
#include "cli/tools.h"
#include "programs.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/png.h>
#include <facetloc/io/trajectory.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
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
  bool of_poses = false;  ///< wrong in its poses alone
};

Recording readRecording(const fs::path& folder) {
  const DepthSequence sequence = DepthSequence::open(folder);
  Recording recording;
  recording.camera = sequence.camera().value();
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
  return {fmt::format("stamps of the poses off by {} s", seconds),
          [=](Recording& r) {
            for (StampedPose& pose : r.poses) pose.stamp += seconds;
          },
          true};
}

WrongReading poses(const std::string& name,
                   const std::function<Eigen::Isometry3d(const Eigen::Isometry3d&)>& change) {
  return {name, [=](Recording& r) { forEachPose(r, change); }, true};
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
  all.push_back({"poses in another order",
                 [](Recording& r) {
                   Poses reversed = r.poses;
                   for (std::size_t i = 0; i < reversed.size(); ++i)
                     reversed[i].T_w_c = r.poses[reversed.size() - 1 - i].T_w_c;
                   r.poses = reversed;
                 },
                 true});
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

/** \name Witnesses: the evidence of findings */
/// @{
constexpr std::array<const char*, 7> kWitnesses = {"reading",        "values",          "flatness",  "angles",
                                                   "poses, motions", "floor, mounting", "map, query"};
constexpr std::size_t kMapWitness = 6;

std::size_t witnessOf(const std::string& id) {
  struct Kind {
    const char* begin;
    std::size_t witness;
  };
  constexpr Kind kKinds[] = {{"values.", 1},          {"depth.", 1},
                             {"planes.", 1},          {"camera.field", 1},
                             {"camera.centre", 1},    {"geometry.angles", 3},
                             {"geometry.pixels", 3},  {"geometry.", 2},
                             {"camera.noise", 2},     {"camera.distortion", 2},
                             {"poses.", 4},           {"trajectory.", 4},
                             {"times.", 4},           {"camera.mounting", 5},
                             {"camera.robot", 5},     {"localize.", 6},
                             {"camera.difference", 6}};
  for (const Kind& kind : kKinds)
    if (id.rfind(kind.begin, 0) == 0) return kind.witness;
  return 0;
}
/// @}

Findings findingsOf(App& app, const std::vector<std::string>& arguments) {
  std::ostringstream out, err;
  Findings findings;
  Console console{out, err, false, true, {}};
  console.findings = &findings;
  if (app.run(arguments, console) != kOk && !firstOf(findings, Severity::refusal))
    findings.push_back({"reading.failed", Severity::refusal, std::string(text::trimmed(err.str())), ""});
  return findings;
}

/** The findings of facetloc_check, and of facetloc_localize about the map if one is given. */
Findings findingsOf(const fs::path& recording, const std::string& map, const fs::path& work) {
  Findings findings = findingsOf(*checkApp(), {recording.string()});
  if (map.empty()) return findings;
  const fs::path results = work / "results";
  fs::remove_all(results);
  for (Finding& finding : findingsOf(*localizeApp(), {map, recording.string(), "-o", results.string()}))
    if (witnessOf(finding.id) == kMapWitness) findings.push_back(std::move(finding));
  return findings;
}

/** "geometry.angles poses.disagree", each once. */
std::string idsOf(const Findings& findings, Severity severity) {
  std::string ids;
  for (const Finding& finding : findings)
    if (finding.severity == severity && (" " + ids + " ").find(" " + finding.id + " ") == std::string::npos)
      ids += (ids.empty() ? "" : " ") + finding.id;
  return ids;
}

/** Numbers of readings. */
struct Counts {
  int refused = 0, doubted = 0, silent = 0;

  void add(const Findings& findings) {
    const bool is_refused = firstOf(findings, Severity::refusal) != nullptr;
    ++(is_refused ? refused : firstOf(findings, Severity::doubt) ? doubted : silent);
  }
};

class ReadingsApp : public App {
public:
  ReadingsApp()
      : App("score_readings", "RECORDING... [options]",
            "Makes wrong readings of recordings that are read rightly, and counts which of them "
            "facetloc_check refuses or doubts, by the evidence.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("RECORDING...", recordings_);
    line.addOption("images", images_, "N",
                   "Also check all parts of N neighbouring images as sound readings; may be repeated.");
    line.addOption("map", map_, "MAP.flmap", "Also localize each reading in this map of its place.");
    line.addOption("csv", csv_, "FILE", "Write the findings of each reading to this file.");
  }

  int execute(const CommandLine&, const Console& console) override {
    console.out << "| recording | reading | sound | refusals | doubts |\n|---|---|---|---|---|\n";
    for (const std::string& recording : recordings_) score(recording, console);
    console.out << "\n| witness | sound: refused | doubted | silent | wrong: refused | doubted | silent "
                   "|\n|---|---|---|---|---|---|---|\n";
    for (std::size_t w = 0; w <= kWitnesses.size(); ++w) {
      const Counts &sound = counts_[0][w], &wrong = counts_[1][w];
      console.out << fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n",
                                 w < kWitnesses.size() ? kWitnesses[w] : "all", sound.refused, sound.doubted,
                                 sound.silent, wrong.refused, wrong.doubted, wrong.silent);
    }
    if (!csv_.empty())
      writeTextAtomically(csv_, [this](std::ostream& out) {
        out << "recording,reading,sound,refusals,doubts,notes\n" << rows_;
      });
    return kOk;
  }

  void score(const fs::path& folder, const Console& console) {
    const Recording right = readRecording(folder);
    const auto add = [&](const Recording& recording, const std::string& reading, bool is_sound) {
      take(recording, folder.string(), reading, is_sound, console);
    };
    add(right, "as recorded", true);
    for (const std::string& images : images_) {
      const auto n = text::to<std::size_t>(images);
      if (!n || *n == 0) throw UsageError("--images needs a positive number, not " + images);
      for (std::size_t first = 0; first + *n <= right.images.size(); first += *n)
        add(part(right, first, *n), fmt::format("{} images from {}", *n, first), true);
    }
    for (const WrongReading& wrong : wrongReadings()) {
      if (wrong.of_poses && right.poses.empty()) continue;
      Recording recording = right;
      wrong.make(recording);
      add(recording, wrong.name, false);
    }
  }

  static Recording part(Recording recording, std::size_t first, std::size_t n) {
    const auto cut = [first, n](auto& values) {
      const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first);
      values = {begin, begin + static_cast<std::ptrdiff_t>(n)};
    };
    cut(recording.names), cut(recording.images);
    return recording;
  }

  void take(const Recording& recording, const std::string& name, const std::string& reading, bool is_sound,
            const Console& console) {
    const test::OwnFolder work;
    writeRecording(recording, work.path() / "walk");
    const Findings findings = findingsOf(work.path() / "walk", map_, work.path());
    std::array<Findings, kWitnesses.size() + 1> of_witness;
    of_witness.back() = findings;
    for (const Finding& finding : findings) of_witness[witnessOf(finding.id)].push_back(finding);
    for (std::size_t w = 0; w < of_witness.size(); ++w) {
      const bool is_asked = w != kMapWitness || !map_.empty();
      if (is_asked) counts_[is_sound ? 0 : 1][w].add(of_witness[w]);
    }
    const std::string refusals = idsOf(findings, Severity::refusal),
                      doubts = idsOf(findings, Severity::doubt);
    const char* sound = is_sound ? "yes" : "no";
    console.out << fmt::format("| {} | {} | {} | {} | {} |\n", name, reading, sound, refusals, doubts)
                << std::flush;
    rows_ += fmt::format("\"{}\",\"{}\",{},{},{},{}\n", name, reading, sound, refusals, doubts,
                         idsOf(findings, Severity::note));
  }

  std::vector<std::string> recordings_, images_;
  std::string map_, csv_, rows_;
  std::array<std::array<Counts, kWitnesses.size() + 1>, 2> counts_{};  // sound and wrong readings
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<ReadingsApp>(argc, argv); }
