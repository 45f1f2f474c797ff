// SPDX-License-Identifier: BSD-3-Clause
//
// The paper's experiment on simulated floors, pooled, and what each choice of ours is worth in it.
//
//   facetloc_simulate office -o office1 --seed 1; ...
//   score_floors [--ablation] [--every N] [--set PARAMETER VALUE] FLOOR...
//
// For each floor a map is built of its run map/ by the paper's rule, and every N-th image of its run query/
// is localized in it. With --ablation the same is done again and again, with one choice at a time put back to
// the paper's. Frames are classed by the rendered truth (facetloc_evaluate). Two threads or twenty: same
// figures.
#include "evaluation/evaluation.h"
#include "mapping_camera.h"
#include "set_parameter.h"
#include "tools/localization_report.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/registration/global_localization.h>
#include <facetloc/registration/map_builder.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace facetloc;

constexpr int kWorkingWidth = 320;
constexpr int kMaxHypotheses = 100;  // per image, as facetloc_localize keeps them

/** One choice put back to the paper's. */
struct Variant {
  const char* name;
  ViewParams view;
  GlobalLocalizationParams localization;
  bool calibrated = true;  ///< as facetloc_map build does
};

std::vector<Variant> variants(bool ablation) {
  std::vector<Variant> all = {{"facetloc", {}, {}, true}};
  if (!ablation) return all;
  const auto add = [&all](const char* name) -> Variant& {
    all.push_back({name, {}, {}, true});
    return all.back();
  };
  Variant& sigma = add("Sigma_q by eq. (4)-(5)");
  sigma.view.features.faithful = true;
  sigma.view.features.faithful_factor = 1;
  add("a single EKF step").localization.registration.ekf.iterations = 1;
  add("segment-overlap score").localization.registration.consensus.surface_score = true;
  add("no joint refinement").localization.registration.joint_refinement = false;
  add("no information of the floor").localization.registration.floor_information = false;
  add("no dense last degree of freedom").localization.registration.depth_assistance = false;
  Variant& free_space = add("no free-space term");
  free_space.localization.registration.consensus.free_space_weight = 0;
  free_space.localization.ranking.contradiction_weight = 0;
  add("no multi-model evidence").localization.ranking.multi_model = false;
  add("no support by several models").localization.ranking.support_weight = 0;
  add("no dense refinement").localization.ranking.dense_refinement = false;
  add("no calibration of the camera").calibrated = false;
  add("minimum support 1000 px").view.features.min_support = 1000;
  return all;
}

/** The views of some images of a run. */
struct Run {
  DepthSequence sequence;
  std::vector<std::size_t> frames;
  std::vector<View> views;

  void see(const ViewParams& params) {
    views.assign(frames.size(), {});
    const int n = static_cast<int>(frames.size());
#pragma omp parallel
    {
      ViewBuilder builder(params);
#pragma omp for schedule(dynamic)
      for (int i = 0; i < n; ++i) views[i] = builder.build(sequence.load(frames[i], kWorkingWidth));
    }
  }
};

class Floor {
public:
  Floor(const fs::path& folder, std::size_t every)
      : truth_(PlaceTruth::open(folder)),
        mapping_{DepthSequence::open(folder / "map"), {}, {}},
        query_{DepthSequence::open(folder / "query"), {}, {}} {
    MapBuilder rule;
    for (std::size_t i = 0; i < mapping_.sequence.frames().size(); ++i) {
      const FrameFile& frame = mapping_.sequence.frames()[i];
      const auto pose = truth_.poses().nearest(frame.stamp, kTolerance);
      if (!pose || !rule.accept(*pose)) continue;
      mapping_.frames.push_back(i);
      models_.push_back({frame.name, frame.stamp, *pose});
    }
    for (std::size_t i = 0; i < query_.sequence.frames().size(); i += every) query_.frames.push_back(i);
  }

