// SPDX-License-Identifier: BSD-3-Clause
#include "batch/shared_batch.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "drawing/colours.h"
#include "drawing/depth_drawing.h"
#include "inputs/depth_input.h"
#include "outputs/output_folder.h"
#include "outputs/provenance.h"

#include <facetloc/io/atomic_file.h>
#include <facetloc/io/cloud_file.h>
#include <facetloc/io/segment_file.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fmt/core.h>
#include <map>
#include <memory>
#include <set>

namespace facetloc {
namespace {

namespace fs = std::filesystem;

/** Endings of the files of results that an image may have, in addition to kSegmentEnding. */
constexpr const char *kLabels = ".png", *kOverlay = "_overlay.png", *kCloud = ".pcd", *kPolygons = ".ply";

/** Colours of a view's segments in their pictures. */
std::vector<PointColour> coloursOf(const View& view) {
  std::vector<PointColour> colours;
  for (std::size_t k = 0; k < view.segments.size(); ++k) {
    const Colour colour = segmentColour(k);
    colours.push_back({colour.red, colour.green, colour.blue});
  }
  return colours;
}

std::vector<ColouredPolygon> polygonsOf(const View& view) {
  const std::vector<PointColour> colours = coloursOf(view);
  std::vector<ColouredPolygon> polygons;
  for (std::size_t k = 0; k < view.segments.size(); ++k)
    polygons.push_back(polygonOf(view.segments[k], colours[k]));
  return polygons;
}

/** Names that differ: those of the folders of equal ones stand before them, as many as it takes. \param
 * folders of the files of the names; those named depth distinguish nothing */
std::vector<std::string> distinguished(std::vector<std::string> names, std::vector<fs::path> folders) {
  for (bool is_changed = true; std::exchange(is_changed, false);) {
    std::map<std::string, int> uses;
    for (const std::string& name : names) ++uses[name];
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (folders[i].filename() == "depth") folders[i] = folders[i].parent_path();
      if (uses[names[i]] < 2 || !folders[i].has_filename()) continue;
      names[i] = fmt::format("{}_{}", folders[i].filename().string(), names[i]);
      folders[i] = folders[i].parent_path();
      is_changed = true;
    }
  }
  return names;
}

/** The names of the frames' files, or of the frames if a file holds several. */
std::vector<std::string> stemsOf(const DepthSequence& sequence) {
  std::map<fs::path, int> uses;
  for (const FrameFile& file : sequence.frames()) ++uses[file.path];
  std::vector<std::string> stems;
  for (const FrameFile& file : sequence.frames())
    stems.push_back(uses[file.path] > 1 ? file.name : file.path.stem().string());
  return stems;
}

/** facetloc_segment: depth images -> planar surface segments, in batch. */
class SegmentApp : public App {
public:
  SegmentApp()
      : App("facetloc_segment", "RECORDING... -o DIR [options]",
            "Segments depth images into planar surfaces. A RECORDING is a folder, a list (.txt, .lst) "
            "or one image of 16-bit PNGs or organized PCDs, or an .oni, .mcap, .db3, .bag or .db file. For "
            "each image, DIR/<name>.segments.pcd holds its segments. Under mpirun, its processes share the "
            "images.") {}

private:
  /** One image of one of the inputs. */
  struct Image {
    const DepthSequence* sequence;
    std::size_t index;  // index within its sequence
    std::string name;   // base of the names of its output files
    std::string stem;   // the base of its cloud's

    const FrameFile& file() const { return sequence->frames()[index]; }
  };

  /** A file of the results of an image. */
  struct Output {
    std::string name;
    bool is_written;
  };

  /** One per thread: keeps its buffers from image to image as long as these are of the same camera. */
  struct Worker {
    std::optional<ViewBuilder> builder{};
    const DepthSequence* sequence = nullptr;  // sequence of the last image
  };

  /** Writes the results of an image. \return the number of its segments */
  std::size_t process(const Image& image, Worker& worker, const CommandLine& line) const {
    if (image.sequence != worker.sequence)
      worker.builder.emplace(input_.camera(image.sequence->camera(), line), input_.view);
    worker.sequence = image.sequence;

    const DepthImage full = image.sequence->load(image.index), depth = workingImage(full, input_.width);
    const View view = worker.builder->build(depth);
    const LabelImage& labels = worker.builder->segmentation().labels;
    const std::string base = (fs::path(folder_) / image.name).string();
    if (labels_) writeLabels(base + kLabels, labels);
    if (overlay_) writePng(base + kOverlay, overlay(depth, labels));
    if (pcd_) writeCloud(image, full, fullLabels(labels, full, input_.width), coloursOf(view));
    if (ply_) writePolygons(base + kPolygons, polygonsOf(view));
    writeSegments(segmentsOf(image), view.segments);
    return view.segments.size();
  }

