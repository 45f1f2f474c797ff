// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "batch/batch.h"
#include "batch/map_watch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "inputs/depth_input.h"
#include "inputs/localization_options.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/localization/localization_params.h>
#include <facetloc/localization/localizer.h>
#include <facetloc/localization/sure_calibration.h>
#include <facetloc/mapping/map_session.h>

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

void requireShare(const char* name, double value) {
  if (!(value > 0 && value < 1)) throw UsageError(std::string(name) + " must be above 0 and below 1");
}

std::string percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

void printCandidates(std::ostream& out, const SureCalibration& calibration) {
  TextTable table({"sure from p", "sure", "wrong", "at most wrong", ""});
  for (const SureCalibration::Candidate& c : calibration.candidates())
    table.add({text::shortest(c.min_probability), std::to_string(c.sure), std::to_string(c.wrong),
               c.sure == 0 ? "-" : percent(c.bound), c.accepted ? "holds" : "not shown"});
  out << table;
}

/** facetloc_map calibrate: sets from which probability on answers in a map are sure. */
class MapCalibrateApp : public App {
public:
  MapCalibrateApp()
      : App("facetloc_map calibrate", "MAP.flmap [RECORDING] [--alpha A] [options]",
            "Finds the minimum probability of sure answers in a map. It is the lowest one at which at most a "
            "share A of the sure answers is wrong, with the given confidence. It is found on images with "
            "known poses: those of the RECORDING, in the coordinates of the map, or the map's own, each "
            "localized without itself. The map keeps the result, and facetloc_localize and facetloc_live use "
            "it unless --min-probability is given. If the images do not suffice, the map is not changed.") {}

private:
  /** An image whose place is known. */
  struct Asked {
    std::size_t frame;
    Eigen::Isometry3d T_w_c;
  };

  void addOptions(CommandLine& line) override {
    line.addArgument("MAP.flmap", map_);
    line.addArgument("RECORDING", recording_, false);
    line.addOption("alpha", alpha_, "A", "Maximum share of wrong answers among the sure ones.");
    line.addOption("confidence", confidence_, "C", "Confidence that this share is not exceeded.");
    line.addOption("max-translation", is_right_.max_translation, "M",
                   "Maximum position error of a right pose [m].");
    line.addOption("max-rotation-deg", is_right_.max_rotation_deg, "DEG",
                   "Maximum orientation error of a right pose [deg].");
    line.addOption("poses", poses_, "FILE",
                   "Camera poses in the coordinates of the map; those of the RECORDING unless given.");
    addPoseTolerance(line, pose_tolerance_);
    line.addCheck([this] {
      requireShare("alpha", alpha_);
      requireShare("confidence", confidence_);
      if (!(is_right_.max_translation > 0)) throw UsageError("max-translation must be positive");
      if (!(is_right_.max_rotation_deg > 0)) throw UsageError("max-rotation-deg must be positive");
    });
    input_.addAllOptions(line);
    addLocalizationOptions(line, localization_);
    line.addExample("office.flmap walk --alpha 0.01", "at most 1 % of the sure answers wrong");
    line.addExample("office.flmap --alpha 0.05", "by the images of the map itself");
  }

  /** Images of known poses, each of another view, none of them a local model. Throws IoError. */
  std::vector<Asked> askedOf(const DepthSequence& sequence, const Map& map, const Console& console) const {
    const Trajectory poses = givenPoses(sequence, poses_, console);
    if (poses.empty())
      throw IoError(recording_, "has no poses to distinguish right answers from wrong ones; give --poses");
    if (!sequence.stamped())
      throw IoError(recording_, "its image names are no time stamps: poses cannot be matched");
    std::set<std::pair<std::string, double>> in_map;
    for (const LocalModel& model : map.models) in_map.emplace(model.name, model.stamp);
    std::size_t left_out = 0;
    std::vector<Asked> posed, asked;
    std::vector<Eigen::Isometry3d> T_w_c;
    for (std::size_t i = 0; i < sequence.frames().size(); ++i) {
      const FrameFile& frame = sequence.frames()[i];
      const auto T = poses.at(frame.stamp, pose_tolerance_);
      if (!T) continue;
      if (in_map.count({frame.name, frame.stamp})) {
        ++left_out;
        continue;
      }
      posed.push_back({i, *T});
      T_w_c.push_back(*T);
    }
    if (left_out > 0)
      console.note(
          fmt::format("{} of its images are local models of the map and left out: the others are too "
                      "much like them for an honest bound; calibrate by a later drive",
                      left_out));
    if (posed.empty())
      throw IoError(recording_, fmt::format("none of its {}images has a pose within {:f} s",
                                            left_out > 0 ? "other " : "", pose_tolerance_));
    for (const std::size_t i : independentImages(T_w_c)) asked.push_back(posed[i]);
    if (asked.size() < posed.size())
      console.note(fmt::format("{} of {} are used: the others show the same as the one before", asked.size(),
                               counted(posed.size(), "image")));
    return asked;
  }

