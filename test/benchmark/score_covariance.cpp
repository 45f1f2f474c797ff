// SPDX-License-Identifier: BSD-3-Clause
//
// How well stated covariances agree with the errors of poses.
//
//   score_covariance [--truth-deg DEG] [--truth-mm MM] [--map-poses poses.txt] [--csv FILE]
//   [--GROUP.PARAMETER VALUE] PLACE...
//
// Each PLACE is a folder with a run map/, which makes the map by the paper's rule, and a run query/ that is
// compared with its true poses, in four ways: each image alone in the map (single), image against image, by
// distance (pair), from each N-th image to the next (motion), and all images in a row (sequence).
// A pose is right within 0.3 m and 5 deg; right ones alone count for the covariance. Printed are how many are
// sure, right of these, and right at rank 1; NEES, e^T P^-1 e, its mean (6 if covariances are right), median
// (5.35) and 97 % bound (13.97); the share in the 50 and 95 % ellipsoids; and |error| / std along the
// weakest, middle and strongest principal axis of the stated position, as 50, 90 and 97 % bounds
// (0.67, 1.64, 2.17).
#include "base/text.h"
#include "cli/app.h"
#include "cli/text.h"
#include "covariance_statistics.h"
#include "image_overlap.h"
#include "mapped_place.h"
#include "motion/camera_motion.h"
#include "programs.h"
#include "ranking/global_localization.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/localization/localizer.h>
#include <facetloc/registration/pair_registration.h>

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace facetloc;
using benchmarks::CovarianceStatistics, benchmarks::MappedPlace, benchmarks::percent, benchmarks::PosedRun;

constexpr std::array<std::pair<double, double>, 4> kDistances = {
    {{0, 0.3}, {0.3, 0.6}, {0.6, 1}, {1, 1.7}}};           // between two views [m]
constexpr double kMostTurned = 45 * kDegree;               // between two views
constexpr double kLeastOverlap = 0.3;                      // overlap of two views
constexpr double kPairRotation = 60, kPairDistance = 1.5;  // prior of a pair [deg], [m]
constexpr int kPairAttempts = 50000;
constexpr std::array<std::size_t, 4> kGaps = {1, 2, 4, 8};  // images from one to the next, of motions
constexpr std::uint32_t kSeed = 1;

/** The answer of one kind of localization for one image. */
struct Answer {
  std::optional<PoseWithCovariance> pose;
  bool sure = false;
};

/** The answers of one kind to the images of one place. */
struct Tally {
  std::string place, kind, group;
  std::size_t images = 0, sure = 0, sure_right = 0, right = 0;
  CovarianceStatistics statistics{};
};

/** Heading and cells of a table of tallies. */
using Column = std::pair<std::string, std::string>;

std::vector<Column> columnsOf(const Tally& t) {
  const CovarianceStatistics& s = t.statistics;
  const bool any = s.size() > 0;
  const auto number = [&](double x) { return any ? text::decimals(x, x < 100 ? 2 : 0) : ""; };
  const auto share_of = [&](double x) { return any ? text::decimals(100 * x, 1) : ""; };
  std::vector<Column> columns = {{"place", t.place},
                                 {"kind", t.kind},
                                 {"group", t.group},
                                 {"images", std::to_string(t.images)},
                                 {"sure", std::to_string(t.sure)},
                                 {"right of sure [%]", text::decimals(percent(t.sure_right, t.sure), 1)},
                                 {"rank 1 [%]", text::decimals(percent(t.right, t.images), 1)},
                                 {"n", std::to_string(s.size())},
                                 {"NEES", number(s.meanNees())},
                                 {"median", number(s.nees(0.5))},
                                 {"97 %", number(s.nees(0.97))},
                                 {"in 50 %", share_of(s.inside50())},
                                 {"in 95 %", share_of(s.inside95())}};
  const std::array<std::string, 3> names = {"weakest", "middle", "strongest"};
  for (std::size_t axis = 0; axis < names.size(); ++axis)
    for (const double share : {0.5, 0.9, 0.97})
      columns.emplace_back((share == 0.5 ? names[axis] + " " : "") + text::shortest(100 * share) + " %",
                           number(s.ratio(static_cast<CovarianceStatistics::Axis>(axis), share)));
  return columns;
}

constexpr auto kHeading = &Column::first, kCell = &Column::second;

std::vector<std::string> partOf(const std::vector<Column>& columns, std::string Column::*part) {
  std::vector<std::string> all;
  for (const Column& column : columns) all.push_back(column.*part);
  return all;
}

