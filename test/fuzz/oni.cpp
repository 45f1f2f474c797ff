// SPDX-License-Identifier: BSD-3-Clause
// Bytes as an .oni recording, read without OpenNI.
#include "fuzz_file.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>
#include <facetloc/io/oni_file.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto path = folder.put("walk.oni", fuzz::asText(data, size));
  fuzz::accepts<IoError>([&] {
    const OniFile recording = OniFile::open(path);
    recording.requireSound();
    for (std::size_t i = 0; i < recording.size(); ++i) recording.read(i);
  });
  fuzz::accepts<IoError>([&] {
    const DepthSequence sequence = DepthSequence::open(path);
    for (std::size_t i = 0; i < sequence.frames().size(); ++i) sequence.load(i, 4);
  });
  return 0;
}
