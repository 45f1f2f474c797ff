// SPDX-License-Identifier: BSD-3-Clause
#include "tools/localize_app.h"

#include "base/batch.h"
#include "base/localization_options.h"
#include "base/localization_report.h"
#include "base/milliseconds.h"
#include "base/pose_stream.h"
#include "base/text.h"
#include "drawing/outputs.h"
#include "tools/drive.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/map_database.h>
#include <facetloc/io/output_lock.h>
#include <facetloc/io/text.h>
#include <facetloc/localization/global_localization.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <iterator>
#include <memory>
#include <set>
#include <utility>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/** The results of a finished run. A frame that one of its files lacks is still to be done. */
std::map<std::string, FrameResult> finishedResults(const fs::path& folder) {
  std::map<std::string, std::vector<ResultRow>> rows;
  for (ResultRow& row : readHypotheses(folder)) rows[row.frame].push_back(std::move(row));
  for (const auto& [frame, covariance] : readCovariances(folder))
    if (const auto found = rows.find(frame); found != rows.end()) found->second.front().P_w_c = covariance;
  std::map<std::string, FrameResult> results;
  for (const TimingRow& timing : readTiming(folder))
    if (const auto found = rows.find(timing.frame); found != rows.end())
      results[timing.frame] = {0, found->second, timing};
  return results;
}

/** What is found for an image. */
struct FrameAnswer {
  Localization localization;
  AnswerState state = AnswerState::unknown;
};
using Localizer = std::function<FrameAnswer(std::size_t index, const View& view, double stamp)>;

Localizer eachByItself(const std::shared_ptr<const GlobalLocalization>& localization,
                       double min_probability) {
  return [localization, min_probability](std::size_t, const View& view, double) {
    FrameAnswer answer;
    answer.localization = localization->localize(view);
    answer.state = answer.localization.state(min_probability);
    return answer;
  };
}

std::shared_ptr<const GlobalLocalization> globalLocalization(const std::shared_ptr<const Map>& map,
                                                             const GlobalLocalizationParams& params,
                                                             int threads) {
  auto localization = std::make_shared<GlobalLocalization>(map, params);
  localization->setNumberOfThreads(threads);
  return localization;
}

FrameAnswer frameAnswer(SequenceAnswer&& of_sequence) {
  FrameAnswer answer;
  answer.localization.hypotheses = std::move(of_sequence.places);
  answer.localization.reason = std::move(of_sequence.reason);
  answer.state = of_sequence.state;
  return answer;
}

Localizer asOneDrive(Drive& drive) {
  return [&drive](std::size_t index, const View& view, double stamp) {
    return frameAnswer(drive.add(index, view, stamp));
  };
}

/** Why a drive is not sure yet, although there are places. */
void addRemark(ResultRow& row, const std::string& remark) {
  if (!row.reason.empty() && !remark.empty()) row.reason += "; ";
  row.reason += remark;
}

/** ", first sure at image 5": how long a drive takes until it knows where it is. */
std::string firstSure(const std::vector<FrameResult>& results) {
  const auto first = std::find_if(results.begin(), results.end(), [](const FrameResult& result) {
    return result.rows.front().state == AnswerState::sure;
  });
  if (first == results.end()) return "";
  return ", first sure at image " + std::to_string(first - results.begin() + 1);
}

std::vector<ResultRow> rowsOf(const std::string& frame, const FrameAnswer& answer, const Map& map,
                              int max_hypotheses) {
  auto rows = resultRows(frame, answer.localization, map, max_hypotheses);
  for (ResultRow& row : rows) row.state = answer.state;
  if (!answer.localization.hypotheses.empty()) addRemark(rows.front(), answer.localization.reason);
  return rows;
}

