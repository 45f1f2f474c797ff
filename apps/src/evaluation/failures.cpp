// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/failures.h"

#include "drawing/page.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>

namespace facetloc {
namespace {

bool failed(const FrameEvaluation& frame) {
  if (frame.unmapped) return frame.hypotheses > 0 && frame.probability >= kUnsure;
  return frame.first_correct != 1;
}

std::string poseDifference(double translation, double rotation_deg) {
  return fmt::format("{:.2f} m and {:.2f}°", translation, rotation_deg);
}

std::string whatFailed(const FrameEvaluation& frame) {
  if (frame.hypotheses == 0) return "no hypothesis: " + frame.reason;
  const auto& error = frame.best_error;
  return fmt::format("{}, probability {:.2f}{}",
                     error ? poseDifference(error->translation, error->rotation_deg) + " off"
                           : "in a local model without a pose",
                     frame.probability,
                     frame.first_correct > 0 ? fmt::format(", correct at rank {}", frame.first_correct) : "");
}

}  // namespace

std::vector<Failure> findFailures(const Evaluation& evaluation, const std::vector<RunResults>& runs,
                                  const Map& map) {
  const ModelIndices indices(map);
  std::map<std::pair<std::string, std::string>, const ResultRow*> first;  // keyed by run and frame
  for (const RunResults& run : runs)
    for (const ResultRow& row : run.rows)
      if (row.rank == 1) first[{run.name, row.frame}] = &row;

  std::vector<Failure> failures;
  for (const FrameEvaluation& frame : evaluation.frames) {
    if (!failed(frame)) continue;
    Failure failure{frame.run, frame.name, whatFailed(frame), frame.probability, {}};
    const auto best = first.find({frame.run, frame.name});
    if (best != first.end()) {
      const ResultRow& row = *best->second;
      failure.answers.push_back({indices.of(row.model), row.T_m_c, "rank 1: " + failure.what});
    } else {
      failure.answers.push_back({-1, Eigen::Isometry3d::Identity(), failure.what});
    }
    if (frame.nearest) {
      const int nearest = indices.of(frame.nearest->name);
      failure.answers.push_back(
          {nearest, map.models[nearest].T_w_m->inverse() * frame.T_w_c,
           fmt::format("true pose in the nearest local model, {} away{}",
                       poseDifference(frame.nearest->distance, frame.nearest->angle_deg),
                       frame.unmapped ? "; the map has nothing here" : "")});
    }
    failures.push_back(std::move(failure));
  }
  std::stable_sort(failures.begin(), failures.end(),
                   [](const Failure& a, const Failure& b) { return a.probability > b.probability; });
  return failures;
}

Raster<std::uint8_t> contactSheet(const std::vector<Raster<std::uint8_t>>& pictures,
                                  const std::vector<std::string>& titles) {
  constexpr double kWidth = 800, kGap = 20, kTitle = 28;  // [px]
  constexpr int kColumns = 2;
  double cell = 0;
  for (const auto& picture : pictures)
    cell = std::max(cell, kWidth * picture.height / picture.width + kTitle + kGap);
  const int n = static_cast<int>(pictures.size()), columns = std::min(n, kColumns);
  const int rows = (n + kColumns - 1) / kColumns;
  Page page(static_cast<int>(columns * (kWidth + kGap) + kGap), static_cast<int>(rows * cell + kGap));
  for (int i = 0; i < n; ++i) {
    const double left = kGap + (i % kColumns) * (kWidth + kGap), top = kGap / 2 + (i / kColumns) * cell;
    TextStyle style;
    style.bold = true;
    page.text({left, top + kTitle / 2}, titles[i], style);
    const Box box = {left, top + kTitle, kWidth, kWidth * pictures[i].height / pictures[i].width};
    page.picture(box, pictures[i]);
    page.frame(box, {Colour(190, 190, 190), 1});
  }
  return page.render();
}

}  // namespace facetloc
