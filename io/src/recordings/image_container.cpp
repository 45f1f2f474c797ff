// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/image_container.h"

#include "recordings/message_file.h"

#include <facetloc/io/oni_file.h>

#include <fmt/format.h>

namespace facetloc::internal {
namespace {

class OniContainer : public ImageContainer {
public:
  explicit OniContainer(const fs::path& path) : file_(OniFile::open(path)) {}

  std::size_t size() const override { return file_.size(); }
  double stamp(std::size_t index) const override { return file_.stamp(index); }
  fs::path path(std::size_t) const override { return file_.path(); }
  DepthImage read(std::size_t index) const override { return file_.read(index); }

  CameraFile camera() const override {
    if (!file_.camera().valid())
      throw IoError(file_.path().string(),
                    "does not contain the field of view of its camera; put a camera.ini beside it");
    CameraFile camera;
    camera.camera.intrinsics = file_.camera();
    camera.depth_scale = 1000 / file_.millimetres();
    return camera;
  }

  std::string remark() const override {
    if (file_.finished()) return {};
    return fmt::format("{}: the recording was never finished; it is read as far as it goes, {} frames",
                       file_.path().string(), file_.size());
  }

private:
  OniFile file_;
};

bool isRtabmap(const fs::path& path) { return lowerExtension(path) == ".db"; }

}  // namespace

bool isContainer(const fs::path& path) {
  return (!files::isFolder(path) && (lowerExtension(path) == ".oni" || isRtabmap(path))) ||
         isMessageRecording(path);
}

std::shared_ptr<const ImageContainer> openContainer(const fs::path& path, const std::string& topic) {
  if (isMessageRecording(path)) return openMessageRecording(path, topic);
  if (isRtabmap(path)) return openRtabmapDatabase(path);
  return std::make_shared<const OniContainer>(path);
}

ReadPoses readContainerPoses(const fs::path& path, const std::string& camera_frame) {
  if (isMessageRecording(path)) return readMessageOdometry(path, camera_frame);
  const auto container = openContainer(path, "");
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < container->size(); ++i)
    if (const auto T_w_c = container->pose(i)) poses.push_back({container->stamp(i), *T_w_c});
  if (poses.empty()) throw IoError(path.string(), "has no poses");
  return {Trajectory(std::move(poses)), {}};
}

std::string containerEndings() { return ".oni, .bag, .db3, .mcap, .db"; }

}  // namespace facetloc::internal
