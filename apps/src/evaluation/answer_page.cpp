// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/answer_page.h"

#include "evaluation/evaluation_details.h"

#include <facetloc/features/map_parts.h>

#include <map>
#include <utility>

namespace facetloc {
namespace {

void judge(const FrameEvaluation& frame, bool relative, PageAnswer& answer) {
  answer.wrong = frame.state == AnswerState::sure && !isRight(frame, relative).value_or(true);
  answer.relative = relative;
  if (const auto& error = relative ? frame.local_error : frame.best_error) {
    answer.error_m = error->translation;
    answer.error_deg = error->rotation_deg;
  }
  if (!relative) answer.truth = frame.T_w_c;
}

}  // namespace

MapPage answerPage(const Map& map, const std::vector<RunResults>& runs, const Evaluation* evaluation,
                   bool relative) {
  const ModelIndices indices(map);
  const auto part = static_cast<std::size_t>(mainPart(map));
  const std::string drawn = part < map.parts.size() ? map.parts[part] : "";
  std::map<std::pair<std::string, std::string>, const FrameEvaluation*> frames;
  if (evaluation)
    for (const FrameEvaluation& frame : evaluation->frames) frames[{frame.run, frame.name}] = &frame;
  MapPage page;
  for (const RunResults& run : runs) {
    const std::size_t first = page.answers.size();
    for (const ResultRow& row : run.rows) {
      if (page.answers.size() == first || page.answers.back().frame != row.frame) {
        PageAnswer begun;
        begun.run = run.name;
        begun.frame = row.frame;
        begun.state = row.state;
        begun.reason = row.reason;
        const auto judged = frames.find({run.name, row.frame});
        if (judged != frames.end()) judge(*judged->second, relative, begun);
        page.answers.push_back(std::move(begun));
      }
      if (row.rank == 0 || !row.T_w_c || row.part != drawn) continue;
      PageAnswer& answer = page.answers.back();
      const auto covariance = run.covariances.find(row.frame);
      if (row.rank == 1 && covariance != run.covariances.end()) answer.P_w_c = covariance->second;
      answer.places.push_back(
          {indices.of(row.model), row.T_m_c, *row.T_w_c, row.probability, row.sd_trans_m, row.sd_rot_deg});
    }
  }
  return page;
}

}  // namespace facetloc
