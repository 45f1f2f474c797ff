// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/app.h"
#include "base/depth_input.h"
#include "base/localization_hints.h"
#include "base/provenance.h"
#include "base/results_journal.h"

#include <facetloc/localization/sequence_localization.h>

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
  /** Hands out the answer to a frame as soon as it is final. */
  using Publish = std::function<void(std::size_t frame, const FrameResult& result)>;

  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  bool dealsOut() const override { return true; }
  std::string paramsIni(const std::optional<CameraFile>& file, const Camera& camera, const Map& map) const;
  std::map<std::string, FrameResult> earlierResults(const ResultsJournal& journal,
                                                    const Provenance& provenance) const;
  static std::vector<FrameResult> startWith(const std::map<std::string, FrameResult>& earlier,
                                            const std::vector<FrameFile>& frames,
                                            std::vector<std::size_t>& todo);
  std::vector<FrameResult> begin(const std::vector<FrameFile>& frames, const Provenance& provenance,
                                 ResultsJournal& journal, std::vector<std::size_t>& todo) const;
  int localize(const DepthSequence& sequence, const Camera& camera, const std::shared_ptr<const Map>& map,
               const std::vector<std::size_t>& todo, ResultsJournal& journal,
               std::vector<FrameResult>& results, const Publish& publish, const Console& console);
  int localizeAll(const CommandLine& line, const Console& console, std::ostream* out);
  SequenceLocalization newSequence(const std::shared_ptr<const Map>& map, int threads) const;
  int localizeFromStarts(const DepthSequence& sequence, const Camera& camera,
                         const std::shared_ptr<const Map>& map, const Console& console) const;
  void printSummary(const std::vector<FrameResult>& results, const Map& map, const Console& console) const;

  std::string map_;
  std::string input_path_;
  std::string folder_;
  int max_hypotheses_ = 100;
  double min_probability_ = kMinProbability;
  bool resume_ = false;
  bool streams_ = false;
  bool is_sequence_ = false;
  bool smooth_ = false;
  int starts_ = 0;
  DepthInput input_;
  GlobalLocalizationParams localization_;
  SequenceParams sequence_;
  std::vector<ViewTraits> views_;  // of the images of this run
};

}  // namespace facetloc
