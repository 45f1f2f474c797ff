// SPDX-License-Identifier: BSD-3-Clause
//
// Costs and savings of the shortlist in large maps of simulated floors.
//
//   score_large_maps --floors DIR [--models N,N,...] [--queries N] [--exhaustive N] [--csv FILE]
//                    [--first-seed N] [--shortlist.PARAMETER VALUE]
//
// The floors (office, home and hall of every seed) are rendered once and kept in DIR. A map of N local models
// is made of as many floors as that takes, far from each other, and kept in DIR/large-N.flmap. It is used as
// the tools use it: views are read when they are needed, and the index comes with the file. The queries are
// images of the later runs on these floors, at most --queries of them (200).
//
// A query is answerable if registering it with some local model near the truth gives a pose within 0.2 m and
// 2 deg of it. Recall of a list: the share of the answerable queries for which it holds such a model. It is
// reported for the best aligned models, by their number, and for the shortlist.
// --exhaustive localizes N of the queries with the shortlist and with all models, and counts whose
// answers have a right place among their first ones, and whose first place is right or wrong at which
// probability.
#include "base/text.h"
#include "cli/app.h"
#include "pairs/view_registration.h"
#include "programs.h"
#include "ranking/global_localization.h"
#include "shortlist/shortlist.h"
#include "simulated_floors.h"

#include <facetloc/features/pose.h>
#include <facetloc/io/map_database.h>
#include <facetloc/localization/place_index.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <malloc.h>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

using namespace facetloc;
using internal::Batch, internal::NextBatch, internal::Query, internal::Shortlist, internal::Start,
    internal::ViewRegistration;

const std::vector<std::string> kScenes = {"office", "home", "hall", "corridor", "hotel"};
constexpr double kFloorDistance = 1000;  // [m]
constexpr double kRightTranslation = 0.2, kRightRotationDeg = 2;
constexpr double kNear = 3, kNearRotationDeg = 45;  // models that may show the same
constexpr int kLengths[] = {1, 10, 20, 40, 50, 75, 100, 150, 200, 300, 500, 1000};

struct Options {
  std::string floors;
  int queries = 200, exhaustive = 0, first_seed = 1;
  ShortlistParams shortlist;
};

struct Question {
  View view;
  Eigen::Isometry3d T_w_c;
  std::vector<int> shown_by;  // local models that give the right pose

  bool isShownBy(int model) const { return std::binary_search(shown_by.begin(), shown_by.end(), model); }
};

// Processor time, so that other load does not matter [s].
double seconds(std::clock_t since) { return static_cast<double>(std::clock() - since) / CLOCKS_PER_SEC; }

bool isRight(const Eigen::Isometry3d& T_w_c, const Eigen::Isometry3d& truth) {
  return isNear(T_w_c, truth, kRightTranslation, kRightRotationDeg);
}

double mean(double sum, std::size_t n) { return sum / static_cast<double>(std::max<std::size_t>(n, 1)); }

/** Which floor of how many local models and queries. */
struct Floor {
  std::string scene;
  std::uint64_t seed;
  std::size_t models, queries;
  std::string name() const { return scene + std::to_string(seed); }
};

/** The views of floors, one after the other, in the order of the floors. */
class ViewsOfFloors : public MapStore {
public:
  ViewsOfFloors(std::string folder, std::vector<Floor> floors)
      : folder_(std::move(folder)), floors_(std::move(floors)) {}

  std::shared_ptr<const View> view(int i) const override {
    auto rest = static_cast<std::size_t>(i);
    std::size_t k = 0;
    while (rest >= floors_[k].models) rest -= floors_[k++].models;
    if (k != loaded_) map_ = simulatedFloor(folder_, floors_[k].scene, floors_[k].seed).map;
    loaded_ = k;
    return map_.view(static_cast<int>(rest));
  }

private:
  std::string folder_;
  std::vector<Floor> floors_;
  mutable std::size_t loaded_ = std::numeric_limits<std::size_t>::max();
  mutable Map map_;
};

/** Floors, one after the other, as one map. */
class Building {
public:
  explicit Building(const Options& options)
      : options_(options), seed_(static_cast<std::uint64_t>(options.first_seed)) {}