  /** \return the exit code. */
  int ask(const std::shared_ptr<const Map>& map, const CommandLine& line, SureCalibration& calibration,
          const Console& console) {
    if (recording_.empty()) {
      MapWatch watch(console);
      addOwnViews(map, calibration, is_right_, localization_, threads(), watch.callback());
      return kOk;
    }
    const bool has_world = std::any_of(map->models.begin(), map->models.end(), [&](const LocalModel& model) {
      return model.T_w_m && (map->parts.empty() || map->parts[model.part].empty());
    });
    if (!has_world)
      throw IoError(map_,
                    "has no poses in a world, with which those of a recording could be compared; without a "
                    "recording it is calibrated by its own images");
    input_.recording.segments = true;
    const DepthSequence sequence = openSequence(recording_, input_.recording, console);
    const Camera camera = map->calibrated(input_.camera(sequence.camera(), line));
    noteDifference(camera, *map, console);
    const std::vector<Asked> asked = askedOf(sequence, *map, console);
    std::vector<std::optional<std::pair<double, bool>>> answers(asked.size());
    Batch batch(threads(), asked.size(), console);
    std::vector<ViewBuilder> builders(batch.workers(), ViewBuilder(camera, input_.view));
    const Localizer localizer(map, {}, localization_);
    batch.run([&](std::size_t i) { return sequence.frames()[asked[i].frame].path.string(); },
              [&](std::size_t i, int worker) {
                const View view = viewOf(sequence, asked[i].frame, input_.width, builders[worker]);
                const Localization found = localizer.localize(view);
                answers[i] = {0, false};
                if (found.hypotheses.empty()) return;
                const Hypothesis& best = found.hypotheses.front();
                answers[i] = {best.probability, best.T_w_c && map->partOf(best.model).empty() &&
                                                    is_right_(*best.T_w_c, asked[i].T_w_c)};
              });
    for (const auto& answer : answers)
      if (answer) calibration.add(answer->first, answer->second);
    return batch.report();
  }

  /** Throws with the missing data named. */
  [[noreturn]] void refuse(const SureCalibration& calibration) const {
    const std::string images = recording_.empty() ? map_ : recording_;
    const std::vector<SureCalibration::Candidate> all = calibration.candidates();
    const auto usual = std::find_if(all.begin(), all.end(),
                                    [](const auto& c) { return c.min_probability <= kMinProbability; });
    const std::string what =
        fmt::format("no threshold is shown to leave at most {} of the sure answers wrong", percent(alpha_));
    if (const auto needed = calibration.imagesNeeded())
      throw IoError(images,
                    fmt::format("{}: its {} are too few; it takes about {} like these, or a larger --alpha",
                                what, counted(calibration.images(), "image"), *needed));
    if (usual->sure == 0)
      throw IoError(images, fmt::format("{}: none of its {} is sure; it takes at least {} that are", what,
                                        counted(calibration.images(), "image"), calibration.leastSure()));
    const bool elsewhere = !recording_.empty() && 2 * usual->wrong > usual->sure;
    throw IoError(images,
                  fmt::format("{}: {} of {} sure answers are wrong{}; {}", what, usual->wrong, usual->sure,
                              fmt::format(" at p >= {}", text::shortest(usual->min_probability)),
                              elsewhere ? "its poses must be in the coordinates of the map"
                                        : "more images would not help, a larger --alpha may"));
  }

  int execute(const CommandLine& line, const Console& console) override {
    if (recording_.empty() && !poses_.empty()) throw UsageError("poses belong to a RECORDING");
    if (localization_.score.by_overlap)
      throw UsageError("score.by_overlap, which --preset paper sets, has no probabilities to calibrate");
    if (!fs::is_regular_file(map_)) throw IoError(map_, "is not there");
    const OutputLock lock = OutputLock::ofFile(map_);
    const auto map = std::make_shared<const Map>(noteUnfinished(openMap(map_), map_, console));
    if (map->models.empty()) throw IoError(map_, "has no local models");
    SureCalibration calibration(alpha_, confidence_);
    const int code = ask(map, line, calibration, console);
    printCandidates(console.out, calibration);
    const auto threshold = calibration.threshold(
        recording_.empty() ? "the map itself" : fs::path(recording_).lexically_normal().string());
    if (!threshold) refuse(calibration);
    MapDatabase::open(map_).setMeta(kSureKey, toText(*threshold));
    console.out << fmt::format("sure from {}\n", threshold->toString());
    return code;
  }

  std::string map_, recording_, poses_;
  double pose_tolerance_ = 0.02, alpha_ = 0.01, confidence_ = 0.95;
  RightPose is_right_;
  DepthInput input_;
  GlobalLocalizationParams localization_;
};

}  // namespace

std::unique_ptr<App> mapCalibrateApp() { return std::make_unique<MapCalibrateApp>(); }

}  // namespace facetloc
