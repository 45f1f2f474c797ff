// SPDX-License-Identifier: BSD-3-Clause
//
// How often is an answer sure in a map of another place, where every answer is wrong?
//
//   score_cross [--every N] [--GROUP.PARAMETER VALUE] MAPS... RECORDINGS...
//
// MAPS end in .flmap, the rest are RECORDINGS; of a folder with a run query/, that run. Each recording is
// localized image by image in the maps of all other places. A place is called by the name of the map's file,
// and a recording by its own, or a run by its folder's; PLACE:PATH calls it otherwise.
#include "batch/batch.h"
#include "cli/app.h"
#include "cli/text.h"
#include "inputs/depth_input.h"
#include "inputs/localization_options.h"
#include "programs.h"

#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/localization/localizer.h>
#include <facetloc/localization/sure_calibration.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace facetloc;

constexpr std::array<double, 4> kThresholds = {0.5, 0.9, 0.99, 0.999};

/** A map or a recording, and the place that it is of. */
struct Input {
  std::string place;
  fs::path path;
};

/** The probability of each image's first place; 0 without one. */
using Probabilities = std::vector<double>;

bool isRun(const std::string& name) {
  return name == "map" || name == "query" || name == "drive" || name == "depth";
}

std::string nameOf(fs::path path) {
  path = fs::absolute(path).lexically_normal();
  if (path.filename().empty()) path = path.parent_path();
  while (isRun(path.stem().string())) path = path.parent_path();
  return fs::is_directory(path) ? path.filename().string() : path.stem().string();
}

Input inputOf(const std::string& argument) {
  const auto colon = argument.find(':');
  const bool named = colon != std::string::npos && !fs::exists(argument);
  Input input{named ? argument.substr(0, colon) : "", named ? argument.substr(colon + 1) : argument};
  if (input.place.empty()) input.place = nameOf(input.path);
  if (!fs::exists(input.path)) throw IoError(input.path.string(), "does not exist");
  if (fs::is_directory(input.path / "query")) input.path /= "query";
  return input;
}

std::string percent(std::size_t n, std::size_t of) {
  return of == 0 ? "-" : fmt::format("{:.2f} %", benchmarks::percent(n, of));
}

std::size_t countFrom(double threshold, const Probabilities& answers) {
  return static_cast<std::size_t>(
      std::count_if(answers.begin(), answers.end(), [&](double p) { return p >= threshold; }));
}

class CrossApp : public App {
public:
  CrossApp()
      : App("score_cross", "MAPS... RECORDINGS... [options]",
            "Localizes each recording in the maps of all other places, where every answer is wrong, and "
            "tells "
            "how many are probable.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("MAPS... RECORDINGS...", inputs_);
    line.addOption("every", every_, "N", "Ask every N-th image of a recording.");
    input_.addOptions(line);
    addLocalizationOptions(line, localization_);
  }

  int execute(const CommandLine& line, const Console& console) override {
    if (every_ < 1) throw UsageError("every must be positive");
    std::vector<Input> maps, recordings;
    for (const std::string& argument : inputs_) {
      const Input input = inputOf(argument);
      (input.path.extension() == ".flmap" ? maps : recordings).push_back(input);
    }
    if (maps.empty() || recordings.empty()) throw UsageError("at least one map and one recording");
    TextTable table({"map", "recordings", "images", "p >= 0.5", "0.9", "0.99", "0.999", "highest p"});
    Probabilities all;
    for (const Input& map : maps) {
      const Probabilities of_map = answersIn(map, recordings, line, console);
      std::size_t others = 0;
      for (const Input& recording : recordings) others += recording.place != map.place;
      addRow(table, map.place, others, of_map);
      all.insert(all.end(), of_map.begin(), of_map.end());
    }
    addRow(table, "all", recordings.size(), all);
    console.out << table;
    const std::size_t sure = countFrom(kThresholds[1], all);
    console.out << fmt::format(
        "of {} images, none of which the map holds, {} are sure at p >= 0.9: {}, with 95 % "
        "confidence at most {:.2f} %\n",
        all.size(), sure, percent(sure, all.size()), 100 * upperLimitOfShare(sure, all.size(), 0.95));
    return kOk;
  }

  Probabilities answersIn(const Input& of_map, const std::vector<Input>& recordings, const CommandLine& line,
                          const Console& console) const {
    const auto map = std::make_shared<const Map>(openMap(of_map.path));
    const Localizer localizer(map, {}, localization_);
    Probabilities answers;
    for (const Input& recording : recordings) {
      if (recording.place == of_map.place) continue;
      const DepthSequence sequence = openSequence(recording.path.string(), input_.recording, console);
      const Camera camera = map->calibrated(input_.camera(sequence.camera(), line));
      const auto every = static_cast<std::size_t>(every_);
      const std::size_t n = (sequence.frames().size() + every - 1) / every;
      std::vector<std::optional<double>> found(n);
      Batch batch(threads(), n, console);
      std::vector<ViewBuilder> builders(batch.workers(), ViewBuilder(camera, input_.view));
      batch.run([&](std::size_t i) { return sequence.frames()[i * every].path.string(); },
                [&](std::size_t i, int worker) {
                  const View view = viewOf(sequence, i * every, input_.width, builders[worker]);
                  const Localization answer = localizer.localize(view);
                  found[i] = answer.hypotheses.empty() ? 0 : answer.hypotheses.front().probability;
                });
      batch.report();
      for (const std::optional<double>& answer : found)
        if (answer) answers.push_back(*answer);
    }
    return answers;
  }

  static void addRow(TextTable& table, const std::string& name, std::size_t recordings,
                     const Probabilities& answers) {
    std::vector<std::string> cells = {name, std::to_string(recordings), std::to_string(answers.size())};
    for (const double threshold : kThresholds)
      cells.push_back(percent(countFrom(threshold, answers), answers.size()));
    cells.push_back(
        fmt::format("{:.4f}", answers.empty() ? 0 : *std::max_element(answers.begin(), answers.end())));
    table.add(cells);
  }

  std::vector<std::string> inputs_;
  int every_ = 1;
  DepthInput input_;
  GlobalLocalizationParams localization_;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<CrossApp>(argc, argv); }