  /** The file of the map of exactly n models, of the floors that it takes. */
  std::string map(std::size_t n) {
    while (models_.size() < n) addFloor();
    const std::string path = options_.floors + "/large-" + std::to_string(n) + ".flmap";
    if (std::filesystem::exists(path)) return path;
    Map map;
    map.camera.mounting = mounting_;
    map.models.assign(models_.begin(), models_.begin() + static_cast<std::ptrdiff_t>(n));
    map.setStore(std::make_shared<ViewsOfFloors>(options_.floors, floors_));
    writeMap(path, map);
    return path;
  }
  /** Queries on the floors that are in a map of n models as a whole, evenly chosen. */
  std::vector<Question> queries(std::size_t n) const {
    std::size_t floors = 0, all = 0;
    for (std::size_t models = 0; floors < floors_.size(); ++floors) {
      models += floors_[floors].models;
      if (models > n) break;
      all += floors_[floors].queries;
    }
    std::vector<Question> chosen;
    const std::size_t wanted = std::min(all, static_cast<std::size_t>(options_.queries));
    for (std::size_t k = 0, before = 0; k < floors; before += floors_[k++].queries) {
      SimulatedFloor floor;
      while (chosen.size() < wanted && chosen.size() * all / wanted < before + floors_[k].queries) {
        if (floor.query.models.empty())
          floor = simulatedFloor(options_.floors, floors_[k].scene, floors_[k].seed);
        const std::size_t i = chosen.size() * all / wanted - before;
        const LocalModel& q = floor.query.models[i];
        chosen.push_back({*floor.query.view(static_cast<int>(i)), placeOf(k) * *q.T_w_m, {}});
        chosen.back().view.camera = std::make_shared<const Camera>(floor.query.camera);
      }
    }
    return chosen;
  }

private:
  static Eigen::Isometry3d placeOf(std::size_t floor) {
    return Eigen::Isometry3d(Eigen::Translation3d(kFloorDistance * static_cast<double>(floor), 0, 0));
  }
  void addFloor() {
    const std::string scene = kScenes[kind_];
    const SimulatedFloor floor = simulatedFloor(options_.floors, scene, seed_);
    mounting_ = floor.map.camera.mounting;
    const Eigen::Isometry3d place = placeOf(floors_.size());
    floors_.push_back({scene, seed_, floor.map.models.size(), floor.query.models.size()});
    for (const LocalModel& m : floor.map.models)
      models_.emplace_back(floors_.back().name() + "/" + m.name, m.stamp, place * *m.T_w_m);
    if (++kind_ == kScenes.size()) kind_ = 0, ++seed_;
  }

  const Options& options_;
  std::uint64_t seed_;
  std::size_t kind_ = 0;
  std::optional<CameraMounting> mounting_;
  std::vector<Floor> floors_;
  std::vector<LocalModel> models_;  // without their views
};

/** Memory of this process [MB]. */
double memory() {
  std::ifstream statm("/proc/self/statm");
  double size = 0, resident = 0;
  statm >> size >> resident;
  return 1e-6 * resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void findWhoShows(const Map& map, const GlobalLocalizationParams& params, std::vector<Question>& queries) {
  const ViewRegistration registration(params);
  PoseWithCovariance prior{Eigen::Isometry3d::Identity(), posePrior(map.camera.mounting, params.prior)};
  const Matrix6d known = floorInformation(map.camera.mounting, params.prior);
  const int n = static_cast<int>(queries.size());
#pragma omp parallel for schedule(dynamic)
  for (int i = 0; i < n; ++i) {
    Question& q = queries[i];
    const Query query(q.view, prior, known);
    if (!registration.mayFixPose(query)) continue;
    for (std::size_t m = 0; m < map.models.size(); ++m) {
      const Eigen::Isometry3d& T_w_m = *map.models[m].T_w_m;
      if (!isNear(T_w_m, q.T_w_c, kNear, kNearRotationDeg)) continue;
      const int model = static_cast<int>(m);
      const std::vector<Hypothesis> found = registration.align(query, *map.view(model));
      if (std::any_of(found.begin(), found.end(),
                      [&](const Hypothesis& h) { return isRight(T_w_m * h.T_m_c.T, q.T_w_c); }))
        q.shown_by.push_back(model);
    }
  }
}

constexpr std::size_t kNoRank = std::numeric_limits<std::size_t>::max();

/** The quality of an answer to a query. */
struct Grade {
  std::size_t rank;    // rank of the first right place; kNoRank if none is right
  double probability;  // probability of the first place
};

Grade grade(const Localization& answer, const Question& q) {
  const std::vector<Hypothesis>& places = answer.hypotheses;
  const auto right = std::find_if(places.begin(), places.end(),
                                  [&q](const Hypothesis& h) { return isRight(*h.T_w_c, q.T_w_c); });
  return {right == places.end() ? kNoRank : static_cast<std::size_t>(right - places.begin()),
          places.empty() ? 0 : places.front().probability};
}

/** Answers to the same queries, with all models and with the shortlist. */
void compare(const std::vector<Grade>& all, const std::vector<Grade>& some) {
  std::printf("%22s %10s %10s %5s\n", "right among the first", "all models", "shortlist", "both");
  for (const std::size_t places : {std::size_t{1}, std::size_t{2}, std::size_t{5}, std::size_t{10},
                                   std::size_t{20}, std::size_t{100}, kNoRank}) {
    int of_all = 0, of_shortlist = 0, of_both = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      of_all += all[i].rank < places, of_shortlist += some[i].rank < places;
      of_both += all[i].rank < places && some[i].rank < places;
    }
    std::printf("%22s %10d %10d %5d\n", places == kNoRank ? "any" : std::to_string(places).c_str(), of_all,
                of_shortlist, of_both);
  }
  // Lost: right with all models and that probability, wrong with the shortlist.
  std::printf("%22s %10s %10s %10s %10s %10s\n", "probability at least", "all: right", "wrong", "some: right",
              "wrong", "lost");
  for (const double least : {0.0, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95}) {
    int all_right = 0, all_wrong = 0, some_right = 0, some_wrong = 0, lost = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const bool all_sure = all[i].probability >= least, some_sure = some[i].probability >= least;
      all_right += all_sure && all[i].rank == 0, all_wrong += all_sure && all[i].rank != 0;
      some_right += some_sure && some[i].rank == 0, some_wrong += some_sure && some[i].rank != 0;
      lost += all_sure && all[i].rank == 0 && some[i].rank != 0;
    }
    std::printf("%22.2f %10d %10d %10d %10d %10d\n", least, all_right, all_wrong, some_right, some_wrong,
                lost);
  }
}

