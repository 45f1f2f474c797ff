// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_extension.h"

#include "batch/map_watch.h"
#include "cli/text.h"
#include "outputs/map_completion.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>

#include <fmt/format.h>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr double kStep = 0.15, kTurnDeg = 8;  // least motion between images that are kept [m, deg]
constexpr double kDepthScale = 4000;          // up to 16 m, in steps finer than any camera's noise
constexpr std::size_t kMostKept = 20000;      // images, which take 1 GB
constexpr const char* kCameraFile = "camera.ini";

fs::path imagesOf(const fs::path& folder) { return folder / "depth"; }

/** Where images go that are not found: the first of the names that is not taken. */
fs::path setAside(const fs::path& folder) {
  for (int n = 1;; ++n)
    if (const fs::path name = fmt::format("{}-{}", folder.string(), n); !fs::exists(name)) return name;
}

/** The map as it is with the images; nothing if they are not found in it. */
std::optional<Map> extended(const std::shared_ptr<const Map>& map, const DepthSequence& images,
                            const MapUpdateParams& params, int threads, const Console& console) {
  MapSession session(map, map->calibrated(images.camera()->camera), params);
  session.setNumberOfThreads(threads);
  MapWatch watch(console);
  session.setProgress(watch.callback());
  for (std::size_t i = 0; i < images.frames().size(); ++i)
    session.add({images.frames()[i].name, images.frames()[i].stamp, [&images, i] { return images.load(i); }});
  const SessionPlace& place = session.find();
  if (!place.found()) {
    console.error(
        fmt::format("today's images are not found in the map, which stays as it is: {}", place.toString()));
    return {};
  }
  Map changed = *map;
  const MapChanges changes = session.update(changed);
  noteSession(fmt::format("live: {}; {}", counted(images.frames().size(), "image"), changes.toString()),
              changed);
  console.print(changes.toString() + "\n");
  return changed;
}

}  // namespace

fs::path LiveExtension::folderOf(const fs::path& map) { return map.string() + ".session"; }

LiveExtension::LiveExtension(const fs::path& map, const Camera& camera)
    : folder_(folderOf(map)), camera_(camera) {
  createFolders(imagesOf(folder_));
}

void LiveExtension::put(const LiveResult& result) {
  if (!result.answer || kept_ >= kMostKept) return;
  T_kept_now_ = T_kept_now_ * result.answer->T_before_now.T;
  const bool moved = !isNear(Eigen::Isometry3d::Identity(), T_kept_now_, kStep, kTurnDeg);
  if (result.image.view.segments.empty() || (kept_ > 0 && !moved)) return;
  if (kept_ == 0) {
    CameraFile file;
    file.camera = camera_;
    file.camera.intrinsics = result.image.depth.camera;
    file.depth_scale = kDepthScale;
    writeCameraFile(folder_ / kCameraFile, file);
  }
  writeDepthPng(imagesOf(folder_) / (result.image.name + ".png"), result.image.depth, kDepthScale);
  T_kept_now_.setIdentity();
  ++kept_;
}

void takeUpSession(const fs::path& map_file, const MapUpdateParams& params, int threads,
                   const Console& console) {
  const fs::path folder = LiveExtension::folderOf(map_file);
  if (!fs::exists(folder)) return;
  if (!fs::exists(folder / kCameraFile) || fs::is_empty(imagesOf(folder))) {  // a run without images
    fs::remove_all(folder);
    return;
  }
  const auto map = std::make_shared<const Map>(readMap(map_file));
  if (!hasGivenPose(*map)) throw IoError(map_file.string(), "cannot be extended: no local model has a pose");
  const DepthSequence images = DepthSequence::open(folder);
  console.print(fmt::format("{} is brought up to date with {}\n", map_file.string(),
                            counted(images.frames().size(), "image")));
  const std::optional<Map> changed = extended(map, images, params, threads, console);
  if (!changed) {
    const fs::path aside = setAside(folder);
    fs::rename(folder, aside);
    console.note(
        fmt::format("the images are kept in {}: facetloc_map extend takes them, too", aside.string()));
    return;
  }
  replaceWholeMap(map_file, *changed, threads, console);
  fs::remove_all(folder);
  console.print(
      fmt::format("map of {} in {}\n", counted(changed->models.size(), "local model"), map_file.string()));
}

}  // namespace facetloc
