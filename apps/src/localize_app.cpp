// SPDX-License-Identifier: BSD-3-Clause
#include <facetloc/apps/batch.h>
#include <facetloc/apps/localization_report.h>
#include <facetloc/apps/localize_app.h>
#include <facetloc/apps/text.h>
#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>

namespace facetloc {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr const char* kParamsFile = "params.ini";

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

std::string readText(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/** The results of a finished run. */
std::map<std::string, FrameResult> finishedResults(const fs::path& folder) {
  std::map<std::string, FrameResult> results;
  for (const TimingRow& row : readTiming(folder)) results[row.frame].timing = row;
  for (ResultRow& row : readHypotheses(folder)) {
    const std::string frame = row.frame;
    results[frame].rows.push_back(std::move(row));
  }
  return results;
}

FrameResult localizeFrame(const FrameFile& file, const DepthImage& image, ViewBuilder& builder,
                          const GlobalLocalization& localization, int max_hypotheses) {
  FrameResult result;
  const View scene = builder.build(image);
  const Clock::time_point start = Clock::now();
  const Localization answer = localization.localize(scene);
  result.stamp = file.stamp;
  result.timing = {file.name, builder.segmentMilliseconds(), builder.featuresMilliseconds(),
                   millisecondsSince(start), static_cast<int>(localization.map().models.size())};
  result.rows = resultRows(file.name, answer, localization.map(), max_hypotheses);
  return result;
}

}  // namespace

LocalizeApp::LocalizeApp()
    : App("facetloc_localize", "MAP.flmap INPUT -o RESULTS [options]",
          "Finds where depth images were taken. INPUT is a depth sequence (a folder with depth/ in it), a "
          "folder or a "
          "list of 16-bit PNG or organized PCD files, one such file, or an .oni recording. "
          "RESULTS/hypotheses.csv lists the ranked poses "
          "of each image, RESULTS/poses_tum.txt the best one; images that cannot be localized are listed "
          "with the "
          "reason.") {}

void LocalizeApp::addOptions(CommandLine& line) {
  line.addArgument("MAP.flmap", map_);
  line.addArgument("INPUT", input_path_);
  line.addOption("output,o", folder_, "RESULTS", "Folder of the results.");
  line.addOption("max-hypotheses", max_hypotheses_, "K", "Keep so many hypotheses per image at most.");
  line.addSwitch("resume", resume_, "Skip images that an earlier, perhaps interrupted run has done.");
  input_.addOptions(line);
  line.addParams(localization_);
}

/** Of a run with the same parameters: of the journal if it was interrupted, else of its results. */
std::map<std::string, FrameResult> LocalizeApp::earlierResults(const ResultsJournal& journal,
                                                               const std::string& params_ini) const {
  const fs::path folder = folder_, params = folder / kParamsFile;
  if (!resume_ || !fs::exists(params)) return {};
  if (readText(params) != params_ini)
    throw IoError(folder_,
                  "was begun with another map or other parameters; leave out --resume or use another folder");
  if (journal.exists()) return journal.read();
  return isResultsFolder(folder) ? finishedResults(folder) : std::map<std::string, FrameResult>();
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

/** The images one after the other, several at a time. \return the exit code. */
int LocalizeApp::localize(const DepthSequence& sequence, const ViewParams& view_params,
                          const GlobalLocalization& localization, const std::vector<std::size_t>& todo,
                          ResultsJournal& journal, std::vector<FrameResult>& results,
                          const Console& console) const {
  Batch batch(threads(), todo.size(), console);
  std::vector<ViewBuilder> builders(batch.workers(), ViewBuilder(view_params));
  const auto fileOf = [&](std::size_t i) -> const FrameFile& { return sequence.frames()[todo[i]]; };
  batch.run([&](std::size_t i) { return fileOf(i).path.string(); },
            [&](std::size_t i, int worker) {
              FrameResult& result = results[todo[i]];
              try {
                const DepthImage image = sequence.load(todo[i], input_.width);
                result = localizeFrame(fileOf(i), image, builders[worker], localization, max_hypotheses_);
              } catch (const std::exception& e) {
                result.timing.frame = fileOf(i).name;
                result.rows = {noHypothesis(fileOf(i).name, e.what())};
                throw;
              }
              journal.append(fileOf(i).name, result);
            });
  return batch.report();
}

void LocalizeApp::printSummary(const std::vector<FrameResult>& results, const Console& console) const {
  std::size_t localized = 0;
  double milliseconds = 0;
  for (const FrameResult& result : results) {
    localized += result.rows.front().rank > 0;
    milliseconds += result.timing.segment_ms + result.timing.features_ms + result.timing.localize_ms;
  }
  console.out << counted(results.size(), "image") << ", " << localized << " with hypotheses, "
              << fixed(milliseconds / static_cast<double>(std::max<std::size_t>(results.size(), 1)), 1)
              << " ms per image and thread; results in " << folder_ << "\n";
}

int LocalizeApp::execute(const CommandLine& line, const Console& console) {
  if (folder_.empty()) throw UsageError("the folder of the results is missing: -o RESULTS");
  if (max_hypotheses_ < 1) throw UsageError("max-hypotheses must be positive");
  const DepthSequence sequence = DepthSequence::open(input_path_);
  const ViewParams view_params = input_.viewParams(sequence.camera(), line);
  const auto map = std::make_shared<const Map>(readMapFor(sequence.camera(), map_, console));
  GlobalLocalization localization(map, localization_, view_params.noise);
  if (sequence.frames().size() == 1) localization.setNumberOfThreads(threads());
  const std::string params_ini = "# " + versionText() + ", map " + fs::path(map_).filename().string() +
                                 " of " + counted(localization.map().models.size(), "local model") +
                                 "\nmax-hypotheses = " + std::to_string(max_hypotheses_) + "\n" +
                                 toIni(input_, view_params) + toIni(localization_);

  createFolder(folder_);
  ResultsJournal journal(folder_);
  const auto earlier = earlierResults(journal, params_ini);
  std::vector<std::size_t> todo;
  std::vector<FrameResult> results = startWith(earlier, sequence.frames(), todo);
  int code = kOk;
  if (!todo.empty() || journal.exists()) {
    writeTextAtomically(fs::path(folder_) / kParamsFile, [&](std::ostream& out) { out << params_ini; });
    journal.begin(earlier);
    code = localize(sequence, view_params, localization, todo, journal, results, console);
    writeResults(folder_, results, params_ini);
    if (code == kOk) journal.remove();  // else it tells --resume which images are still to be done
  }
  printSummary(results, console);
  return code;
}

}  // namespace facetloc
