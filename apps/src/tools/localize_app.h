// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "batch/shared_batch.h"
#include "cli/app.h"
#include "inputs/depth_input.h"
#include "inputs/gravity_option.h"
#include "outputs/provenance.h"
#include "tools/drive.h"

#include <facetloc/io/results.h>
#include <facetloc/localization/localizer.h>

#include <functional>
#include <map>
#include <memory>
#include <ostream>

namespace facetloc {

/** \brief facetloc_localize: finds depth images in a map, in batch. */
class LocalizeApp : public App {
public:
  LocalizeApp();

private:
  using ImageBatch = SharedBatch<std::vector<std::size_t>, LocalizedImage>;
  struct Task;  // the images and the map
  struct Run;   // work on it
  /** Hands out the answer to a frame as soon as it is final. */
  using Publish = std::function<void(std::size_t frame, const FrameResult& result)>;

  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  bool dealsOut() const override { return !is_sequence_ && !streams_; }
  void requireSense() const;
  int localizeAll(const CommandLine& line, const Console& console, std::ostream* out);
  std::string paramsIni(const std::optional<CameraFile>& file, const Camera& camera, const Map& map) const;
  std::map<std::string, FrameResult> earlierResults(const Provenance& provenance) const;
  Run begin(const Task& task) const;
  ImageBatch::Work imageWork(const Task& task, const std::vector<std::size_t>& images, int workers,
                             Drive* drive) const;
  void localize(const Task& task, Run& run, ImageBatch& batch, const Drive* drive, const Publish& publish,
                const Console& console) const;
  void smooth(const Task& task, Run& run, const std::vector<std::size_t>& localized, const Drive& drive,
              const Console& console) const;
  Localizer newLocalizer(const std::shared_ptr<const Map>& map, int threads) const;
  MeasuredMotion measuredMotion(const Task& task) const;
  int localizeFromStarts(const Task& task, const Console& console) const;
  void printSummary(const Run& run, const Map& map, const Console& console) const;

  std::string map_;
  std::string input_path_;
  std::string folder_;
  std::string map_covers_;
  std::string near_;
  std::string odometry_;
  int max_hypotheses_ = 100;
  double min_probability_ = kMinProbability;
  bool resume_ = false;
  bool streams_ = false;
  bool is_sequence_ = false;
  bool smooth_ = false;
  int starts_ = 0;
  DepthInput input_;
  GravityOption gravity_;
  OdometryError odometry_error_;
  GlobalLocalizationParams localization_;
  LocalizerParams localizer_;
};

}  // namespace facetloc
