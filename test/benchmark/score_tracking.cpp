// SPDX-License-Identifier: BSD-3-Clause
//
// How well a camera is tracked on simulated floors, in the time that it really has.
//
//   facetloc_simulate office -o office1 --runs map,drive --width 320; ...
//   score_tracking [--kidnap SECONDS] [--busy MS] [--step MS] [--GROUP.PARAMETER VALUE] FLOOR...
//
// For each floor a map is built of its run map/ by the paper's rule, and its run drive/ is tracked in it. A
// view that is searched in the whole map takes --busy ms (300), and tracking one takes --step ms (40, with
// segmentation): images in the meantime are dropped, as in a live run. With --kidnap it is tracked once
// more, jumping by half of its length every SECONDS; the time until it is found again counts from
// the jump, and once more only where a local model shows the place, within 1 m and 20 deg.
#include "cli/app.h"
#include "mapped_place.h"
#include "programs.h"

#include <facetloc/features/pose.h>
#include <facetloc/localization/localizer.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace facetloc;

constexpr double kGoodTranslation = 0.05, kGoodRotation = 1 * kDegree;

struct Options {
  double kidnap = 0;  // [s]
  double busy_ms = 300, step_ms = 40;
  LocalizerParams localizer;
};

/** The map of a floor, and its run drive/. */
struct Floor : benchmarks::PosedRun {
  explicit Floor(const std::string& folder) {
    benchmarks::MappedPlace place(folder, 1, "drive");
    map = std::make_shared<const Map>(place.see({}));
    PosedRun::operator=(place.posedQuery());
  }
  std::shared_ptr<const Map> map;
};

struct Score {
  int frames = 0, after_fix = 0, good = 0, posed = 0;
  std::array<int, 5> states{};
  double translation = 0, rotation = 0, nees = 0, step_ms = 0, search_ms = 0, worst_ms = 0;
  int steps = 0, searches = 0, kidnaps = 0, noticed = 0, repaired = 0;
  int covered = 0, shown = 0;  // frames; kidnappings to where the map shows something before the next one
  double notice = 0, worst_notice = 0, repair = 0, worst_repair = 0, worst_repair_in_map = 0;  // [s]
};

Score track(const Floor& floor, const Options& options) {
  Score score;
  Localizer localizer(floor.map, options.localizer);
  const std::size_t n = floor.views.size();
  bool fixed = false, noticed = true, repaired = true, shown = true;
  std::size_t jump = 0;
  double free_at = 0, jumped_at = 0, next_jump = options.kidnap;
  double in_map = 0;  // since the jump [s]
  for (std::size_t i = 0; i < n; ++i) {
    const double now = floor.stamps[i] - floor.stamps[0];
    if (options.kidnap > 0 && now >= next_jump) {
      jump = (jump + n / 2) % n;
      next_jump += options.kidnap;
      jumped_at = now;
      ++score.kidnaps;
      noticed = repaired = shown = false;
      in_map = 0;
    }
    const std::size_t k = (i + jump) % n;
    if (floor.covered[k] && i > 0) in_map += floor.stamps[i] - floor.stamps[i - 1];
    if (now < free_at) continue;
    const auto start = std::chrono::steady_clock::now();
    const Localization pose = localizer.update(floor.views[k], now);
    const double ms = benchmarks::milliseconds(start);
    const bool searched = pose.searched;
    free_at = now + 1e-3 * (searched ? options.busy_ms : options.step_ms);
    (searched ? score.search_ms : score.step_ms) += ms;
    ++(searched ? score.searches : score.steps);
    if (!searched) score.worst_ms = std::max(score.worst_ms, ms);

    ++score.frames;
    ++score.states[static_cast<int>(pose.tracking)];
    score.covered += floor.covered[k];
    if (!shown && floor.covered[k]) {
      shown = true;
      ++score.shown;
    }
    fixed = fixed || pose.tracking == TrackingState::localized;
    Vector6d e = Vector6d::Zero();
    bool good = false;
    double nees = 0;
    if (pose.T_w_c) {
      e = boxminus(floor.truth[k], pose.T_w_c->T);
      good = e.tail<3>().norm() <= kGoodTranslation && e.head<3>().norm() <= kGoodRotation;
      nees = e.dot(pose.T_w_c->P.ldlt().solve(e));
    }
    if (!noticed && !pose.T_w_c) {
      noticed = true;
      ++score.noticed;
      score.notice += now - jumped_at;
      score.worst_notice = std::max(score.worst_notice, now - jumped_at);
    }
    if (!repaired && good) {
      repaired = true;
      ++score.repaired;
      score.repair += now - jumped_at;
      score.worst_repair = std::max(score.worst_repair, now - jumped_at);
      score.worst_repair_in_map = std::max(score.worst_repair_in_map, in_map);
    }
    if (fixed) {
      ++score.after_fix;
      score.good += good;
      if (pose.T_w_c) {
        ++score.posed;
        score.translation += e.tail<3>().norm();
        score.rotation += e.head<3>().norm() / kDegree;
        score.nees += nees;
      }
    }
  }
  return score;
}

