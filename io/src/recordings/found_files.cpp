// SPDX-License-Identifier: BSD-3-Clause
#include "recordings/image_list.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <system_error>

namespace facetloc::internal {
namespace {

namespace fs = std::filesystem;

/** A kind of file that is not read, and how to make one that is. */
struct Unread {
  const char* extension;
  const char* advice;
};

constexpr Unread kUnread[] = {
    {".exr", "OpenEXR is not read; as TIFF it is: oiiotool IN.exr --ch Y -d float -o OUT.tif"},
    {".hdf5",
     "HDF5 is not read; as NPY it is: python3 -c \"import h5py, numpy, sys; "
     "numpy.save(sys.argv[2], numpy.array(h5py.File(sys.argv[1])['dataset'], 'f4'))\" IN.hdf5 OUT.npy"},
    {".h5", "HDF5 is not read; as NPY it is (h5py and numpy.save)"},
    {".npz", "a .npz holds several arrays; write depth alone: numpy.save('OUT.npy', "
             "numpy.load('IN.npz')['depth'])"},
    {".db", "a database of RTAB-Map is read if it is named itself, not its folder"},
    {".oni", "an .oni recording is read if it is named itself, not its folder"},
    {".mkv", "recordings of Azure Kinects are not read; Open3D's azure_kinect_mkv_reader writes depth PNGs"},
    {".sens", "ScanNet's .sens is not read; its SensReader exports depth, pose and intrinsic folders"},
    {".klg", "Kintinuous' .klg is not read; write its depth images as PNGs"},
    {".r3d", "Record3D's .r3d is not read; its export as EXR + RGB, with the depth converted to TIFF, is"},
    {".depth", "Record3D's compressed .depth is not read; its export as EXR + RGB, converted to TIFF, is"},
    {".bin", "raw depth has no size in it; write it as NPY: numpy.save('OUT.npy', numpy.fromfile('IN.bin', "
             "'u2').reshape(HEIGHT, WIDTH))"},
    {".raw", "raw depth has no size in it; write it as NPY: numpy.save('OUT.npy', numpy.fromfile('IN.raw', "
             "'u2').reshape(HEIGHT, WIDTH))"},
    {".jpg", "JPEG holds no depth: it has 8 bits, and is not exact"},
    {".jpeg", "JPEG holds no depth: it has 8 bits, and is not exact"},
    {".ply", "PLY clouds are not organized; as organized PCD they are read"},
    {".mp4", "videos hold no depth"},
    {".zstd", "unpack it first: zstd -d"},
    {".zst", "unpack it first: zstd -d"},
    {".zip", "unpack it first"},
};

/** "120 .jpg, 3 .txt". */
std::string kindsIn(const fs::path& folder) {
  constexpr std::size_t kMostKinds = 6;
  std::map<std::string, std::size_t> kinds;
  for (const fs::path& file : files::entriesOf(folder, files::isFile)) ++kinds[lowerExtension(file)];
  std::string words;
  std::size_t n = 0;
  for (const auto& [extension, count] : kinds) {
    if (++n > kMostKinds) return words + ", ...";
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", count,
                         extension.empty() ? "without an ending" : extension);
  }
  return words;
}

std::string adviceIn(const fs::path& folder) {
  std::error_code ignored;
  std::map<std::string, std::string> found;  // keyed by advice, so that the first by name counts
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (const std::string advice = adviceOnFile(entry.path()); !advice.empty())
      found.emplace(lowerExtension(entry.path()), advice);
  for (const Unread& kind : kUnread)
    if (const auto advice = found.find(kind.extension); advice != found.end()) return advice->second;
  return {};
}

}  // namespace

std::string adviceOnFile(const fs::path& path) {
  const std::string extension = lowerExtension(path);
  for (const Unread& kind : kUnread)
    if (extension == kind.extension) return kind.advice;
  return {};
}

std::string foundIn(const fs::path& folder) {
  constexpr std::size_t kMostFolders = 8;
  std::string words = kindsIn(folder), advice = adviceIn(folder);
  const std::vector<fs::path> folders = files::entriesOf(folder, files::isFolder);
  for (std::size_t i = 0; i < folders.size() && i < kMostFolders; ++i) {
    const std::string kinds = kindsIn(folders[i]);
    words += fmt::format("{}{}/ ({})", words.empty() ? "" : ", ", folders[i].filename().string(),
                         kinds.empty() ? "no files" : kinds);
    if (advice.empty()) advice = adviceIn(folders[i]);
  }
  if (words.empty()) return "it is empty";
  return "found: " + words + (advice.empty() ? "" : "; " + advice);
}

}  // namespace facetloc::internal
