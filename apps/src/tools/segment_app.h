// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"
#include "inputs/depth_input.h"
#include "outputs/provenance.h"

#include <filesystem>

namespace facetloc {

/** \brief facetloc_segment: depth images -> planar surface segments, in batch. */
class SegmentApp : public App {
public:
  SegmentApp();

private:
  struct Image;  // one image of one of the inputs, and where it goes
  class Worker;

  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  bool dealsOut() const override { return !measures_noise_; }
  int measureNoise(const CommandLine& line, const Console& console) const;
  std::vector<Image> images(const std::vector<DepthSequence>& sequences) const;
  std::filesystem::path segmentsOf(const Image& image) const;
  bool done(const Image& image) const;
  struct Output;  // results of an image
  std::vector<Output> outputs() const;
  void removeResultsOf(const std::string& name) const;
  Provenance provenance(const std::vector<Image>& images, const CommandLine& line) const;
  std::vector<std::size_t> prepare(const std::vector<Image>& images, const Provenance& provenance) const;

  std::vector<std::string> inputs_;
  std::string folder_;
  bool labels_ = false;
  bool overlay_ = false;
  bool pcd_ = false;
  bool ply_ = false;
  bool resume_ = false;
  bool measures_noise_ = false;
  DepthInput input_;
};

}  // namespace facetloc