/** The map as the tools open it, with the index in its file. */
struct Opened {
  std::shared_ptr<const Map> map;
  double build_s, open_s, map_mb, index_mb;
};

Opened open(const std::string& path, const ShortlistParams& params) {
  Opened opened;
  {
    const Map map = openMap(path);
    const auto start = std::clock();
    const PlaceIndex index(map);
    MapDatabase::open(path).setPlaceIndex([&index](std::ostream& out) { index.write(out); });
    opened.build_s = seconds(start);
  }
  malloc_trim(0);
  const double before = memory();
  const auto start = std::clock();
  opened.map = std::make_shared<Map>(openMap(path));
  opened.map_mb = memory() - before;
  const PlaceIndex index = PlaceIndex::of(*opened.map, params);
  opened.open_s = seconds(start);
  opened.index_mb = memory() - before - opened.map_mb;
  std::printf(
      "\n%zu local models: file of %.0f MB; map opened with its index in %.2f s; index of %zu descriptors, "
      "built in %.1f s; memory: map %.1f MB, index %.1f MB\n",
      opened.map->models.size(), 1e-6 * static_cast<double>(std::filesystem::file_size(path)), opened.open_s,
      index.descriptors(), opened.build_s, opened.map_mb, opened.index_mb);
  return opened;
}

