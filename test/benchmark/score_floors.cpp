// SPDX-License-Identifier: BSD-3-Clause
//
// The paper's experiment on simulated floors, pooled, and the effect of each choice of ours in it.
//
//   facetloc_simulate office -o office1 --seed 1; ...
//   score_floors [--ablation] [--every N] [--map-images] [--preset paper] [--GROUP.PARAMETER VALUE] FLOOR...
//
// For each floor a map is built of its run map/ by the paper's rule, and every N-th image of its run query/
// is localized in it. With --ablation the same is done again and again, with one choice at a time put back to
// the paper's, and with two that stand in for each other. Frames are classed by the rendered truth
// (facetloc_evaluate). Two threads or twenty: same figures.
#include "cli/app.h"
#include "evaluation/evaluation.h"
#include "inputs/localization_options.h"
#include "mapped_place.h"
#include "outputs/localization_report.h"
#include "programs.h"
#include "ranking/global_localization.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace facetloc;
using namespace facetloc::internal;
using benchmarks::MappedPlace, benchmarks::percent, benchmarks::SeenRun;

/** One choice put back to the paper's. */
struct Variant {
  std::string name;
  ViewParams view;
  GlobalLocalizationParams localization;
  bool calibrated = true;  ///< as facetloc_map build does
};

std::vector<Variant> ablation(const Variant& all_of_it) {
  std::vector<Variant> variants = {all_of_it};
  const auto add = [&](const char* name) -> Variant& {
    variants.push_back(all_of_it);
    variants.back().name = name;
    return variants.back();
  };
  add("Sigma_q by eq. (4)-(5)").view.features.paper_uncertainty = true;
  add("a single EKF step").localization.ekf.iterations = 1;
  add("segment-overlap score").localization.score.by_overlap = true;
  add("no joint refinement").localization.steps.joint_refinement = false;
  Variant& plain = add("single step, no joint refinement");
  plain.localization.ekf.iterations = 1, plain.localization.steps.joint_refinement = false;
  add("no information of the floor").localization.steps.floor_information = false;
  add("no dense last degree of freedom").localization.steps.depth_assistance = false;
  Variant& free_space = add("no free-space term");
  free_space.localization.calibration.score.free_space_weight = 0;
  free_space.localization.calibration.evidence.contradiction_weight = 0;
  add("no evidence, no dense refinement").localization.evidence.enabled = false;  // the one needs the other
  add("no support by several models").localization.calibration.evidence.support_weight = 0;
  add("no dense refinement").localization.refinement.enabled = false;
  add("no calibration of the camera").calibrated = false;
  add("minimum support 1000 px").view.labels.min_support = 1000;
  return variants;
}

RunResults localized(const char* name, const SeenRun& run, const GlobalLocalization& localization,
                     int max_hypotheses) {
  std::vector<std::vector<ResultRow>> rows(run.frames.size());
  const int n = static_cast<int>(rows.size());
#pragma omp parallel for schedule(dynamic)
  for (int i = 0; i < n; ++i)
    rows[i] = resultRows(run.sequence.frames()[run.frames[i]].name, localization.localize(run.views[i]),
                         localization.map(), max_hypotheses);
  RunResults results{name, {}, {}};
  for (const auto& of_frame : rows) results.rows.insert(results.rows.end(), of_frame.begin(), of_frame.end());
  return results;
}

/** \param with_map_images the images of the mapping run are localized, too */
Evaluation evaluate(MappedPlace& floor, const Variant& variant, bool with_map_images, int max_hypotheses) {
  Map seen = floor.see(variant.view, variant.calibrated);
  benchmarks::findAmbiguity(seen, variant.localization);
  const auto map = std::make_shared<const Map>(std::move(seen));
  GlobalLocalization localization(map, variant.localization);
  localization.setNumberOfThreads(1);

  std::vector<RunResults> results = {localized("query", floor.query(), localization, max_hypotheses)};
  if (with_map_images) {
    SeenRun whole{floor.mapping().sequence, {}, {}};
    for (std::size_t i = 0; i < whole.sequence.frames().size(); ++i) whole.frames.push_back(i);
    whole.see(map->calibrated(whole.sequence.camera()->camera), variant.view);
    results.push_back(localized("map", whole, localization, max_hypotheses));
  }
  return evaluate(results, floor.truth(), floor.models(), {}, benchmarks::kPoseTolerance);
}

void printHeader() {
  std::printf("%-32s %6s %6s | %8s %8s %8s | %8s %8s %7s %6s | %17s %9s %8s\n", "", "images", "covered",
              "solvable", "covered", "rank 1", "error", "", "rank", "none", "p >= 0.9: right", "deviation",
              "nothing");
}

