// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a .scene file. A place that is quickly made is also made, and one image of it.
#include "frame_source.h"
#include "fuzz_file.h"

#include <facetloc/io/error.h>

#include <optional>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto path = folder.put("a.scene", fuzz::asText(data, size));
  std::optional<SceneFile> file;
  fuzz::accepts<IoError>([&] { file = readSceneFile(path); });
  constexpr int kQuickFrames = 20, kQuickWidth = 60;
  if (!file || file->frames + file->jump > kQuickFrames || file->width > kQuickWidth) return 0;
  fuzz::accepts<IoError>([&] {
    const auto source = openFrameSource(path);
    std::vector<std::uint16_t> depth(static_cast<std::size_t>(source->camera().width) *
                                     static_cast<std::size_t>(source->camera().height));
    source->read(source->size() - 1, depth.data());
  });
  return 0;
}
