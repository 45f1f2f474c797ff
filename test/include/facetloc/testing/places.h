// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace facetloc::test {

/** \name Absolute paths of this checkout and this build */
/// @{
extern const char* const kLiveTool;
extern const char* const kLocalizeTool;
extern const char* const kMapTool;
extern const char* const kSegmentTool;
extern const char* const kMpirun;       ///< empty if this build has no MPI
extern const char* const kCalibration;  ///< the file that ships
extern const char* const kGoldenFolder;
extern const char* const kSupervise;   ///< the example that keeps a robot localized
extern const char* const kReadStream;  ///< the example that reads the stream of a tool
extern const char* const kStreamSchema;
extern const char* const kWriteBag;
extern const char* const kWriteRecording;
/// @}

/** \brief A folder of recordings and real images beside the checkout, or below $FACETLOC_DATA; may be absent.
 */
std::filesystem::path dataFolder(const std::string& name);

}  // namespace facetloc::test