double ratio(double a, double b) { return b > 0 ? a / b : 0; }

void print(const std::string& name, const Score& s) {
  std::printf("%s: %d frames processed, %d after the first fix\n", name.c_str(), s.frames, s.after_fix);
  std::printf("  %.1f %% where the map shows something\n", 100 * ratio(s.covered, s.frames));
  std::printf("  within 5 cm and 1 deg %.2f %%; mean error %.1f mm, %.3f deg; mean NEES %.1f of 6\n",
              100 * ratio(s.good, s.after_fix), 1e3 * ratio(s.translation, s.posed),
              ratio(s.rotation, s.posed), ratio(s.nees, s.posed));
  std::printf("  ");
  for (std::size_t i = 0; i < s.states.size(); ++i)
    std::printf("%s%s %.2f %%", i > 0 ? ", " : "", stateName(static_cast<TrackingState>(i)),
                100 * ratio(s.states[i], s.frames));
  std::printf("\n  %.2f ms a tracked frame (at most %.1f), %.0f ms a searched one\n",
              ratio(s.step_ms, s.steps), s.worst_ms, ratio(s.search_ms, s.searches));
  if (s.kidnaps > 0)
    std::printf("  %d kidnappings, %d of them to where the map shows something: %d noticed after %.2f s (at "
                "most %.2f), %d repaired after %.2f s (at most %.2f, %.2f of them in the map)\n",
                s.kidnaps, s.shown, s.noticed, ratio(s.notice, s.noticed), s.worst_notice, s.repaired,
                ratio(s.repair, s.repaired), s.worst_repair, s.worst_repair_in_map);
  std::fflush(stdout);
}

class ScoreTrackingApp : public App {
public:
  ScoreTrackingApp()
      : App("score_tracking", "FLOOR... [options]",
            "Tracks a camera on simulated floors, in the time that it really has.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("FLOOR", floors_);
    line.addOption("kidnap", options_.kidnap, "SECONDS", "Track it once more, with a jump after each.");
    line.addOption("busy", options_.busy_ms, "MS", "Time of a search in the whole map.");
    line.addOption("step", options_.step_ms, "MS", "Time of tracking a view.");
    line.addParams(options_.localizer, "sequence");
  }

  int execute(const CommandLine&, const Console&) override {
    for (const std::string& name : floors_) {
      const Floor floor(name);
      Options undisturbed = options_;
      undisturbed.kidnap = 0;
      print(name, track(floor, undisturbed));
      if (options_.kidnap > 0) print(name + ", kidnapped", track(floor, options_));
    }
    return kOk;
  }

  std::vector<std::string> floors_;
  Options options_;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<ScoreTrackingApp>(argc, argv); }
