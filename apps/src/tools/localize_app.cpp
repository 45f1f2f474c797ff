// SPDX-License-Identifier: BSD-3-Clause
#include "base/odometry_steps.h"
#include "base/text.h"
#include "batch/batch.h"
#include "batch/shared_batch.h"
#include "cli/findings_file.h"
#include "cli/progress.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "inputs/depth_input.h"
#include "inputs/gravity_option.h"
#include "inputs/localization_options.h"
#include "inputs/rig_input.h"
#include "outputs/localization_report.h"
#include "outputs/output_folder.h"
#include "outputs/pose_stream.h"
#include "outputs/provenance.h"
#include "tools/image_trajectory.h"

#include <facetloc/features/map_metadata.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/results.h>
#include <facetloc/localization/localizer.h>
#include <facetloc/registration/pose_prior.h>

#include <algorithm>
#include <chrono>
#include <fmt/core.h>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <ostream>
#include <set>
#include <utility>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/** Localizes an image. */
using Locate = std::function<Localization(const View& view, double stamp)>;

/** Motions of a camera from image to image, as an odometry has measured them. */
struct MeasuredMotion {
  PosesByTime odometry;  // T_o_c; may be empty
  std::optional<CameraMounting> mounting;
  OdometryError error;
  internal::OdometrySteps steps{};

  /** T_before_now since the last call; nothing at the first, and where the odometry has a gap. */
  std::optional<PoseWithCovariance> until(double stamp) {
    const auto T_before_now = odometry ? steps.to(odometry(stamp)) : std::nullopt;
    if (!T_before_now) return {};
    return motionByOdometry(*T_before_now, mounting, error);
  }
};

/** Images of one drive, which are localized by each other, in their order. */
struct Drive {
  Localizer localizer;
  MeasuredMotion motion;
  bool smoothing = false;          // later images refine the poses of earlier ones, which are kept
  bool advising = false;           // answers that are not sure say where to look next
  std::vector<DriveView> views{};  // those that are kept

  /** The answer by all images up to this one. */
  Localization add(const View& view, double stamp) {
    const std::optional<PoseWithCovariance> moved = motion.until(stamp);
    Localization answer = localizer.update(view, stamp, moved);
    if (advising) answer.next_look = localizer.nextLook(view, answer);
    if (smoothing) views.push_back({view, stamp, moved, answer});
    return answer;
  }
};

/** ", first sure at image 5": how long a drive takes until it knows where it is. */
std::string firstSure(const std::vector<FrameResult>& results) {
  const auto first = std::find_if(results.begin(), results.end(), [](const FrameResult& result) {
    return result.rows.front().state == AnswerState::sure;
  });
  if (first == results.end()) return "";
  return fmt::format(", first sure at image {}", first - results.begin() + 1);
}

void noteWithoutOdometry(const DepthSequence& sequence, const PosesByTime& odometry, const Console& console) {
  if (!odometry) return;
  const auto& frames = sequence.frames();
  const auto without = std::count_if(frames.begin(), frames.end(),
                                     [&](const FrameFile& frame) { return !odometry(frame.stamp); });
  if (without > 0)
    console.note(counted(static_cast<std::size_t>(without), "image") + " outside the time of the odometry");
}

FrameResult failedFrame(const FrameFile& file, const std::string& reason) {
  FrameResult result;
  result.stamp = file.stamp;
  result.timing.frame = file.name;  // no local model was searched
  result.rows = {noHypothesis(file.name, reason)};
  return result;
}

/** The first poses of an image, or the reason without one. */
void printImage(std::vector<ResultRow> rows, const Console& console) {
  constexpr std::size_t kMostRows = 3;
  rows.resize(std::min(rows.size(), kMostRows));
  if (rows.front().rank == 0) return console.print(rows.front().reason + "\n");
  printPoses(console.out, rows, "world");
}

bool hasFailed(const FrameResult& result) { return result.timing.models == 0; }

/** facetloc_localize: finds depth images in a map, in batch. */
class LocalizeApp : public App {
public:
  LocalizeApp()
      : App("facetloc_localize", "MAP.flmap... RECORDING -o RESULTS [options]",
            "Finds where depth images were taken in a map. RECORDING is a folder, a list (.txt, .lst) or one "
            "image of 16-bit PNGs or organized PCDs, an .oni, .mcap, .db3, .bag or .db file, or output of "
            "facetloc_segment, or a folder with a rig.ini, which makes several cameras one view. "
            "RESULTS/hypotheses.csv lists the ranked poses of each image, "
            "RESULTS/poses_tum.txt the sure ones; those of one image are printed, and need no RESULTS. With "
            "several maps, as of floors, part names the map of a pose. Images that cannot be localized are "
            "listed with the reason. Under mpirun, its processes share the images.") {}

private:
  using ImageBatch = SharedBatch<std::vector<std::size_t>, LocalizedImage>;

