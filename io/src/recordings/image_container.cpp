// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/image_container.h"

#include "recordings/bag.h"
#include "recordings/image_list.h"

#include <facetloc/io/error.h>
#include <facetloc/io/oni_file.h>

#include <fmt/format.h>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

class OniContainer : public ImageContainer {
public:
  explicit OniContainer(const fs::path& path) : file_(OniFile::open(path)) {}

  std::size_t size() const override { return file_.size(); }
  double stamp(std::size_t index) const override { return file_.stamp(index); }
  DepthImage read(std::size_t index) const override { return file_.read(index); }

  CameraFile camera() const override {
    if (!file_.camera().valid())
      throw IoError(file_.path().string(),
                    "does not tell the field of view of its camera; a camera.ini beside it would");
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

}  // namespace

bool isBag(const fs::path& path) { return lowerExtension(path) == ".bag"; }

bool isContainer(const fs::path& path) { return lowerExtension(path) == ".oni" || isBag(path); }

std::shared_ptr<const ImageContainer> openContainer(const fs::path& path, const std::string& topic) {
  if (isBag(path)) return openBag(path, topic);
  return std::make_shared<const OniContainer>(path);
}

}  // namespace facetloc::internal
