// SPDX-License-Identifier: BSD-3-Clause
//
// What do people in view cost?
//
//   score_people [--map-frames N] [--query-frames N] [--people N] KIND+SEED...
//
// Each place, such as office31, is mapped without people. Every image of the later drive is taken without
// people and with 1 to N people around the camera, and localized one by one and as a drive. A row has the
// images of which people hide a tenth of the pixels, two tenths, ..., and the same images without people.
#include "cli/app.h"
#include "programs.h"

#include <facetloc/localization/localizer.h>
#include <facetloc/mapping/map_making.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_people.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace facetloc;

constexpr int kWidth = 320, kCoarseWidth = 80;    // images, and renderings that show the hidden share
constexpr double kMapStep = 0.25, kSwayDeg = 10;  // as facetloc_simulate [m, deg]
constexpr double kRightTranslation = 0.3, kRightRotationDeg = 5;  // as on recordings [m, deg]
constexpr std::size_t kTenths = 7;                                // tenths of an image that people hide

/** Numbers of sure answers, and of the wrong ones among them. */
struct Counts {
  int sure = 0, wrong = 0;

  void add(const Localization& answer, const Eigen::Isometry3d& T_w_c) {
    if (answer.state != AnswerState::sure) return;
    ++sure;
    wrong += !isNear(*answer.hypotheses.front().T_w_c, T_w_c, kRightTranslation, kRightRotationDeg);
  }
};

/** Answers to the images of which people hide some share. */
struct Row {
  int images = 0;
  Counts single, drive, single_alone, drive_alone;  // the last two without people

  void print(const std::string& name) const {
    std::printf("%-18s %6d | %5d %5d %5d %6.1f %% | %5d %5d %5d %6.1f %%\n", name.c_str(), images,
                single_alone.sure, single.sure, single.wrong,
                benchmarks::percent(single.sure, single_alone.sure), drive_alone.sure, drive.sure,
                drive.wrong, benchmarks::percent(drive.sure, drive_alone.sure));
  }
};

/** A simulated place, its map, and a later drive through it. */
class PeopledPlace {
public:
  PeopledPlace(const std::string& kind, std::uint64_t seed, std::size_t map_frames, std::size_t query_frames)
      : seed_(seed),
        camera_(centredKinect(kWidth), {}, seed),
        coarse_(centredKinect(kCoarseWidth), {}, seed) {
    DriveParams drive;
    known_.intrinsics = camera_.camera();
    known_.mounting = drive.mounting();
    drive.step = kMapStep;
    const SimulatedRun mapping = simulatedRun(kind, seed, kMappingRun, map_frames, drive);
    MapMaking making(known_);
    making.setNumberOfThreads(0);
    const std::vector<double> times = drivingTimes(basePoses(mapping.poses, drive.mounting()));
    for (std::size_t i = 0; i < mapping.poses.size(); ++i)
      making.add({std::to_string(i), times[i],
                  [&, i] { return camera_.render(mapping.world, mapping.poses[i], i).depth; },
                  mapping.poses[i]});
    map_ = std::make_shared<const Map>(making.finish());
    drive.step = DriveParams().step, drive.sway_deg = kSwayDeg;
    query_ = simulatedRun(kind, seed, kLaterRun, query_frames, drive);
    stamps_ = drivingTimes(basePoses(query_.poses, drive.mounting()));
    noise_ = mapping.poses.size();
  }

  std::size_t images() const { return query_.poses.size(); }
  const Eigen::Isometry3d& truth(std::size_t i) const { return query_.poses[i]; }

