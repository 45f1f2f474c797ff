// SPDX-License-Identifier: BSD-3-Clause
#include "cli/findings_file.h"
#include "cli/progress.h"
#include "cli/tools.h"
#include "evaluation/evaluation_report.h"
#include "inputs/depth_input.h"
#include "outputs/output_folder.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/error.h>

#include <filesystem>
#include <fmt/format.h>
#include <sstream>
#include <string>
#include <unistd.h>
#include <vector>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReport = "report.html";

std::string lastLine(std::string text) {
  text.erase(text.find_last_not_of('\n') + 1);
  return text.substr(text.rfind('\n') + 1);
}

/** The paragraph before the last one. */
std::string verdictIn(const std::string& text) {
  const std::string gap = "\n\n";
  const std::size_t end = text.rfind(gap);
  if (end == std::string::npos || end == 0) return "";
  const std::size_t before = text.rfind(gap, end - 1);
  const std::size_t begin = before == std::string::npos ? 0 : before + gap.size();
  return text.substr(begin, end + 1 - begin);
}

/** The folder of a recording, which is one or is in one. */
fs::path folderOf(const std::string& recording) {
  const fs::path path = fs::canonical(recording);
  return fs::is_directory(path) ? path : path.parent_path();
}

bool isWithin(const fs::path& folder, const fs::path& parent) {
  const fs::path from = fs::weakly_canonical(folder).lexically_relative(parent);
  return !from.empty() && *from.begin() != "..";
}

/** Report in the working folder, unless that is in the recording: then next to the recording. */
std::string reportOf(const std::string& recording) {
  const bool is_of_place = titleOf(recording) == "map";  // as facetloc_simulate and many others name it
  const std::string name = titleOf(is_of_place ? fs::path(recording) / ".." : fs::path(recording)) + ".try";
  const bool among_images = fs::is_directory(recording) && isWithin(fs::current_path(), folderOf(recording));
  return among_images ? (folderOf(recording).parent_path() / name).string() : name;
}

/** Throws UsageError if a report would come among the files of a recording. */
void requireOutside(const fs::path& report, const std::string& recording) {
  const bool is_new = !fs::exists(report) || fs::is_empty(report) || fs::exists(report / kReport);
  const bool is_recording = fs::exists(report) && fs::equivalent(report, folderOf(recording));
  if (fs::is_directory(recording) && (is_recording || (!is_new && isWithin(report, folderOf(recording)))))
    throw UsageError(fmt::format(
        "the report would come among the files of the recording {}; -o names another folder", recording));
}

