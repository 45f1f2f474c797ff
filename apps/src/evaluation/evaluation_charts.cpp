// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/pictures.h"
#include "evaluation/evaluation_report.h"

#include <cmath>
#include <initializer_list>
#include <json/value.h>

namespace facetloc {
namespace {

constexpr double kMillimetres = 1000;                               // millimetres in a metre
constexpr double kPaperPosition = 164, kPaperOrientationDeg = 1.9;  // 99 % bounds of the paper's Fig. 6

Json::Value row(std::initializer_list<double> values) {
  Json::Value cells(Json::arrayValue);
  for (const double value : values) cells.append(value);
  return cells;
}

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
    rows.append(
        row({group.mean, static_cast<double>(group.summary.total), static_cast<double>(group.summary.correct),
             static_cast<double>(group.summary.best_correct)}));
  return rows;
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
        row({bin.lowest, bin.highest, static_cast<double>(bin.n), bin.mean_probability, bin.correct}));
  data["position"] = errorData(report, &Summary::translation_mm, kMillimetres * report.params.max_translation,
                               kPaperPosition);
  data["orientation"] =
      errorData(report, &Summary::rotation_deg, report.params.max_rotation_deg, kPaperOrientationDeg);
  data["planes"] = groupData(errorsByVisiblePlanes(frames));
  data["distance"] = groupData(errorsByDistance(frames));
  for (const StartCurve& curve : report.starts)
    for (const StartCurve::Point& p : curve.points)
      data["starts"][curve.name].append(row({p.x, double(p.starts), double(p.sure), double(p.right)}));
  return data;
}

Json::Value chartData(const TrajectoryErrors& errors) {
  const PlanView plan = planOf(errors.pairs);
  Json::Value data;
  for (std::size_t i = 0; i < errors.pairs.size(); ++i) {
    const Eigen::Vector2d truth = plan.point(errors.pairs[i].truth.translation()),
                          estimated = plan.point(errors.pairs[i].estimated.translation());
    data["plan"]["true"].append(row({truth.x(), truth.y()}));
    data["plan"]["estimated"].append(row({estimated.x(), estimated.y()}));
    data["errors"].append(
        row({errors.distance[i], kMillimetres * errors.translation[i], errors.rotation_deg[i]}));
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
