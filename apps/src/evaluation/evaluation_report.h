// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/text.h"
#include "evaluation/evaluation_details.h"
#include "evaluation/trajectory_errors.h"

#include <facetloc/features/finding.h>

#include <filesystem>
#include <json/value.h>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace facetloc {

/** \brief Summaries of all frames and, as far as there are any, of the map images (of a single run), the new
 * images, and of the new images the covered ones, those solvable by planes, the rest that is not covered, and
 * those taken where the map has nothing. */
std::vector<Summary> summarizeSets(const Evaluation& evaluation);
/** \brief The summary of the new images; of all where it is not known which are new. */
const Summary& newImages(const std::vector<Summary>& summaries);

/** \brief A table for people, in text and in HTML. */
struct ReportTable {
  std::string title;
  TextTable table;
};
/** \brief The frames that miss, and why as far as the data tell; the last column holds words. */
std::vector<ReportTable> missTables(const Evaluation& evaluation, bool relative);

/** \brief Tables I and II and further ones as CSV, one column per summary. */
void writeTables(std::ostream& out, const std::vector<Summary>& summaries);

/** \brief How results in a world of their own were brought to the true one. */
struct ResultsAlignment {
  Alignment motion;
  std::size_t answers = 0;  ///< sure ones with a true pose
  Sample errors;            ///< position errors of all pairs after the alignment [m]
};

/** \brief The findings of facetloc_evaluate: one summary per set of frames; the first one is of all. */
struct EvaluationReport {
  std::string results;
  std::string truth;  ///< empty: nothing is known to be true
  EvaluationParams params;
  Evaluation evaluation;
  std::vector<Summary> summaries;
  std::vector<TimingRow> timing;  ///< timing of all runs; may be empty
  std::optional<ResultsAlignment> alignment{};
  bool own_frame = false;                    ///< the map lies in another frame than the truth
  std::optional<Alignment> map_alignment{};  ///< then: local models against their true poses, if known
  Findings findings{};                       ///< about the recordings and their localization
  bool of_map = false;                       ///< the images localized are those that the map was made of
  bool as_drive = false;                     ///< they were localized as a sequence
  bool beside_paper = false;                 ///< the paper's figures stand beside these
  std::vector<StartCurve> starts{};          ///< after each of several starts of a drive; may be empty

  bool isJudged() const { return !truth.empty(); }
};

/** \brief Tables I and II, beside the paper's figures if the report has them, and further ones. */
std::vector<ReportTable> reportTables(const EvaluationReport& report);

/** \brief The results judged and the rules applied, in sentences. */
std::vector<std::string> reportPreface(const EvaluationReport& report);

/** \brief The preface and the tables. */
void printReport(std::ostream& out, const EvaluationReport& report);

/** \brief Some points of each curve. */
void printStartCurves(std::ostream& out, const std::vector<StartCurve>& curves);

/** \brief Writes evaluation.txt, tables.csv, frames.csv, fig6.csv, errors.csv, starts_by_NAME.csv of each
 * curve and, where times are known, timing_summary.csv, atomically. Times are in the last one and in the text
 * only: everything else depends on nothing but the answers. */
void writeReport(const std::filesystem::path& folder, const EvaluationReport& report);

/** \brief A picture file and its caption. */
struct ReportPicture {
  std::filesystem::path path;
  std::string caption;
};
/** \brief The parts of a report that need the map, the images or a display. */
struct ReportFigures {
  Json::Value plan;                     ///< planData() of the answers; may be null
  bool map_page = false;                ///< map.html lies beside the report
  std::vector<ReportPicture> pictures;  ///< pictures of images with a wrong or missing answer
};
/** \brief Writes report.html, atomically: the verdict, the map, charts, then tables; everything in one file.
 * Throws IoError. */
void writeHtmlReport(const std::filesystem::path& folder, const EvaluationReport& report,
                     const ReportFigures& figures);

/** \brief The last part of a path, as a title: where files are says nothing. */
std::string titleOf(const std::filesystem::path& path);

/** \brief The comparison of a trajectory with the true one. */
struct TrajectoryReport {
  std::string estimate;
  std::string truth;
  TrajectoryErrors errors;
};

void printReport(std::ostream& out, const TrajectoryReport& report);

/** \brief Writes evaluation.txt, trajectory_errors.csv (by pose) and trajectory_summary.csv, atomically. */
void writeReport(const std::filesystem::path& folder, const TrajectoryReport& report);

/** \brief Writes report.html, atomically: everything in one file. Throws IoError. */
void writeHtmlReport(const std::filesystem::path& folder, const TrajectoryReport& report);

// The data of the charts of reports, which apps/pages/report.js draws. Rows are arrays of numbers. Each
// comment below lists the names of a row's numbers in their order.

/** \brief The charts of an evaluation; null without data.
 *
 * reliability: images, brier, enough (images of a bin that says something), bins (lowest, highest, images,
 * mean probability, share correct). position, orientation: limit, marks (99 % bounds by name), sets (name,
 * ascending errors of first correct hypotheses). planes, distance: mean, images, correct, correct at rank 1.
 * starts by images, metres: since the start, starts, sure, right. */
Json::Value chartData(const EvaluationReport& report);
/** \brief The charts of a trajectory. plan: true, estimated (to the right, to the top [m]). errors: true
 * distance [m], position [mm], orientation [deg]. */
Json::Value chartData(const TrajectoryErrors& errors);

/** \brief Draws a trajectory and the true one from above into a PNG, atomically. Needs an X display
 * (OffscreenDisplay). Throws IoError. */
void drawTrajectories(const std::filesystem::path& path, const TrajectoryErrors& errors);

/** \brief "rotated by 12.30 deg, moved by (1.000, 2.000, 3.000) m". */
std::string motionText(const Eigen::Isometry3d& T);

}  // namespace facetloc
