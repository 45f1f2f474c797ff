// SPDX-License-Identifier: BSD-3-Clause
//
// Is a probability a frequency where the map lacks the place?
//
//   score_unknown [--radius 3] [--every N] [--map FILE] [--GROUP.PARAMETER VALUE] PLACE...
//
// Each PLACE is a folder with a run map/ and a run query/, as facetloc_simulate makes them, or as recordings
// have them. Every query is localized twice: in the whole map, and in a map that is made anew without the
// local models within the radius of where the query was taken. With --map, a finished map with poses in the
// world of the query, such as one of a model or a densified one, takes the place of the run map/.
#include "calibration/map_ambiguity.h"
#include "cli/app.h"
#include "inputs/localization_options.h"
#include "mapped_place.h"
#include "programs.h"
#include "ranking/global_localization.h"

#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <optional>
#include <queue>
#include <string>
#include <vector>

namespace {

using namespace facetloc;
using namespace facetloc::internal;
using benchmarks::MappedPlace, benchmarks::percent, benchmarks::without;

/** The outcome of one query in one map. */
struct Answer {
  bool asked = false;    ///< the query has a true pose
  bool emptied = false;  ///< the map has no local model near the query
  bool covered = false;  ///< the whole map has one
  bool right = false;
  Localization localization;

  double probability() const {
    return localization.hypotheses.empty() ? 0 : localization.hypotheses.front().probability;
  }
};

bool isRight(const Localization& answer, const Eigen::Isometry3d& T_w_c, const EvaluationParams& params) {
  return !answer.hypotheses.empty() && answer.hypotheses.front().T_w_c &&
         isNear(*answer.hypotheses.front().T_w_c, T_w_c, params.max_translation, params.max_rotation_deg);
}

/** The wrong places for the views of a map's own models, so that a map with some models less need not ask for
 * all of them again: only for those that count, and where a model that is gone had a part in the answer. */
class OwnViews {
public:
  explicit OwnViews(const GlobalLocalization& whole) : whole_(whole), models_(viewsToAsk(whole.map())) {
    wrong_.resize(models_.size());
    const int n = static_cast<int>(models_.size());
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < n; ++i) wrong_[i] = wrongPlace(whole, models_[i]);
  }

  /** \brief Models that are gone can only lower a score: the highest are settled first. */
  template <class Gone>
  std::optional<MapAmbiguity> ambiguityWithout(const Gone& gone) const {
    struct Score {
      double value;
      std::size_t view;
      bool settled;
      bool operator<(const Score& o) const { return value < o.value; }
    };
    std::priority_queue<Score> highest;
    for (std::size_t i = 0; i < models_.size(); ++i) {
      if (gone(models_[i]) || !wrong_[i]) continue;
      const auto& by = wrong_[i]->supporting_models;
      highest.push({wrong_[i]->score, i, std::none_of(by.begin(), by.end(), gone)});
    }
    const std::size_t views = highest.size();
    std::vector<double> scores;
    while (!highest.empty() && 10 * scores.size() < views) {
      Score next = highest.top();
      highest.pop();
      if (next.settled) {
        scores.push_back(next.value);
      } else if (const auto wrong = wrongPlace(whole_, models_[next.view], gone)) {
        highest.push({wrong->score, next.view, true});
      }
    }
    if (scores.empty()) return {};
    const double sum = std::accumulate(scores.begin(), scores.end(), 0.0);
    return MapAmbiguity{sum / static_cast<double>(scores.size()), static_cast<int>(views)};
  }

private:
  const GlobalLocalization& whole_;
  std::vector<int> models_;
  std::vector<std::optional<Hypothesis>> wrong_;
};

template <class Chosen>
std::size_t count(const std::vector<Answer>& answers, const Chosen& chosen) {
  return static_cast<std::size_t>(std::count_if(answers.begin(), answers.end(), chosen));
}

void printHeader() {
  std::printf("%-24s %8s %8s | %28s | %35s | %9s\n", "", "", "", "whole map, of the covered",
              "emptied map: wrong", "deviation");
  std::printf("%-24s %8s %8s | %8s %8s %10s | %8s %8s %8s %8s | %9s\n", "", "queries", "covered", "right",
              "sure", "sure right", "p >= 0.5", "0.9", "0.99", "right", "");
}

/** Tenths of probability, in which the answers of both maps count half and half. */
struct Reliability {
  std::array<double, 10> weight{}, probability{}, right{};

  explicit Reliability(const std::vector<Answer>& answers) {
    const auto emptied = static_cast<double>(count(answers, [](const Answer& a) { return a.emptied; }));
    const double whole = static_cast<double>(answers.size()) - emptied;
    for (const Answer& answer : answers) {
      if (answer.localization.hypotheses.empty()) continue;
      const std::size_t bin = std::min<std::size_t>(9, static_cast<std::size_t>(10 * answer.probability()));
      const double w = 0.5 / (answer.emptied ? emptied : whole);
      weight[bin] += w, probability[bin] += w * answer.probability(), right[bin] += w * answer.right;
    }
  }
  /** Largest deviation over the tenths that hold a hundredth of the answers or more. */
  double largestDeviation() const {
    double largest = 0;
    for (std::size_t i = 0; i < weight.size(); ++i)
      if (weight[i] >= 0.01) largest = std::max(largest, std::abs(right[i] - probability[i]) / weight[i]);
    return largest;
  }
  void print() const {
    std::printf("\nprobability of rank 1   answers   mean   right\n");
    for (std::size_t i = 0; i < weight.size(); ++i)
      if (weight[i] > 0)
        std::printf("%12.1f to %.1f %10.1f %% %6.3f %7.3f\n", 0.1 * static_cast<double>(i),
                    0.1 * static_cast<double>(i + 1), 100 * weight[i], probability[i] / weight[i],
                    right[i] / weight[i]);
  }
};

