// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/evaluation_report.h>
#include <facetloc/apps/text.h>
#include <facetloc/io/atomic_file.h>

#include <algorithm>
#include <functional>
#include <optional>

namespace facetloc {
namespace {

/** One line of a table: what it is, the paper's figure if there is one, and ours for each set of frames. */
struct Quantity {
  const char* table;
  const char* group;  // printed above the first quantity of a group; may be empty
  const char* name;
  std::optional<double> paper;
  std::optional<double> paper_percent;
  int decimals;
  std::function<double(const Summary&)> value;
  std::function<double(const Summary&)> percent;  // printed beside the value; may be empty
};

double percentOf(std::size_t n, const Summary& s) {
  return s.total == 0 ? 0 : 100.0 * static_cast<double>(n) / static_cast<double>(s.total);
}

Quantity count(const char* table, const char* name, std::optional<double> paper,
               std::optional<double> paper_percent, std::size_t Summary::*n) {
  return {table,
          "",
          name,
          paper,
          paper_percent,
          0,
          [n](const Summary& s) { return static_cast<double>(s.*n); },
          [n](const Summary& s) { return percentOf(s.*n, s); }};
}

Quantity moment(const char* group, const char* name, std::optional<double> paper, Statistics Summary::*of,
                double Statistics::*which) {
  return {"II", group, name, paper, {}, 2, [of, which](const Summary& s) { return (s.*of).*which; }, {}};
}

Quantity bound(const char* group, std::optional<double> paper, CumulativeHistogram Summary::*of) {
  return {"II",
          group,
          "99 % are below",
          paper,
          {},
          2,
          [of](const Summary& s) { return (s.*of).bound(kMarkedShare); },
          {}};
}

const std::vector<Quantity>& quantities() {
  constexpr const char* kTranslation = "Translation error [mm]";
  constexpr const char* kOrientation = "Orientation error [deg]";
  constexpr const char* kHeading = "Heading error [deg]";
  constexpr const char* kIndex = "Index of the first correct hypothesis";
  using S = Statistics;
  using Y = Summary;
  static const std::vector<Quantity> all = {
      count("I", "Total", 792, 100.00, &Y::total),
      count("I", "No hypothesis", 30, 3.79, &Y::none),
      count("I", "No correct hypothesis", 44, 5.56, &Y::wrong),
      count("I", "Correct hypothesis", 718, 90.65, &Y::correct),
      moment(kTranslation, "Avg.", 36.83, &Y::translation_stats, &S::mean),
      moment(kTranslation, "Std.", 38.22, &Y::translation_stats, &S::std),
      moment(kTranslation, "Max.", 199.65, &Y::translation_stats, &S::max),
      bound(kTranslation, 164, &Y::translation_mm),
      moment(kOrientation, "Avg.", 0.62, &Y::rotation_stats, &S::mean),
      moment(kOrientation, "Std.", 0.56, &Y::rotation_stats, &S::std),
      moment(kOrientation, "Max.", 1.99, &Y::rotation_stats, &S::max),
      bound(kOrientation, 1.9, &Y::rotation_deg),
      moment(kHeading, "Avg.", {}, &Y::heading_stats, &S::mean),
      moment(kHeading, "Std.", {}, &Y::heading_stats, &S::std),
      moment(kHeading, "Max.", {}, &Y::heading_stats, &S::max),
      bound(kHeading, {}, &Y::heading_deg),
      moment(kIndex, "Avg.", 4.29, &Y::index_stats, &S::mean),
      moment(kIndex, "Std.", 25.53, &Y::index_stats, &S::std),
      moment(kIndex, "Max.", 530, &Y::index_stats, &S::max),
      bound(kIndex, {}, &Y::index),
      count("beyond", "Rank 1 correct", {}, {}, &Y::best_correct),
      {"beyond",
       "",
       "Recall at 100 % precision [%]",
       {},
       {},
       2,
       [](const Y& s) { return 100 * s.recall; },
       {}},
      {"beyond", "", "  at a probability above", {}, {}, 4, [](const Y& s) { return s.threshold; }, {}},
      {"beyond", "", "Brier score of rank 1", {}, {}, 4, [](const Y& s) { return s.brier; }, {}}};
  return all;
}

std::string cell(double value, int decimals, std::optional<double> percent) {
  return fixed(value, decimals) + (percent ? " (" + fixed(*percent, 2) + " %)" : "");
}

std::string paperCell(const Quantity& q) {
  return q.paper ? cell(*q.paper, q.decimals, q.paper_percent) : "";
}

std::string ownCell(const Quantity& q, const Summary& s) {
  return cell(q.value(s), q.decimals, q.percent ? std::optional<double>(q.percent(s)) : std::nullopt);
}

void printTable(std::ostream& out, const std::string& name, const std::vector<Summary>& summaries) {
  std::vector<std::string> header = {"", "paper"};
  for (const Summary& s : summaries) header.push_back(s.name);
  TextTable table(header);
  std::string group;
  for (const Quantity& q : quantities()) {
    if (q.table != name) continue;
    if (group != q.group) table.add({group = q.group});
    std::vector<std::string> row = {(group.empty() ? "" : "  ") + std::string(q.name), paperCell(q)};
    for (const Summary& s : summaries) row.push_back(ownCell(q, s));
    table.add(row);
  }
  out << table;
}

void printReliability(std::ostream& out, const Summary& summary) {
  TextTable table({"probability", "images", "mean", "correct"});
  for (const ReliabilityBin& bin : summary.reliability) {
    const std::string range = fixed(bin.lowest, 1) + " to " + fixed(bin.highest, 1);
    if (bin.n == 0)
      table.add({range, "0", "-", "-"});
    else
      table.add({range, std::to_string(bin.n), fixed(bin.mean_probability, 3), fixed(bin.correct, 3)});
  }
  out << table;
}

void writeTables(std::ostream& out, const std::vector<Summary>& summaries) {
  out << "table,group,quantity,paper";
  for (const Summary& s : summaries) out << "," << csvCell(s.name);
  out << "\n";
  for (const Quantity& q : quantities()) {
    std::string name = q.name;
    name.erase(0, name.find_first_not_of(' '));
    out << q.table << "," << csvCell(q.group) << "," << csvCell(name) << ","
        << (q.paper ? shortNumber(*q.paper) : "");
    for (const Summary& s : summaries) out << "," << shortNumber(q.value(s));
    out << "\n";
  }
  for (std::size_t i = 0; i < summaries.front().reliability.size(); ++i) {
    const ReliabilityBin& range = summaries.front().reliability[i];
    const std::string group = "probability " + fixed(range.lowest, 1) + " to " + fixed(range.highest, 1);
    const auto line = [&](const char* name, double (*value)(const ReliabilityBin&)) {
      out << "reliability," << group << "," << name << ",";
      for (const Summary& s : summaries) out << "," << shortNumber(value(s.reliability[i]));
      out << "\n";
    };
    line("images", [](const ReliabilityBin& b) { return static_cast<double>(b.n); });
    line("mean probability", [](const ReliabilityBin& b) { return b.mean_probability; });
    line("share correct", [](const ReliabilityBin& b) { return b.correct; });
  }
}

void writeFrames(std::ostream& out, const Evaluation& evaluation) {
  out << "frame,stamp,class,covered,hypotheses,first_correct_rank,translation_mm,orientation_deg,heading_deg,"
         "rank1_probability,rank1_translation_mm,rank1_orientation_deg,nearest_model,nearest_distance_m,"
         "nearest_angle_deg,reason\n";
  for (const FrameEvaluation& f : evaluation.frames) {
    const bool known = f.frame_class != FrameClass::unknown;
    out << csvCell(f.name) << "," << exactNumber(f.stamp) << "," << toString(f.frame_class) << ","
        << (known ? (f.covered ? "1" : "0") : "") << "," << f.hypotheses << "," << f.first_correct << ",";
    if (f.first_correct)
      out << shortNumber(1000 * f.first_correct_error.translation) << ","
          << shortNumber(f.first_correct_error.rotation_deg) << ","
          << shortNumber(f.first_correct_error.heading_deg);
    else
      out << ",,";
    if (f.hypotheses)
      out << "," << shortNumber(f.probability) << "," << shortNumber(1000 * f.best_error.translation) << ","
          << shortNumber(f.best_error.rotation_deg);
    else
      out << ",,,";
    if (f.nearest)
      out << "," << csvCell(f.nearest->name) << "," << shortNumber(f.nearest->distance) << ","
          << shortNumber(f.nearest->angle_deg);
    else
      out << ",,,";
    out << "," << csvCell(f.reason) << "\n";
  }
}

void writeHistograms(std::ostream& out, const std::vector<Summary>& summaries) {
  out << "set,share,translation_mm,orientation_deg,index\n";
  for (const Summary& s : summaries)
    for (std::size_t i = 0; i < s.translation_mm.x.size(); ++i)
      out << csvCell(s.name) << "," << shortNumber(s.translation_mm.y[i]) << ","
          << shortNumber(s.translation_mm.x[i]) << "," << shortNumber(s.rotation_deg.x[i]) << ","
          << shortNumber(s.index.x[i]) << "\n";
}

}  // namespace

std::vector<Summary> summarizeSets(const Evaluation& evaluation) {
  using F = FrameEvaluation;
  const auto isMapImage = [](const F& f) { return f.frame_class == FrameClass::map_image; };
  const auto isNew = [](const F& f) { return f.frame_class == FrameClass::new_image; };
  std::vector<Summary> summaries = {summarize("all", evaluation.frames)};
  const auto add = [&](const std::string& name, const auto& chosen) {
    Summary summary = summarize(name, evaluation.frames, chosen);
    if (summary.total > 0) summaries.push_back(std::move(summary));
  };
  if (std::any_of(evaluation.frames.begin(), evaluation.frames.end(), isMapImage)) {
    add("map images", isMapImage);
    add("new images", isNew);
    add("new and covered", [&](const F& f) { return isNew(f) && f.covered; });
  } else {
    if (isNew(evaluation.frames.front())) summaries.front().name = "all (new)";
    add("covered", [](const F& f) { return f.covered; });
  }
  return summaries;
}

void printReport(std::ostream& out, const EvaluationReport& report) {
  const EvaluationParams& p = report.params;
  out << "Results " << report.results << " against " << report.truth << "\n"
      << "Correct: position within " << shortNumber(p.max_translation) << " m and orientation within "
      << shortNumber(p.max_rotation_deg) << " deg.";
  if (report.evaluation.frames.front().nearest)
    out << " Covered: a local model within " << shortNumber(p.covered_distance) << " m and "
        << shortNumber(p.covered_rotation_deg) << " deg.";
  out << "\n";
  if (!report.evaluation.without_truth.empty())
    out << "Left out, without a true pose: " << counted(report.evaluation.without_truth.size(), "image")
        << ".\n";
  out << "\nTABLE I. GLOBAL LOCALIZATION RESULTS (number of images)\n";
  printTable(out, "I", report.summaries);
  out << "\nTABLE II. POSE ERROR AND INDEX OF THE FIRST CORRECT HYPOTHESIS\n";
  printTable(out, "II", report.summaries);
  out << "\nBEYOND THE PAPER\n";
  printTable(out, "beyond", report.summaries);
  out << "\nRELIABILITY OF THE PROBABILITY OF RANK 1, ALL IMAGES\n";
  printReliability(out, report.summaries.front());
}

void writeReport(const std::filesystem::path& folder, const EvaluationReport& report) {
  writeTextAtomically(folder / "evaluation.txt", [&](std::ostream& out) { printReport(out, report); });
  writeTextAtomically(folder / "tables.csv", [&](std::ostream& out) { writeTables(out, report.summaries); });
  writeTextAtomically(folder / "frames.csv", [&](std::ostream& out) { writeFrames(out, report.evaluation); });
  writeTextAtomically(folder / "fig6.csv",
                      [&](std::ostream& out) { writeHistograms(out, report.summaries); });
}

}  // namespace facetloc
