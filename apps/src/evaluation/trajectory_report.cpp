// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "drawing/pictures.h"
#include "evaluation/evaluation_report.h"
#include "evaluation/html_report.h"

#include <facetloc/features/pose.h>
#include <facetloc/io/atomic_file.h>

#include <cmath>
#include <fmt/format.h>

namespace facetloc {
namespace {

constexpr double kMillimetres = 1000;  // millimetres in a metre
constexpr double kPercent = 100;

std::vector<std::string> preface(const TrajectoryReport& report) {
  const TrajectoryErrors& e = report.errors;
  std::vector<std::string> lines = {
      fmt::format("Trajectory {} against {}", report.estimate, report.truth),
      fmt::format("{} over {:.2f} m and {:.1f} s.", counted(e.pairs.size(), "pose"), e.length(),
                  e.duration()),
      fmt::format("Aligned by a rigid motion: {}.", motionText(e.alignment.T_true_estimated))};
  if (e.without_truth > 0)
    lines.push_back(fmt::format("Left out, without a true pose: {}.", counted(e.without_truth, "pose")));
  return lines;
}

std::vector<std::string> row(const std::string& name, const Sample& m, double unit, int decimals) {
  std::vector<std::string> cells = {name};
  for (const double value : {m.rmse, m.mean, m.median, m.max})
    cells.push_back(text::decimals(unit * value, decimals));
  return cells;
}

std::vector<ReportTable> tables(const TrajectoryErrors& e) {
  TextTable absolute({"", "RMSE", "mean", "median", "max."});
  absolute.add(row("position [mm]", e.absolute, kMillimetres, 1));
  if (e.length() > 0) absolute.add(row("position [% of the way]", e.absolute, kPercent / e.length(), 3));
  absolute.add(row("orientation [deg]", e.absolute_rotation_deg, 1, 2));
  TextTable relative({"", "RMSE", "mean", "median", "max.", "mean per metre", "intervals"});
  for (const RelativeErrors& r : e.relative) {
    std::vector<std::string> translation =
        row(fmt::format("over {} [mm]", r.over), r.translation, kMillimetres, 1);
    translation.push_back(fmt::format("{:.2f} %", kPercent * r.translationShare()));
    translation.push_back(std::to_string(r.intervals));
    relative.add(translation);
    std::vector<std::string> rotation = row(fmt::format("over {} [deg]", r.over), r.rotation_deg, 1, 2);
    rotation.push_back(fmt::format("{:.3f} deg", r.rotationPerMetre()));
    rotation.push_back(std::to_string(r.intervals));
    relative.add(rotation);
  }
  std::vector<ReportTable> all = {{"ABSOLUTE TRAJECTORY ERROR, after alignment", absolute}};
  if (!e.relative.empty()) all.push_back({"RELATIVE POSE ERROR", relative});
  return all;
}

void writePoses(std::ostream& out, const TrajectoryErrors& e) {
  out << "stamp,way_m,translation_mm,orientation_deg,x,y,z,true_x,true_y,true_z\n";
  for (std::size_t i = 0; i < e.pairs.size(); ++i) {
    out << text::shortest(e.pairs[i].stamp) << "," << text::significant(e.distance[i]) << ","
        << text::significant(kMillimetres * e.translation[i]) << "," << text::significant(e.rotation_deg[i]);
    for (const Eigen::Isometry3d* T : {&e.pairs[i].estimated, &e.pairs[i].truth})
      for (int axis = 0; axis < 3; ++axis) out << "," << text::significant(T->translation()[axis]);
    out << "\n";
  }
}

void writeSummary(std::ostream& out, const TrajectoryErrors& e) {
  out << "error,over,n,rmse,mean,median,max,mean_per_metre\n";
  const auto line = [&](const std::string& name, const std::string& over, std::size_t n, const Sample& m,
                        double unit, const std::string& per_metre) {
    out << name << "," << over << "," << n;
    for (const double value : {m.rmse, m.mean, m.median, m.max})
      out << "," << text::significant(unit * value);
    out << "," << per_metre << "\n";
  };
  line("absolute translation [mm]", "", e.pairs.size(), e.absolute, kMillimetres, "");
  line("absolute orientation [deg]", "", e.pairs.size(), e.absolute_rotation_deg, 1, "");
  for (const RelativeErrors& r : e.relative) {
    line("relative translation [mm]", r.over, r.intervals, r.translation, kMillimetres,
         text::significant(kMillimetres * r.translationShare()));
    line("relative orientation [deg]", r.over, r.intervals, r.rotation_deg, 1,
         text::significant(r.rotationPerMetre()));
  }
}

/** The axis of the world that the upper edges of the images look to. */
PlanView planOf(const std::vector<PosePair>& pairs) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) sum -= pair.truth.linear().col(1);
  Eigen::Index axis = 0;
  sum.cwiseAbs().maxCoeff(&axis);
  return PlanView(std::copysign(1.0, sum[axis]) * Eigen::Vector3d::Unit(axis));
}

}  // namespace