/** One column each for CSV, without units and with the axis in each name. */
void writeCsv(const fs::path& path, const std::vector<Tally>& tallies) {
  writeTextAtomically(path, [&](std::ostream& out) {
    out << "place,kind,group,images,sure,sure_right_percent,rank1_percent,n,nees_mean,nees_median,nees_97,"
           "inside_50_percent,inside_95_percent";
    for (const char* axis : {"weakest", "middle", "strongest"})
      for (const char* share : {"50", "90", "97"}) out << "," << axis << "_" << share;
    out << "\n";
    for (const Tally& tally : tallies) {
      std::string line;
      for (const std::string& cell : partOf(columnsOf(tally), kCell))
        line += (line.empty() ? "" : ",") + text::csvCell(cell);
      out << line << "\n";
    }
  });
}

/** Pairs (view, other view) of a run that overlap and are so far apart; a fixed seed chooses them. */
std::vector<std::pair<std::size_t, std::size_t>> choosePairs(const PosedRun& run,
                                                             const std::vector<DepthImage>& images,
                                                             const std::pair<double, double>& distance,
                                                             std::size_t n) {
  std::mt19937 random(kSeed);
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (int attempt = 0; attempt < kPairAttempts && pairs.size() < n; ++attempt) {
    const std::size_t i = random() % run.truth.size(), j = random() % run.truth.size();
    const Eigen::Isometry3d T_j_i = run.truth[j].inverse() * run.truth[i];
    const double apart = T_j_i.translation().norm();
    if (i == j || apart < distance.first || apart >= distance.second) continue;
    if (rotationAngle(T_j_i.linear()) > kMostTurned) continue;
    if (benchmarks::overlap(images[i], images[j], T_j_i) < kLeastOverlap) continue;
    if (benchmarks::overlap(images[j], images[i], T_j_i.inverse()) < kLeastOverlap) continue;
    pairs.emplace_back(i, j);
  }
  return pairs;
}