/** \param traits receives what tells a wrong camera. */
FrameResult localizeFrame(std::size_t index, const FrameFile& file, const View& scene,
                          const ViewBuilder& builder, const Localizer& localize, const Map& map,
                          int max_hypotheses, ViewTraits& traits) {
  FrameResult result;
  const Clock::time_point start = Clock::now();
  const FrameAnswer answer = localize(index, scene, file.stamp);
  result.stamp = file.stamp;
  result.timing = {file.name, builder.segmentMilliseconds(), builder.featuresMilliseconds(),
                   millisecondsSince(start), static_cast<int>(map.models.size())};
  result.rows = rowsOf(file.name, answer, map, max_hypotheses);
  traits = ViewTraits::of(scene);
  traits.noise = scene.noise();
  return result;
}

}  // namespace

LocalizeApp::LocalizeApp()
    : App("facetloc_localize", "MAP.flmap INPUT -o RESULTS [options]",
          "Finds where depth images were taken. INPUT is a recording: a folder, a list (.txt, .lst) or one "
          "image of 16-bit PNGs or organized PCDs, an .oni or .bag file, or what facetloc_segment made of "
          "it. RESULTS/hypotheses.csv lists the "
          "ranked poses of each image, RESULTS/poses_tum.txt the sure ones; images that cannot be localized "
          "are listed with the reason. Under mpirun, the images are dealt out to its processes.") {}

void LocalizeApp::addOptions(CommandLine& line) {
  line.addArgument("MAP.flmap", map_);
  line.addArgument("INPUT", input_path_);
  line.addOption("output,o", folder_, "RESULTS", "Folder of the results.");
  line.addOption("max-hypotheses", max_hypotheses_, "K", "Keep so many hypotheses per image at most.");
  addMinProbability(line, min_probability_);
  line.addSwitch(
      "sequence", is_sequence_,
      "The images are one drive: each is localized by all images up to it, which may decide what one "
      "of them leaves open.");
  line.addSwitch("smooth", smooth_, "With --sequence: each image is localized by those after it, too.");
  line.addOption(
      "starts", starts_, "N",
      "With --sequence, also from every N-th image as if the camera woke up there: starts.csv, of which "
      "facetloc_evaluate draws how soon it knows where it is.");
  addStreamOption(line, streams_);
  line.addSwitch("resume", resume_, "Skip images that an earlier, perhaps interrupted run has done.");
  line.addPresets();
  addRecordingOptions(line, input_.recording);
  input_.addOptions(line);
  addLocalizationOptions(line, localization_);
  line.addParams(sequence_, "sequence");
}

/** Of a run of the same images with the same map and parameters: of the journal if it was interrupted, else
 * of its results. */
std::map<std::string, FrameResult> LocalizeApp::earlierResults(const ResultsJournal& journal,
                                                               const Provenance& provenance) const {
  if (!resume_) return {};
  const bool interrupted = journal.exists();
  const auto before =
      Provenance::read(folder_, interrupted ? Provenance::Of::run_under_way : Provenance::Of::results);
  if (!before) return {};
  std::map<std::string, FrameResult> earlier;
  if (interrupted)
    earlier = journal.read();
  else if (isResultsFolder(folder_))
    earlier = finishedResults(folder_);
  std::vector<std::string> done;
  for (const auto& [frame, result] : earlier)
    if (provenance.images.count(frame)) done.push_back(frame);
  before->requireSame(provenance, done, folder_);
  return earlier;
}

/** \param todo receives the frames that earlier has no result of. */
std::vector<FrameResult> LocalizeApp::startWith(const std::map<std::string, FrameResult>& earlier,
                                                const std::vector<FrameFile>& frames,
                                                std::vector<std::size_t>& todo) {
  std::vector<FrameResult> results(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto found = earlier.find(frames[i].name);
    if (found != earlier.end())
      results[i] = found->second;
    else
      todo.push_back(i);
    results[i].stamp = frames[i].stamp;
  }
  return results;
}

