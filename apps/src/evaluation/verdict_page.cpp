// SPDX-License-Identifier: BSD-3-Clause
#include "cli/text.h"
#include "evaluation/html_report.h"
#include "evaluation/verdict.h"

#include <facetloc/io/atomic_file.h>

#include <fmt/format.h>

namespace facetloc {
namespace {

constexpr double kPaperPosition = 164, kPaperOrientationDeg = 1.9;  // 99 % bounds of the paper's Fig. 6

/** The paper's Fig. 6. */
Json::Value errorData(const EvaluationReport& report, Sample Summary::*errors, double limit,
                      double paper_bound) {
  Json::Value data;
  for (const Summary& summary : report.summaries) {
    if (summary.correct == 0) continue;
    Json::Value set;
    set["name"] = summary.name;
    for (const double error : (summary.*errors).values) set["errors"].append(error);
    data["sets"].append(set);
  }
  if (data.isNull()) return data;
  data["limit"] = limit;
  data["marks"]["99 %"] = (report.summaries.front().*errors).bound(kMarkedShare);
  if (report.beside_paper) data["marks"]["99 % in the paper"] = paper_bound;
  return data;
}

Json::Value groupData(const std::vector<ErrorGroup>& groups) {
  Json::Value rows;
  for (const ErrorGroup& group : groups)
    rows.append(chartRow({group.mean, static_cast<double>(group.summary.total),
                          static_cast<double>(group.summary.correct),
                          static_cast<double>(group.summary.best_correct)}));
  return rows;
}

std::string figuresOf(const std::vector<KeyFigure>& figures) {
  std::string html = "<div class=\"figures\">";
  for (const KeyFigure& figure : figures)
    html += fmt::format("<div><b>{}</b>{}</div>", htmlEscaped(figure.value), htmlEscaped(figure.words));
  return html + "</div>\n";
}

void addVerdict(const Verdict& verdict, const ReportFigures& figures, HtmlPage& page) {
  page.begin("verdict");
  for (const std::string& sentence : verdict.sentences) page.paragraph(sentence);
  page.end();
  for (const std::string& remark : verdict.remarks) page.paragraph(remark);
  page.begin(figures.plan.isNull() ? "first alone" : "first");
  if (!figures.plan.isNull()) page.drawing("plan", figures.plan);
  page.insert(figuresOf(verdict.figures));
  page.end();
  if (figures.map_page) page.link("map.html", "The map to turn and to click, with all answers");
  page.begin("next");
  page.paragraph("Next: " + verdict.next);
  page.end();
}

void addFindings(const Findings& findings, HtmlPage& page) {
  if (findings.empty()) return;
  page.heading("Findings");
  TextTable table({"severity", "finding", "what to do"});
  table.setWordsLast();
  for (const Finding& finding : findings)
    table.add({toString(finding.severity), printable(finding.words), printable(finding.cure)});
  page.table("Findings about the recordings and their localization", table);
}

void addMisses(const EvaluationReport& report, const std::vector<ReportPicture>& pictures, HtmlPage& page) {
  page.heading("Images that miss");
  const std::vector<ReportTable> missing = missTables(report.evaluation, judgesRelatively(report));
  if (missing.empty()) page.paragraph("None.");
  page.begin("pictures");
  for (const ReportPicture& p : pictures) page.picture(p.path, p.caption);
  page.end();
  for (const ReportTable& t : missing) {
    const std::string title = fmt::format("{} ({})", t.title, t.table.rows().size() - 1);
    page.beginFolded(title);
    page.table(title, t.table);
    page.end();
  }
}

void addTables(const EvaluationReport& report, HtmlPage& page) {
  page.heading("Tables");
  page.beginFolded(report.beside_paper ? "All figures, beside those of the paper" : "All figures");
  for (const ReportTable& t : reportTables(report)) page.table(t.title, t.table);
  page.end();
  page.beginFolded("How it was judged");
  for (const std::string& line : reportPreface(report)) page.paragraph(line);
  page.end();
}

/** The answers that cannot be acted on, where nothing is known to be true. */
void addUnsure(const EvaluationReport& report, HtmlPage& page) {
  TextTable table({"image", "answer", "probability", "reason"});
  table.setWordsLast();
  for (const FrameEvaluation& f : report.evaluation.frames)
    if (f.state != AnswerState::sure)
      table.add({(f.run.empty() ? "" : f.run + " ") + f.name, toString(f.state),
                 f.hypotheses ? fmt::format("{:.3f}", f.probability) : "-", f.reason});
  if (table.rows().size() < 2) return;
  page.heading("Images without a sure answer");
  page.beginFolded(counted(table.rows().size() - 1, "image"));
  page.table("Answers that cannot be acted on", table);
  page.end();
}

}  // namespace

Json::Value chartData(const EvaluationReport& report) {
  const Summary& summary = newImages(report.summaries);
  const std::vector<FrameEvaluation> frames = framesInQuestion(report.evaluation);
  Json::Value data;
  Json::Value& reliability = data["reliability"];
  reliability["images"] = summary.name;
  reliability["brier"] = summary.brier;
  reliability["enough"] = static_cast<Json::UInt64>(kReliableCount);
  for (const ReliabilityBin& bin : summary.reliability)
    reliability["bins"].append(
        chartRow({bin.lowest, bin.highest, static_cast<double>(bin.n), bin.mean_probability, bin.correct}));
  data["position"] =
      errorData(report, &Summary::translation_mm, 1000 * report.params.max_translation, kPaperPosition);
  data["orientation"] =
      errorData(report, &Summary::rotation_deg, report.params.max_rotation_deg, kPaperOrientationDeg);
  data["planes"] = groupData(errorsByVisiblePlanes(frames));
  data["distance"] = groupData(errorsByDistance(frames));
  for (const StartCurve& curve : report.starts)
    for (const StartCurve::Point& p : curve.points)
      data["starts"][curve.name].append(chartRow({p.x, double(p.starts), double(p.sure), double(p.right)}));
  return data;
}

void writeHtmlReport(const std::filesystem::path& folder, const EvaluationReport& report,
                     const ReportFigures& figures) {
  // A recording says more than a folder that may be called results.
  const bool of_recording = std::filesystem::is_directory(report.truth);
  HtmlPage page("Localization of " + titleOf(of_recording ? report.truth : report.results));
  addVerdict(verdictOf(report), figures, page);
  addFindings(report.findings, page);
  if (report.isJudged()) {
    page.heading("Charts");
    page.drawing("charts", chartData(report));
    addMisses(report, figures.pictures, page);
    addTables(report, page);
  } else {
    addUnsure(report, page);
  }
  writeTextAtomically(folder / "report.html", [&](std::ostream& out) { out << page.str(); });
}

}  // namespace facetloc
