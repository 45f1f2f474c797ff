// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/charts.h>
#include <facetloc/apps/evaluate_app.h>
#include <facetloc/apps/offscreen_display.h>
#include <facetloc/apps/text.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>

#include <algorithm>
#include <filesystem>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

using Colour = std::array<std::uint8_t, 3>;
constexpr std::array<Colour, 5> kColours = {
    {{31, 119, 180}, {44, 160, 44}, {255, 127, 14}, {148, 103, 189}, {140, 86, 75}}};
constexpr Colour kGrey = {110, 110, 110};
constexpr Colour kRed = {200, 40, 40};
constexpr double kManyRanks = 30;  // from here on the axis of ranks is logarithmic

/** A histogram as a staircase from the axis to the edge of the chart. */
Curve staircase(const Summary& summary, const CumulativeHistogram& histogram, const Panel& panel,
                const Colour& colour) {
  Curve curve;
  curve.label = summary.name + " (" + std::to_string(histogram.x.size()) + ")";
  curve.colour = colour;
  double share = 0;
  const auto add = [&](double x, double y) {
    curve.x.push_back(x);
    curve.y.push_back(y);
  };
  add(panel.x_min, 0);
  for (std::size_t i = 0; i < histogram.x.size(); ++i) {
    add(histogram.x[i], share);
    share = histogram.y[i];
    add(histogram.x[i], share);
  }
  add(panel.x_max, share);
  return curve;
}

/** The 99 % mark of Fig. 6: across to the curve and down to the axis. */
Curve mark(const Panel& panel, double bound, const std::string& label, const Colour& colour) {
  Curve curve;
  curve.label = label;
  curve.x = {panel.x_min, bound, bound};
  curve.y = {kMarkedShare, kMarkedShare, 0};
  curve.colour = colour;
  curve.width = 1.5f;
  curve.dashed = true;
  return curve;
}

struct Fig6Panel {
  Panel panel;
  CumulativeHistogram Summary::*histogram;
  int decimals;
  std::string unit;
  double paper_bound;  // 0 = the paper does not tell it in words
};

Panel drawn(const Fig6Panel& what, const std::vector<Summary>& summaries) {
  Panel panel = what.panel;
  panel.y_title = "Share of images";
  panel.y_max = 1.02;
  for (std::size_t i = 0; i < summaries.size(); ++i)
    panel.curves.push_back(
        staircase(summaries[i], summaries[i].*what.histogram, panel, kColours[i % kColours.size()]));
  panel.curves.front().width = 5;  // shows beside the others where they coincide
  const double bound = (summaries.front().*what.histogram).bound(kMarkedShare);
  panel.curves.push_back(mark(panel, bound, "99 %: " + fixed(bound, what.decimals) + what.unit, kRed));
  if (what.paper_bound > 0)
    panel.curves.push_back(mark(panel, what.paper_bound,
                                "99 % in the paper: " + fixed(what.paper_bound, what.decimals) + what.unit,
                                kGrey));
  return panel;
}

std::vector<Panel> fig6(const EvaluationReport& report) {
  Panel position, orientation, index;
  position.title = "Error in position";
  position.x_title = "Translation error [mm]";
  position.x_max = 1000 * report.params.max_translation;
  position.place = {0, 0.5f, 0.5f, 0.5f};
  orientation.title = "Error in orientation";
  orientation.x_title = "Orientation error [deg]";
  orientation.x_max = report.params.max_rotation_deg;
  orientation.place = {0.5f, 0.5f, 0.5f, 0.5f};
  index.title = "Index of the first correct hypothesis";
  index.x_title = "Rank";
  index.place = {0, 0, 1, 0.5f};
  const double largest = report.summaries.front().index_stats.max;
  index.logarithmic_x = largest > kManyRanks;
  index.whole_x = !index.logarithmic_x;
  index.x_min = index.logarithmic_x ? 1 : 0;
  index.x_max = std::max(largest, 4.0) + 1;

  std::vector<Panel> panels;
  const auto& summaries = report.summaries;
  panels.push_back(drawn({position, &Summary::translation_mm, 0, " mm", 164}, summaries));
  panels.push_back(drawn({orientation, &Summary::rotation_deg, 1, " deg", 1.9}, summaries));
  panels.push_back(drawn({index, &Summary::index, 0, "", 0}, summaries));
  return panels;
}

Panel reliabilityPanel(const Summary& summary) {
  Curve ideal, ours;
  ideal.label = "ideal";
  ideal.x = ideal.y = {0, 1};
  ideal.colour = kGrey;
  ideal.width = 1.5f;
  ideal.dashed = true;
  ours.label = "rank 1, Brier score " + fixed(summary.brier, 3);
  ours.markers = true;
  for (const ReliabilityBin& bin : summary.reliability) {
    if (bin.n == 0) continue;
    ours.x.push_back(bin.mean_probability);
    ours.y.push_back(bin.correct);
  }
  Panel panel;
  panel.title = "Reliability of the probability";
  panel.x_title = "Mean probability of rank 1";
  panel.y_title = "Share of images where it is correct";
  panel.y_max = 1.02;
  panel.place = {0, 0.3f, 1, 0.7f};
  panel.curves = {ideal, ours};
  return panel;
}

