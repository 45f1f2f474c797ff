// SPDX-License-Identifier: BSD-3-Clause
//
// How many metres it takes until a moving camera knows where it is.
//
//   facetloc_simulate office -o office1 --seed 1 --runs map,drive --drive 60 --width 320; ...
//   score_sequence [--run drive] [--way 5] [--every N] [--start N] [--unknown] [--GROUP.PARAMETER VALUE]
//   PLACE...
//
// Each PLACE is a folder with a run map/, which makes the map by the paper's rule, and another run, of which
// every N-th image (--every) is seen and every N-th of those (--start) is a start: the camera wakes up there
// and drives on. Printed is, after N metres where the map shows something, within 1 m and 20 deg of a
// local model, how many are sure and how many of these are right. With --unknown each start has a map of its
// own, without the local models within 3 m of its way.
#include "cli/app.h"
#include "inputs/localization_options.h"
#include "mapped_place.h"
#include "programs.h"

#include <facetloc/localization/localizer.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace facetloc;
using namespace facetloc::internal;
using benchmarks::MappedPlace, benchmarks::percent, benchmarks::PosedRun;

constexpr std::array<double, 7> kMetres = {0, 0.5, 1, 2, 3, 4, 5};

/** The outcome of one start. */
struct Course {
  bool whole = false;  // it has gone all the way
  std::array<AnswerState, kMetres.size()> state{};
  std::array<bool, kMetres.size()> right{};
  bool ever_wrong = false;  // and sure
  int images = 0, sure = 0, sure_right = 0, searches = 0, places = 0, rank1 = 0, carried = 0;
  double milliseconds = 0;
};

Map without(const Map& whole, const std::vector<Eigen::Isometry3d>& way, double radius) {
  return benchmarks::without(whole, [&](int model) {
    return std::any_of(way.begin(), way.end(), [&](const Eigen::Isometry3d& T) {
      return (whole.models[model].T_w_m->translation() - T.translation()).norm() <= radius;
    });
  });
}

class ScoreSequenceApp : public App {
public:
  ScoreSequenceApp()
      : App("score_sequence", "PLACE... [options]", "Localizes a moving camera from many starts of a run.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("PLACE", places_);
    line.addOption("run", run_, "NAME", "The run that is localized.");
    line.addOption("way", way_, "M", "Way of each start [m].");
    line.addOption("every", every_, "N", "See only every N-th image.");
    line.addOption("start", start_, "N", "Start at every N-th of these.");
    line.addOption("radius", radius_, "M", "Distance of the local models that are taken out [m].");
    line.addSwitch("unknown", unknown_, "Take the local models around the way out of the map.");
    line.addPresets();
    line.addParams(view_);
    line.addParams(evaluation_, "evaluation");
    line.addParams(sequence_, "sequence");
    addLocalizationOptions(line, localization_);
  }

  Course follow(Localizer& sequence, const PosedRun& seen, std::size_t start) const {
    Course course;
    double gone = 0;
    std::size_t next = 0;
    for (std::size_t i = start; i < seen.views.size(); ++i) {
      if (i > start && (unknown_ || seen.covered[i]))
        gone += (seen.truth[i].translation() - seen.truth[i - 1].translation()).norm();
      const auto begin = std::chrono::steady_clock::now();
      const Localization answer = sequence.update(seen.views[i], seen.stamps[i]);
      course.milliseconds += benchmarks::milliseconds(begin);
      const bool right =
          !answer.hypotheses.empty() && isNear(*answer.hypotheses.front().T_w_c, seen.truth[i],
                                               evaluation_.max_translation, evaluation_.max_rotation_deg);
      const bool sure = answer.state == AnswerState::sure;
      ++course.images;
      course.sure += sure;
      course.sure_right += sure && right;
      course.rank1 += right, course.searches += answer.searched, course.carried += answer.began_anew;
      course.places += static_cast<int>(answer.hypotheses.size());
      course.ever_wrong = course.ever_wrong || (sure && !right);
      while ((unknown_ || seen.covered[i]) && next < kMetres.size() && gone >= kMetres[next]) {
        course.state[next] = answer.state, course.right[next] = right;
        ++next;
      }
      if (gone >= way_) {
        course.whole = true;
        break;
      }
    }
    return course;
  }