/** Begins a run, or goes on with an earlier one. Results that are in the folder stay until those of this run
 * are whole. \param journal is left alone if all is done already and there is nothing else. */
std::vector<FrameResult> LocalizeApp::begin(const std::vector<FrameFile>& frames,
                                            const Provenance& provenance, ResultsJournal& journal,
                                            std::vector<std::size_t>& todo) const {
  if (!journal.exists()) Provenance::removeUnderWay(folder_);  // of a run that was killed at its very end
  for (const FrameFile& frame : frames) requireOtherFolder(folder_, frame.path.parent_path());
  const auto earlier = earlierResults(journal, provenance);
  std::vector<FrameResult> results = startWith(earlier, frames, todo);
  const bool has_others = earlier.size() + todo.size() > frames.size();  // of images that are not there now
  if (!todo.empty() || has_others || journal.exists()) {
    journal.begin(earlier);
    provenance.write(folder_, Provenance::Of::run_under_way);
  }
  return results;
}

/** The images one after the other, several at a time. \param results of all ranks, on the first one.
 * \return the exit code. */
int LocalizeApp::localize(const DepthSequence& sequence, const Camera& camera,
                          const std::shared_ptr<const Map>& map, const std::vector<std::size_t>& todo,
                          ResultsJournal& journal, std::vector<FrameResult>& results, const Publish& publish,
                          const Console& console) {
  Batch batch(is_sequence_ ? 1 : threads(), todo.size(), console, ranks());  // a drive has an order
  const bool is_alone = sequence.frames().size() == 1;  // else several images are localized at a time
  std::optional<Drive> drive;
  if (is_sequence_) drive.emplace(newSequence(map, threads()), smooth_);
  const Localizer localizer =
      drive
          ? asOneDrive(*drive)
          : eachByItself(globalLocalization(map, localization_, is_alone ? threads() : 1), min_probability_);
  std::vector<ViewBuilder> builders(batch.workers(), ViewBuilder(camera, input_.view));
  std::vector<FrameResult> found(todo.size());
  std::vector<ViewTraits> traits(todo.size());
  const auto fileOf = [&](std::size_t i) -> const FrameFile& { return sequence.frames()[todo[i]]; };
  const auto publishNow = [&](std::size_t i) {
    if (!smooth_) publish(todo[i], found[i]);  // else it is not the last word
  };
  batch.run([&](std::size_t i) { return fileOf(i).path.string(); },
            [&](std::size_t i, int worker) {
              FrameResult& result = found[i];
              try {
                const View scene = viewOf(sequence, todo[i], input_.width, builders[worker]);
                result = localizeFrame(i, fileOf(i), scene, builders[worker], localizer, *map,
                                       max_hypotheses_, traits[i]);
              } catch (const std::exception& e) {
                result.stamp = fileOf(i).stamp;
                result.timing.frame = fileOf(i).name;
                result.rows = {noHypothesis(fileOf(i).name, e.what())};
                publishNow(i);
                throw;
              }
              journal.append(fileOf(i).name, result);
              publishNow(i);
            });
  if (smooth_) {
    SequenceLocalization backward = newSequence(map, threads());
    drive->smooth(
        backward, [&](std::size_t i) { return fileOf(i).name + " once more"; }, console,
        [&](std::size_t i, SequenceAnswer answer) {
          found[i].rows = rowsOf(fileOf(i).name, frameAnswer(std::move(answer)), *map, max_hypotheses_);
        });
    for (std::size_t i = 0; i < found.size(); ++i) publish(todo[i], found[i]);
  }
  ranks().collect(found);
  for (std::size_t i = 0; i < todo.size() && ranks().isFirst(); ++i) results[todo[i]] = std::move(found[i]);
  std::vector<double> noise;
  for (const ViewTraits& of_image : traits) noise.push_back(of_image.noise);
  if (ranks().isFirst()) noteNoise(std::move(noise), camera.noise, console);
  views_ = std::move(traits);
  return batch.report();
}