  Evaluation evaluate(Variant variant) {
    mapping_.see(variant.view);
    if (variant.calibrated) {
      const Map raw = map();
      variant.view.distortion = benchmarks::distortionOf(raw, variant.view.noise);
      mapping_.see(variant.view);
    }
    query_.see(variant.view);
    const auto map = std::make_shared<const Map>(this->map());
    GlobalLocalization localization(map, variant.localization, variant.view.noise);
    localization.setNumberOfThreads(1);

    std::vector<std::vector<ResultRow>> rows(query_.frames.size());
    const int n = static_cast<int>(rows.size());
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < n; ++i)
      rows[i] = resultRows(query_.sequence.frames()[query_.frames[i]].name,
                           localization.localize(query_.views[i]), *map, kMaxHypotheses);
    RunResults results{"query", {}, {}};
    for (const auto& of_frame : rows)
      results.rows.insert(results.rows.end(), of_frame.begin(), of_frame.end());
    return facetloc::evaluate({results}, truth_, models_, {}, kTolerance);
  }

private:
  static constexpr double kTolerance = 0.02;  // [s]

  Map map() const {
    Map map;
    map.mounting = mapping_.sequence.camera()->mounting;
    for (std::size_t i = 0; i < models_.size(); ++i)
      map.models.push_back({models_[i].name, models_[i].stamp, models_[i].T_w_m, mapping_.views[i]});
    return map;
  }

  PlaceTruth truth_;
  Run mapping_, query_;
  std::vector<ModelPose> models_;
};

double percent(std::size_t n, std::size_t of) {
  return of == 0 ? 0 : 100.0 * static_cast<double>(n) / static_cast<double>(of);
}

void printHeader() {
  std::printf("%-32s %6s %6s | %8s %8s %8s | %8s %8s %7s %6s | %17s %9s %8s\n", "", "images", "covered",
              "solvable", "covered", "rank 1", "error", "", "rank", "none", "p >= 0.9: right", "deviation",
              "nothing");
}

void print(const std::string& name, const Evaluation& evaluation) {
  const auto set = [&](auto chosen) { return summarize("", evaluation.frames, chosen); };
  const Summary all = set([](const FrameEvaluation&) { return true; });
  const Summary covered = set([](const FrameEvaluation& f) { return f.covered; });
  const Summary solvable = set([](const FrameEvaluation& f) { return f.solvable.value_or(false); });
  const Summary nothing = set([](const FrameEvaluation& f) { return f.unmapped; });
  std::printf("%-32s %6zu %6zu | %6.1f %% %6.1f %% %6.1f %% | %5.1f mm %4.2f deg %7.2f %4.1f %% | %6.2f %%, "
              "%5.1f %% %9.3f "
              "%4zu/%zu\n",
              name.c_str(), all.total, covered.total, percent(solvable.correct, solvable.total),
              percent(covered.correct, covered.total), percent(covered.best_correct, covered.total),
              covered.translation_stats.mean, covered.rotation_stats.mean, covered.index_stats.mean,
              percent(covered.none, covered.total), percent(all.confident_correct, all.confident),
              percent(covered.confident_correct, covered.total), all.largest_deviation, nothing.unsure,
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

int run(int argc, char** argv) {
  bool ablation = false;
  std::size_t every = 1;
  std::vector<Floor> floors;
  std::vector<std::string> names;
  std::vector<std::pair<std::string, double>> settings;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--ablation") {
      ablation = true;
    } else if (argument == "--every" && i + 1 < argc) {
      every = std::max(1l, std::atol(argv[++i]));
    } else if (argument == "--set" && i + 2 < argc) {
      settings.emplace_back(argv[i + 1], std::atof(argv[i + 2]));
      i += 2;
    } else {
      names.push_back(argument);
    }
  }
  if (names.empty()) {
    std::fprintf(stderr, "usage: score_floors [--ablation] [--every N] [--set NAME VALUE] FLOOR...\n");
    return 2;
  }
  for (const std::string& name : names) floors.emplace_back(name, every);

  printHeader();
  for (Variant variant : variants(ablation)) {
    for (const auto& [name, value] : settings)
      if (!benchmarks::setParameter(variant.localization, name, value))
        throw std::invalid_argument("no parameter " + name);
    Evaluation pooled;
    for (std::size_t i = 0; i < floors.size(); ++i) {
      Evaluation one = floors[i].evaluate(variant);
      if (!ablation) print(names[i], one);
      pooled.frames.insert(pooled.frames.end(), one.frames.begin(), one.frames.end());
    }
    print(variant.name, pooled);
    if (!ablation) printReliability(pooled);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "score_floors: %s\n", e.what());
    return 1;
  }
}