void score(const Options& options, Building& building, std::size_t n, std::FILE* csv) {
  const Opened opened = open(building.map(n), options.shortlist);
  const std::shared_ptr<const Map>& map = opened.map;
  std::vector<Question> queries = building.queries(n);
  GlobalLocalizationParams all;
  all.shortlist = options.shortlist, all.shortlist.size = 0;
  const internal::GlobalLocalization exhaustive(map, all);
  findWhoShows(*map, all, queries);

  ShortlistParams whole = options.shortlist;
  whole.gap = 1e6;  // keeps hopeless models: the curve shows their value
  const PlaceIndex index = PlaceIndex::of(*map, whole);

  // Not longer than the number of aligned models, so that it takes the time of a shortlist of any length.
  const int longest = std::min(kLengths[std::size(kLengths) - 1], options.shortlist.aligned_models);
  std::vector<int> ranks;  // rank of the first model that shows the place
  auto start = std::clock();
  for (const Question& q : queries) {
    const std::vector<int> list = index.shortlist(q.view, longest);
    if (q.shown_by.empty()) continue;
    const auto first = std::find_if(list.begin(), list.end(), [&q](int m) { return q.isShownBy(m); });
    ranks.push_back(first == list.end() ? std::numeric_limits<int>::max()
                                        : static_cast<int>(first - list.begin()));
  }
  const double vote = mean(1e3 * seconds(start), queries.size());
  std::printf("%zu queries, %zu answerable; aligned in %.1f ms\n", queries.size(), ranks.size(), vote);
  std::printf("%10s %10s\n", "aligned", "recall");
  for (const int length : kLengths) {
    if (length > longest) break;
    const auto held = std::count_if(ranks.begin(), ranks.end(), [length](int r) { return r < length; });
    const double recall = mean(static_cast<double>(held), ranks.size());
    std::printf("%10d %8.1f %%\n", length, 100 * recall);
    if (csv)
      std::fprintf(csv, "%zu,%d,%zu,%.5f,%.3f,%.3f,%.3f,%.1f,%.1f\n", n, length, ranks.size(), recall, vote,
                   opened.build_s, opened.open_s, opened.map_mb, opened.index_mb);
  }

  GlobalLocalizationParams some = all;
  some.shortlist = options.shortlist, some.shortlist.exhaustive_up_to = 0;
  const internal::GlobalLocalization quick(map, some);
  const Shortlist shortlist(map, some);
  std::size_t listed = 0, held = 0;
  for (const Question& q : queries) {
    const Query query(q.view, quick.prior(q.view), floorInformation(map->camera.mounting, some.prior));
    bool holds = false;
    for (const NextBatch& next : shortlist.batches(query, true, 1)) {
      const Batch batch = next(std::numeric_limits<double>::lowest());
      listed += batch.size();
      for (const Start& start_of : batch) holds = holds || q.isShownBy(start_of.model);
    }
    held += holds;
  }
  std::vector<Grade> quick_grades;
  start = std::clock();
  for (const Question& q : queries) quick_grades.push_back(grade(quick.localize(q.view), q));
  const double query_ms = mean(1e3 * seconds(start), queries.size());
  const double of_answerable = mean(100, ranks.size());
  std::printf("the shortlist holds %.1f models, recall %.1f %%\n",
              mean(static_cast<double>(listed), queries.size()), static_cast<double>(held) * of_answerable);
  const auto right_first = std::count_if(quick_grades.begin(), quick_grades.end(),
                                         [](const Grade& answer) { return answer.rank == 0; });
  std::printf(
      "a whole query takes %.1f ms, views that were not in memory included; rank 1 is right for %.1f %% of "
      "the answerable; %.0f MB in use\n",
      query_ms, of_answerable * static_cast<double>(right_first), memory());

  std::fflush(stdout);
  if (csv) std::fflush(csv);
  if (options.exhaustive == 0) return;
  const std::size_t asked = std::min(static_cast<std::size_t>(options.exhaustive), queries.size());
  std::vector<Grade> all_grades, some_grades;
  start = std::clock();
  for (std::size_t i = 0; i < asked; ++i) {
    const std::size_t k = i * queries.size() / asked;
    all_grades.push_back(grade(exhaustive.localize(queries[k].view), queries[k]));
    some_grades.push_back(quick_grades[k]);
  }
  std::printf("%zu queries with all models, %.0f ms each\n", asked, mean(1e3 * seconds(start), asked));
  compare(all_grades, some_grades);
  std::fflush(stdout);
}

class ScoreLargeMapsApp : public App {
public:
  ScoreLargeMapsApp()
      : App("score_large_maps", "--floors DIR [options]",
            "Costs and savings of the shortlist in large maps of simulated floors.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addOption("floors", options_.floors, "DIR", "Folder in which floors and maps are kept.");
    line.addOption("models", models_, "N,...", "Numbers of local models; 1000,10000 unless given.");
    line.addOption("queries", options_.queries, "N", "Largest number of queries.");
    line.addOption("exhaustive", options_.exhaustive, "N", "Localize N of them with all models as well.");
    line.addOption("first-seed", options_.first_seed, "N", "Seed of the first floors.");
    line.addOption("csv", csv_, "FILE", "Write the recall of the best aligned models.");
    line.addParams(options_.shortlist, "shortlist");
  }

  int execute(const CommandLine&, const Console&) override {
    if (options_.floors.empty()) throw UsageError("--floors is missing");
    std::FILE* csv = csv_.empty() ? nullptr : std::fopen(csv_.c_str(), "w");
    if (!csv_.empty() && !csv) throw std::runtime_error("cannot write " + csv_);
    if (csv)
      std::fprintf(csv, "models,shortlist,answerable,recall,shortlist_ms,build_s,open_s,map_mb,index_mb\n");
    Building building(options_);
    for (const std::string_view models : text::split(models_, ','))
      score(options_, building, text::to<std::size_t>(models).value_or(0), csv);
    if (csv && std::fclose(csv) != 0) throw std::runtime_error("cannot write " + csv_);
    return kOk;
  }

  std::string models_ = "1000,10000", csv_;
  Options options_;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<ScoreLargeMapsApp>(argc, argv); }
