// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "drawing/offscreen_display.h"
#include "evaluation/evaluation_pictures.h"
#include "evaluation/evaluation_report.h"
#include "evaluation/verdict.h"
#include "inputs/depth_input.h"
#include "outputs/output_folder.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <set>
#include <stdexcept>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFailures = 6;  // that are drawn
constexpr const char* kFailureFolder = "failures";
constexpr const char* kMappingRun = "map";  // folder of a simulated place
constexpr const char* kTrajectories = "trajectory.png";
constexpr const char* kMapPage = "map.html";
constexpr const char* kExamples = "fig5.png";

/** Claims a folder, and removes the output of an earlier evaluation that this one may not replace. */
void begin(const fs::path& folder, bool overwrite, const Console& console) {
  const std::vector<std::string> earlier = {
      "report.html",          kMapPage,        "timing_summary.csv", "fig6.png",   "reliability.png",
      "errors.png",           "floor_map.png", kTrajectories,        "starts.png", "starts_by_images.csv",
      "starts_by_metres.csv", kExamples};
  std::vector<std::string> marks = earlier;
  marks.emplace_back("evaluation.txt");
  claimFolder(folder, marks, overwrite, &console);
  for (const std::string& name : earlier) fs::remove(folder / name);
  removeMisses(folder / kFailureFolder);
}

void requireSameMap(const std::vector<RunResults>& runs, const Map& map, const std::string& path) {
  std::set<std::string> names;
  for (const LocalModel& model : map.models) names.insert(model.name);
  for (const RunResults& run : runs)
    for (const ResultRow& row : run.rows)
      if (row.rank > 0 && !names.count(row.model))
        throw IoError(path, fmt::format("has no local model {}: the results are of another map", row.model));
}

/** How the drawn part of a map differs from the true poses of its images, over all of them; nothing for less
 * than three. */
std::optional<Alignment> alignmentOf(const Map& map, const TrueModelPoses& true_poses) {
  std::vector<PosePair> pairs;
  for (const LocalModel& model : map.models)
    if (const auto truth = true_poses.find(model.name);
        truth != true_poses.end() && model.T_w_m && model.part == mainPart(map))
      pairs.push_back({model.stamp, *model.T_w_m, truth->second});
  if (pairs.size() < kLeastPairs) return {};
  return withResiduals(robustlyAligned(pairs).T_true_estimated, pairs);
}

/** facetloc_evaluate: results against the truth, as the paper does it and beyond. */
class EvaluateApp : public App {
public:
  EvaluateApp()
      : App("facetloc_evaluate", "RESULTS|TRAJECTORY [GROUNDTRUTH] [options]",
            "Compares RESULTS of facetloc_localize with the truth. RESULTS is a folder, or a folder of such "
            "folders, one per run. GROUNDTRUTH is a file of poses in the TUM format, a recording with poses, "
            "or the folder of a simulated place. Prints tables and writes report.html: a verdict, charts and "
            "tables, and with --map the floor map and some failures. map.html shows all answers in the map, "
            "to turn in a browser. For a TRAJECTORY, a file in the TUM format, prints its absolute and "
            "relative errors. Replaces an earlier evaluation in the same folder. Pictures need an X display; "
            "without one, Xvfb is started if installed.") {}

private:
  /** The results to be judged, and the truth. */
  struct Input {
    std::vector<RunResults> runs;
    PlaceTruth truth;
    std::optional<Map> map;
  };

  void addOptions(CommandLine& line) override {
    line.addArgument("RESULTS", results_);
    line.addArgument("GROUNDTRUTH", truth_, false);
    line.addOption("output,o", folder_, "DIR", "Folder of the evaluation; RESULTS/evaluation unless given.");
    addOverwrite(line, overwrite_);
    line.addOption("known", known_, "FILE",
                   "Findings of facetloc_check --findings about the recordings; may be given several times.");
    line.addOption("map", map_, "MAP.flmap", "The map that the images were localized in.");
    line.addOption("map-groundtruth", map_truth_, "FILE",
                   "True poses of the map's images, if those in the map may differ.");
    line.addSwitch(
        "align", align_,
        "First align the results with the truth, by the rigid motion that most sure answers share.");
    line.addSwitch("table-paper", beside_paper_, "Show the paper's figures beside these.");
    addPoseTolerance(line, pose_tolerance_);
    addTimeOffset(line, time_offset_);
    line.addParams(params_, "evaluation", CommandLine::Shown::in_help);
    line.addExample("results walk --map office.flmap", "a report with the map");
    line.addExample("trajectory.txt walk", "errors of a trajectory");
  }

  std::vector<ModelPose> modelPoses(const std::optional<Map>& map) const {
    if (map) return modelPosesOf(*map);
    if (map_truth_.empty()) return {};
    return modelPosesOf(DepthSequence::readTruth(map_truth_, time_offset_));
  }