/** How many images each bin holds, as bars drawn by a line. */
Panel countsPanel(const Summary& summary) {
  Curve bars;
  double most = 1;
  for (const ReliabilityBin& bin : summary.reliability) {
    const double n = static_cast<double>(bin.n);
    most = std::max(most, n);
    for (const auto& [x, y] :
         {std::pair(bin.lowest, 0.0), {bin.lowest, n}, {bin.highest, n}, {bin.highest, 0.0}}) {
      bars.x.push_back(x);
      bars.y.push_back(y);
    }
  }
  Panel panel;
  panel.x_title = "Probability of rank 1";
  panel.y_title = "Images";
  panel.y_max = 1.05 * most;
  panel.place = {0, 0, 1, 0.3f};
  panel.curves = {bars};
  return panel;
}

}  // namespace

std::vector<ModelPose> modelPosesOf(const Trajectory& run, const MapBuilderParams& params) {
  std::vector<ModelPose> models;
  MapBuilder rule(params);
  for (const StampedPose& pose : run.poses())
    if (rule.accept(pose.T_w_c)) models.push_back({"", pose.stamp, pose.T_w_c});
  return models;
}

EvaluateApp::EvaluateApp()
    : App("facetloc_evaluate", "RESULTS GROUNDTRUTH [options]",
          "Judges a results folder of facetloc_localize by the true camera poses (a file in the TUM format, "
          "or a "
          "sequence folder with groundtruth.txt) and prints the "
          "paper's "
          "Tables I and II beside the paper's figures, the rate of rank 1, recall at 100 % precision and how "
          "reliable "
          "the probabilities are. Where the map is known, images are told apart: map images, new images, and "
          "those "
          "that a local model covers. Writes evaluation.txt, tables.csv, frames.csv, fig6.csv, fig6.png and "
          "reliability.png.") {}

void EvaluateApp::addOptions(CommandLine& line) {
  line.addArgument("RESULTS", results_);
  line.addArgument("GROUNDTRUTH", truth_);
  line.addOption("output,o", folder_, "DIR", "Folder of the evaluation; RESULTS/evaluation if not given.");
  line.addOption("map", map_, "MAP.flmap", "The map that the images were localized in.");
  line.addOption("map-groundtruth", map_truth_, "FILE",
                 "Without --map: the trajectory of the map's images, one pose per image.");
  line.addOption("pose-tolerance", pose_tolerance_, "S",
                 "Largest distance in time of an image and its pose [s].");
  line.addParams(params_);
  line.addOption("model-distance", builder_.min_distance, "M",
                 "With --map-groundtruth: spacing of local models [m].");
  line.addOption("model-rotation-deg", builder_.min_rotation_deg, "DEG",
                 "With --map-groundtruth: their spacing in orientation [deg].");
}

std::vector<ModelPose> EvaluateApp::modelPoses() const {
  if (map_.empty())
    return map_truth_.empty() ? std::vector<ModelPose>()
                              : modelPosesOf(readTumTrajectory(map_truth_), builder_);
  std::vector<ModelPose> models;
  for (const LocalModel& model : readMap(map_).models)
    if (model.T_w_m) models.push_back({model.name, model.stamp, *model.T_w_m});
  return models;
}

void EvaluateApp::drawPictures(const EvaluationReport& report, const Console& console) const {
  const OffscreenDisplay display;
  if (!display.available()) return console.note("no pictures: " + display.problem());
  const fs::path folder = folder_;
  drawCharts(folder / "fig6.png", 1200, 960, fig6(report));
  const Summary& all = report.summaries.front();
  drawCharts(folder / "reliability.png", 720, 900, {reliabilityPanel(all), countsPanel(all)});
}

int EvaluateApp::execute(const CommandLine&, const Console& console) {
  if (fs::is_directory(truth_)) truth_ = (fs::path(truth_) / "groundtruth.txt").string();
  EvaluationReport report{results_, truth_, params_, {}, {}};
  const std::vector<ResultRow> rows = readHypotheses(results_);
  report.evaluation = evaluate(rows, readTumTrajectory(truth_), modelPoses(), params_, pose_tolerance_);
  if (report.evaluation.frames.empty()) throw IoError(truth_, "has no pose for any image of " + results_);
  const bool any = std::any_of(rows.begin(), rows.end(), [](const ResultRow& row) { return row.rank > 0; });
  const bool posed =
      std::any_of(rows.begin(), rows.end(), [](const ResultRow& row) { return row.T_w_c.has_value(); });
  if (any && !posed) throw IoError(results_, "has no world poses: the map has none");
  report.summaries = summarizeSets(report.evaluation);

  if (folder_.empty()) folder_ = (fs::path(results_) / "evaluation").string();
  createFolder(folder_);
  printReport(console.out, report);
  writeReport(folder_, report);
  drawPictures(report, console);
  console.out << "\nevaluation in " << folder_ << "\n";
  return kOk;
}

}  // namespace facetloc
