// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation_report.h"

#include "base/text.h"

#include <facetloc/io/atomic_file.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>

namespace facetloc {
namespace {

template <class T>
std::string wholeCell(const std::optional<T>& value) {
  return value ? std::to_string(*value) : "";
}

/** "mm,deg", empty if there is nothing that the error could be of. */
std::string errorCells(bool known, const PoseError& error) {
  if (!known) return ",";
  return fmt::format("{},{}", text::significant(1000 * error.translation),
                     text::significant(error.rotation_deg));
}

std::string nearestCells(const std::optional<NearestModel>& nearest) {
  if (!nearest) return ",,";
  return fmt::format("{},{},{}", text::csvCell(nearest->name), text::significant(nearest->distance),
                     text::significant(nearest->angle_deg));
}

void writeFrames(std::ostream& out, const Evaluation& evaluation) {
  out << "run,frame,stamp,class,nothing_there,covered,solvable,visible_planes,hypotheses,first_correct_rank,"
         "translation_mm,orientation_deg,heading_deg,"
         "state,rank1_probability,rank1_translation_mm,rank1_orientation_deg,nearest_model,nearest_distance_"
         "m,"
         "nearest_angle_deg,nees,closest_rank,closest_translation_mm,closest_orientation_deg,"
         "local_translation_mm,local_orientation_deg,reason\n";
  for (const FrameEvaluation& f : evaluation.frames) {
    const bool known = f.frame_class != FrameClass::unknown;
    out << text::csvCell(f.run) << "," << text::csvCell(f.name) << "," << text::shortest(f.stamp) << ","
        << toString(f.frame_class) << "," << f.unmapped << "," << (known ? std::to_string(f.covered) : "")
        << "," << wholeCell(f.solvable) << "," << wholeCell(f.visible_planes) << "," << f.hypotheses << ","
        << f.first_correct << "," << errorCells(f.first_correct > 0, f.first_correct_error) << ","
        << (f.first_correct ? text::significant(f.first_correct_error.heading_deg) : "") << ","
        << toString(f.state) << "," << (f.hypotheses ? text::significant(f.probability) : "") << ","
        << errorCells(f.best_error.has_value(), f.best_error.value_or(PoseError())) << ","
        << nearestCells(f.nearest) << "," << (f.nees ? text::significant(*f.nees) : "") << ","
        << (f.closest ? std::to_string(f.closest) : "") << "," << errorCells(f.closest > 0, f.closest_error)
        << "," << errorCells(f.local_error.has_value(), f.local_error.value_or(PoseError())) << ","
        << text::csvCell(f.reason) << "\n";
  }
}

void writeHistograms(std::ostream& out, const std::vector<Summary>& summaries) {
  out << "set,share,translation_mm,orientation_deg,index\n";
  for (const Summary& s : summaries)
    for (std::size_t i = 0; i < s.translation_mm.values.size(); ++i)
      out << text::csvCell(s.name) << "," << text::significant(s.translation_mm.share(i)) << ","
          << text::significant(s.translation_mm.values[i]) << ","
          << text::significant(s.rotation_deg.values[i]) << "," << text::significant(s.index.values[i])
          << "\n";
}

void writeErrors(std::ostream& out, const Evaluation& evaluation) {
  const std::vector<FrameEvaluation> frames = framesInQuestion(evaluation);
  out << "by,from,below,images,correct,rank1_correct,mean_translation_mm,mean_orientation_deg\n";
  const auto lines = [&](const char* quantity, const std::vector<ErrorGroup>& groups) {
    for (const ErrorGroup& group : groups) {
      const Summary& s = group.summary;
      out << quantity << "," << text::significant(group.lowest) << ","
          << (std::isinf(group.highest) ? "" : text::significant(group.highest)) << "," << s.total << ","
          << s.correct << "," << s.best_correct << ","
          << errorCells(s.correct > 0, {s.translation_mm.mean / 1000, s.rotation_deg.mean, 0}) << "\n";
    }
  };
  lines("visible planes", errorsByVisiblePlanes(frames));
  lines("distance [m]", errorsByDistance(frames));
}

void writeTimes(std::ostream& out, const std::vector<StageTime>& times) {
  out << "stage,images,mean_ms,median_ms,p95_ms,max_ms\n";
  for (const StageTime& t : times)
    out << fmt::format("{},{},{:.3f},{:.3f},{:.3f},{:.3f}\n", t.stage, t.ms.values.size(), t.ms.mean,
                       t.ms.bound(0.5), t.ms.bound(kMostShare), t.ms.max);
}

void writeCurve(std::ostream& out, const StartCurve& curve) {
  out << curve.name << ",starts,sure,right,recall,precision\n";
  for (const StartCurve::Point& p : curve.points)
    out << fmt::format("{},{},{},{},{:.9g},{:.9g}\n", text::shortest(p.x), p.starts, p.sure, p.right,
                       p.recall(), p.precision());
}

std::string alignmentText(const ResultsAlignment& a) {
  return fmt::format(
      "Aligned with the truth: {}, by {} of {} with a residual of {:.1f} mm and {:.2f} deg (RMS). "
      "Absolute trajectory error of all sure answers: RMSE {:.1f} mm, median {:.1f} mm, largest {:.1f} mm.",
      motionText(a.motion.T_true_estimated), a.motion.used, counted(a.answers, "sure answer"),
      1000 * a.motion.residual, a.motion.rotation_residual_deg, 1000 * a.errors.rmse, 1000 * a.errors.median,
      1000 * a.errors.max);
}

}  // namespace

std::vector<std::string> reportPreface(const EvaluationReport& report) {
  const EvaluationParams& p = report.params;
  const auto& frames = report.evaluation.frames;
  std::vector<std::string> lines = {
      fmt::format("Results {} against {}", report.results, report.truth),
      fmt::format("Correct: position within {:.9g} m and orientation within {:.9g} deg.", p.max_translation,
                  p.max_rotation_deg)};
  if (report.alignment) lines.push_back(alignmentText(*report.alignment));
  if (!frames.empty() && frames.front().nearest)
    lines.push_back(fmt::format("Covered: a local model within {:.9g} m and {:.9g} deg.", kCoveredDistance,
                                kCoveredRotationDeg));
  if (std::any_of(frames.begin(), frames.end(), [](const auto& f) { return f.solvable.has_value(); }))
    lines.push_back(fmt::format(
        "Solvable: the true planes of at least {:.9g} px at 320x240 that the image shares with a covering "
        "local model fix its pose to {:.9g} m and {:.9g} deg (standard deviation).",
        kVisiblePixels, kSolvablePosition, kSolvableRotationDeg));
  const auto unmapped = [](const auto& f) { return f.unmapped; };
  if (const auto n = std::count_if(frames.begin(), frames.end(), unmapped)) {
    const auto near = std::count_if(frames.begin(), frames.end(), [](const auto& f) {
      return f.unmapped && f.nearest && f.nearest->distance <= kCoveredDistance &&
             f.nearest->angle_deg <= kCoveredRotationDeg;
    });
    lines.push_back(fmt::format(
        "Nothing there: {} of places that the map does not know{}.",
        counted(static_cast<std::size_t>(n), "image"),
        near ? fmt::format(
                   "; {} of them are near a local model, such as behind a wall, and not counted as covered",
                   near)
             : ""));
  }
  const auto isNowhere = [](const auto& f) { return f.hypotheses > 0 && !f.best_error; };
  if (const auto n = std::count_if(frames.begin(), frames.end(), isNowhere))
    lines.push_back(fmt::format(
        "Rank 1 is in a local model without a pose: {}; the statistics of probabilities leave them out.",
        counted(static_cast<std::size_t>(n), "image")));
  if (const std::size_t n = report.evaluation.without_truth.size())
    lines.push_back(fmt::format("Left out, without a true pose: {}.", counted(n, "image")));
  return lines;
}

void printReport(std::ostream& out, const EvaluationReport& report) {
  for (const std::string& line : reportPreface(report)) out << line << "\n";
  for (const ReportTable& t : reportTables(report)) out << "\n" << t.title << "\n" << t.table;
}

void printStartCurves(std::ostream& out, const std::vector<StartCurve>& curves) {
  for (const StartCurve& curve : curves) {
    out << "\nAFTER SO MANY " << (curve.name == "images" ? "IMAGES" : "METRES") << " FROM A START\n";
    constexpr std::size_t kPrinted = 10;  // points of each
    const std::size_t step = std::max<std::size_t>(1, curve.points.size() / kPrinted);
    for (std::size_t i = 0; i < curve.points.size(); i += step) {
      const StartCurve::Point& p = curve.points[i];
      out << fmt::format("{}: {} starts, sure and right {:.1f} %, right of the sure ones {:.1f} %\n",
                         text::shortest(p.x), p.starts, 100 * p.recall(), 100 * p.precision());
    }
  }
}

void writeReport(const std::filesystem::path& folder, const EvaluationReport& report) {
  const auto write = [&](const std::string& name, const std::function<void(std::ostream&)>& content) {
    writeTextAtomically(folder / name, content);
  };
  write("evaluation.txt", [&](std::ostream& out) { printReport(out, report); });
  write("tables.csv", [&](std::ostream& out) { writeTables(out, report.summaries); });
  write("frames.csv", [&](std::ostream& out) { writeFrames(out, report.evaluation); });
  write("fig6.csv", [&](std::ostream& out) { writeHistograms(out, report.summaries); });
  write("errors.csv", [&](std::ostream& out) { writeErrors(out, report.evaluation); });
  for (const StartCurve& curve : report.starts)
    write("starts_by_" + curve.name + ".csv", [&](std::ostream& out) { writeCurve(out, curve); });
  const std::vector<StageTime> times = stageTimes(report.timing);
  if (!times.empty()) write("timing_summary.csv", [&](std::ostream& out) { writeTimes(out, times); });
}

std::string titleOf(const std::filesystem::path& path) {
  const auto whole = std::filesystem::absolute(path / "").lexically_normal().parent_path();
  return whole.filename().string();
}

}  // namespace facetloc
