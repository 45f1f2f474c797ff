// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/map_completion.h"

#include "batch/map_watch.h"
#include "outputs/provenance.h"

#include <facetloc/io/error.h>
#include <facetloc/localization/place_index.h>

#include <algorithm>
#include <map>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kParametersKey = "parameters";
constexpr double kSamePose = 1e-9;  // rounding of a file [m], and of the entries of a rotation

bool samePose(const std::optional<Eigen::Isometry3d>& a, const std::optional<Eigen::Isometry3d>& b) {
  if (!a || !b) return !a && !b;
  return (a->matrix() - b->matrix()).cwiseAbs().maxCoeff() < kSamePose;
}

/** Were the local models that are there already made of the same images, with the same poses? */
bool isMadeOf(const Map& present, const MapInputs& inputs) {
  std::map<std::string, const MapPlace*> by_name;
  for (const MapPlace& place : inputs.places) by_name[inputs.sequence.frames()[place.image].name] = &place;
  const auto recorded = present.meta.find(kImagesKey);
  const ImageSizes sizes = recorded == present.meta.end() ? ImageSizes() : imageSizes(recorded->second);
  return std::all_of(present.models.begin(), present.models.end(), [&](const LocalModel& model) {
    const auto place = by_name.find(model.name);
    const auto size = sizes.find(model.name);
    if (place == by_name.end() || size == sizes.end()) return false;
    const auto& [image, T_w_m] = *place->second;
    return size->second == sizeOf(inputs.sequence.frames()[image]) && samePose(model.givenPose(), T_w_m);
  });
}

MapDatabase beginMap(const fs::path& path, const MapInputs& inputs, const Camera& camera) {
  MapDatabase database = MapDatabase::create(path, true);
  database.setMeta("software", versionText());
  database.setMeta("source", inputs.recording);
  database.setCamera(camera);
  database.setMeta(kParametersKey, inputs.parameters);
  database.setMeta(kImagesKey, toText(imageSizes(inputs.sequence)));
  if (!inputs.disagreement.empty()) database.setMeta("poses disagree with images by", inputs.disagreement);
  database.setMeta(kStateKey, kUnderWay);
  return database;
}

/** Locks the file that a map is written to. Throws IoError if it exists and may not be replaced. */
OutputLock lockTarget(const fs::path& map, bool may_replace) {
  OutputLock lock = OutputLock::ofFile(map);
  if (!may_replace && fs::file_size(map) > 0)
    throw IoError(map.string(), "exists already; give --overwrite to replace it");
  return lock;
}

bool hasItsIndex(const Map& map) {
  const auto written = map.store() ? map.store()->placeIndex() : nullptr;
  return written && PlaceIndex::read(*written, map);
}

}  // namespace

std::shared_ptr<Map> MapFile::map() {
  auto map = std::make_shared<Map>(openMap(path_));
  const auto state = map->meta.find(kStateKey);
  whole_ = state == map->meta.end() || state->second == kWhole;
  return map;
}

int MapFile::add(const PackedModel& model) {
  if (std::exchange(whole_, false)) database_.setMeta(kStateKey, kUnderWay);
  return database_.add(model);
}

void MapFile::setWhole() {
  if (!std::exchange(whole_, true)) database_.setMeta(kStateKey, kWhole);
}

void MapFile::setMounting(const Camera& camera, const FoundMounting& found) {
  database_.setCamera(camera);
  console_.out << "the camera is mounted " << found.toString() << "\n";
}

void MapFile::setPlaceIndex(const Map& map) {
  if (!map.camera.mounting || hasItsIndex(map)) return;
  if (const auto index = placeIndexOf(map)) database_.setPlaceIndex(index);
}

void completeMap(const fs::path& path, int threads, const Console& console, bool mounting) {
  MapFile file(path, MapDatabase::open(path), console);
  MapWatch watch(console);
  completeMap(file, {mounting, threads, watch.callback()});
}

void replaceWholeMap(const fs::path& path, const Map& map, int threads, const Console& console) {
  replaceMap(path, [&](const fs::path& temporary) {
    writeMap(temporary, map);
    completeMap(temporary, threads, console);
  });
}

std::pair<std::string, OutputLock> lockSuccessor(const std::string& map, const std::string& output,
                                                 bool overwrite) {
  if (overwrite && output.empty())
    throw UsageError("overwrite belongs to --output; without that, MAP.flmap itself is replaced");
  if (!fs::is_regular_file(map)) throw IoError(map, "is not there");
  if (output.empty()) return {map, OutputLock::ofFile(map)};
  return {output, lockTarget(output, overwrite)};
}

Map writeNewMap(const std::string& path, bool overwrite, int threads, const Console& console,
                const std::function<Map()>& make) {
  if (path.empty()) throw UsageError("the map to write is missing: -o OUT.flmap");
  const OutputLock lock = lockTarget(path, overwrite);
  Map map = make();
  writeMap(path, map);
  completeMap(path, threads, console);
  return map;
}

std::vector<std::string> placeIndexFaults(const fs::path& path) try {
  const Map map = openMap(path, 0);
  const auto written = map.camera.mounting ? map.store()->placeIndex() : nullptr;
  if (written) PlaceIndex::read(*written, map);
  return {};
} catch (const std::exception& e) {
  return {e.what()};
}

bool isThere(const fs::path& path) {
  return fs::exists(path) && !(fs::is_regular_file(path) && fs::file_size(path) == 0);
}

MapDatabase openBuild(const fs::path& path, const MapInputs& inputs, const Camera& camera, bool resume,
                      bool overwrite) {
  if (!isThere(path) || overwrite) return beginMap(path, inputs, camera);
  if (!resume)
    throw IoError(inputs.map, "exists already; give --overwrite to replace it or --resume to go on");
  const Map present = openMap(path);
  if (present.models.empty()) return beginMap(path, inputs, camera);  // killed before it began
  const auto recorded = present.meta.find(kParametersKey);
  if (recorded == present.meta.end() || recorded->second != inputs.parameters || !isMadeOf(present, inputs))
    throw IoError(inputs.map,
                  "was built of other images, with other poses or other parameters; give the same ones, or "
                  "--overwrite");
  MapDatabase database = MapDatabase::open(path);
  const std::string images = toText(imageSizes(inputs.sequence));  // some may have been repaired since
  if (images != present.meta.at(kImagesKey)) database.setMeta(kImagesKey, images);
  return database;
}

}  // namespace facetloc