/** Opens a page in the browser of the desktop, in a process of its own. */
void openInBrowser(const std::string& page, const Console& console) {
  const pid_t child = fork();
  if (child == 0) {
    execlp("xdg-open", "xdg-open", page.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  if (child < 0) console.note("the report cannot be opened; open it by hand");
}

/** facetloc try: from a recording to a report, by the other tools one after the other. */
class TryApp : public App {
public:
  TryApp()
      : App("facetloc try", "RECORDING [LATER] [-o DIR]",
            "Goes from a recording to a report in one command. Checks how both are read, builds a map of the "
            "RECORDING, and localizes the images of a LATER recording of the same place in that map. Without "
            "LATER, it localizes the RECORDING itself, which is easier. Evaluates the answers by the LATER "
            "recording's poses, if available. DIR has report.html, the answers in map.html and map.flmap; "
            "the results, the tables and the output of each tool are in DIR/details.") {}

private:
  /** One of the tools, and its arguments. */
  struct Stage {
    std::string name;
    std::string what;
    MakeApp* tool;
    std::vector<std::string> arguments;
    std::string checked{};  // the recording that it is about; its findings go to a file

    std::string textFile() const { return name + ".txt"; }  // receives the tool's output
    std::string findingsFile() const { return name + ".json"; }
  };

  void addOptions(CommandLine& line) override {
    line.addArgument("RECORDING", recording_);
    line.addArgument("LATER", later_, false);
    line.addOption("output,o", folder_, "DIR",
                   "Folder of the report; RECORDING's name with .try, in the working folder, unless given.");
    addOverwrite(line, overwrite_);
    line.addOption("camera", camera_, "FILE|NAME",
                   "The camera of both recordings: camera.ini, a map or a preset.");
    line.addOption("depth-scale", depth_scale_, "N", "Image values per metre.");
    line.addOption("poses-are", poses_are_, "WORDS", "Convention of the poses, as named by facetloc_check.");
    line.addSwitch("without-poses", without_poses_,
                   "Estimate the trajectory from the images, even if the RECORDING has poses.");
    line.addSwitch("open", open_, "Open the report in a browser.");
    line.addExample("walk1 walk2", "a map of walk1, walk2 in it");
    line.addExample("walk1 -o tried --open", "one recording, and the report in a browser");
  }

  std::vector<Stage> stages(const CommandLine& line, const Console& console) const {
    RecordingHints hints;
    const std::string of_query = later_.empty() ? recording_ : later_;
    std::vector<std::string> reading;
    for (const auto& [name, value] :
         {std::pair("camera", &camera_), {"depth-scale", &depth_scale_}, {"poses-are", &poses_are_}})
      if (line.given(name)) reading.insert(reading.end(), {std::string("--") + name, *value});
    const auto withReading = [&](std::vector<std::string> arguments) {
      arguments.insert(arguments.end(), reading.begin(), reading.end());
      return arguments;
    };
    std::vector<std::string> build = withReading({"--overwrite", "-o", in("map.flmap"), recording_});
    if (without_poses_) build.emplace_back("--without-poses");
    std::vector<std::string> localize =
        withReading({"--overwrite", in("map.flmap"), of_query, "-o", in("results")});
    const DepthSequence map_run = openSequence(recording_, hints, console);
    const DepthSequence query = openSequence(of_query, hints, console);
    if (query.stamped()) localize.emplace_back("--sequence");
    std::vector<Stage> all = {
        {"check", "how the recording is read", checkApp, withReading({recording_}), recording_}};
    if (!later_.empty())
      all.push_back({"check_later", "how the later one is read", checkApp, withReading({later_}), later_});
    std::vector<std::string> evaluate = {in("results"), "--map", in("map.flmap"),
                                         "--overwrite", "-o",    details().string()};
    for (const Stage& check : all) evaluate.insert(evaluate.end(), {"--known", in(check.findingsFile())});
    const bool own_frame = without_poses_ || map_run.groundTruth().empty();
    if (!query.groundTruth().empty()) {
      evaluate.insert(evaluate.begin() + 1, of_query);
      if (own_frame) evaluate.emplace_back("--align");
      if (!map_run.groundTruth().empty()) evaluate.insert(evaluate.end(), {"--map-groundtruth", recording_});
    }
    all.push_back({"build", "images to a map", mapBuildApp, build});
    all.push_back({"localize", "where the images were taken", localizeApp, localize});
    all.push_back({"evaluate",
                   query.groundTruth().empty() ? "no true poses: statistics of the answers alone"
                                               : "the answers and the truth",
                   evaluateApp, evaluate});
    return all;
  }

  /** \return the tool's output */
  std::string runStage(const Stage& stage, std::size_t number, std::size_t of, const Console& console) const {
    const std::string title = fmt::format("{}/{} {}", number, of, stage.name);
    console.print(fmt::format("{}: {}\n", title, stage.what));
    std::ostringstream out;
    double seconds = 0;
    int code = kOk;
    Findings found;
    {
      const Heartbeat heartbeat(console, title);
      Console of_stage = heartbeat.console(out);
      of_stage.findings = &found;
      code = stage.tool()->run(stage.arguments, of_stage);
      seconds = heartbeat.seconds();
    }
    for (Finding& finding : found) {
      if (!stage.checked.empty()) finding.words = titleOf(stage.checked) + ": " + finding.words;
      console.keep(finding);
    }
    if (!stage.checked.empty()) {
      console.print(toString(found));  // which the tool has only listed in its output
      writeFindings(in(stage.findingsFile()), found);
    }
    writeTextAtomically(in(stage.textFile()), [&](std::ostream& file) { file << out.str(); });
    if (code != kOk) {
      console.print(out.str());
      throw std::runtime_error(
          fmt::format("stopped at {}{}; what it printed is in {}", stage.name,
                      stage.checked.empty() ? "" : ": no answer gets better than its images: mend that first",
                      in(stage.textFile())));
    }
    console.print(fmt::format("    {:.1f} s: {}\n", seconds, lastLine(out.str())));
    return out.str();
  }

  int execute(const CommandLine& line, const Console& console) override {
    for (const std::string& recording : {recording_, later_})
      if (!recording.empty() && !fs::exists(recording)) throw IoError(recording, "does not exist");
    if (folder_.empty()) folder_ = reportOf(recording_);
    for (const std::string& recording : {recording_, later_})
      if (!recording.empty()) requireOutside(folder_, recording);
    const std::vector<Stage> all = stages(line, console);
    claimFolder(folder_, {kReport}, overwrite_, &console);
    createFolders(details());
    if (later_.empty())
      console.note(
          "no LATER recording: the images of the map itself are localized, which says little of another day");
    std::string printed;
    for (std::size_t i = 0; i < all.size(); ++i) printed = runStage(all[i], i + 1, all.size(), console);
    console.print(verdictIn(printed));
    for (const char* file : {"map.flmap", "map.html", kReport})
      if (fs::exists(in(file))) fs::rename(in(file), fs::path(folder_) / file);
    const std::string report = (fs::path(folder_) / kReport).string();
    if (open_) openInBrowser(report, console);
    console.print("report in " + report + "\n");
    return kOk;
  }

  bool showsWork() const override { return true; }  // stage by stage
  fs::path details() const { return fs::path(folder_) / "details"; }
  std::string in(const std::string& name) const { return (details() / name).string(); }

  std::string recording_, later_, folder_, camera_, depth_scale_, poses_are_;
  bool overwrite_ = false, without_poses_ = false, open_ = false;
};

}  // namespace

std::unique_ptr<App> tryApp() { return std::make_unique<TryApp>(); }

}  // namespace facetloc
