// SPDX-License-Identifier: BSD-3-Clause
// Bytes as an organized PCD file, with and without a camera that is known.
#include "fuzz_file.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/io/error.h>

#include <pcl/console/print.h>

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto path = folder.put("0.pcd", fuzz::asText(data, size));
  const Intrinsics camera{8, 6, 7, 7, 3.5, 2.5};
  fuzz::accepts<IoError>([&] { readDepthPcd(path); });
  fuzz::accepts<IoError>([&] { readDepthPcd(path, camera); });
  fuzz::accepts<IoError>([&] { DepthSequence::open(path).load(0, 4); });
  return 0;
}