  void writeCloud(const Image& image, const DepthImage& depth, const LabelImage& labels,
                  const std::vector<PointColour>& colours) const {
    const fs::path path = fs::path(folder_) / (image.stem + kCloud);
    if (const auto pixels = image.sequence->pixelsOfPoints(image.index))
      writeLabelledCloud(path, image.file().path, *pixels, labels, colours);
    else
      writeLabelledCloud(path, depth, labels, colours);
  }

  std::array<Output, 5> outputs(const std::string& name, const std::string& stem) const {
    return {{{name + kSegmentEnding, true},
             {name + kLabels, labels_},
             {name + kOverlay, overlay_},
             {stem + kCloud, pcd_},
             {name + kPolygons, ply_}}};
  }

  void addOptions(CommandLine& line) override {
    line.addArguments("RECORDING", inputs_);
    line.addOption("output,o", folder_, "DIR", "Folder of the results.");
    line.addSwitch("labels", labels_,
                   "Also write <name>.png: 16 bit, 0 = no segment, k = k-th segment of the PCD.");
    line.addSwitch("overlay", overlay_,
                   "Also write <name>_overlay.png: grey depth with segment borders in green.");
    line.addSwitch("pcd", pcd_,
                   "Also write <file name>.pcd: all points and fields of the input, labelled by segments.");
    line.addSwitch("ply", ply_, "Also write <name>.ply: the outlines of the segments, for mesh viewers.");
    line.addSwitch("noise", measures_noise_,
                   "Measure the noise of the images over depth instead, and print values for camera.ini.");
    addOverwrite(line, overwrite_);
    line.addSwitch("resume", resume_, "Skip images done by an earlier run, even if it was interrupted.");
    input_.addAllOptions(line);
    line.addExample("image.png -o found --overlay", "one image and its segments");
    line.addExample("walk -o found --ply", "meshes of the outlines of all images");
  }

  std::vector<Image> images(const std::vector<DepthSequence>& sequences) const {
    std::vector<Image> images;
    std::vector<std::string> names, stems;
    std::vector<fs::path> folders;
    for (const DepthSequence& sequence : sequences)
      for (const std::string& stem : stemsOf(sequence)) {
        const std::size_t index =
            images.empty() || images.back().sequence != &sequence ? 0 : images.back().index + 1;
        images.push_back({&sequence, index, {}, {}});
        const FrameFile& file = images.back().file();
        names.push_back(file.name), stems.push_back(stem);
        folders.push_back(fs::absolute(file.path).lexically_normal().parent_path());
      }
    names = distinguished(std::move(names), folders), stems = distinguished(std::move(stems), folders);
    std::map<std::string, fs::path> taken;
    for (std::size_t i = 0; i < images.size(); ++i) {
      images[i].name = names[i], images[i].stem = stems[i];
      const fs::path& file = images[i].file().path;
      for (const auto& [name, is_written] : outputs(names[i], stems[i])) {
        if (!is_written) continue;
        const auto [other, is_new] = taken.emplace(name, file);
        if (!is_new)
          throw UsageError(
              fmt::format("results of {} and {} would both be named {}; use different output folders",
                          other->second.string(), file.string(), name));
      }
    }
    return images;
  }

  /** Written last: with it, an image is done. */
  fs::path segmentsOf(const Image& image) const { return fs::path(folder_) / (image.name + kSegmentEnding); }

  bool done(const Image& image) const {
    const auto files = outputs(image.name, image.stem);
    return std::all_of(files.begin(), files.end(), [this](const Output& output) {
      return !output.is_written || fs::exists(fs::path(folder_) / output.name);
    });
  }

  /** The inputs and parameters of the results. */
  Provenance provenance(const std::vector<DepthSequence>& sequences, const std::vector<Image>& images,
                        const CommandLine& line) const {
    Provenance provenance{fmt::format("# {}\n", versionText()), {}};
    for (const DepthSequence& sequence : sequences) provenance.params_ini += cameraLine(sequence.camera());
    for (const Image& image : images) provenance.images[image.name] = sizeOf(image.file());
    provenance.params_ini += toIni(input_, input_.camera(sequences.front().camera(), line));
    return provenance;
  }

  /** \return which images are still to be done. */
  std::vector<std::size_t> prepare(const std::vector<Image>& images, const Provenance& provenance) const {
    const auto before = Provenance::read(folder_);
    std::vector<std::size_t> todo;
    std::vector<std::string> finished;
    for (std::size_t i = 0; i < images.size(); ++i) {
      if (resume_ && before && done(images[i]))
        finished.push_back(images[i].name);
      else
        todo.push_back(i);
    }
    if (resume_ && before) before->requireSame(provenance, finished, folder_);
    // Files of other images, or made with other parameters, would be taken for results of this run.
    const std::set<std::string> kept(finished.begin(), finished.end());
    std::map<std::string, std::string> stems;
    for (const Image& image : images) stems[image.name] = image.stem;
    for (const auto& [name, size] : before ? before->images : ImageSizes()) {
      const bool is_ours = fs::exists(fs::path(folder_) / (name + kSegmentEnding));  // not another tool's
      if (kept.count(name) || !is_ours) continue;
      for (const Output& output : outputs(name, stems.emplace(name, name).first->second))
        fs::remove(fs::path(folder_) / output.name);
    }
    for (const std::size_t i : todo) fs::remove(segmentsOf(images[i]));
    provenance.write(folder_);
    return todo;
  }

