// SPDX-License-Identifier: BSD-3-Clause
// Bytes as what --resume goes on with: the journal of an interrupted run, and of what it was made. Frames
// that are read are the same when they were written and read again.
#include "base/provenance.h"
#include "base/results_journal.h"
#include "fuzz_file.h"

#include <facetloc/io/error.h>

#include <fstream>
#include <iterator>

namespace {

/** The journal after another run has begun with it. */
std::string rewritten(const std::filesystem::path& folder) {
  facetloc::ResultsJournal journal(folder);
  journal.begin(journal.read());
  std::ifstream in(folder / facetloc::kPartial, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  for (const char* file : {kPartial, "images.txt", "params.ini"}) folder.put(file, fuzz::asText(data, size));
  fuzz::accepts<IoError>([&] {
    const auto before = Provenance::read(folder.path());
    before->requireSame(*before, {"0", "1"}, folder.path().string());
    fuzz::require(imageSizes(toText(before->images)) == before->images, "images are not what was written");
  });
  fuzz::accepts<IoError>([&] {
    const std::string once = rewritten(folder.path());
    fuzz::require(rewritten(folder.path()) == once, "a journal is not what was written");
  });
  return 0;
}
