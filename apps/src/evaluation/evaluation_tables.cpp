// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "evaluation/evaluation_report.h"

#include <facetloc/features/pose.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <optional>

namespace facetloc {
namespace {

constexpr const char* kNew = "new";
constexpr const char* kLocal = "Sure answers relative to their local models";
constexpr const char* kNees = "NEES of correct poses of rank 1 (right: 6)";

/** One row of a table: its name, ours for each set of frames, and the paper's figure if known. */
struct Quantity {
  using Value = std::function<double(const Summary&)>;
  const char* table;
  const char* group;  // printed above the first quantity of a group; may be empty
  const char* name;
  int decimals;
  Value value;
  std::optional<double> paper{};
  Value percent{};  // printed beside the value; may be empty
  std::optional<double> paper_percent{};
};

double shareOf(std::size_t n, std::size_t total) {
  return total == 0 ? 0 : 100.0 * static_cast<double>(n) / static_cast<double>(total);
}
double percentOf(std::size_t n, const Summary& s) { return shareOf(n, s.total); }

Quantity count(const char* table, const char* name, std::size_t Summary::*n, std::optional<double> paper = {},
               std::optional<double> paper_percent = {}) {
  Quantity quantity{table, "", name, 0, [n](const Summary& s) { return static_cast<double>(s.*n); }, paper};
  quantity.percent = [n](const Summary& s) { return percentOf(s.*n, s); };
  quantity.paper_percent = paper_percent;
  return quantity;
}

Quantity::Value moment(Sample Summary::*of, double Sample::*which) {
  return [of, which](const Summary& s) { return (s.*of).*which; };
}

/** The moments of an error, and the bound of most; \param paper of these four. */
void addErrors(const char* group, Sample Summary::*of, const std::array<std::optional<double>, 4>& paper,
               std::vector<Quantity>& all) {
  all.push_back({"II", group, "Avg.", 2, moment(of, &Sample::mean), paper[0]});
  all.push_back({"II", group, "Std.", 2, moment(of, &Sample::std), paper[1]});
  all.push_back({"II", group, "Max.", 2, moment(of, &Sample::max), paper[2]});
  all.push_back({"II", group, "99 % are below", 2,
                 [of](const Summary& s) { return (s.*of).bound(kMarkedShare); }, paper[3]});
}

std::vector<Quantity> allQuantities() {
  using Y = Summary;
  std::vector<Quantity> all = {count("I", "Total", &Y::total, 792, 100.00),
                               count("I", "No hypothesis", &Y::none, 30, 3.79),
                               count("I", "No correct hypothesis", &Y::wrong, 44, 5.56),
                               count("I", "Correct hypothesis", &Y::correct, 718, 90.65)};
  addErrors("Translation error [mm]", &Y::translation_mm, {36.83, 38.22, 199.65, 164}, all);
  addErrors("Orientation error [deg]", &Y::rotation_deg, {0.62, 0.56, 1.99, 1.9}, all);
  addErrors("Heading error [deg]", &Y::heading_deg, {}, all);
  addErrors("Index of the first correct hypothesis", &Y::index, {4.29, 25.53, 530, {}}, all);
  const std::vector<Quantity> further = {
      count("states", "Total", &Y::total, 792, 100.00),
      count("states", "Sure", &Y::sure),
      count("states", "  correct", &Y::sure_correct),
      {"states", "", "  share of the sure that is correct [%]", 2,
       [](const Y& s) { return shareOf(s.sure_correct, s.sure); }},
      count("states", "Doubtful", &Y::doubtful),
      count("states", "  rank 1 correct", &Y::doubtful_correct),
      count("states", "Unknown (in the paper: no hypothesis)", &Y::unknown, 30, 3.79),
      count("beyond", "Rank 1 correct", &Y::best_correct),
      {"beyond", "", "Recall at 100 % precision [%]", 2, [](const Y& s) { return 100 * s.recall; }},
      {"beyond", "", "  at a probability above", 4, [](const Y& s) { return s.threshold; }},
      {"beyond", "", "Brier score of rank 1", 4, [](const Y& s) { return s.brier; }},
      count("beyond", "No hypothesis, or rank 1 below 0.5", &Y::unsure),
      {"beyond", "", "Largest deviation of the probability", 3,
       [](const Y& s) { return s.largest_deviation; }},
      {"beyond", kLocal, "Poses", 0, [](const Y& s) { return static_cast<double>(s.local); }},
      {"beyond", kLocal, "Share within the limits of a correct pose [%]", 2,
       [](const Y& s) { return shareOf(s.local_correct, s.local); }},
      {"beyond", kLocal, "Translation error, avg. [mm]", 2, moment(&Y::local_translation_mm, &Sample::mean)},
      {"beyond", kLocal, "Translation error, median [mm]", 2,
       [](const Y& s) { return s.local_translation_mm.bound(0.5); }},
      {"beyond", kLocal, "Translation error, max. [mm]", 2, moment(&Y::local_translation_mm, &Sample::max)},
      {"beyond", kLocal, "Orientation error, avg. [deg]", 2, moment(&Y::local_rotation_deg, &Sample::mean)},
      {"beyond", kLocal, "Orientation error, max. [deg]", 2, moment(&Y::local_rotation_deg, &Sample::max)},
      {"beyond", kNees, "Poses", 0, [](const Y& s) { return static_cast<double>(s.nees.values.size()); }},
      {"beyond", kNees, "Avg.", 2, moment(&Y::nees, &Sample::mean)},
      {"beyond", kNees, "Median (right: 5.35)", 2, [](const Y& s) { return s.nees.bound(0.5); }},
      {"beyond", kNees, "Share within the 95 % ellipsoid [%]", 2, [](const Y& s) {
         constexpr double kEllipsoid = chiSquareQuantile(6, 0.95);
         return shareOf(static_cast<std::size_t>(std::count_if(s.nees.values.begin(), s.nees.values.end(),
                                                               [](double e) { return e <= kEllipsoid; })),
                        s.nees.values.size());
       }}};
  all.insert(all.end(), further.begin(), further.end());
  return all;
}

const std::vector<Quantity>& quantities() {
  static const std::vector<Quantity> all = allQuantities();
  return all;
}

std::string cell(double value, int decimals, std::optional<double> percent) {
  return text::decimals(value, decimals) + (percent ? fmt::format(" ({:.2f} %)", *percent) : "");
}

std::string paperCell(const Quantity& q) {
  return q.paper ? cell(*q.paper, q.decimals, q.paper_percent) : "";
}

/** Has it no meaning for these frames? */
bool isOfNothing(const Quantity& q, const Summary& s) {
  return (q.table == std::string("II") && s.correct == 0) ||
         (q.group == std::string(kNees) && s.nees.values.empty()) ||
         (q.group == std::string(kLocal) && s.local == 0);
}

std::string ownCell(const Quantity& q, const Summary& s) {
  if (isOfNothing(q, s)) return "-";
  return cell(q.value(s), q.decimals, q.percent ? std::optional<double>(q.percent(s)) : std::nullopt);
}

ReportTable quantityTable(const std::string& title, const std::string& name,
                          const std::vector<Summary>& summaries, bool beside_paper) {
  std::vector<std::string> header = {""};
  if (beside_paper) header.push_back("paper");
  for (const Summary& s : summaries) header.push_back(s.name);
  TextTable table(header);
  std::string group;
  for (const Quantity& q : quantities()) {
    if (q.table != name) continue;
    if (q.group == std::string(kLocal) && isOfNothing(q, summaries.front())) continue;
    if (group != q.group) table.add({group = q.group});
    std::vector<std::string> row = {(group.empty() ? "" : "  ") + std::string(q.name)};
    if (beside_paper) row.push_back(paperCell(q));
    for (const Summary& s : summaries) row.push_back(ownCell(q, s));
    table.add(row);
  }
  return {title, table};
}

ReportTable reliabilityTable(const std::vector<Summary>& summaries) {
  const Summary& summary = newImages(summaries);
  TextTable table({"probability", "images", "mean", "correct"});
  for (const ReliabilityBin& bin : summary.reliability) {
    const std::string range = fmt::format("{:.1f} to {:.1f}", bin.lowest, bin.highest);
    if (bin.n == 0)
      table.add({range, "0", "-", "-"});
    else
      table.add({range, std::to_string(bin.n), text::decimals(bin.mean_probability, 3),
                 text::decimals(bin.correct, 3)});
  }
  return {"RELIABILITY OF THE PROBABILITY OF RANK 1, " + summary.name, table};
}

void addErrorTable(const std::string& title, const std::string& quantity,
                   const std::vector<ErrorGroup>& groups, std::vector<ReportTable>& tables) {
  if (groups.empty()) return;
  TextTable table({quantity, "images", "correct", "rank 1", "mean error [mm]", "[deg]"});
  for (const ErrorGroup& group : groups) {
    const Summary& s = group.summary;
    const bool any = s.correct > 0;
    table.add({s.name, std::to_string(s.total), fmt::format("{:.1f} %", percentOf(s.correct, s)),
               fmt::format("{:.1f} %", percentOf(s.best_correct, s)),
               any ? text::decimals(s.translation_mm.mean, 1) : "-",
               any ? text::decimals(s.rotation_deg.mean, 2) : "-"});
  }
  tables.push_back({title, table});
}

void addTimeTable(const std::vector<StageTime>& times, std::vector<ReportTable>& tables) {
  if (times.empty()) return;
  TextTable table({"stage", "images", "mean", "median", "95 % below", "max."});
  for (const StageTime& t : times)
    table.add({t.stage, std::to_string(t.ms.values.size()), text::decimals(t.ms.mean, 1),
               text::decimals(t.ms.bound(0.5), 1), text::decimals(t.ms.bound(kMostShare), 1),
               text::decimals(t.ms.max, 1)});
  tables.push_back({"TIME PER IMAGE [ms]", table});
}

std::string errorText(const PoseError& error) {
  return fmt::format("{:.2f} m, {:.1f} deg", error.translation, error.rotation_deg);
}

std::string closestText(const FrameEvaluation& f) {
  if (f.first_correct) return fmt::format("correct at rank {}", f.first_correct);
  return f.closest ? fmt::format("rank {}: {}", f.closest, errorText(f.closest_error)) : "-";
}

std::string solvableText(const FrameEvaluation& f) {
  return f.unmapped ? "nothing there" : !f.solvable ? "" : *f.solvable ? "yes" : "no";
}

std::string nearestText(const FrameEvaluation& f) {
  if (!f.nearest) return "";
  const NearestModel& n = *f.nearest;
  return fmt::format("{}{:.2f} m, {:.1f} deg", n.name.empty() ? "" : n.name + ": ", n.distance, n.angle_deg);
}

void addMiss(const FrameEvaluation& f, TextTable& table) {
  table.add({(f.run.empty() ? "" : f.run + " ") + f.name,
             f.visible_planes ? std::to_string(*f.visible_planes) : "", solvableText(f), nearestText(f),
             f.hypotheses ? text::decimals(f.probability, 3) : "-",
             f.best_error   ? errorText(*f.best_error)
             : f.hypotheses ? "nowhere"
                            : "-",
             closestText(f), f.reason});
}

}  // namespace

std::vector<Summary> summarizeSets(const Evaluation& evaluation) {
  using F = FrameEvaluation;
  const auto isMapImage = [](const F& f) { return f.frame_class == FrameClass::map_image; };
  const auto isNew = [](const F& f) { return f.frame_class == FrameClass::new_image; };
  const auto& frames = evaluation.frames;
  const bool known = std::any_of(frames.begin(), frames.end(), isNew);
  const bool mixed = known && !std::all_of(frames.begin(), frames.end(), isNew);
  const bool several_runs =
      std::any_of(frames.begin(), frames.end(), [&](const F& f) { return f.run != frames.front().run; });

  std::vector<Summary> summaries;
  const auto add = [&](const std::string& name, const auto& chosen) {
    std::vector<FrameEvaluation> some;
    std::copy_if(frames.begin(), frames.end(), std::back_inserter(some), chosen);
    if (!some.empty()) summaries.push_back(summarize(name, some));
  };
  summaries.push_back(summarize(!known ? "all" : mixed ? "all images" : "all (new)", frames));
  if (mixed && !several_runs) add("map images", isMapImage);
  if (mixed) add(kNew, isNew);
  add("covered", [&](const F& f) { return isNew(f) && f.covered; });
  add("solvable", [&](const F& f) { return isNew(f) && f.solvable.value_or(false); });
  add("rest", [&](const F& f) { return isNew(f) && !f.covered && !f.unmapped; });
  add("nothing there", [&](const F& f) { return isNew(f) && f.unmapped; });
  return summaries;
}

const Summary& newImages(const std::vector<Summary>& summaries) {
  const auto found =
      std::find_if(summaries.begin(), summaries.end(), [](const Summary& s) { return s.name == kNew; });
  return found == summaries.end() ? summaries.front() : *found;
}

std::vector<ReportTable> reportTables(const EvaluationReport& report) {
  const bool beside_paper = report.beside_paper;
  const auto titled = [&](const char* number, const char* title) {
    return (beside_paper ? number : "") + std::string(title);
  };
  const auto table = [&](const std::string& title, const char* name) {
    return quantityTable(title, name, report.summaries, beside_paper);
  };
  std::vector<ReportTable> tables = {
      table(titled("TABLE I. ", "GLOBAL LOCALIZATION RESULTS (number of images)"), "I"),
      table(titled("TABLE II. ", "POSE ERROR AND INDEX OF THE FIRST CORRECT HYPOTHESIS"), "II"),
      table("STATES OF THE ANSWERS (number of images)", "states"),
      table(beside_paper ? "BEYOND THE PAPER" : "PROBABILITIES AND COVARIANCES", "beyond"),
      reliabilityTable(report.summaries)};
  const std::vector<FrameEvaluation> frames = framesInQuestion(report.evaluation);
  addErrorTable("ERRORS BY THE NUMBER OF VISIBLE PLANES", "planes", errorsByVisiblePlanes(frames), tables);
  addErrorTable("ERRORS BY THE DISTANCE TO THE NEAREST LOCAL MODEL", "distance [m]", errorsByDistance(frames),
                tables);
  addTimeTable(stageTimes(report.timing), tables);
  return tables;
}

std::vector<ReportTable> missTables(const Evaluation& evaluation, bool relative) {
  std::vector<ReportTable> tables;
  for (const Miss& miss : misses(evaluation, relative)) {
    if (tables.empty() || tables.back().title != toString(miss.kind)) {
      tables.push_back({toString(miss.kind),
                        TextTable({"image", "planes", "solvable", "nearest local model", "probability",
                                   "error of rank 1", "closest answer", "why no pose"})});
      tables.back().table.setWordsLast();
    }
    addMiss(miss.frame, tables.back().table);
  }
  return tables;
}

void writeTables(std::ostream& out, const std::vector<Summary>& summaries) {
  out << "table,group,quantity,paper";
  for (const Summary& s : summaries) out << "," << text::csvCell(s.name);
  out << "\n";
  for (const Quantity& q : quantities()) {
    std::string name = q.name;
    name.erase(0, name.find_first_not_of(' '));
    out << q.table << "," << text::csvCell(q.group) << "," << text::csvCell(name) << ","
        << (q.paper ? text::significant(*q.paper) : "");
    for (const Summary& s : summaries) {
      out << "," << (isOfNothing(q, s) ? "" : text::significant(q.value(s)));  // the printed table has a dash
    }
    out << "\n";
  }
  for (std::size_t i = 0; i < summaries.front().reliability.size(); ++i) {
    const ReliabilityBin& range = summaries.front().reliability[i];
    const std::string group = fmt::format("probability {:.1f} to {:.1f}", range.lowest, range.highest);
    const auto line = [&](const char* name, double (*value)(const ReliabilityBin&)) {
      out << "reliability," << group << "," << name << ",";
      for (const Summary& s : summaries) out << "," << text::significant(value(s.reliability[i]));
      out << "\n";
    };
    line("images", [](const ReliabilityBin& b) { return static_cast<double>(b.n); });
    line("mean probability", [](const ReliabilityBin& b) { return b.mean_probability; });
    line("share correct", [](const ReliabilityBin& b) { return b.correct; });
  }
}

}  // namespace facetloc