class ScoreCovarianceApp : public App {
public:
  ScoreCovarianceApp()
      : App("score_covariance", "PLACE... [options]",
            "Compares the covariances of poses with their errors.") {
    evaluation_.max_translation = 0.3, evaluation_.max_rotation_deg = 5;
  }

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("PLACE", places_);
    line.addOption("every", every_, "N", "See only every N-th image.");
    line.addOption("pairs", pairs_, "N", "Largest number of pairs of each distance.");
    line.addOption("map-poses", map_poses_, "NAME", "File in PLACE/map with the poses of the map (TUM).");
    line.addOption("truth-deg", truth_deg_, "DEG", "Error of true orientations, root mean square [deg].");
    line.addOption("truth-mm", truth_mm_, "MM", "Error of true positions, root mean square [mm].");
    line.addOption("csv", csv_, "FILE", "Write the table to this file.");
    line.addPresets();
    line.addParams(view_);
    line.addParams(evaluation_, "evaluation");
    line.addParams(localizer_, "localizer");
    line.addParams(localization_);
  }

  void count(const Answer& answer, const Eigen::Isometry3d& truth, Tally& tally) const {
    ++tally.images;
    tally.sure += answer.sure;
    if (!answer.pose ||
        !isNear(answer.pose->T, truth, evaluation_.max_translation, evaluation_.max_rotation_deg))
      return;
    ++tally.right;
    tally.sure_right += answer.sure;
    tally.statistics.add(*answer.pose, truth, benchmarks::covarianceOfTruth(truth_deg_, truth_mm_));
  }

  void count(const std::vector<Answer>& answers, const PosedRun& run, Tally& tally) const {
    for (std::size_t i = 0; i < answers.size(); ++i) count(answers[i], run.truth[i], tally);
  }

  static std::optional<PoseWithCovariance> worldPose(const Map& map, const std::vector<Hypothesis>& places) {
    if (places.empty() || !map.models[places.front().model].T_w_m) return {};
    return *map.models[places.front().model].T_w_m * places.front().T_m_c;
  }

  std::vector<Answer> singleAnswers(const std::shared_ptr<const Map>& map, const PosedRun& run) const {
    internal::GlobalLocalization localization(map, localization_);
    localization.setNumberOfThreads(1);
    std::vector<Answer> answers(run.views.size());
    const int n = static_cast<int>(answers.size());
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < n; ++i) {
      const Localization found = localization.localize(run.views[i]);
      answers[i] = {worldPose(*map, found.hypotheses), found.state == AnswerState::sure};
    }
    return answers;
  }

  std::vector<Tally> pairs(const MappedPlace& place, const PosedRun& run) const {
    std::vector<DepthImage> images;
    for (const std::size_t frame : run.frames)
      images.push_back(place.query().sequence.load(frame, kWorkingWidth));
    std::vector<Tally> tallies;
    for (const auto& distance : kDistances) {
      Tally tally{"", "pair", text::shortest(distance.first) + "-" + text::shortest(distance.second) + " m"};
      const auto chosen = choosePairs(run, images, distance, static_cast<std::size_t>(pairs_));
      std::vector<Answer> answers(chosen.size());
      const int n = static_cast<int>(answers.size());
#pragma omp parallel for schedule(dynamic)
      for (int k = 0; k < n; ++k)
        answers[k] = registered(run.views[chosen[k].first], run.views[chosen[k].second]);
      for (std::size_t k = 0; k < chosen.size(); ++k)
        count(answers[k], run.truth[chosen[k].second].inverse() * run.truth[chosen[k].first], tally);
      tallies.push_back(std::move(tally));
    }
    return tallies;
  }

  /** The pose of a view in the frame of another one. */
  Answer registered(const View& view, const View& other) const {
    RegistrationParams params = localization_;
    params.prior.rotation_std_deg = kPairRotation, params.prior.translation_std = kPairDistance;
    const Localization found = PairRegistration(other, params).align(view);
    if (found.hypotheses.empty()) return {};
    return {found.hypotheses.front().T_m_c, found.state == AnswerState::sure};
  }

  /** Motions from each image to the one `gap` later; sure if the views have seen the motion. */
  Tally motions(const PosedRun& run, std::size_t gap) const {
    Tally tally{"", "motion", std::to_string(gap)};
    internal::CameraMotion motion(localizer_.odometry);
    for (std::size_t i = 0; i < run.views.size(); i += gap) {
      const auto view = std::make_shared<const View>(run.views[i]);
      const internal::Motion seen = motion.next(view, i ? run.stamps[i] - run.stamps[i - gap] : 0);
      if (i == 0) continue;
      Answer answer;
      if (seen.source != internal::Motion::Source::broken) answer = {seen.likeliest(), seen.agreement > 0};
      count(answer, run.truth[i - gap].inverse() * run.truth[i], tally);
    }
    return tally;
  }

  std::vector<Answer> sequenceAnswers(const std::shared_ptr<const Map>& map, const PosedRun& run) const {
    Localizer sequence(map, localizer_, localization_);
    sequence.setNumberOfThreads(threads());
    std::vector<Answer> answers;
    for (std::size_t i = 0; i < run.views.size(); ++i) {
      const Localization found = sequence.update(run.views[i], run.stamps[i]);
      answers.push_back({worldPose(*map, found.hypotheses), found.state == AnswerState::sure});
    }
    return answers;
  }

  std::vector<Tally> tallies(const std::string& folder) const {
    MappedPlace place(folder, static_cast<std::size_t>(every_), "query", map_poses_);
    Map seen = place.see(view_);
    benchmarks::findAmbiguity(seen, localization_);
    const auto map = std::make_shared<const Map>(std::move(seen));
    const PosedRun run = place.posedQuery();
    std::vector<Tally> all;
    const auto add = [&](const std::string& kind, const std::vector<Answer>& answers) {
      count(answers, run, all.emplace_back(Tally{"", kind, ""}));
    };
    add("single", singleAnswers(map, run));
    for (Tally& tally : pairs(place, run)) all.push_back(std::move(tally));
    for (const std::size_t gap : kGaps) all.push_back(motions(run, gap));
    add("sequence", sequenceAnswers(map, run));
    const fs::path path = fs::path(folder).lexically_normal();
    for (Tally& tally : all)
      tally.place = (path.has_filename() ? path : path.parent_path()).filename().string();
    return all;
  }

  int execute(const CommandLine&, const Console& console) override {
    if (every_ < 1 || pairs_ < 1) throw UsageError("every and pairs must be positive");
    if (!(truth_deg_ >= 0 && truth_mm_ >= 0)) throw UsageError("errors of the truth must not be negative");
    std::vector<Tally> all;
    for (const std::string& folder : places_)
      for (Tally& tally : tallies(folder)) all.push_back(std::move(tally));
    TextTable table(partOf(columnsOf({}), kHeading));
    for (const Tally& tally : all) table.add(partOf(columnsOf(tally), kCell));
    console.out << table;
    if (!csv_.empty()) writeCsv(csv_, all);
    return kOk;
  }

  std::vector<std::string> places_;
  std::string map_poses_, csv_;
  int every_ = 1, pairs_ = 100;
  double truth_deg_ = 0, truth_mm_ = 0;
  ViewParams view_;
  EvaluationParams evaluation_;
  LocalizerParams localizer_;
  GlobalLocalizationParams localization_;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<ScoreCovarianceApp>(argc, argv); }
