// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.h"
#include "batch/batch.h"
#include "batch/map_watch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "drawing/map_page.h"
#include "drawing/offscreen_display.h"
#include "drawing/pictures.h"
#include "evaluation/evaluation_pictures.h"
#include "evaluation/verdict.h"
#include "inputs/depth_input.h"
#include "inputs/localization_options.h"
#include "outputs/output_folder.h"
#include "outputs/provenance.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/io/error.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/occupancy_grid_file.h>
#include <facetloc/localization/localizer.h>

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

std::optional<std::size_t> find(const DepthSequence& sequence, const std::string& name) {
  const auto& frames = sequence.frames();
  const auto found =
      std::find_if(frames.begin(), frames.end(), [&](const FrameFile& f) { return f.name == name; });
  if (found == frames.end()) return {};
  return static_cast<std::size_t>(found - frames.begin());
}

std::size_t indexOf(const DepthSequence& sequence, const std::string& name) {
  if (const auto index = find(sequence, name)) return *index;
  throw UsageError("there is no image " + name);
}

/** The first answers to an image. \param truth where it was taken, if that is known */
std::vector<DrawnMatch> answersTo(const SeenImage& image, const Localizer& localizer, const Map& map,
                                  int most, const std::optional<Eigen::Isometry3d>& truth) {
  const Localization answer = localizer.localize(image.view);
  if (answer.hypotheses.empty())
    return {{-1, Eigen::Isometry3d::Identity(), "no hypothesis: " + answer.reason}};
  std::vector<DrawnMatch> drawn;
  for (const Hypothesis& h : answer.hypotheses) {
    const std::size_t rank = drawn.size() + 1;
    if (static_cast<int>(rank) > most) break;
    std::string caption = fmt::format("rank {}, probability {:.2f}", rank, h.probability);
    if (truth && h.T_w_c && h.part == 0 && hasGivenPose(map)) {
      const PoseError error = poseError(*h.T_w_c, *truth);
      caption += fmt::format(": {:.3f} m and {:.2f}° from the truth", error.translation, error.rotation_deg);
    }
    drawn.push_back({h.model, h.T_m_c.T, caption});
  }
  return drawn;
}

