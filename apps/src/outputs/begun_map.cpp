// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/begun_map.h"

#include "cli/app.h"
#include "outputs/provenance.h"

#include <facetloc/io/error.h>

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

}  // namespace

bool isThere(const fs::path& path) {
  return fs::exists(path) && !(fs::is_regular_file(path) && fs::file_size(path) == 0);
}

MapDatabase beginMap(const fs::path& path, const MapInputs& inputs, const Camera& camera, bool overwrite) {
  if (isThere(path) && !overwrite)
    throw IoError(inputs.map, "exists already; give --overwrite to replace it or --resume to go on");
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

MapDatabase resumeMap(const fs::path& path, const MapInputs& inputs, const Camera& camera) {
  if (!isThere(path)) return beginMap(path, inputs, camera, false);
  const Map present = openMap(path);
  if (present.models.empty()) return beginMap(path, inputs, camera, true);  // killed before it began
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
