// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/io/depth_sequence.h>

#include <filesystem>
#include <string>

namespace facetloc {

/** \brief facetloc_convert: a recording of any layout -> a folder of PNGs with everything beside them. */
class ConvertApp : public App {
public:
  ConvertApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;

  CameraFile outputCamera(const DepthSequence& sequence) const;
  int writeImages(const DepthSequence& sequence, const CameraFile& camera, const Console& console) const;
  void writePoses(const DepthSequence& sequence, const Console& console) const;

  std::string input_;
  std::string folder_;
  RecordingHints recording_;
  double scale_ = 0;
  int every_ = 1;
};

}  // namespace facetloc
