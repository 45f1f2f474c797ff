// SPDX-License-Identifier: BSD-3-Clause
#include "base/median.h"
#include "base/text.h"
#include "batch/batch.h"
#include "batch/map_watch.h"
#include "cli/findings_file.h"
#include "cli/text.h"
#include "cli/tools.h"
#include "inputs/depth_input.h"
#include "tools/image_trajectory.h"

#include <facetloc/features/camera_presets.h>
#include <facetloc/features/image_noise.h>
#include <facetloc/features/local_model.h>
#include <facetloc/io/depth_values.h>
#include <facetloc/io/error.h>
#include <facetloc/mapping/map_making.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <string>
#include <vector>

namespace facetloc {
namespace {

constexpr std::size_t kMostImages = 200;                 // that are read, evenly spread
constexpr std::size_t kPixelsOfImage = 2000;             // whose depth is kept
constexpr double kLeastMedian = 0.25, kMostMedian = 12;  // median depth in rooms and halls [m]
constexpr double kFewMeasured = 0.4;                     // share of the pixels
constexpr int kFewSegments = 4;                          // segments per image
constexpr double kLongGap = 1;                           // between images [s]

std::string percent(double share) { return fmt::format("{:.0f} %", 100 * share); }
std::string metres(double m) { return fmt::format("{:.2f} m", m); }

/** The q-quantile. */
double quantile(std::vector<float>& values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

bool inDoubt(const Findings& findings) { return firstOf(findings, Severity::doubt) != nullptr; }
bool isRefused(const Findings& findings) { return firstOf(findings, Severity::refusal) != nullptr; }

void line(const Console& console, const std::string& title, const std::string& words) {
  console.out << fmt::format("{:10}{}\n", title, words);
}

std::string toString(const Intrinsics& k) {
  const auto angle = [](double size, double f) { return 2 * std::atan(size / 2 / f) / kDegree; };
  return fmt::format("{}x{}, fx {:.5g}, fy {:.5g}, cx {:.5g}, cy {:.5g}; field of view {:.0f} x {:.0f} deg",
                     k.width, k.height, k.fx, k.fy, k.cx, k.cy, angle(k.width, k.fx), angle(k.height, k.fy));
}

/** Has the camera moved, and turned about the vertical only, at one height? Floors are uneven. */
bool hasDrivenOnFloor(const Trajectory& poses, const SeenFloor& floor) {
  constexpr double kLeastDistance = 2, kMostHeight = 0.05;  // [m]
  constexpr double kMostSlope = 0.01;                       // the floor's direction is known to this slope
  constexpr double kMostLean = 6 * kDegree, kMostly = 0.9;
  if (poses.empty()) return false;
  const double tilt = floor.tilt_deg * kDegree, roll = floor.roll_deg * kDegree;
  const Eigen::Vector3d down(std::cos(tilt) * std::sin(roll), std::cos(tilt) * std::cos(roll),
                             std::sin(tilt));
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::AlignedBox3d way;
  for (const StampedPose& pose : poses.poses())
    mean += pose.T_w_c.linear() * down, way.extend(pose.T_w_c.translation());
  mean.normalize();
  if (way.diagonal().norm() < kLeastDistance) return false;
  const auto level = std::count_if(poses.poses().begin(), poses.poses().end(), [&](const StampedPose& pose) {
    const Eigen::Vector3d from_middle = pose.T_w_c.translation() - way.center();
    return (pose.T_w_c.linear() * down).cross(mean).norm() < std::sin(kMostLean) &&
           std::abs(mean.dot(from_middle)) < kMostHeight + kMostSlope * from_middle.norm();
  });
  return static_cast<double>(level) > kMostly * static_cast<double>(poses.poses().size());
}

/** facetloc_check: the content of a recording, and the results to expect of it. */
class CheckApp : public App {
public:
  CheckApp()
      : App("facetloc_check", "RECORDING [options]",
            "Checks a recording and how it is read: layout, times, camera, noise over range, share of "
            "measured pixels, agreement of poses and images, the camera's mounting above the floor, and the "
            "map to expect of facetloc_map build. Reads up to 200 images, evenly spread. Writes no files. "
            "Exits with 1 if the recording cannot be right as it is read.") {}

private:
  /** Findings about one image. */
  struct ImageReport {
    bool is_read = false;
    Intrinsics camera;         // camera of the whole image
    double measured = 0;       // share of its pixels
    std::vector<float> depth;  // sampled pixels
    std::vector<NoiseSample> noise;
    View view;
  };

  void addOptions(CommandLine& line) override {
    line.addArgument("RECORDING", input_);
    line.addOption("poses", poses_, "FILE", "Check these poses instead of those of the RECORDING.");
    addPoseTolerance(line, pose_tolerance_);
    depth_.addAllOptions(line);
    line.addExample("walk", "the content of walk, and faults");
    line.addExample("walk --poses poses.csv", "whether these poses fit its images");
  }

  void reportImages(const DepthSequence& sequence, const std::vector<ImageReport>& images,
                    const Console& console, Findings& found) const {
    const auto& frames = sequence.frames();
    line(console, "recording", fmt::format("{}, {}", counted(frames.size(), "image"), sequence.layout()));
    if (sequence.stamped() && frames.size() > 1) {
      std::vector<double> steps;
      for (std::size_t i = 1; i < frames.size(); ++i) steps.push_back(frames[i].stamp - frames[i - 1].stamp);
      const double usual = internal::median(steps), longest = *std::max_element(steps.begin(), steps.end());
      line(console, "times",
           fmt::format("{:.3f} to {:.3f} s, {:.3g} images per second, longest gap {:.3g} s",
                       frames.front().stamp, frames.back().stamp, 1 / usual, longest));
      if (longest > kLongGap)
        found.push_back({"times.gap",
                         Severity::note,
                         fmt::format("between some images there are more than {:.2g} s: without poses, a "
                                     "trajectory may break there",
                                     kLongGap),
                         "",
                         {{"longest_s", longest}}});
    } else if (!sequence.stamped()) {
      found.push_back({"times.none", Severity::note,
                       "the images have no times, so that poses cannot be matched with them",
                       "name them by their times in seconds, or add a depth.txt"});
    }
    std::vector<float> depth;
    double measured = 0, segments = 0;
    for (const ImageReport& image : images) {
      measured += image.measured;
      segments += static_cast<double>(image.view.segments.size());
      depth.insert(depth.end(), image.depth.begin(), image.depth.end());
    }
    measured /= static_cast<double>(images.size()), segments /= static_cast<double>(images.size());
    if (depth.empty()) {
      line(console, "depth", "nothing is measured");
      found.push_back({"depth.none", Severity::refusal, "no pixel is measured",
                       "look at the images, and at depth_scale"});
      return;
    }
    const double median = quantile(depth, 0.5);
    line(console, "depth",
         fmt::format("{} of the pixels are measured; 98 % of them from {} to {}, median {}",
                     percent(measured), metres(quantile(depth, 0.01)), metres(quantile(depth, 0.99)),
                     metres(median)));
    const CameraPreset* preset = sequence.camera() ? findCameraPreset(sequence.camera()->preset) : nullptr;
    const auto scale = [&](const std::string& words) {
      found.push_back(
          {"values.scale",
           Severity::doubt,
           "half of the depths are " + words + ": is depth_scale right? (--depth-scale tries another one)",
           "",
           {{"median_depth", median}}});
    };
    if (!inDoubt(found) && (median < kLeastMedian || median > kMostMedian))
      scale(
          fmt::format("{} {}, as no room has it", median < kLeastMedian ? "below" : "above", metres(median)));
    else if (preset && median < preset->min_depth)
      scale(fmt::format("below {}, nearer than a {} measures", metres(median), preset->name));
    else if (measured < kFewMeasured)
      found.push_back({"depth.few",
                       Severity::note,
                       "most of the image is not measured",
                       "the scene is too far or too dark for the camera, or 0 is not its only mark for that",
                       {{"share_measured", measured}}});
    line(console, "planes", fmt::format("{:.1f} segments in an image", segments));
    if (segments < kFewSegments)
      found.push_back({"planes.few",
                       Severity::note,
                       "the images show few planes: such places are easily confused",
                       "",
                       {{"segments", segments}}});
  }

  void reportCamera(const DepthSequence& sequence, const std::vector<ImageReport>& images,
                    const Console& console) const {
    line(console, "camera", toString(images.front().camera));
    const auto& file = sequence.camera();
    if (!file) return line(console, "", "by the points of the clouds");
    const bool is_png = text::lowerExtension(sequence.frames().front().path) == ".png";
    const Camera& camera = file->camera;
    std::string words = is_png ? fmt::format("{:.6g} PNG values per metre", file->depth_scale) : "";
    const auto add = [&words](const std::string& more) { words += (words.empty() ? "" : ", ") + more; };
    if (!file->preset.empty()) add(std::string("a ") + file->preset);
    if (std::isfinite(camera.max_depth)) add("measures up to " + metres(camera.max_depth));
    if (camera.mounting) add("mounted " + facetloc::toString(*camera.mounting));
    if (!words.empty()) line(console, "", words);
  }

  void reportSurfaces(const MapMaking& making, const Console& console) const {
    const auto& check = making.findings().geometry;
    if (check && check->surfaces > 0)
      line(console, "surfaces",
           fmt::format("{} in {} are flat{}", counted(check->surfaces, "large one"),
                       counted(check->images, "image"), check->findings.empty() ? "" : ", but see below"));
  }

  void reportNoise(std::vector<ImageReport>& images, const Console& console, const Findings& found) const {
    if (inDoubt(found)) return line(console, "noise", "not known while the images are in doubt");
    std::vector<NoiseSample> samples;
    for (const ImageReport& image : images)
      samples.insert(samples.end(), image.noise.begin(), image.noise.end());
    const std::vector<NoiseBin> bins = binned(std::move(samples));
    if (bins.empty()) return line(console, "noise", "not known: too few flat places");
    console.out << "noise\n";
    printNoise(console.out, bins);
  }

  void reportFloor(std::vector<ImageReport>& images, const Camera& camera, const Trajectory& poses,
                   const Console& console, Findings& found) const {
    Map map;
    for (ImageReport& image : images)
      map.models.emplace_back(std::string(), 0.0, std::nullopt, std::move(image.view));
    const auto floor = findFloor(map);
    if (!floor) return line(console, "floor", "none that the images have in common");
    const auto degrees = [](double deg) { return text::decimals(deg, 1) + " deg"; };
    line(console, "floor",
         fmt::format(
             "{} below the camera (spread {:.0f} mm), which is tilted by {} and rolled by {}; in {} of {}",
             metres(floor->height), 1000 * floor->height_std, degrees(floor->tilt_deg),
             degrees(floor->roll_deg), floor->views, counted(floor->all_views, "image")));
    if (!floor->steady || inDoubt(found)) return;
    const CameraMounting seen = floor->mounting();
    std::string lines =
        fmt::format("mount_height={:.3f} mount_tilt_deg={}", seen.height, text::decimals(seen.tilt_deg, 1));
    if (seen.roll_deg != 0) lines += fmt::format(" mount_roll_deg={:.1f}", seen.roll_deg);
    const std::vector<Evidence> evidence = {{"height_m", floor->height, floor->height_std},
                                            {"tilt_deg", floor->tilt_deg},
                                            {"roll_deg", floor->roll_deg}};
    if (camera.mounting && !camera.mounting->agreesWith(seen))
      found.push_back({"camera.mounting", Severity::note,
                       "the camera is not mounted as camera.ini says: the floor shows " + lines, "",
                       evidence});
    else if (!camera.mounting && hasDrivenOnFloor(poses, *floor))
      found.push_back(
          {"camera.robot", Severity::note,
           "the camera seems to be mounted on a robot, which helps much; for camera.ini: " + lines, "",
           evidence});
  }

  /** Empty if there are none, or none that can be read. */
  Trajectory posesOf(const DepthSequence& sequence, const Console& console, Findings& found) const {
    try {
      std::string remark;
      Trajectory poses = poses_.empty() ? sequence.groundTruth() : sequence.readPoses(poses_, &remark);
      if (!remark.empty()) found.push_back({"reading.remark", Severity::note, remark, ""});
      if (!poses.empty()) return poses;
      line(console, "poses", "none");
    } catch (const IoError& e) {
      line(console, "poses", "cannot be read");
      found.push_back({"poses.unreadable", Severity::note, e.what(), ""});
    }
    return {};
  }

  MapMaking makingOf(const DepthSequence& sequence, const Camera& camera, const Trajectory& poses) const {
    MapMakingParams params;
    params.view = depth_.view;
    params.distortion = false;  // no picture is kept for its estimate
    MapMaking making(camera, params);
    making.setNumberOfThreads(threads());
    addImages(sequence, poses, {depth_.width, pose_tolerance_}, making);
    return making;
  }

  void reportPoses(const DepthSequence& sequence, const Trajectory& poses, MapMaking& making,
                   const Console& console, const Findings& found) const {
    const std::size_t all = sequence.frames().size();
    std::size_t posed = 0;
    for (std::size_t i = 0; i < all; ++i) posed += making.pose(i).has_value();
    line(console, "poses",
         fmt::format("{} from {:.3f} to {:.3f} s; {} of {} have one", poses.poses().size(),
                     poses.poses().front().stamp, poses.poses().back().stamp, counted(posed, "image"), all));
    const auto& checked = making.findings().poses;
    if (!checked && (isRefused(found) || isRefused(making.findings().list()))) return;
    if (posed == 0) return;
    const PoseCheck check = checked.value_or(PoseCheck());
    if (check.isKnown()) {
      line(console, "", "poses and images disagree by " + check.as_given.toString());
      for (const std::string& words : check.ratiosInWords()) line(console, "", words);
    }
    line(console, "map",
         fmt::format("facetloc_map build will make about {} with these poses",
                     counted(making.places().size(), "local model")));
  }

  int execute(const CommandLine& command, const Console& console) override {
    const DepthSequence sequence = DepthSequence::open(input_, depth_.recording);
    const Camera camera = depth_.camera(sequence.camera(), command);
    const std::size_t all = sequence.frames().size(), n = std::min(all, kMostImages);
    std::vector<ImageReport> images(n);
    Batch batch(threads(), n, console);
    std::vector<ViewBuilder> builders(batch.workers(), ViewBuilder(camera, depth_.view, depth_.width));
    const auto index = [&](std::size_t i) { return i * all / n; };
    batch.run([&](std::size_t i) { return sequence.frames()[index(i)].path.string(); },
              [&](std::size_t i, int worker) {
                DepthImage image = sequence.load(index(i));
                ImageReport& report = images[i];
                report.camera = image.camera;
                const std::size_t step = std::max<std::size_t>(1, image.depth.size() / kPixelsOfImage);
                std::size_t measured = 0;
                for (std::size_t p = 0; p < image.depth.size(); ++p) {
                  const bool is_measured = isMeasured(image.depth[p]);
                  measured += is_measured;
                  if (is_measured && p % step == 0) report.depth.push_back(image.depth[p]);
                }
                report.measured = static_cast<double>(measured) / static_cast<double>(image.depth.size());
                dropBeyond(camera.max_depth, image);
                report.noise = noiseSamples(image);
                report.view = builders[worker].build(image);
                report.is_read = true;
              });
    const int code = batch.report();
    const auto unread = [](const ImageReport& image) { return !image.is_read; };
    images.erase(std::remove_if(images.begin(), images.end(), unread), images.end());
    if (images.empty()) throw IoError(input_, "none of its images can be read");

    Findings found = readingFindings(sequence);
    reportImages(sequence, images, console, found);
    reportCamera(sequence, images, console);
    const Trajectory poses = posesOf(sequence, console, found);
    MapMaking making = makingOf(sequence, camera, poses);
    MapWatch watch(console);
    making.setProgress(watch.callback());
    checkRun(sequence, found, making);
    reportSurfaces(making, console);
    if (poses.empty())
      line(console, "map", "facetloc_map build will find the trajectory from the images");
    else
      reportPoses(sequence, poses, making, console, found);
    append(making.findings().list(), found);  // the surfaces as the poses confirm them
    reportFloor(images, camera, poses, console, found);
    reportNoise(images, console, found);
    Findings listed;
    for (const Finding& finding : found) {
      if (finding.id != PoseCheck::kAccuracy) listed.push_back(finding);  // a line above states it
      console.keep(finding);
    }
    console.out << (listed.empty() ? "" : "note\n") << toString(listed);
    if (isRefused(found)) {
      console.out << "the recording cannot be right as it is read; facetloc_map build refuses it\n";
      return kFailed;
    }
    console.out << "next: facetloc_map build " << input_ << " -o MAP.flmap\n";
    return code;
  }

  std::string input_, poses_;
  DepthInput depth_;
  double pose_tolerance_ = 0.02;
};

}  // namespace

std::unique_ptr<App> checkApp() { return std::make_unique<CheckApp>(); }

}  // namespace facetloc
