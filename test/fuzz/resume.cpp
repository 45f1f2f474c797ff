// SPDX-License-Identifier: BSD-3-Clause
// Bytes as the files that --resume reads: the tables of an interrupted run, one after the other with a zero
// byte between them, and its provenance. Frames that are kept are the same when they are kept again.
#include "fuzz_file.h"
#include "outputs/provenance.h"

#include <facetloc/io/error.h>
#include <facetloc/io/results.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace {

constexpr const char* kTables[] = {"hypotheses.csv", "covariances.csv", "timing.csv"};

/** All tables after another run has begun with them. */
std::string rewritten(const std::filesystem::path& folder) {
  std::vector<facetloc::ResultFrame> kept;
  for (const auto& [name, result] : facetloc::readResults(folder)) kept.push_back({name, 0});
  facetloc::ResultsWriter(folder, "", kept);
  std::string all;
  for (const char* table : kTables) {
    std::ifstream in(folder / table, std::ios::binary);
    all.append(std::istreambuf_iterator<char>(in), {});
  }
  return all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  std::string_view left = fuzz::asText(data, size);
  for (const char* file : {"images.txt", "params.ini"}) folder.put(file, left);
  fuzz::accepts<IoError>([&] {
    const auto before = Provenance::read(folder.path());
    before->requireSame(*before, {"0", "1"}, folder.path().string());
    fuzz::require(imageSizes(toText(before->images)) == before->images, "images differ from those written");
  });
  for (const char* table : kTables) {
    const std::size_t end = std::min(left.find('\0'), left.size());
    folder.put(table, left.substr(0, end));
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  fuzz::accepts<IoError>([&] {
    const std::string once = rewritten(folder.path());
    fuzz::require(rewritten(folder.path()) == once, "results differ from those written");
  });
  return 0;
}