  int measureNoise(const CommandLine& line, const Console& console) const {
    constexpr std::size_t kMostImages = 200;  // images sampled evenly from an input
    std::vector<DepthSequence> sequences;
    for (const std::string& input : inputs_)
      sequences.push_back(openSequence(input, input_.recording, console));
    std::vector<std::pair<const DepthSequence*, std::size_t>> images;
    for (const DepthSequence& sequence : sequences) {
      const std::size_t n = sequence.frames().size(), wanted = std::min(n, kMostImages);
      for (std::size_t i = 0; i < wanted; ++i) images.emplace_back(&sequence, i * n / wanted);
    }
    std::vector<std::vector<NoiseSample>> found(images.size());
    Batch batch(threads(), images.size(), console);
    batch.run([&](std::size_t i) { return images[i].first->frames()[images[i].second].path.string(); },
              [&](std::size_t i, int) {
                const auto& [sequence, index] = images[i];
                DepthImage image = sequence->load(index, line.given("width") ? input_.width : 0);
                dropBeyond(input_.camera(sequence->camera(), line).max_depth, image);
                found[i] = noiseSamples(image);
              });
    std::vector<NoiseSample> samples;
    for (const auto& of_image : found) samples.insert(samples.end(), of_image.begin(), of_image.end());
    const std::vector<NoiseBin> bins = binned(std::move(samples));
    const int code = batch.report();
    if (bins.empty()) {
      console.error("the images show too few flat places to measure noise at: take some of walls, floors and "
                    "tables at several distances");
      return kFailed;
    }
    printNoise(console.out, bins);
    return code;
  }

  int execute(const CommandLine& line, const Console& console) override {
    if (measures_noise_) {
      for (const char* other : {"output", "labels", "overlay", "pcd", "ply", "overwrite", "resume"})
        if (line.given(other)) throw UsageError(std::string("--noise writes no files: leave out --") + other);
      return measureNoise(line, console);
    }
    if (folder_.empty()) throw UsageError("the folder of the results is missing: -o DIR");
    if (!resume_) Provenance::requireNotReplaced(line.paramsFile(), folder_);  // else it has to say the same
    std::vector<DepthSequence> sequences;
    for (const std::string& input : inputs_) {
      Provenance::requireNotReplaced(input, folder_);
      sequences.push_back(openSequence(input, input_.recording, console));
    }
    const std::vector<Image> all = images(sequences);
    using Images = std::vector<std::size_t>;  // among all
    using Segmentation = SharedBatch<Images, std::size_t>;
    Segmentation batch(threads(), console, [&](const Images& images, int n) -> Segmentation::Work {
      const auto workers = std::make_shared<std::vector<Worker>>(n);
      return {[&all, images](std::size_t i) { return all[images[i]].file().path.string(); },
              [&, images, workers](std::size_t i, int worker) {
                return process(all[images[i]], (*workers)[worker], line);
              }};
    });
    if (batch.helped()) return kOk;
    std::vector<FrameFile> frames;
    for (const Image& image : all) frames.push_back(image.file());
    for (const FrameFile& frame : frames) {
      const fs::path of_images = frame.path.parent_path();
      requireOtherFolder(folder_, of_images);
      requireOtherFolder(folder_, of_images / ".." / "labels");  // the true ones of a simulated sequence
    }
    claimFolder(folder_, {"params.ini", "images.txt"}, overwrite_, resume_ ? nullptr : &console);
    const OutputLock lock = OutputLock::ofFolder(folder_);
    const Images todo = prepare(all, provenance(sequences, all, line));
    writeInputs(folder_, frames);

    const auto start = std::chrono::steady_clock::now();
    std::size_t sum = 0;
    batch.run(todo, todo.size(),
              [&](std::size_t, const std::optional<std::size_t>& segments, const std::string&) {
                sum += segments.value_or(0);
              });
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const int code = batch.report();
    const std::size_t done = todo.size() - batch.failures().size();
    const std::size_t before = all.size() - todo.size();
    console.print(fmt::format("{} with {} in {:.1f} s{}; results in {}\n", counted(done, "image"),
                              counted(sum, "segment"), seconds,
                              before > 0 ? fmt::format(" ({} were done before)", before) : "", folder_));
    return code;
  }

  bool dealsOut() const override { return !measures_noise_; }

  std::vector<std::string> inputs_;
  std::string folder_;
  bool labels_ = false, overlay_ = false, pcd_ = false, ply_ = false, overwrite_ = false, resume_ = false,
       measures_noise_ = false;
  DepthInput input_;
};

}  // namespace

std::unique_ptr<App> segmentApp() { return std::make_unique<SegmentApp>(); }

}  // namespace facetloc