SequenceLocalization LocalizeApp::newSequence(const std::shared_ptr<const Map>& map, int threads) const {
  SequenceLocalization sequence(map, sequence_, localization_);
  sequence.setNumberOfThreads(threads);
  sequence.setMinProbability(min_probability_);
  return sequence;
}

/** Every so many images are a start. Its drive ends after kMostWay, as far as the camera itself can tell, or
 * with the images. \return the exit code. */
int LocalizeApp::localizeFromStarts(const DepthSequence& sequence, const Camera& camera,
                                    const std::shared_ptr<const Map>& map, const Console& console) const {
  constexpr double kMostWay = 10;  // [m]
  const std::vector<FrameFile>& frames = sequence.frames();
  std::vector<View> views(frames.size());
  Batch seeing(threads(), frames.size(), console);
  std::vector<ViewBuilder> builders(seeing.workers(), ViewBuilder(camera, input_.view));
  seeing.run(
      [&](std::size_t i) { return frames[i].path.string(); },
      [&](std::size_t i, int worker) { views[i] = viewOf(sequence, i, input_.width, builders[worker]); });
  const std::size_t n = (frames.size() + starts_ - 1) / starts_;
  std::vector<std::vector<StartAnswer>> found(n);
  Batch batch(threads(), n, console);
  std::vector<SequenceLocalization> drives;
  for (int worker = 0; worker < batch.workers(); ++worker) drives.push_back(newSequence(map, 1));
  batch.run([&](std::size_t k) { return "start " + frames[k * starts_].name; },
            [&](std::size_t k, int worker) {
              SequenceLocalization& from_here = drives[worker];
              from_here.reset();
              double way = 0;
              for (std::size_t i = k * starts_; i < frames.size() && way < kMostWay; ++i) {
                const SequenceAnswer answer = from_here.add(views[i], frames[i].stamp);
                way += answer.T_before_now.T.translation().norm();
                StartAnswer out{frames[k * starts_].name, frames[i].name, answer.state, 0, {}};
                if (!answer.places.empty()) {
                  out.probability = answer.places.front().probability;
                  if (map->partOf(answer.places.front().model).empty())
                    out.T_w_c = answer.places.front().T_w_c;
                }
                found[k].push_back(std::move(out));
              }
            });
  std::vector<StartAnswer> all;
  for (std::vector<StartAnswer>& of_start : found)
    std::move(of_start.begin(), of_start.end(), std::back_inserter(all));
  writeStarts(folder_, all);
  console.out << counted(n, "start") << " in " << folder_ << "/starts.csv\n";
  return std::max(seeing.report(), batch.report());
}

void LocalizeApp::printSummary(const std::vector<FrameResult>& results, const Map& map,
                               const Console& console) const {
  StateCounts states;
  std::size_t timed = 0;
  double milliseconds = 0;
  for (const FrameResult& result : results) {
    states.add(result.rows.front().state);
    timed += result.timing.sum() > 0;  // others failed
    milliseconds += result.timing.sum();
  }
  for (const std::string& hint : whatToLookAt(states, views_, map)) console.out << hint << "\n";
  console.out << inWords(states) << (is_sequence_ ? firstSure(results) : "") << "; "
              << text::decimals(milliseconds / static_cast<double>(std::max<std::size_t>(timed, 1)), 1)
              << " ms per image and thread; results in " << folder_ << "\n";
}

/** What the results depend on beside the images. */
std::string LocalizeApp::paramsIni(const std::optional<CameraFile>& file, const Camera& camera,
                                   const Map& map) const {
  return "# " + versionText() + ", map " + fs::path(map_).filename().string() + " of " +
         counted(map.models.size(), "local model") + ", checksum " + checksum(map_) + "\n" +
         cameraLine(file) + "max-hypotheses = " + std::to_string(max_hypotheses_) + "\n" +
         "min-probability = " + text::shortest(min_probability_) + "\n" +
         (is_sequence_ ? "sequence = 1\n" : "") + (smooth_ ? "smooth = 1\n" : "") + toIni(input_, camera) +
         localizationIni(localization_) + (is_sequence_ ? "\n" + toIni(sequence_, "sequence") : "");
}

