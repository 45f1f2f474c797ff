// SPDX-License-Identifier: BSD-3-Clause
//
// How well stated covariances agree with the errors of poses of one single image in another.
//
//   score_covariance [--every N] [--truth-deg DEG] [--truth-mm MM] [--GROUP.PARAMETER VALUE] PLACE...
//
// Each PLACE is a folder with a run map/, by which the camera is calibrated, and a run query/, whose images
// are registered in pairs and compared with their true poses, by distance. A pose is right within 0.3 m and 5
// deg; right ones alone count for the covariance. Printed are how many are sure, right of these, and right at
// rank 1; NEES, e^T P^-1 e, its mean (6 if covariances are right), median (5.35) and 97 % bound (13.97); the
// share in the 50 and 95 % ellipsoids; and |error| / std along the weakest, middle and strongest principal
// axis of the stated position, as 50, 90 and 97 % bounds (0.67, 1.64, 2.17).
#include "base/text.h"
#include "cli/app.h"
#include "cli/text.h"
#include "covariance_statistics.h"
#include "image_overlap.h"
#include "mapped_place.h"
#include "programs.h"

#include <facetloc/registration/pair_registration.h>

#include <array>
#include <filesystem>
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
constexpr double kRightTranslation = 0.3, kRightRotationDeg = 5;  // errors of right poses [m, deg]
constexpr std::uint32_t kSeed = 1;

/** The pose of a pair. */
struct Answer {
  std::optional<PoseWithCovariance> pose;
  bool sure = false;
};

/** The answers to the pairs of one place that are so far apart. */
struct Tally {
  std::string place, group;
  std::size_t pairs = 0, sure = 0, sure_right = 0, right = 0;
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
                                 {"group", t.group},
                                 {"pairs", std::to_string(t.pairs)},
                                 {"sure", std::to_string(t.sure)},
                                 {"right of sure [%]", text::decimals(percent(t.sure_right, t.sure), 1)},
                                 {"rank 1 [%]", text::decimals(percent(t.right, t.pairs), 1)},
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
            "Compares the covariances of poses of single images in each other with their errors.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("PLACE", places_);
    line.addOption("every", every_, "N", "See only every N-th image.");
    line.addOption("pairs", pairs_, "N", "Largest number of pairs of each distance.");
    line.addOption("truth-deg", truth_deg_, "DEG", "Error of true orientations, root mean square [deg].");
    line.addOption("truth-mm", truth_mm_, "MM", "Error of true positions, root mean square [mm].");
    line.addPresets();
    line.addParams(view_);
    line.addParams(registration_);
  }

  void count(const Answer& answer, const Eigen::Isometry3d& truth, Tally& tally) const {
    ++tally.pairs;
    tally.sure += answer.sure;
    if (!answer.pose || !isNear(answer.pose->T, truth, kRightTranslation, kRightRotationDeg)) return;
    ++tally.right;
    tally.sure_right += answer.sure;
    tally.statistics.add(*answer.pose, truth, benchmarks::covarianceOfTruth(truth_deg_, truth_mm_));
  }

  /** The pose of a view in the frame of another one. */
  Answer registered(const View& view, const View& other) const {
    RegistrationParams params = registration_;
    params.prior.rotation_std_deg = kPairRotation, params.prior.translation_std = kPairDistance;
    const Localization found = PairRegistration(other, params).align(view);
    if (found.hypotheses.empty()) return {};
    return {found.hypotheses.front().T_m_c, found.state == AnswerState::sure};
  }

  void addRows(const fs::path& folder, TextTable& table) const {
    MappedPlace place(folder, static_cast<std::size_t>(every_));
    place.see(view_);
    const PosedRun run = place.posedQuery();
    std::vector<DepthImage> images;
    for (const std::size_t frame : run.frames)
      images.push_back(place.query().sequence.load(frame, kWorkingWidth));
    for (const auto& distance : kDistances) {
      Tally tally{(folder.has_filename() ? folder : folder.parent_path()).filename().string(),
                  text::shortest(distance.first) + "-" + text::shortest(distance.second) + " m"};
      const auto chosen = choosePairs(run, images, distance, static_cast<std::size_t>(pairs_));
      std::vector<Answer> answers(chosen.size());
      const int n = static_cast<int>(answers.size());
#pragma omp parallel for schedule(dynamic)
      for (int k = 0; k < n; ++k)
        answers[k] = registered(run.views[chosen[k].first], run.views[chosen[k].second]);
      for (std::size_t k = 0; k < chosen.size(); ++k)
        count(answers[k], run.truth[chosen[k].second].inverse() * run.truth[chosen[k].first], tally);
      table.add(partOf(columnsOf(tally), kCell));
    }
  }

  int execute(const CommandLine&, const Console& console) override {
    if (every_ < 1 || pairs_ < 1) throw UsageError("every and pairs must be positive");
    if (!(truth_deg_ >= 0 && truth_mm_ >= 0)) throw UsageError("errors of the truth must not be negative");
    TextTable table(partOf(columnsOf({}), kHeading));
    for (const std::string& folder : places_) addRows(fs::path(folder).lexically_normal(), table);
    console.out << table;
    return kOk;
  }

  std::vector<std::string> places_;
  int every_ = 1, pairs_ = 100;
  double truth_deg_ = 0, truth_mm_ = 0;
  ViewParams view_;
  RegistrationParams registration_;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<ScoreCovarianceApp>(argc, argv); }