  TrueModelPoses trueModelPoses(const Input& input) const {
    std::optional<Trajectory> mapping;
    if (!map_truth_.empty()) mapping = DepthSequence::readTruth(map_truth_, time_offset_);
    for (const PlaceTruth::Sequence& sequence : input.truth.sequences())
      if (!mapping && sequence.folder.filename() == kMappingRun) mapping = sequence.poses;
    TrueModelPoses poses;
    if (!mapping) return poses;
    const auto add = [&](const std::string& model, std::optional<double> stamp) {
      if (!stamp) return;
      if (const auto pose = mapping->at(*stamp, pose_tolerance_)) poses[model] = *pose;
    };
    if (input.map)
      for (const LocalModel& model : input.map->models) add(model.name, model.stamp);
    else
      for (const RunResults& run : input.runs)
        for (const ResultRow& row : run.rows) add(row.model, text::to<double>(row.model));
    return poses;
  }

  std::optional<ResultsAlignment> align(Input& input) const {
    const std::vector<PosePair> pairs =
        sureAnswers(input.runs, input.truth, input.map ? modelPoses(input.map) : std::vector<ModelPose>(),
                    pose_tolerance_);
    if (pairs.size() < kLeastPairs)
      throw IoError(results_, fmt::format("has {} in a world and with a true pose, and --align needs {}",
                                          counted(pairs.size(), "sure answer"), kLeastPairs));
    ResultsAlignment alignment{robustlyAligned(pairs), pairs.size(), {}};
    const Eigen::Isometry3d& T = alignment.motion.T_true_estimated;
    std::vector<double> distances;
    for (const PosePair& pair : pairs) distances.push_back(distanceAfter(T, pair));
    alignment.errors = Sample(std::move(distances));
    moveWorld(T, input.runs);
    if (input.map)
      for (LocalModel& model : input.map->models)
        if (model.T_w_m) model.T_w_m = T * *model.T_w_m;
    return alignment;
  }

  void requireWorldPoses(const std::vector<RunResults>& runs, const std::optional<Map>& map) const {
    bool any = false, posed = false;
    for (const RunResults& run : runs)
      for (const ResultRow& row : run.rows) {
        any = any || row.rank > 0;
        posed = posed || (row.T_w_c && row.part.empty() && (!map || hasGivenPose(*map)));
      }
    if (any && !posed) throw IoError(results_, "has no world poses: the map has none");
  }

  /** The facts that the verdict rests on beside the answers. */
  void addFacts(const Input& input, EvaluationReport& report) const {
    report.beside_paper = beside_paper_;
    const auto all = [&input](const auto& holds) {
      return std::all_of(input.runs.begin(), input.runs.end(), holds);
    };
    report.as_drive = all([](const RunResults& run) { return run.as_drive; });
    for (const RunResults& run : input.runs)
      report.timing.insert(report.timing.end(), run.timing.begin(), run.timing.end());
    if (!input.map) return;
    requireSameMap(input.runs, *input.map, map_);
    const auto images = input.map->meta.find(kImagesKey);
    report.of_map = images != input.map->meta.end() && all([&](const RunResults& run) {
                      return !run.images.empty() && run.images == imageSizes(images->second);
                    });
  }

  void judge(const Input& input, EvaluationReport& report) const {
    addFacts(input, report);
    if (std::all_of(input.runs.begin(), input.runs.end(), [](const RunResults& r) { return r.rows.empty(); }))
      throw IoError(results_, "contains no results of any image");
    const TrueModelPoses true_models = trueModelPoses(input);
    report.own_frame = report.alignment || (input.map && !hasGivenPose(*input.map));
    if (report.own_frame && input.map) report.map_alignment = alignmentOf(*input.map, true_models);
    report.evaluation =
        evaluate(input.runs, input.truth, modelPoses(input.map), report.params, pose_tolerance_, true_models);
    if (report.evaluation.frames.empty()) throw IoError(truth_, "has no pose for any image of " + results_);
    if (true_models.empty() && (!input.map || modelPoses(input.map).empty()))
      requireWorldPoses(input.runs, input.map);
    report.summaries = summarizeSets(report.evaluation);
    if (const auto answers = readStarts(results_); !answers.empty())
      report.starts = startCurves(answers, report.evaluation.frames,
                                  report.alignment ? report.alignment->motion.T_true_estimated
                                                   : Eigen::Isometry3d::Identity(),
                                  report.params);
  }

  void addMap(const EvaluationReport& report, const Input& input, ReportFigures& figures) const {
    MapPage page =
        pageOfAnswers(*input.map, input.truth, input.runs, report.evaluation, judgesRelatively(report));
    figures.plan = planData(*input.map, report.evaluation, page);
    page.findings = report.findings;
    page.title = fmt::format("{} in {}", titleOf(results_), fs::path(map_).stem().string());
    writeMapPage(fs::path(folder_) / kMapPage, *input.map, page);
    figures.map_page = true;
  }

