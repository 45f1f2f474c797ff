// SPDX-License-Identifier: BSD-3-Clause
// Bytes as a file of --params. Those that are read are the same when they were written and read again.
#include "cli/command_line.h"
#include "fuzz_file.h"
#include "inputs/depth_input.h"

#include <facetloc/localization/localization_params.h>

#include <sstream>

namespace facetloc::fuzz {
namespace {

/** As facetloc_localize has them. */
struct Parameters {
  DepthInput input;
  GlobalLocalizationParams localization;

  void read(const std::filesystem::path& path) {
    CommandLine line("facetloc_fuzz", "", "");
    line.addPresets();
    input.addOptions(line);
    line.addParams(localization);
    std::ostringstream out;
    line.parse({"--params=" + path.string()}, out);
  }
  std::string ini() const {
    Camera camera;
    camera.noise = input.noise;
    return toIni(input, camera) + toIni(localization);
  }
};

}  // namespace
}  // namespace facetloc::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace facetloc;
  static const fuzz::Folder folder;
  const auto path = folder.put("params.ini", fuzz::asText(data, size));
  fuzz::Parameters read, again;
  if (!fuzz::accepts<UsageError>([&] { read.read(path); })) return 0;
  again.read(folder.put("params.ini", read.ini()));
  fuzz::require(again.ini() == read.ini(), "parameters differ from those written");
  return 0;
}
