// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/provenance.h"

#include "base/text.h"
#include "cli/command_line.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <array>
#include <cmath>
#include <fmt/core.h>
#include <fstream>
#include <libdeflate.h>
#include <sstream>
#include <system_error>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char *kParams = "params.ini", *kImages = "images.txt";

void writeText(const fs::path& path, const std::string& text) {
  writeTextAtomically(path, [&](std::ostream& out) { out << text; });
}

}  // namespace

std::uintmax_t sizeOf(const FrameFile& image) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(image.path, error);
  return error ? 0 : size;
}

ImageSizes imageSizes(const DepthSequence& sequence) {
  ImageSizes sizes;
  for (const FrameFile& frame : sequence.frames()) sizes[frame.name] = sizeOf(frame);
  return sizes;
}

std::string toText(const ImageSizes& sizes) {
  std::string text;
  for (const auto& [name, size] : sizes) text += fmt::format("{} {}\n", size, name);
  return text;
}

ImageSizes imageSizes(const std::string& text) {
  ImageSizes sizes;
  std::istringstream in(text);
  std::uintmax_t size = 0;
  for (std::string name; in >> size && in.get() && std::getline(in, name);) sizes[name] = size;
  return sizes;
}

std::string cameraLine(const std::optional<CameraFile>& file) {
  if (!file) return "# camera: as the images say\n";
  const Camera& camera = file->camera;
  const Intrinsics& k = camera.intrinsics;
  std::string line = fmt::format("# camera: {}x{}", k.width, k.height);
  const auto add = [&line](const char* name, double value) {
    line += fmt::format(", {} {}", name, text::shortest(value));
  };
  add("fx", k.fx), add("fy", k.fy), add("cx", k.cx), add("cy", k.cy), add("depth_scale", file->depth_scale);
  if (const auto& mounting = camera.mounting) {
    add("mount_height", mounting->height), add("mount_tilt_deg", mounting->tilt_deg);
    const auto addIfAny = [&add](const char* name, double value) {
      if (value != 0) add(name, value);
    };
    addIfAny("mount_roll_deg", mounting->roll_deg), addIfAny("mount_pan_deg", mounting->pan_deg);
    addIfAny("mount_x", mounting->x), addIfAny("mount_y", mounting->y);
  }
  if (!std::isinf(camera.max_depth)) add("max_depth", camera.max_depth);
  const LensDistortion& lens = file->lens;
  if (!lens.isNone()) {
    add("k1", lens.k1), add("k2", lens.k2), add("k3", lens.k3), add("k4", lens.k4);
    add("k5", lens.k5), add("k6", lens.k6), add("p1", lens.p1), add("p2", lens.p2);
  }
  if (file->depth_is == DepthKind::distance) line += ", depth_is distance";
  return line + "\n";
}

std::string checksum(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::array<char, 1 << 16> bytes;
  std::uint32_t sum = 0;
  while (in.read(bytes.data(), bytes.size()), in.gcount() > 0)
    sum = libdeflate_crc32(sum, bytes.data(), static_cast<std::size_t>(in.gcount()));
  if (!in.eof()) throw IoError(file.string(), "cannot be read");
  return fmt::format("{:x}", sum);
}

std::optional<Provenance> Provenance::read(const fs::path& folder) {
  if (!fs::exists(folder / kParams)) return {};
  Provenance found{readText(folder / kParams), {}};
  if (fs::exists(folder / kImages)) found.images = imageSizes(readText(folder / kImages));
  return found;
}

void Provenance::write(const fs::path& folder) const {
  writeText(folder / kImages, toText(images));
  writeText(folder / kParams, params_ini);
}

void Provenance::requireNotReplaced(const fs::path& input, const fs::path& folder) {
  for (const char* file : {kParams, kImages}) {
    std::error_code ignored;
    if (!folder.empty() && fs::equivalent(input, folder / file, ignored))
      throw UsageError(
          fmt::format("the results would replace {}; use another output folder", input.string()));
  }
}

void Provenance::requireSame(const Provenance& now, const std::vector<std::string>& done,
                             const std::string& folder) const {
  const auto sizeIn = [](const ImageSizes& sizes, const std::string& name) {
    const auto found = sizes.find(name);
    return found == sizes.end() ? std::nullopt : std::optional(found->second);
  };
  bool same = params_ini == now.params_ini;
  for (const std::string& name : done) same = same && sizeIn(images, name) == sizeIn(now.images, name);
  if (!same)
    throw IoError(folder,
                  "was begun with another map, other images or other parameters; leave out --resume or "
                  "use another folder");
}

void requireOtherFolder(const fs::path& results, const fs::path& images) {
  std::error_code ignored;
  if (fs::equivalent(images.empty() ? fs::path(".") : images, results, ignored))
    throw UsageError(fmt::format("the results would come among the images in {}; use another output folder",
                                 results.string()));
}

void writeInputs(const fs::path& folder, const std::vector<FrameFile>& frames) {
  std::string table = "frame,file\n";
  for (const FrameFile& frame : frames)
    table += text::csvCell(frame.name) + "," + text::csvCell(frame.path.string()) + "\n";
  writeText(folder / "inputs.csv", table);
}

}  // namespace facetloc