int LocalizeApp::execute(const CommandLine& line, const Console& console) {
  return streams_ ? localizeAll(line, besideStream(console), &console.out)
                  : localizeAll(line, console, nullptr);
}

/** \param out where answers are streamed to; null = nowhere */
int LocalizeApp::localizeAll(const CommandLine& line, const Console& console, std::ostream* out) {
  if (folder_.empty()) throw UsageError("the folder of the results is missing: -o RESULTS");
  if (max_hypotheses_ < 1) throw UsageError("max-hypotheses must be positive");
  if (starts_ < 0) throw UsageError("starts must not be negative");
  if (starts_ > 0 && !is_sequence_) throw UsageError("--starts goes with --sequence");
  if (smooth_ && !is_sequence_) throw UsageError("--smooth goes with --sequence");
  if (is_sequence_ && resume_)
    throw UsageError("--sequence does not go with --resume: its answers need all images before; run it anew");
  if (is_sequence_ && ranks().size() > 1)
    throw UsageError("--sequence does not go with mpirun: its images have an order; run it without");
  if (streams_ && ranks().size() > 1) throw UsageError("--stream does not go with mpirun; run it without");
  if (is_sequence_ && localization_.score.by_overlap)
    throw UsageError("--sequence does not go with --score.by_overlap, which --preset paper sets: overlaps "
                     "have no probabilities");
  Provenance::requireNotReplaced(input_path_, folder_);
  if (!resume_) Provenance::requireNotReplaced(line.paramsFile(), folder_);  // else it has to say the same
  input_.recording.segments = true;
  const DepthSequence sequence = openSequence(input_path_, input_.recording, console);
  const auto map = std::make_shared<const Map>(openMap(map_));
  noteUnfinished(*map, map_, console);
  const Camera camera = map->calibrated(input_.camera(sequence.camera(), line));
  noteDifference(camera, *map, console);

  ResultsJournal journal(folder_, ranks().rank());
  std::vector<FrameResult> results;
  std::vector<std::size_t> todo;
  Provenance provenance;
  std::optional<OutputLock> lock;
  if (ranks().isFirst()) {
    createFolders(folder_);
    lock = OutputLock::ofFolder(folder_);
    provenance = {paramsIni(sequence.camera(), camera, *map), imageSizes(sequence)};
    results = begin(sequence.frames(), provenance, journal, todo);
  }
  todo = ranks().broadcast(todo);
  if (!ranks().isFirst() && !todo.empty()) journal.begin({});
  std::optional<PoseStream> stream;
  if (out) stream.emplace(*out, camera.mounting);
  const Publish publish = [&stream](std::size_t frame, const FrameResult& result) {
    if (stream) stream->put(frame, result);
  };
  const std::set<std::size_t> undone(todo.begin(), todo.end());
  for (std::size_t i = 0; i < results.size(); ++i)
    if (!undone.count(i)) publish(i, results[i]);  // of an earlier run
  const int code = localize(sequence, camera, map, todo, journal, results, publish, console);
  if (!ranks().isFirst()) return kOk;
  if (journal.exists()) {
    writeResults(folder_, results, provenance.params_ini);
    provenance.write(folder_);
    if (code == kOk) journal.remove();  // else it tells --resume which images are still to be done
    if (code == kOk) Provenance::removeUnderWay(folder_);
  }
  printSummary(results, *map, console);
  fs::remove(fs::path(folder_) / "starts.csv");  // of an earlier run
  return starts_ == 0 ? code : std::max(code, localizeFromStarts(sequence, camera, map, console));
}

}  // namespace facetloc