/** \brief Half of the images up to the first that is sure, half from there to the end, each half evenly. */
std::vector<std::size_t> imagesOfStrip(const std::vector<PageAnswer>& answers, std::size_t most) {
  const std::size_t n = answers.size();
  std::vector<std::size_t> chosen;
  if (n <= most) {
    for (std::size_t i = 0; i < n; ++i) chosen.push_back(i);
    return chosen;
  }
  const auto sure = std::find_if(answers.begin(), answers.end(),
                                 [](const PageAnswer& a) { return a.state == AnswerState::sure; });
  const std::size_t middle = sure == answers.end() ? n - 1 : static_cast<std::size_t>(sure - answers.begin());
  const std::size_t before = middle + 1 < n ? std::min(middle + 1, most / 2) : most, after = most - before;
  for (std::size_t k = 0; k < before; ++k) chosen.push_back(before > 1 ? k * middle / (before - 1) : middle);
  for (std::size_t k = 1; k <= after; ++k) chosen.push_back(middle + k * (n - 1 - middle) / after);
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

void requirePng(const fs::path& output) {
  if (text::lowerExtension(output) != ".png")
    throw UsageError("pictures are PNG files, and pages HTML: -o " + output.string());
}

/** Marks of files between commas, each named as its file and in a colour of its own; an empty name
 * leaves its colour out. */
std::vector<DrawnMarks> marksIn(const std::string& files) {
  constexpr Colour kColours[] = {{0, 130, 60}, {130, 60, 170}, kRed};
  std::vector<DrawnMarks> marks;
  std::size_t kind = 0;
  for (const std::string_view file : text::split(files, ',')) {
    const Colour& colour = kColours[kind++ % std::size(kColours)];
    if (const fs::path path(file); !path.empty())
      marks.push_back({path.stem().string(), posesOf(DepthSequence::readTruth(path)), colour});
  }
  return marks;
}

/** facetloc_render: pictures of images, maps, answers and failures. */
class RenderApp : public App {
public:
  RenderApp()
      : App("facetloc_render", "INPUT -o OUT [--map MAP.flmap] [options]",
            "Draws pictures, and 3D pages for a browser. INPUT is one of: (1) A map *.flmap: OUT is an HTML "
            "page to turn, zoom and click, or a PNG file, the map from above. (2) A results folder of "
            "facetloc_localize with --map: OUT is an HTML page, the answers in their map over time, or a PNG "
            "file, the possible places of each image. With --sequence, OUT may be a folder: the failures "
            "beside the true poses. (3) A depth image (OUT is a PNG file) or a recording (OUT is a folder, "
            "or, with --frame, a file): its segments outlined and in 3D; with --map, beside the matched "
            "local models. PNG files need an X display; without one, Xvfb is started if installed.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArgument("INPUT", input_);
    line.addOption("output,o", output_, "OUT", "An HTML page, a PNG file, or a folder of PNG files.");
    addOverwrite(line, overwrite_);
    line.addOption("map", map_, "MAP.flmap", "The map to localize the images in, or the map of the results.");
    line.addOption("frame", frame_, "NAME", "Draw only this image of a recording.");
    line.addOption("max-hypotheses", max_hypotheses_, "K", "Maximum number of answers drawn per image.");
    line.addOption("trajectory", trajectory_, "FILE",
                   "Draw this trajectory into a map: a TUM file, or a recording with poses.");
    line.addOption("marks", marks_, "FILE,...",
                   "Mark the poses of these files in a map, green, purple and red.");
    line.addOption("grid", grid_, "PLAN.yaml", "Draw this occupancy grid in a map, for its segments.");
    line.addSwitch("self", self_,
                   "Localize a map's own images without themselves, and colour the local models of its page "
                   "by the answers.");
    line.addOption("sequence", sequence_, "RECORDING",
                   "The recording of the results: its images, and its true poses.");
    line.addOption("most", most_, "N", "Maximum number of failures drawn, the most confident first.");
    depth_.addAllOptions(line);
    line.addParams(evaluation_, "evaluation");
    addLocalizationOptions(line, localization_);
    line.addExample("office.flmap -o map.html", "a map, to turn in a browser");
    line.addExample("results --map office.flmap --sequence walk -o answers.html",
                    "answers, each with its match at a click");
  }

  std::vector<DrawnRun> drawnRuns() const {
    if (trajectory_.empty()) return {};
    return {{"trajectory", posesOf(DepthSequence::readTruth(trajectory_))}};
  }

  int renderMap(const Console& console) const {
    requirePng(output_);
    requireReplaceable(output_);
    const Map map = readMap(input_);
    std::optional<OccupancyGrid> grid;
    if (!grid_.empty()) grid = readOccupancyGrid(grid_);
    drawFloorMap(output_, map, drawnRuns(), marksIn(marks_), grid ? &*grid : nullptr);
    console.out << counted(map.models.size(), "local model") << "; picture in " << output_ << "\n";
    return kOk;
  }

  int renderImages(const CommandLine& line, const Console& console) const {
    RecordingHints recording = depth_.recording;
    recording.segments = true;
    const DepthSequence sequence = openSequence(input_, recording, console);
    std::vector<std::size_t> chosen;
    if (!frame_.empty())
      chosen = {indexOf(sequence, frame_)};
    else
      for (std::size_t i = 0; i < sequence.frames().size(); ++i) chosen.push_back(i);

    const bool to_folder =
        chosen.size() > 1 || fs::is_directory(output_) || !fs::path(output_).has_extension();
    if (to_folder && text::lowerExtension(output_) == ".png")
      throw UsageError(fmt::format("{} has several images: -o names a folder, or use --frame", input_));
    if (!to_folder) requirePng(output_);
    const auto pathOf = [&](std::size_t i) {
      return to_folder ? fs::path(output_) / (sequence.frames()[i].name + ".png") : fs::path(output_);
    };
    for (const std::size_t i : chosen) {
      if (to_folder) requireOtherFolder(output_, sequence.frames()[i].path.parent_path());
      requireReplaceable(pathOf(i));
    }
    if (to_folder) claimPictureFolder(output_, overwrite_);

    const Camera camera = depth_.camera(sequence.camera(), line);
    std::shared_ptr<const Map> map;
    std::optional<Localizer> localizer;
    if (!map_.empty()) {
      map = std::make_shared<const Map>(noteUnfinished(openMap(map_), map_, console));
      noteDifference(map->calibrated(camera), *map, console);
      localizer.emplace(map, LocalizerParams(), localization_);
      localizer->setNumberOfThreads(threads());
    }
    ViewBuilder builder(map ? map->calibrated(camera) : camera, depth_.view);
    Batch batch(1, chosen.size(), console);  // OpenGL is used by one thread
    batch.run([&](std::size_t k) { return sequence.frames()[chosen[k]].path.string(); },
              [&](std::size_t k, int) {
                const std::size_t i = chosen[k];
                const FrameFile& file = sequence.frames()[i];
                const SeenImage image =
                    sequence.ofSegments() ? seeSegments(file.name, viewOf(sequence, i, depth_.width, builder))
                                          : see(file.name, sequence.load(i, depth_.width), builder);
                if (localizer)
                  writePng(pathOf(i), matchesPicture(image, *map,
                                                     answersTo(image, *localizer, *map, max_hypotheses_,
                                                               sequence.groundTruth().at(file.stamp))));
                else
                  drawSegmentation(pathOf(i), image);
              });
    const int code = batch.report();
    console.out << counted(chosen.size() - batch.failures().size(), "picture") << " in " << output_ << "\n";
    return code;
  }

  int renderBeliefs(const Console& console) const {
    constexpr std::size_t kMostImages = 12;
    if (map_.empty()) throw UsageError("the picture of results needs --map");
    requirePng(output_);
    requireReplaceable(output_);
    const Map map = readMap(map_);
    const std::vector<PageAnswer> answers = answerPage(map, readRuns(input_)).answers;
    if (answers.empty()) throw IoError(input_, "has no results");
    std::vector<PageAnswer> drawn;
    std::vector<std::string> titles;
    for (const std::size_t i : imagesOfStrip(answers, kMostImages)) {
      drawn.push_back(answers[i]);
      titles.push_back(
          fmt::format("image {}, {}: {}", i + 1, drawn.back().frame, toString(drawn.back().state)));
    }
    if (!sequence_.empty()) {
      const DepthSequence sequence = openSequence(sequence_, depth_.recording, console);
      for (PageAnswer& answer : drawn)
        if (const auto index = find(sequence, answer.frame))
          answer.truth = sequence.groundTruth().at(sequence.frames()[*index].stamp);
    }
    drawBeliefs(output_, map, drawn, titles);
    console.out << drawn.size() << " of " << counted(answers.size(), "image") << "; picture in " << output_
                << "\n";
    return kOk;
  }

  int renderFailures(const CommandLine& line, const Console& console) const {
    constexpr std::size_t kOnSheet = 6;
    if (map_.empty() || sequence_.empty())
      throw UsageError("the pictures of results need --map and --sequence");
    const DepthSequence sequence = openSequence(sequence_, depth_.recording, console);
    const Map map = readMap(map_);
    const std::vector<ModelPose> models = modelPosesOf(map);
    if (models.empty()) throw IoError(map_, "has no poses of local models: the truth cannot be drawn");
    const std::vector<RunResults> runs = readRuns(input_);
    const Evaluation evaluation = evaluate(runs, PlaceTruth::open(sequence_), models,
                                           withinTruth(evaluation_, knownFindings({}, input_, runs)));
    if (evaluation.frames.empty()) throw IoError(sequence_, "has no pose for any image of " + input_);
    const std::vector<Failure> failures = findFailures(evaluation, runs, map);
    const std::size_t drawn = std::min<std::size_t>(failures.size(), most_);
    for (const FrameFile& frame : sequence.frames()) requireOtherFolder(output_, frame.path.parent_path());
    const auto pathOf = [&](const std::string& name) { return fs::path(output_) / (name + ".png"); };
    const fs::path sheet_path = pathOf("failures");
    requireReplaceable(sheet_path);
    for (std::size_t i = 0; i < drawn; ++i) requireReplaceable(pathOf(failures[i].frame));
    claimPictureFolder(output_, overwrite_);
    fs::remove(sheet_path);  // left by an earlier run; there may be no failure now

    ViewBuilder builder(map.calibrated(depth_.camera(sequence.camera(), line)), depth_.view);
    std::vector<Raster<std::uint8_t>> sheet(std::min(drawn, kOnSheet));
    std::vector<std::string> titles;
    for (std::size_t i = 0; i < sheet.size(); ++i)
      titles.push_back(fmt::format("{}: {}", failures[i].frame, failures[i].what));
    Batch batch(1, drawn, console);  // OpenGL is used by one thread
    batch.run([&](std::size_t i) { return failures[i].frame; },
              [&](std::size_t i, int) {
                const Failure& failure = failures[i];
                const std::size_t index = indexOf(sequence, failure.frame);
                const SeenImage image = see(failure.frame, sequence.load(index, depth_.width), builder);
                Raster<std::uint8_t> picture = matchesPicture(image, map, failure.answers);
                writePng(pathOf(failure.frame), picture);
                if (i < sheet.size()) sheet[i] = std::move(picture);
              });
    const int code = batch.report();
    if (code == kOk && drawn > 0) writePng(sheet_path, contactSheet(sheet, titles));
    console.out << fmt::format("{} of {} failed, {} drawn; pictures in {}\n", failures.size(),
                               counted(evaluation.frames.size(), "image"), drawn, output_);
    return code;
  }

  int renderMapPage(const Console& console) const {
    const auto map = std::make_shared<const Map>(openMap(input_));
    MapPage page;
    page.title = "Map " + fs::path(input_).stem().string();
    page.runs = drawnRuns();
    if (self_) {
      MapWatch watch(console);
      page.own_views = localizeOwnViews(map, {}, localization_, threads(), watch.callback());
    }
    writeMapPage(output_, *map, page);
    console.out << counted(map->models.size(), "local model") << "; page in " << output_ << "\n";
    return kOk;
  }

  int renderAnswerPage(const CommandLine& line, const Console& console) const {
    if (map_.empty()) throw UsageError("the page of results needs --map");
    const Map map = openMap(map_);
    const std::vector<RunResults> runs =
        readRuns(input_, [&](const std::string& text) { console.note(text); });
    if (runs.empty() || runs.front().rows.empty()) throw IoError(input_, "has no results");
    const Findings findings = knownFindings({}, input_, runs);
    std::optional<DepthSequence> sequence;
    std::optional<Evaluation> evaluation;
    if (!sequence_.empty()) {
      sequence = openSequence(sequence_, depth_.recording, console);
      if (hasGivenPose(map) && !sequence->groundTruth().empty())
        evaluation = evaluate(runs, PlaceTruth(sequence->groundTruth()), modelPosesOf(map),
                              withinTruth(evaluation_, findings));
    }
    MapPage page = answerPage(map, runs, evaluation ? &*evaluation : nullptr);
    page.findings = findings;
    page.title = fmt::format("{} in {}", titleOf(input_), fs::path(map_).stem().string());
    page.runs = drawnRuns();
    if (evaluation) page.runs.push_back({"true poses", posesOf(sequence->groundTruth())});
    std::optional<ViewBuilder> builder;
    if (sequence) {
      builder.emplace(map.calibrated(depth_.camera(sequence->camera(), line)), depth_.view);
      page.view = [&](std::size_t answer) -> std::optional<View> {
        const auto found = find(*sequence, page.answers[answer].frame);
        if (!found) return {};
        return viewOf(*sequence, *found, depth_.width, *builder);
      };
    }
    writeMapPage(output_, map, page);
    console.out << counted(page.answers.size(), "image") << "; page in " << output_ << "\n";
    return kOk;
  }

  int execute(const CommandLine& line, const Console& console) override {
    if (output_.empty()) throw UsageError("the picture to write is missing: -o OUT");
    if (max_hypotheses_ < 1) throw UsageError("max-hypotheses must be positive");
    if (most_ < 1) throw UsageError("most must be positive");
    if (!fs::exists(input_)) throw IoError(input_, "does not exist");
    const bool is_page = text::lowerExtension(output_) == ".html";
    const bool is_map = text::lowerExtension(input_) == ".flmap";
    if (is_page && !overwrite_) requireReplaceable(output_);
    if (self_ && !(is_page && is_map)) throw UsageError("--self goes with the page of a map");
    if (is_map && !map_.empty())
      throw UsageError(fmt::format("--map goes with images and results; {} is a map itself", input_));
    if (is_page) {
      if (is_map) return renderMapPage(console);
      if (!isResultsFolder(input_))
        throw UsageError("pages are of maps and of results: " + input_ + " is neither");
      return renderAnswerPage(line, console);
    }
    const OffscreenDisplay display;
    if (!display.available()) throw std::runtime_error("nothing can be drawn: " + display.problem());
    if (is_map) return renderMap(console);
    if (!isResultsFolder(input_)) return renderImages(line, console);
    return text::lowerExtension(output_) == ".png" ? renderBeliefs(console) : renderFailures(line, console);
  }

  std::string input_, output_, map_, frame_, trajectory_, marks_, grid_, sequence_;
  bool overwrite_ = false, self_ = false;
  int max_hypotheses_ = 1, most_ = 20;
  DepthInput depth_;
  EvaluationParams evaluation_;
  GlobalLocalizationParams localization_;
};

}  // namespace

std::unique_ptr<App> renderApp() { return std::make_unique<RenderApp>(); }

}  // namespace facetloc