void print(const std::string& name, const Evaluation& evaluation) {
  const auto set = [&](auto chosen) {
    std::vector<FrameEvaluation> some;
    std::copy_if(evaluation.frames.begin(), evaluation.frames.end(), std::back_inserter(some), chosen);
    return summarize("", some);
  };
  const Summary all = set([](const FrameEvaluation&) { return true; });
  const Summary covered = set([](const FrameEvaluation& f) { return f.covered; });
  const Summary solvable = set([](const FrameEvaluation& f) { return f.solvable.value_or(false); });
  const Summary nothing = set([](const FrameEvaluation& f) { return f.unmapped; });
  std::printf("%-32s %6zu %6zu | %6.1f %% %6.1f %% %6.1f %% | %5.1f mm %4.2f deg %7.2f %4.1f %% | %6.2f %%, "
              "%5.1f %% %9.3f "
              "%4zu/%zu\n",
              name.c_str(), all.total, covered.total, percent(solvable.correct, solvable.total),
              percent(covered.correct, covered.total), percent(covered.best_correct, covered.total),
              covered.translation_mm.mean, covered.rotation_deg.mean, covered.index.mean,
              percent(covered.none, covered.total), percent(all.sure_correct, all.sure),
              percent(covered.sure_correct, covered.total), all.largest_deviation, nothing.unsure,
              nothing.total);
  std::fflush(stdout);
}

void printReliability(const Evaluation& evaluation) {
  const Summary all = summarize("", evaluation.frames);
  std::printf("\nprobability of rank 1   images   mean   correct\n");
  for (const ReliabilityBin& bin : all.reliability)
    std::printf("%12.1f to %.1f %11zu %6.3f %9.3f\n", bin.lowest, bin.highest, bin.n, bin.mean_probability,
                bin.correct);
}

/** The paper's Tables I and II, all images in one column. */
void printTable(const Evaluation& evaluation) {
  const Summary all = summarize("", evaluation.frames);
  std::printf(
      "\nall %zu images: no hypothesis %.2f %%, none correct %.2f %%, correct %.2f %%, at rank 1 %.2f %%; "
      "mean error %.1f mm, %.2f deg; mean index of the first correct one %.2f\n",
      all.total, percent(all.none, all.total), percent(all.total - all.none - all.correct, all.total),
      percent(all.correct, all.total), percent(all.best_correct, all.total), all.translation_mm.mean,
      all.rotation_deg.mean, all.index.mean);
}

/** Options as the tools have them, including algorithms and presets. */
class ScoreFloorsApp : public App {
public:
  ScoreFloorsApp()
      : App("score_floors", "FLOOR... [options]",
            "The paper's experiment on simulated floors of facetloc_simulate, pooled: a map is built of the "
            "run "
            "map/ of each floor by the paper's rule, and the images of its run query/ are localized in it.") {
  }

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("FLOOR", floors_);
    line.addOption("every", every_, "N", "Localize only every N-th image.");
    line.addSwitch("map-images", map_images_, "Also localize the images of the mapping run.");
    line.addSwitch("ablation", ablation_,
                   "Again and again, with one choice at a time put back to the paper's.");
    line.addSwitch("raw-depth", raw_depth_, "Do not estimate and remove the depth distortion.");
    line.addOption("max-hypotheses", max_hypotheses_, "K", "Maximum number of hypotheses per image.");
    line.addPresets();
    line.addParams(view_);
    addLocalizationOptions(line, localization_);
  }

  int execute(const CommandLine&, const Console&) override {
    if (every_ < 1) throw UsageError("every must be positive");
    std::vector<MappedPlace> floors;
    for (const std::string& name : floors_) floors.emplace_back(name, static_cast<std::size_t>(every_));
    const Variant all_of_it{"facetloc", view_, localization_, !raw_depth_};
    printHeader();
    for (const Variant& variant : ablation_ ? ablation(all_of_it) : std::vector<Variant>{all_of_it}) {
      Evaluation pooled;
      for (std::size_t i = 0; i < floors.size(); ++i) {
        Evaluation one = evaluate(floors[i], variant, map_images_, max_hypotheses_);
        if (!ablation_) print(floors_[i], one);
        pooled.frames.insert(pooled.frames.end(), one.frames.begin(), one.frames.end());
      }
      print(variant.name, pooled);
      if (!ablation_) printReliability(pooled);
      if (map_images_) printTable(pooled);
    }
    return kOk;
  }

  std::vector<std::string> floors_;
  int every_ = 1, max_hypotheses_ = 100;
  bool map_images_ = false, ablation_ = false, raw_depth_ = false;
  ViewParams view_;
  GlobalLocalizationParams localization_;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<ScoreFloorsApp>(argc, argv); }
