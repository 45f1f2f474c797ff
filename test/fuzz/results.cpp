// SPDX-License-Identifier: BSD-3-Clause
// Bytes as the tables of a results folder.
#include "fuzz_file.h"

#include <facetloc/io/error.h>
#include <facetloc/io/results.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  for (const char* table : {"hypotheses.csv", "covariances.csv", "shares.csv", "timing.csv"})
    folder.put(table, fuzz::asText(data, size));
  fuzz::accepts<IoError>([&] { readHypotheses(folder.path()); });
  fuzz::accepts<IoError>([&] { readCovariances(folder.path()); });
  fuzz::accepts<IoError>([&] { readShares(folder.path()); });
  fuzz::accepts<IoError>([&] { readTiming(folder.path()); });
  return 0;
}