  /** Pictures of the map and of images that miss; none without the map. */
  std::vector<ReportPicture> drawPictures(const EvaluationReport& report, const Input& input,
                                          const Console& console) const {
    if (!input.map) return {};
    const OffscreenDisplay display;
    if (!display.available()) {
      console.note("no pictures: " + display.problem());
      return {};
    }
    const fs::path folder = folder_;
    const bool relative = judgesRelatively(report);
    drawMapOfRuns(folder / "floor_map.png", *input.map, input.truth, report.evaluation, relative);
    std::vector<ReportPicture> pictures =
        drawMisses(folder / kFailureFolder, chosenMisses(report.evaluation, kFailures, relative), *input.map,
                   input.truth, input.runs, relative, console);
    const fs::path examples = folder / kExamples;
    if (beside_paper_ &&
        drawExamples(examples, report.evaluation, *input.map, input.truth, input.runs, relative))
      pictures.push_back({examples, "examples of each run, as in the paper's Fig. 5, and their places"});
    return pictures;
  }

  ReportFigures figuresOf(const EvaluationReport& report, const Input& input, const Console& console) const {
    ReportFigures figures;
    // A map without poses, or a build without three.js, is no reason to miss the report.
    const auto attempt = [&](const auto& draw) {
      try {
        draw();
      } catch (const std::exception& e) {
        console.note(std::string("a picture is missing: ") + e.what());
      }
    };
    if (input.map) attempt([&] { addMap(report, input, figures); });
    if (report.isJudged()) attempt([&] { figures.pictures = drawPictures(report, input, console); });
    return figures;
  }

  int evaluateTrajectory(const Console& console) const {
    const Trajectory estimate = readTrajectory(results_);
    TrajectoryReport report{results_, truth_, {}};
    try {
      report.errors =
          trajectoryErrors(estimate, PlaceTruth::open(truth_, time_offset_).poses(), pose_tolerance_);
    } catch (const std::invalid_argument& e) {
      throw IoError(results_ + " and " + truth_, e.what());
    }
    const fs::path beside = fs::path(results_).replace_extension();
    const fs::path folder = folder_.empty() ? fs::path(beside.string() + "_evaluation") : fs::path(folder_);
    begin(folder, overwrite_, console);
    writeReport(folder, report);
    const OffscreenDisplay display;
    if (display.available())
      drawTrajectories(folder / kTrajectories, report.errors);
    else
      console.note("no pictures: " + display.problem());
    writeHtmlReport(folder, report);
    printReport(console.out, report);
    console.out << "\nevaluation in " << folder.string() << "\n";
    return kOk;
  }

  /** Reports the answers alone. */
  int reportWithoutTruth(const Input& input, EvaluationReport& report, const Console& console) const {
    if (align_ || !map_truth_.empty())
      throw UsageError("GROUNDTRUTH is missing: --align and --map-groundtruth need it");
    addFacts(input, report);
    report.evaluation = withoutTruth(input.runs);
    if (report.evaluation.frames.empty()) throw IoError(results_, "contains no results of any image");
    begin(folder_, overwrite_, console);
    writeHtmlReport(folder_, report, figuresOf(report, input, console));
    return conclude(report, console);
  }

  int conclude(const EvaluationReport& report, const Console& console) const {
    printFindings(console.out, report.findings);
    printVerdict(console.out, verdictOf(report));
    console.out << "\nevaluation in " << folder_ << "\n";
    return kOk;
  }

  int execute(const CommandLine&, const Console& console) override {
    if (fs::is_regular_file(results_)) {
      if (truth_.empty()) throw UsageError("GROUNDTRUTH is missing: a trajectory is judged by true poses");
      return evaluateTrajectory(console);
    }
    Input input{readRuns(results_, [&](const std::string& text) { console.note(text); }), {}, {}};
    if (!map_.empty()) input.map = readMap(map_);
    EvaluationReport report{results_, truth_, params_, {}, {}, {}};
    report.findings = knownFindings(known_, results_, input.runs);
    report.params = withinTruth(params_, report.findings);
    if (folder_.empty()) folder_ = (fs::path(results_) / "evaluation").string();
    if (truth_.empty()) return reportWithoutTruth(input, report, console);
    input.truth = PlaceTruth::open(truth_, time_offset_);
    if (align_) report.alignment = align(input);
    judge(input, report);
    begin(folder_, overwrite_, console);
    writeReport(folder_, report);
    writeHtmlReport(folder_, report, figuresOf(report, input, console));
    printReport(console.out, report);  // last, for who reads it may stop doing so
    printStartCurves(console.out, report.starts);
    console.out << "\n";
    return conclude(report, console);
  }

  std::string results_, truth_, folder_, map_, map_truth_;
  std::vector<std::string> known_;  // files of findings
  bool overwrite_ = false, align_ = false, beside_paper_ = false;
  double pose_tolerance_ = 0.02, time_offset_ = 0;
  EvaluationParams params_;
};

}  // namespace

std::unique_ptr<App> evaluateApp() { return std::make_unique<EvaluateApp>(); }

}  // namespace facetloc