  std::vector<Course> coursesOf(const std::shared_ptr<const Map>& map, const PosedRun& seen) const {
    const int n = (static_cast<int>(seen.views.size()) + start_ - 1) / start_;
    std::vector<Course> courses(n);
#pragma omp parallel
    {
      std::optional<Localizer> whole;
      if (!unknown_) whole.emplace(map, sequence_, localization_);
#pragma omp for schedule(dynamic)
      for (int k = 0; k < n; ++k) {
        const std::size_t start = static_cast<std::size_t>(k) * start_;
        if (whole) {
          whole->reset();
          courses[k] = follow(*whole, seen, start);
          continue;
        }
        std::vector<Eigen::Isometry3d> way;
        double gone = 0;
        for (std::size_t i = start; i < seen.truth.size() && gone < way_; ++i) {
          if (i > start) gone += (seen.truth[i].translation() - seen.truth[i - 1].translation()).norm();
          way.push_back(seen.truth[i]);
        }
        Localizer sequence(std::make_shared<const Map>(without(*map, way, radius_)), sequence_,
                           localization_);
        courses[k] = follow(sequence, seen, start);
      }
    }
    return courses;
  }

  static void print(const std::string& name, const std::vector<Course>& courses) {
    Course sum;
    int whole = 0, ever_wrong = 0;
    for (const Course& c : courses) {
      sum.images += c.images, sum.sure += c.sure, sum.sure_right += c.sure_right;
      sum.searches += c.searches, sum.places += c.places, sum.milliseconds += c.milliseconds;
      sum.rank1 += c.rank1, sum.carried += c.carried;
      whole += c.whole, ever_wrong += c.ever_wrong;
    }
    std::printf("%s: %zu starts, %d whole; ever sure and wrong %.2f %%; of all images sure %.1f %%, right of "
                "these %.2f %%, rank 1 %.1f %%; "
                "searched %.1f %%, carried away %.2f %%, %.1f places, %.1f ms an image\n",
                name.c_str(), courses.size(), whole, percent(ever_wrong, courses.size()),
                percent(sum.sure, sum.images), percent(sum.sure_right, sum.sure),
                percent(sum.rank1, sum.images), percent(sum.searches, sum.images),
                percent(sum.carried, sum.images), double(sum.places) / std::max(1, sum.images),
                sum.milliseconds / std::max(1, sum.images));
    for (std::size_t m = 0; m < kMetres.size(); ++m) {
      int n = 0, sure = 0, right = 0, doubtful = 0;
      for (const Course& c : courses) {
        if (!c.whole) continue;
        ++n;
        sure += c.state[m] == AnswerState::sure;
        doubtful += c.state[m] == AnswerState::doubtful;
        right += c.state[m] == AnswerState::sure && c.right[m];
      }
      std::printf("  after %.1f m: sure %5.1f %% (right %6.2f %%), doubtful %.1f %%\n", kMetres[m],
                  percent(sure, n), percent(right, sure), percent(doubtful, n));
    }
    std::fflush(stdout);
  }

  int execute(const CommandLine&, const Console&) override {
    if (every_ < 1 || start_ < 1) throw UsageError("every and start must be positive");
    std::vector<Course> all;
    for (const std::string& name : places_) {
      MappedPlace place(name, static_cast<std::size_t>(every_), run_);
      Map map = place.see(view_);
      const PosedRun seen = place.posedQuery();
      benchmarks::findAmbiguity(map, localization_);
      const std::vector<Course> courses = coursesOf(std::make_shared<const Map>(std::move(map)), seen);
      print(fs::path(name).filename().string(), courses);
      all.insert(all.end(), courses.begin(), courses.end());
    }
    if (places_.size() > 1) print("all", all);
    return kOk;
  }

  std::vector<std::string> places_;
  std::string run_ = "drive";
  double way_ = 5, radius_ = 3;
  int every_ = 3, start_ = 10;
  bool unknown_ = false;
  ViewParams view_;
  EvaluationParams evaluation_;
  LocalizerParams sequence_;
  GlobalLocalizationParams localization_;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<ScoreSequenceApp>(argc, argv); }
