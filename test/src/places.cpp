// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/testing/places.h>

#include <cstdlib>

namespace facetloc::test {

const char* const kLiveTool = FACETLOC_TOOLS "/facetloc_live";
const char* const kLocalizeTool = FACETLOC_TOOLS "/facetloc_localize";
const char* const kMapTool = FACETLOC_TOOLS "/facetloc_map";
const char* const kSegmentTool = FACETLOC_TOOLS "/facetloc_segment";
const char* const kMpirun = FACETLOC_MPIRUN;
const char* const kCalibration = FACETLOC_SOURCE "/apps/calibration.ini";
const char* const kGoldenFolder = FACETLOC_SOURCE "/test/apps/golden";
const char* const kSupervise = FACETLOC_SOURCE "/apps/examples/supervise.py";
const char* const kReadStream = FACETLOC_SOURCE "/apps/examples/read_stream.py";
const char* const kStreamSchema = FACETLOC_SOURCE "/apps/stream.schema.json";
const char* const kWriteBag = FACETLOC_SOURCE "/test/io/write_bag.py";
const char* const kWriteRecording = FACETLOC_SOURCE "/test/io/write_recording.py";

std::filesystem::path dataFolder(const std::string& name) {
  const char* set = std::getenv("FACETLOC_DATA");
  return std::filesystem::path(set ? set : FACETLOC_SOURCE "/../shared/data") / name;
}

}  // namespace facetloc::test
