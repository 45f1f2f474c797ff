// SPDX-License-Identifier: BSD-3-Clause
// Bytes as frames that another program sends through a pipe.
#include "fuzz_file.h"

#include <facetloc/io/error.h>
#include <facetloc/io/pipe_frames.h>

#include <sys/mman.h>
#include <unistd.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  const int file = memfd_create("frames", MFD_CLOEXEC);
  fuzz::require(::write(file, data, size) == static_cast<ssize_t>(size), "the bytes are not written");
  ::lseek(file, 0, SEEK_SET);
  fuzz::accepts<IoError>([&] {
    PipeFrames frames(file, "the pipe");
    frames.setLines([](const std::string&) {});
    FrameConverter convert;
    while (!frames.atEnd()) {
      const auto frame = frames.next(std::chrono::milliseconds(1000));
      if (!frame) continue;
      const Intrinsics& k = frame->camera->camera.intrinsics;
      fuzz::require(k.valid() && frame->values.size() == std::size_t(k.width) * k.height,
                    "a frame is of another size");
      fuzz::require(convert(*frame).valid(), "an image is not valid");
    }
  });
  ::close(file);
  return 0;
}
