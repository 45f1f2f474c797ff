// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fuzz_file.h"
#include "recordings/image_container.h"
#include "recordings/message_file.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>

namespace facetloc::fuzz {

/** \brief Reads everything that a recording of messages can hold. */
inline void readMessageRecording(const std::filesystem::path& path) {
  accepts<IoError>([&] {
    const auto file = internal::openMessageFile(path);
    for (const internal::MessageEntry& entry : file->entries()) accepts<IoError>([&] { file->read(entry); });
  });
  accepts<IoError>([&] {
    const DepthSequence sequence = DepthSequence::open(path);
    sequence.gravity(1);
    for (std::size_t i = 0; i < sequence.frames().size(); ++i) accepts<IoError>([&] { sequence.load(i, 4); });
  });
  accepts<IoError>([&] { internal::readMessageOdometry(path, "camera"); });
}

}  // namespace facetloc::fuzz
