// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "sql.h"
#include "temporary_folder.h"

#include <facetloc/io/depth_sequence.h>

namespace facetloc::test {

/** \brief Changes a recording that is a database. \return the error of reading all its images; empty if they
 * are read. */
inline std::string errorWhenChanged(const std::filesystem::path& recording, const char* statement) {
  sql(recording, statement);
  return ioErrorOf([&] {
    const DepthSequence read = DepthSequence::open(recording);
    for (std::size_t i = 0; i < read.frames().size(); ++i) read.load(i);
  });
}

}  // namespace facetloc::test
