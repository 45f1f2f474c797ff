// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/answer_page.h"

#include "evaluation/evaluation_details.h"

#include <facetloc/features/map_parts.h>

#include <map>
#include <utility>

namespace facetloc {
namespace {

using RunAndFrame = std::pair<std::string, std::string>;

/** Turns rows of results into answers of a page. */
class AnswerList {
public:
  AnswerList(const Map& map, const Evaluation* evaluation, bool relative)
      : relative_(relative), indices_(map) {
    const int part = mainPart(map);
    part_ = static_cast<std::size_t>(part) < map.parts.size() ? map.parts[part] : "";
    if (evaluation)
      for (const FrameEvaluation& frame : evaluation->frames) frames_[{frame.run, frame.name}] = &frame;
  }

  void add(const RunResults& run) {
    for (const ResultRow& row : run.rows) {
      if (answers_.empty() || last_ != RunAndFrame(run.name, row.frame)) begin(run, row);
      if (row.rank == 0) continue;
      PageAnswer& answer = answers_.back();
      if (!row.T_w_c || row.part != part_) continue;
      if (row.rank == 1) {
        const auto covariance = run.covariances.find(row.frame);
        if (covariance != run.covariances.end()) answer.P_w_c = covariance->second;
      }
      answer.places.push_back(
          {indices_.of(row.model), row.T_m_c, *row.T_w_c, row.probability, row.sd_trans_m, row.sd_rot_deg});
    }
  }

  std::vector<PageAnswer> take() { return std::move(answers_); }

private:
  void begin(const RunResults& run, const ResultRow& row) {
    last_ = {run.name, row.frame};
    PageAnswer answer;
    answer.run = run.name;
    answer.frame = row.frame;
    answer.state = row.state;
    answer.reason = row.reason;
    if (const auto found = frames_.find(last_); found != frames_.end()) judge(*found->second, answer);
    answers_.push_back(std::move(answer));
  }

  void judge(const FrameEvaluation& frame, PageAnswer& answer) const {
    answer.wrong = frame.state == AnswerState::sure && !isRight(frame, relative_).value_or(true);
    answer.relative = relative_;
    if (const auto& error = relative_ ? frame.local_error : frame.best_error) {
      answer.error_m = error->translation;
      answer.error_deg = error->rotation_deg;
    }
    if (!relative_) answer.truth = frame.T_w_c;
  }

  const bool relative_;
  const ModelIndices indices_;
  std::string part_;  // that is drawn
  std::map<RunAndFrame, const FrameEvaluation*> frames_;
  RunAndFrame last_;
  std::vector<PageAnswer> answers_;
};

}  // namespace

MapPage answerPage(const Map& map, const std::vector<RunResults>& runs, const Evaluation* evaluation,
                   bool relative) {
  AnswerList answers(map, evaluation, relative);
  for (const RunResults& run : runs) answers.add(run);
  MapPage page;
  page.answers = answers.take();
  return page;
}

}  // namespace facetloc