  /** The images and the map. */
  struct Task {
    DepthSequence sequence;
    std::shared_ptr<const Map> map;
    Camera camera;
    std::vector<SideRecording> sides{};  // other cameras
    PosesByTime odometry{};              // odometry of the camera; may be empty
    std::string params_ini{};            // parameters that the results depend on

    const std::vector<FrameFile>& frames() const { return sequence.frames(); }
    std::vector<ResultFrame> resultFrames() const {
      std::vector<ResultFrame> all;
      for (const FrameFile& file : frames()) all.push_back({file.name, file.stamp});
      return all;
    }
  };

  /** The work on them. */
  struct Run {
    std::vector<FrameResult> results;     // one per image
    std::vector<std::size_t> todo;        // images
    std::optional<ResultsWriter> writer;  // nothing if all is done already, or without a folder
    std::vector<ViewTraits> views{};      // one per image of this run
    std::optional<PoseStream> stream{};   // where answers go as soon as they are final, if anywhere

    /** Are the images that are still to be done the last ones? */
    bool inOrder() const { return todo.empty() || todo.front() + todo.size() == results.size(); }
    void publish(std::size_t frame) {
      if (stream) stream->put(frame, results[frame]);
    }
  };

  void addOptions(CommandLine& line) override {
    line.addArguments("MAP.flmap", maps_);
    line.addArgument("RECORDING", recording_);
    line.addOption("output,o", folder_, "RESULTS", "Folder of the results.");
    line.addOption("max-hypotheses", max_hypotheses_, "K", "Maximum number of hypotheses per image.");
    addMinProbability(line, min_probability_);
    line.addSwitch(
        "sequence", is_sequence_,
        "Treat the images as one drive: localize each by all images up to it, which resolves ambiguities.");
    addMapCovers(line, map_covers_, localization_.probability);
    addStartOption(line, near_);
    line.addOption("odometry", odometry_, "FILE", "With --sequence: odometry, poses that drift (ROBOT.md).");
    gravity_.addOptions(line);
    line.addSwitch("smooth", smooth_, "With --sequence: localize each image also by the images after it.");
    addStreamOption(line, streams_);
    addOverwrite(line, overwrite_);
    line.addSwitch("resume", resume_, "Skip images done by an earlier run, even if it was interrupted.");
    line.addPresets();
    input_.addAllOptions(line);
    line.rareFromHere();
    line.addOption(
        "starts", starts_, "N",
        "With --sequence: also start at every N-th image and record the answers after it in starts.csv.");
    addLocalizationOptions(line, localization_);
    line.addParams(localizer_, "localizer");
    line.addParams(odometry_error_, "odometry_error");
    line.addExample("office.flmap walk -o results", "each image on its own");
    line.addExample("office.flmap walk -o results --sequence", "as one drive");
  }

  /** Results of an earlier run of the same images with the same map and parameters, by name. */
  std::map<std::string, FrameResult> earlierResults(const Provenance& provenance) const {
    const auto before = resume_ ? Provenance::read(folder_) : std::nullopt;
    if (!before) return {};
    std::map<std::string, FrameResult> earlier;
    if (isResultsFolder(folder_)) earlier = readResults(folder_);
    std::vector<std::string> done;
    for (const auto& [frame, result] : earlier)
      if (provenance.images.count(frame) && !hasFailed(result)) done.push_back(frame);
    before->requireSame(provenance, done, folder_);
    return earlier;
  }