void print(const std::string& name, const std::vector<Answer>& answers) {
  const auto inWhole = [&](auto chosen) {
    return count(answers, [&](const Answer& a) { return !a.emptied && chosen(a); });
  };
  const auto inEmptied = [&](auto chosen) {
    return count(answers, [&](const Answer& a) { return a.emptied && chosen(a); });
  };
  const auto wrong = [&](double p) {
    return inEmptied([p](const Answer& a) { return !a.right && a.probability() >= p; });
  };
  constexpr double kSure = 0.9;
  const std::size_t covered = inWhole([](const Answer& a) { return a.covered; });
  const std::size_t right = inWhole([](const Answer& a) { return a.covered && a.right; });
  const std::size_t sure_right =
      inWhole([](const Answer& a) { return a.covered && a.right && a.probability() >= kSure; });
  const std::size_t sure = inWhole([](const Answer& a) { return a.probability() >= kSure; });
  const std::size_t all_sure_right =
      inWhole([](const Answer& a) { return a.right && a.probability() >= kSure; });
  const std::size_t emptied = inEmptied([](const Answer&) { return true; });
  std::printf("%-24s %8zu %8zu | %6.1f %% %6.1f %% %8.2f %% | %6.1f %% %6.2f %% %6.2f %% %6.1f %% | %9.3f\n",
              name.c_str(), emptied, covered, percent(right, covered), percent(sure_right, covered),
              percent(all_sure_right, sure), percent(wrong(0.5), emptied), percent(wrong(kSure), emptied),
              percent(wrong(0.99), emptied),
              percent(inEmptied([](const Answer& a) { return a.right; }), emptied),
              Reliability(answers).largestDeviation());
  std::fflush(stdout);
}

class ScoreUnknownApp : public App {
public:
  ScoreUnknownApp()
      : App("score_unknown", "PLACE... [options]",
            "Localizes every query in the map of its place, and in that map without the local models around "
            "it.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("PLACE", places_);
    line.addOption("radius", radius_, "M", "Distance of the local models that are taken out [m].");
    line.addOption("every", every_, "N", "Localize only every N-th image.");
    line.addOption("map", map_, "FILE", "Use this map of the only PLACE instead of one of its run map/.");
    line.addPresets();
    line.addParams(view_);
    line.addParams(evaluation_, "evaluation");
    addLocalizationOptions(line, localization_);
  }

  /** A finished one, or the place's own by the paper's rule. */
  Map mapOfPlace(MappedPlace& place) const {
    if (map_.empty()) return place.see(view_);
    Map map = readMap(map_);
    for (const LocalModel& model : map.models)
      if (!model.T_w_m)
        throw IoError(map_,
                      "local model " + model.name + " has no pose in the world; build the map with poses");
    place.use(map, view_);
    return map;
  }

  std::vector<Answer> answersIn(MappedPlace& place) const {
    Map seen = mapOfPlace(place);
    const GlobalLocalization asked(std::make_shared<const Map>(seen), localization_);
    const OwnViews own_views(asked);
    seen.ambiguity = own_views.ambiguityWithout([](int) { return false; });
    const auto whole = std::make_shared<const Map>(std::move(seen));
    const GlobalLocalization localization(whole, localization_);
    const auto& query = place.query();
    const PlaceTruth truth = place.truth().of("query");
    std::vector<Answer> answers(2 * query.frames.size());
    const int n = static_cast<int>(query.frames.size());
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < n; ++i) {
      const FrameFile& frame = query.sequence.frames()[query.frames[i]];
      const auto T_w_c = truth.poses().at(frame.stamp, benchmarks::kPoseTolerance);
      if (!T_w_c) continue;
      const View& view = query.views[i];
      const auto gone = [&](int model) {
        return (whole->models[model].T_w_m->translation() - T_w_c->translation()).norm() <= radius_;
      };
      Map rest = without(*whole, gone);
      rest.ambiguity = own_views.ambiguityWithout(gone);
      const auto emptied = std::make_shared<const Map>(std::move(rest));
      for (const bool is_emptied : {false, true}) {
        Answer& answer = answers[2 * i + is_emptied];
        answer = {true, is_emptied, place.covers(*T_w_c), false, {}};
        answer.localization = is_emptied ? GlobalLocalization(emptied, localization_).localize(view)
                                         : localization.localize(view);
        answer.right = isRight(answer.localization, *T_w_c, evaluation_);
      }
    }
    answers.erase(std::remove_if(answers.begin(), answers.end(), [](const Answer& a) { return !a.asked; }),
                  answers.end());
    return answers;
  }

  int execute(const CommandLine&, const Console&) override {
    if (every_ < 1) throw UsageError("every must be positive");
    if (!map_.empty() && places_.size() > 1) throw UsageError("--map is of one PLACE");
    printHeader();
    std::vector<Answer> all;
    for (const std::string& name : places_) {
      MappedPlace place(name, static_cast<std::size_t>(every_));
      const std::vector<Answer> answers = answersIn(place);
      print(name, answers);
      all.insert(all.end(), answers.begin(), answers.end());
    }
    print("all", all);
    Reliability(all).print();
    return kOk;
  }

  std::vector<std::string> places_;
  double radius_ = 3;
  int every_ = 1;
  std::string map_;
  ViewParams view_;
  EvaluationParams evaluation_;
  GlobalLocalizationParams localization_;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<ScoreUnknownApp>(argc, argv); }