std::string motionText(const Eigen::Isometry3d& T) {
  const auto metres = [&](int axis) { return text::decimals(T.translation()[axis], 3); };
  return fmt::format("rotated by {:.2f} deg, moved by ({}, {}, {}) m", rotationAngle(T.linear()) / kDegree,
                     metres(0), metres(1), metres(2));
}

void printReport(std::ostream& out, const TrajectoryReport& report) {
  for (const std::string& line : preface(report)) out << line << "\n";
  for (const ReportTable& t : tables(report.errors)) out << "\n" << t.title << "\n" << t.table;
}

void writeReport(const std::filesystem::path& folder, const TrajectoryReport& report) {
  writeTextAtomically(folder / "evaluation.txt", [&](std::ostream& out) { printReport(out, report); });
  writeTextAtomically(folder / "trajectory_errors.csv",
                      [&](std::ostream& out) { writePoses(out, report.errors); });
  writeTextAtomically(folder / "trajectory_summary.csv",
                      [&](std::ostream& out) { writeSummary(out, report.errors); });
}

void writeHtmlReport(const std::filesystem::path& folder, const TrajectoryReport& report) {
  const TrajectoryErrors& e = report.errors;
  HtmlPage page("Trajectory " + titleOf(report.estimate));
  page.begin("verdict");
  page.paragraph(
      fmt::format("Over {:.1f} m and {:.0f} s, {} are off by {:.0f} mm and {:.2f}° (RMS, after alignment).",
                  e.length(), e.duration(), counted(e.pairs.size(), "pose"), kMillimetres * e.absolute.rmse,
                  e.absolute_rotation_deg.rmse));
  if (e.length() > 0)
    page.paragraph(fmt::format("That is {:.2f} % of the distance travelled; the largest error is {:.0f} mm.",
                               kPercent * e.absolute.rmse / e.length(), kMillimetres * e.absolute.max));
  page.end();
  page.drawing("charts", chartData(e));
  for (const ReportTable& t : tables(e)) page.table(t.title, t.table);
  page.beginFolded("How it was judged");
  for (const std::string& line : preface(report)) page.paragraph(line);
  page.end();
  writeTextAtomically(folder / "report.html", [&](std::ostream& out) { out << page.str(); });
}

Json::Value chartData(const TrajectoryErrors& errors) {
  const PlanView plan = planOf(errors.pairs);
  Json::Value data;
  for (std::size_t i = 0; i < errors.pairs.size(); ++i) {
    const Eigen::Vector2d truth = plan.point(errors.pairs[i].truth.translation()),
                          estimated = plan.point(errors.pairs[i].estimated.translation());
    data["plan"]["true"].append(chartRow({truth.x(), truth.y()}));
    data["plan"]["estimated"].append(chartRow({estimated.x(), estimated.y()}));
    data["errors"].append(
        chartRow({errors.distance[i], kMillimetres * errors.translation[i], errors.rotation_deg[i]}));
  }
  return data;
}

void drawTrajectories(const std::filesystem::path& path, const TrajectoryErrors& errors) {
  DrawnRun truth{"true", {}, {110, 110, 110}}, estimated{"estimated", {}};
  for (const PosePair& pair : errors.pairs) {
    truth.T_w_c.push_back(pair.truth);
    estimated.T_w_c.push_back(pair.estimated);
  }
  drawRuns(path, planOf(errors.pairs), {truth, estimated});
}

}  // namespace facetloc