  /** Begins a run, or goes on with an earlier one. The folder is left alone if all is done already
   * and nothing else is in it. */
  Run begin(const Task& task) const {
    const Provenance provenance{task.params_ini, imageSizes(task.sequence)};
    const auto earlier = earlierResults(provenance);
    const std::vector<ResultFrame> frames = task.resultFrames();
    Run run{std::vector<FrameResult>(frames.size()), {}, {}};
    std::vector<ResultFrame> kept;
    std::size_t others = earlier.size();  // images that no longer exist
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const auto found = earlier.find(frames[i].name);
      if (found != earlier.end()) --others;
      if (found == earlier.end() || hasFailed(found->second)) {
        run.todo.push_back(i);
        continue;
      }
      kept.push_back(frames[i]);
      run.results[i] = found->second;
      run.results[i].stamp = frames[i].stamp;
    }
    if (folder_.empty() || (run.todo.empty() && others == 0)) return run;
    run.writer.emplace(folder_, task.params_ini, kept);
    provenance.write(folder_);
    return run;
  }

  /** \param drive if the images are one */
  ImageBatch::Work imageWork(const Task& task, const std::vector<std::size_t>& images, int workers,
                             Drive* drive) const {
    const bool is_alone = task.frames().size() == 1;  // else several images are localized at a time
    Locate locate = [drive](const View& view, double stamp) { return drive->add(view, stamp); };
    if (!drive)
      locate = [advising = streams_, localizer = std::make_shared<const Localizer>(newLocalizer(
                                         task.map, is_alone ? threads() : 1))](const View& view, double) {
        Localization answer = localizer->localize(view);
        if (advising) answer.next_look = localizer->nextLook(view, answer);
        return answer;
      };
    const auto all = std::make_shared<std::vector<RigViews>>(workers, viewsOf(task));
    return {[&task, images](std::size_t i) { return task.frames()[images[i]].path.string(); },
            [this, &task, images, locate, all](std::size_t i, int worker) {
              return localized(task, images[i], (*all)[worker], locate);
            }};
  }

  LocalizedImage localized(const Task& task, std::size_t index, RigViews& views, const Locate& locate) const {
    const FrameFile& file = task.frames()[index];
    const View view = views.at(index, gravity_.at(file.stamp));
    const Clock::time_point start = Clock::now();
    const Localization answer = locate(view, file.stamp);
    LocalizedImage image;
    auto& [result, traits] = image;
    result.stamp = file.stamp;
    result.timing = {file.name, views.segmentMilliseconds(), views.featuresMilliseconds(),
                     millisecondsSince(start), static_cast<int>(task.map->models.size())};
    result.rows = resultRows(file.name, answer, *task.map, max_hypotheses_);
    traits = ViewTraits::of(view);
    traits.noise = view.noise();
    return image;
  }

  RigViews viewsOf(const Task& task) const {
    return {task.sequence, task.camera, task.sides, input_, task.odometry, odometry_error_};
  }

  /** \param localized the images of the drive */
  void smooth(const Task& task, Run& run, const std::vector<std::size_t>& localized, const Drive& drive,
              const Console& console) const {
    Progress progress(console, localized.size());
    const StopSignal stop;
    std::size_t done = 0;
    const std::vector<Localization> answers = drive.localizer.smoothed(drive.views, [&] {
      if (stop.raised()) throw Stopped(done, localized.size());
      ++done;
      progress.step();
    });
    for (std::size_t i = 0; i < localized.size(); ++i)
      run.results[localized[i]].rows =
          resultRows(task.frames()[localized[i]].name, answers[i], *task.map, max_hypotheses_);
  }

  /** The images one after the other, several at a time. \param drive that smoothes, if any */
  void localize(const Task& task, Run& run, ImageBatch& batch, const Drive* drive,
                const Console& console) const {
    const auto finish = [&](std::size_t frame) {
      if (run.writer) run.writer->append(run.results[frame]);
      run.publish(frame);
    };
    std::vector<std::size_t> localized;
    batch.run(run.todo, run.todo.size(),
              [&](std::size_t i, std::optional<LocalizedImage>&& image, const std::string& reason) {
                FrameResult& result = run.results[run.todo[i]];
                if (image) run.views.push_back(image->second), localized.push_back(run.todo[i]);
                result = image ? std::move(image->first) : failedFrame(task.frames()[run.todo[i]], reason);
                if (!smooth_) finish(run.todo[i]);  // else it is not the last word
              });
    if (smooth_) {
      smooth(task, run, localized, *drive, console);
      for (const std::size_t frame : run.todo) finish(frame);
    }
    std::vector<double> noise;
    for (const ViewTraits& of_image : run.views) noise.push_back(of_image.noise);
    noteNoise(std::move(noise), task.camera.noise, console);
  }

  Localizer newLocalizer(const std::shared_ptr<const Map>& map, int threads) const {
    Localizer localizer(map, localizer_, localization_);
    localizer.setNumberOfThreads(threads);
    localizer.setMinProbability(min_probability_);
    return localizer;
  }

  /** Every N-th image is a start. Its drive ends after kMostDistance, as far as the camera can tell, or
   * with the images. \return the exit code. */
  int localizeFromStarts(const Task& task, const Console& console) const {
    constexpr double kMostDistance = 10;  // [m]
    const std::vector<FrameFile>& frames = task.frames();
    std::vector<View> views(frames.size());
    Batch views_of(threads(), frames.size(), console);
    std::vector<RigViews> of_workers(views_of.workers(), viewsOf(task));
    views_of.run([&](std::size_t i) { return frames[i].path.string(); },
                 [&](std::size_t i, int worker) {
                   views[i] = of_workers[worker].at(i, gravity_.at(frames[i].stamp));
                 });
    const std::size_t n = (frames.size() + starts_ - 1) / starts_;
    std::vector<std::vector<StartAnswer>> found(n);
    Batch batch(threads(), n, console);
    std::vector<Localizer> drives;
    for (int worker = 0; worker < batch.workers(); ++worker) drives.push_back(newLocalizer(task.map, 1));
    batch.run([&](std::size_t k) { return "start " + frames[k * starts_].name; },
              [&](std::size_t k, int worker) {
                Localizer& from_here = drives[worker];
                from_here.reset();
                MeasuredMotion motion{task.odometry, task.camera.mounting, odometry_error_};
                double distance = 0;
                for (std::size_t i = k * starts_; i < frames.size() && distance < kMostDistance; ++i) {
                  const Localization answer =
                      from_here.update(views[i], frames[i].stamp, motion.until(frames[i].stamp));
                  distance += answer.T_before_now.T.translation().norm();
                  StartAnswer out{frames[k * starts_].name, frames[i].name, answer.state, 0, {}};
                  if (!answer.hypotheses.empty()) {
                    out.probability = answer.hypotheses.front().probability;
                    if (task.map->partOf(answer.hypotheses.front().model).empty())
                      out.T_w_c = answer.hypotheses.front().T_w_c;
                  }
                  found[k].push_back(std::move(out));
                }
              });
    std::vector<StartAnswer> all;
    for (std::vector<StartAnswer>& of_start : found)
      std::move(of_start.begin(), of_start.end(), std::back_inserter(all));
    writeStarts(folder_, all);
    console.print(fmt::format("{} in {}/starts.csv\n", counted(n, "start"), folder_));
    return std::max(views_of.report(), batch.report());
  }

  void printSummary(const Run& run, const Map& map, const Console& console) const {
    StateCounts states;
    std::size_t timed = 0;
    double milliseconds = 0;
    for (const FrameResult& result : run.results) {
      states.add(result.rows.front().state);
      timed += result.timing.sum() > 0;  // others failed
      milliseconds += result.timing.sum();
    }
    std::string words;
    for (const Finding& hint : whatToLookAt(states, run.views, map)) {
      console.keep(hint);
      words += hint.text() + "\n";
    }
    if (!folder_.empty()) writeFindings(fs::path(folder_) / kFindingsFile, *console.findings);
    if (run.results.size() == 1) printImage(run.results.front().rows, console);
    console.print(fmt::format("{}{}{}; {:.1f} ms per image and thread{}\n", words, toString(states),
                              is_sequence_ ? firstSure(run.results) : "",
                              milliseconds / static_cast<double>(std::max<std::size_t>(timed, 1)),
                              folder_.empty() ? "" : "; results in " + folder_));
  }

  /** The parameters that the results depend on. */
  std::string paramsIni(const std::optional<CameraFile>& file, const Camera& camera, const Map& map) const {
    std::string head;
    for (std::size_t i = 0; i < maps_.size(); ++i)
      head += fmt::format(
          "# {}, map {} of {}, checksum {}\n", versionText(), fs::path(maps_[i]).filename().string(),
          counted((map.joined.empty() ? map : *map.joined[i].map).models.size(), "local model"),
          checksum(maps_[i]));
    return head + cameraLine(file) +
           fmt::format("max-hypotheses = {}\nmin-probability = {}\n", max_hypotheses_,
                       text::shortest(min_probability_)) +
           (is_sequence_ ? "sequence = 1\n" : "") + (smooth_ ? "smooth = 1\n" : "") +
           (near_.empty() ? "" : "near = " + near_ + "\n") +
           (odometry_.empty() ? "" : "odometry = " + odometry_ + "\n") + gravity_.toIni() +
           toIni(input_, camera) + localizationIni(localization_) +
           (is_sequence_ ? "\n" + toIni(localizer_, "localizer") : "") +
           (odometry_.empty() ? "" : "\n" + toIni(odometry_error_, "odometry_error"));
  }

  void requireSense() const {
    if (max_hypotheses_ < 1) throw UsageError("max-hypotheses must be positive");
    if (starts_ < 0) throw UsageError("starts must not be negative");
    if (starts_ > 0 && !is_sequence_) throw UsageError("--starts goes with --sequence");
    if (smooth_ && !is_sequence_) throw UsageError("--smooth goes with --sequence");
    if (!near_.empty() && !is_sequence_) throw UsageError("--near goes with --sequence");
    if (!odometry_.empty() && !is_sequence_ && !readRigFile(recording_))
      throw UsageError("--odometry goes with --sequence, or with several cameras (rig.ini)");
    startPose(near_, {});
    if (is_sequence_ && resume_)
      throw UsageError(
          "--sequence does not go with --resume: its answers need all images before; run it anew");
    if (is_sequence_ && localization_.score.by_overlap)
      throw UsageError("--sequence does not go with --score.by_overlap, which --preset paper sets: overlaps "
                       "have no probabilities");
  }

  int execute(const CommandLine& line, const Console& given) override {
    const Console console = streams_ ? besideStream(given) : given;
    requireSense();
    Provenance::requireNotReplaced(recording_, folder_);
    if (!resume_) Provenance::requireNotReplaced(line.paramsFile(), folder_);  // else it has to say the same
    input_.recording.segments = true;
    const std::optional<RigFile> rig = readRigFile(recording_);
    DepthSequence sequence =
        openSequence(rig ? rig->cameras.front().string() : recording_, input_.recording, console);
    if (folder_.empty() && (resume_ || starts_ > 0 || sequence.frames().size() > 1))
      throw UsageError("the folder of the results is missing: -o RESULTS");
    std::shared_ptr<const Map> map = openMaps(maps_, console);
    if (!line.given("min-probability")) min_probability_ = minProbabilityOf(*map);
    const Camera camera = map->calibrated(input_.camera(sequence.camera(), line));
    noteDifference(camera, *map, console);
    gravity_.read(sequence, console);
    PosesByTime odometry = odometryByTime(odometry_, sequence, camera.mounting, console);
    noteWithoutOdometry(sequence, odometry, console);
    std::vector<SideRecording> sides;
    if (rig) {
      sides = openSides(*rig, camera, input_, line, console);
      map = mapForRig(map, posesOf(sides));
    }
    Task task{std::move(sequence), map, camera, std::move(sides), std::move(odometry)};
    std::optional<Drive> drive;
    if (is_sequence_) {
      Localizer localizer = newLocalizer(map, threads());
      if (const auto start = startPose(near_, camera.mounting)) localizer.setPose(*start);
      drive.emplace(
          Drive{std::move(localizer), {task.odometry, camera.mounting, odometry_error_}, smooth_, streams_});
    }
    const int at_a_time = drive ? 1 : threads();  // a drive has an order
    ImageBatch batch(at_a_time, console, [&](const std::vector<std::size_t>& images, int workers) {
      return imageWork(task, images, workers, drive ? &*drive : nullptr);
    });
    if (batch.helped()) return kOk;

    std::optional<OutputLock> lock;
    if (!folder_.empty()) {
      for (const FrameFile& frame : task.frames()) requireOtherFolder(folder_, frame.path.parent_path());
      claimFolder(folder_, marksOfResults(), overwrite_, resume_ ? nullptr : &console);
      lock.emplace(OutputLock::ofFolder(folder_));
    }
    task.params_ini = paramsIni(task.sequence.camera(), camera, *map) + (rig ? rigLine(*rig) : "");
    Run run = begin(task);
    if (lock) writeInputs(folder_, task.sequence.frames());
    if (streams_) run.stream.emplace(given.out, camera.mounting);
    const std::set<std::size_t> undone(run.todo.begin(), run.todo.end());
    for (std::size_t i = 0; i < run.results.size(); ++i)
      if (!undone.count(i)) run.publish(i);  // localized by an earlier run
    localize(task, run, batch, drive ? &*drive : nullptr, console);
    const int code = batch.report();
    if (!run.inOrder()) run.writer.emplace(folder_, task.params_ini, task.resultFrames());
    printSummary(run, *map, console);
    if (lock) fs::remove(fs::path(folder_) / "starts.csv");  // left by an earlier run
    return starts_ == 0 ? code : std::max(code, localizeFromStarts(task, console));
  }

  bool dealsOut() const override { return !is_sequence_ && !streams_; }

  std::vector<std::string> maps_;
  std::string recording_, folder_, map_covers_, near_, odometry_;
  int max_hypotheses_ = 100;
  double min_probability_ = kMinProbability;
  bool overwrite_ = false, resume_ = false, streams_ = false, is_sequence_ = false, smooth_ = false;
  int starts_ = 0;
  DepthInput input_;
  GravityOption gravity_;
  OdometryError odometry_error_;
  GlobalLocalizationParams localization_;
  LocalizerParams localizer_;
};

}  // namespace

std::unique_ptr<App> localizeApp() { return std::make_unique<LocalizeApp>(); }

}  // namespace facetloc
