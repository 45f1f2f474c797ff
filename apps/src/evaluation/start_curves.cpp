// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/start_curves.h"

#include "base/text.h"

#include <facetloc/io/atomic_file.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <optional>

namespace facetloc {
namespace {

constexpr double kMetreStep = 0.25;   // between points of a curve [m]
constexpr std::size_t kPrinted = 10;  // points of each

/** Counts an answer at a point, and makes points up to it. */
void count(StartCurve& curve, std::size_t i, double step, bool sure, bool right) {
  while (curve.points.size() <= i) curve.points.push_back({step * static_cast<double>(curve.points.size())});
  StartCurve::Point& point = curve.points[i];
  ++point.starts;
  point.sure += sure;
  point.right += sure && right;
}

std::string percent(double share) { return fmt::format("{:.1f} %", 100 * share); }

}  // namespace

std::vector<StartCurve> startCurves(const std::vector<StartAnswer>& answers,
                                    const std::vector<FrameEvaluation>& frames,
                                    const Eigen::Isometry3d& T_true_estimated,
                                    const EvaluationParams& params) {
  std::map<std::string, Eigen::Isometry3d> truth;
  for (const FrameEvaluation& frame : frames) truth[frame.name] = frame.T_w_c;
  StartCurve images{"images", {}}, metres{"metres", {}};
  std::string start;
  std::optional<Eigen::Isometry3d> before;  // the true pose of the image before, of the same start
  double distance = 0;
  std::size_t image = 0, next = 0;  // points of the start
  for (const StartAnswer& answer : answers) {
    const auto found = truth.find(answer.frame);
    if (found == truth.end()) continue;
    const Eigen::Isometry3d& T_w_c = found->second;
    if (!before || answer.start != start) {
      start = answer.start;
      before = T_w_c;
      distance = 0;
      image = next = 0;
    }
    distance += (T_w_c.translation() - before->translation()).norm();
    before = T_w_c;
    const bool sure = answer.state == AnswerState::sure;
    const bool right = answer.T_w_c && isNear(T_true_estimated * *answer.T_w_c, T_w_c, params.max_translation,
                                              params.max_rotation_deg);
    count(images, image++, 1, sure, right);
    for (; distance >= kMetreStep * static_cast<double>(next); ++next)
      count(metres, next, kMetreStep, sure, right);
  }
  return {images, metres};
}

void writeStartCurves(const std::filesystem::path& folder, const std::vector<StartCurve>& curves) {
  for (const StartCurve& curve : curves)
    writeTextAtomically(folder / ("starts_by_" + curve.name + ".csv"), [&](std::ostream& out) {
      out << curve.name << ",starts,sure,right,recall,precision\n";
      for (const StartCurve::Point& p : curve.points)
        out << fmt::format("{},{},{},{},{:.9g},{:.9g}\n", text::shortest(p.x), p.starts, p.sure, p.right,
                           p.recall(), p.precision());
    });
}

void printStartCurves(std::ostream& out, const std::vector<StartCurve>& curves) {
  for (const StartCurve& curve : curves) {
    out << "\nAFTER SO MANY " << (curve.name == "images" ? "IMAGES" : "METRES") << " FROM A START\n";
    const std::size_t step = std::max<std::size_t>(1, curve.points.size() / kPrinted);
    for (std::size_t i = 0; i < curve.points.size(); i += step) {
      const StartCurve::Point& p = curve.points[i];
      out << fmt::format("{}: {} starts, sure and right {}, right of the sure ones {}\n", text::shortest(p.x),
                         p.starts, percent(p.recall()), percent(p.precision()));
    }
  }
}

}  // namespace facetloc