  /** The answers one by one and as a drive, and the share of each image that people hide. */
  struct Answers {
    std::vector<Localization> single, drive;
    std::vector<double> hidden;
  };
  Answers ask(int people) const {
    const SimulatedPeople around(people, query_.poses, stamps_, seed_);
    const Localizer localizer(map_);
    const int n = static_cast<int>(images());
    std::vector<View> views(n);
    Answers answers{std::vector<Localization>(n), {}, std::vector<double>(n)};
#pragma omp parallel
    {
      ViewBuilder builder(map_->calibrated(known_));
#pragma omp for schedule(dynamic)
      for (int i = 0; i < n; ++i) {
        const SimulatedWorld world = around.in(query_.world, i);
        views[i] = builder.build(camera_.render(world, truth(i), noise_ + i).depth);
        answers.single[i] = localizer.localize(views[i]);
        answers.hidden[i] = hidden(world, i);
      }
    }
    Localizer drive(map_);
    for (int i = 0; i < n; ++i) answers.drive.push_back(drive.update(views[i], stamps_[i]));
    return answers;
  }

private:
  double hidden(const SimulatedWorld& peopled, int i) const {
    constexpr float kNearer = 0.99f;
    const DepthImage all = coarse_.renderExact(query_.world, truth(i)).depth,
                     seen = coarse_.renderExact(peopled, truth(i)).depth;
    std::size_t nearer = 0;
    for (std::size_t k = 0; k < all.depth.size(); ++k)
      nearer += seen.depth[k] > 0 && (all.depth[k] == 0 || seen.depth[k] < kNearer * all.depth[k]);
    return static_cast<double>(nearer) / static_cast<double>(all.depth.size());
  }

  std::uint64_t seed_;
  SimulatedCamera camera_, coarse_;
  Camera known_;
  std::shared_ptr<const Map> map_;
  SimulatedRun query_;
  std::vector<double> stamps_;
  std::uint64_t noise_ = 0;
};

class ScorePeopleApp : public App {
public:
  ScorePeopleApp()
      : App("score_people", "PLACE... [options]",
            "Localizes a camera among people in the map of an empty place, such as office31.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("PLACE", places_);
    line.addOption("map-frames", map_frames_, "N", "Number of images of the mapping run.");
    line.addOption("query-frames", query_frames_, "N", "Number of images of the later run.");
    line.addOption("people", people_, "N", "Largest number of people.");
  }

  int execute(const CommandLine&, const Console&) override {
    if (map_frames_ < 1 || query_frames_ < 1 || people_ < 1)
      throw UsageError("map-frames, query-frames and people must be positive");
    std::printf("%-18s %6s | %32s | %32s\n%-18s %6s | %5s %5s %5s %8s | %5s %5s %5s %8s\n", "", "",
                "one by one: sure", "as a drive: sure", "hidden", "images", "alone", "sure", "wrong", "share",
                "alone", "sure", "wrong", "share");
    std::array<Row, kTenths> all;
    for (const std::string& name : places_) {
      const std::size_t digits = std::min(name.find_first_of("0123456789"), name.size());
      const std::string seed = name.substr(digits);
      if (seed.empty() || seed.size() > 6 || seed.find_first_not_of("0123456789") != std::string::npos)
        throw UsageError("a PLACE is a kind and a seed, such as office31: " + name);
      const std::array<Row, kTenths> rows =
          of({name.substr(0, digits), std::stoul(seed), static_cast<std::size_t>(map_frames_),
              static_cast<std::size_t>(query_frames_)},
             all);
      print(name, rows);
    }
    if (places_.size() > 1) print("all", all);
    return kOk;
  }

  std::array<Row, kTenths> of(const PeopledPlace& place, std::array<Row, kTenths>& all) const {
    std::array<Row, kTenths> rows;
    const PeopledPlace::Answers alone = place.ask(0);
    for (int people = 1; people <= people_; ++people) {
      const PeopledPlace::Answers among = place.ask(people);
      for (std::size_t i = 0; i < place.images(); ++i) {
        const auto tenth = std::min(kTenths - 1, static_cast<std::size_t>(std::ceil(10 * among.hidden[i])));
        for (Row* row : {&rows[tenth], &all[tenth]}) {
          const Eigen::Isometry3d& T_w_c = place.truth(i);
          ++row->images;
          row->single_alone.add(alone.single[i], T_w_c), row->drive_alone.add(alone.drive[i], T_w_c);
          row->single.add(among.single[i], T_w_c), row->drive.add(among.drive[i], T_w_c);
        }
      }
    }
    return rows;
  }

  static void print(const std::string& name, const std::array<Row, kTenths>& rows) {
    for (std::size_t k = 0; k < kTenths; ++k)
      rows[k].print(name + (k == 0             ? " 0"
                            : k == kTenths - 1 ? " > 50 %"
                                               : " <= " + std::to_string(10 * k) + " %"));
    std::fflush(stdout);
  }

  std::vector<std::string> places_;
  int map_frames_ = 160, query_frames_ = 80, people_ = 4;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<ScorePeopleApp>(argc, argv); }
