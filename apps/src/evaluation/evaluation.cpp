// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation.h"

#include "base/text.h"
#include "cli/text.h"

#include <facetloc/features/map_parts.h>
#include <facetloc/features/pose.h>
#include <facetloc/io/error.h>
#include <facetloc/mapping/map_builder.h>

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace facetloc {
namespace {

constexpr double kSameStamp = 1e-6;     // [s]
constexpr double kSamePosition = 1e-3;  // [m]
constexpr int kReliabilityBins = 10;
constexpr const char* kTiming = "timing.csv";

/** The rows of one frame, in the order of their ranks. */
struct FrameRows {
  std::string name;
  double stamp = 0;
  std::vector<const ResultRow*> rows;
};

/** Are these poses of images that are numbered from 0? */
bool areNumbered(const Trajectory& truth) {
  double index = 0;
  return std::all_of(truth.poses().begin(), truth.poses().end(),
                     [&](const StampedPose& pose) { return pose.stamp == index++; });
}

std::vector<FrameRows> groupByFrame(const std::vector<ResultRow>& rows, const Trajectory& truth) {
  std::vector<FrameRows> frames;
  std::map<std::string, std::size_t> index;
  for (const ResultRow& row : rows) {
    const auto [found, is_new] = index.emplace(row.frame, frames.size());
    if (is_new) frames.push_back({row.frame, 0, {}});
    frames[found->second].rows.push_back(&row);
  }
  const auto stray = std::find_if(frames.begin(), frames.end(),
                                  [](const FrameRows& f) { return !text::to<double>(f.name).has_value(); });
  const bool numbers = stray == frames.end();
  if (!numbers && !areNumbered(truth))
    throw IoError(stray->name, "the name of this image is no time stamp: true poses cannot be matched");
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].stamp = numbers ? *text::to<double>(frames[i].name) : static_cast<double>(i);
    std::stable_sort(frames[i].rows.begin(), frames[i].rows.end(),
                     [](const ResultRow* a, const ResultRow* b) { return a->rank < b->rank; });
  }
  return frames;
}

/** Empty for an invalid covariance. */
std::optional<double> neesOf(const Vector6d& error, const Matrix6d& P) {
  const Eigen::LLT<Matrix6d> factor(P);
  if (factor.info() != Eigen::Success) return {};
  return error.dot(factor.solve(error));
}

/** Where hypotheses are in the world. */
class WorldPoses {
public:
  WorldPoses(const std::vector<ModelPose>& models, const TrueModelPoses& true_models)
      : pose_of_(true_models) {
    for (const ModelPose& model : models) pose_of_[model.name] = model.T_w_m;
  }

  std::optional<Eigen::Isometry3d> of(const ResultRow& row) const {
    if (row.T_w_c && row.part.empty()) return row.T_w_c;
    const auto model = pose_of_.find(row.model);
    if (model == pose_of_.end()) return {};
    return model->second * row.T_m_c;
  }

private:
  std::map<std::string, Eigen::Isometry3d> pose_of_;
};

/** The truth of one run of results. */
PlaceTruth truthOf(const RunResults& run, const PlaceTruth& truth) {
  return truth.of(run.folder.empty() ? run.name : run.folder);
}

/** Compares frames with the truth and the map. */
class Judge {
public:
  Judge(const PlaceTruth& truth, const std::vector<ModelPose>& models, const EvaluationParams& params,
        const TrueModelPoses& true_models)
      : truth_(truth),
        models_(models),
        params_(params),
        true_models_(true_models),
        world_poses_(models, true_models),
        model_segments_(models.size()) {}

  /** \param truth of the run */
  FrameEvaluation judge(const RunResults& run, const FrameRows& frame, const Eigen::Isometry3d& T_w_c,
                        const PlaceTruth& truth) {
    FrameEvaluation e;
    e.run = run.name;
    e.name = frame.name;
    e.stamp = frame.stamp;
    e.T_w_c = T_w_c;
    e.unmapped = truth.unmapped(frame.name);
    judgeHypotheses(frame, T_w_c, run.covariances, e);
    const std::vector<std::size_t> covering = locate(run.images, e);
    judgePlanes(covering, truth, e);
    return e;
  }

private:
  void judgeHypotheses(const FrameRows& frame, const Eigen::Isometry3d& truth,
                       const std::map<std::string, Matrix6d>& covariances, FrameEvaluation& e) const {
    e.state = frame.rows.front()->state;
    for (const ResultRow* row : frame.rows) {
      if (row->rank == 0) {
        e.reason = row->reason;
        continue;
      }
      ++e.hypotheses;
      if (row->rank == 1) {
        e.probability = row->probability;
        judgeLocally(*row, truth, e);
      }
      const auto pose = world_poses_.of(*row);
      if (!pose) continue;
      const PoseError error = poseError(*pose, truth);
      if (row->rank == 1) e.best_error = error;
      if (!e.closest || cost(error) < cost(e.closest_error)) {
        e.closest = row->rank;
        e.closest_error = error;
      }
      if (!isCorrect(error) || e.first_correct) continue;
      e.first_correct = row->rank;
      e.first_correct_error = error;
      const auto covariance = covariances.find(row->frame);
      if (row->rank == 1 && row->part.empty() && covariance != covariances.end())
        e.nees = neesOf(boxminus(truth, *pose), covariance->second);
    }
  }

  /** Orders errors; multiplied out, since a limit may be zero. */
  double cost(const PoseError& error) const {
    return std::max(error.translation * params_.max_rotation_deg,
                    error.rotation_deg * params_.max_translation);
  }

  bool isCorrect(const PoseError& error) const {
    return error.translation <= params_.max_translation && error.rotation_deg <= params_.max_rotation_deg;
  }

  void judgeLocally(const ResultRow& row, const Eigen::Isometry3d& truth, FrameEvaluation& e) const {
    const auto model = true_models_.find(row.model);
    if (model == true_models_.end()) return;
    e.local_error = poseError(row.T_m_c, model->second.inverse() * truth);
    e.locally_correct = isCorrect(*e.local_error);
  }

  /** The nearest local model, by the limits of "covered". Returns the covering ones. */
  std::vector<std::size_t> locate(const ImageSizes& images, FrameEvaluation& e) const {
    const auto found = images.find(e.name);
    const std::uintmax_t size = found == images.end() ? 0 : found->second;
    std::vector<std::size_t> covering;
    if (!models_.empty()) e.frame_class = FrameClass::new_image;
    double least = 0;
    for (std::size_t i = 0; i < models_.size(); ++i) {
      const ModelPose& model = models_[i];
      const NearestModel near{model.name, (model.T_w_m.translation() - e.T_w_c.translation()).norm(),
                              rotationAngle(model.T_w_m.linear() * e.T_w_c.linear().transpose()) / kDegree};
      const bool same =
          (!model.name.empty() && model.name == e.name) || std::abs(model.stamp - e.stamp) < kSameStamp;
      const bool same_file = size > 0 && size == model.image_size && model.name == e.name;
      if (same && (same_file || near.distance < kSamePosition)) e.frame_class = FrameClass::map_image;
      if (near.distance <= kCoveredDistance && near.angle_deg <= kCoveredRotationDeg) covering.push_back(i);
      const double cost = std::max(near.distance * kCoveredRotationDeg, near.angle_deg * kCoveredDistance);
      if (e.nearest && cost >= least) continue;
      least = cost;
      e.nearest = near;
    }
    e.covered = !covering.empty() && !e.unmapped;
    return covering;
  }

  void judgePlanes(const std::vector<std::size_t>& covering, const PlaceTruth& truth, FrameEvaluation& e) {
    const auto seen = truth.segments(e.name, e.T_w_c, kVisiblePixels);
    if (!seen) return;
    e.visible_planes = static_cast<int>(seen->size());
    if (models_.empty()) return;
    bool compared = !e.covered;  // then no model's planes need be known
    for (const std::size_t i : covering) {
      const auto& model = segmentsOf(i);
      if (!e.covered || !model) continue;
      compared = true;
      if (!sharedPlanesSuffice(*seen, *model, kSolvablePosition, kSolvableRotationDeg * kDegree)) continue;
      e.solvable = true;
      return;
    }
    if (compared) e.solvable = false;
  }

  /** The true segments of a local model, read when they are needed first. */
  const std::optional<TrueSegments>& segmentsOf(std::size_t i) {
    if (!model_segments_[i])
      model_segments_[i] = truth_.segments(models_[i].name, models_[i].T_w_m, kVisiblePixels);
    return *model_segments_[i];
  }

  const PlaceTruth& truth_;
  const std::vector<ModelPose>& models_;
  const EvaluationParams& params_;
  const TrueModelPoses& true_models_;
  WorldPoses world_poses_;
  std::vector<std::optional<std::optional<TrueSegments>>> model_segments_;
};

/** Marks images of the runs that the map was made of: where there are other runs, these are not new. */
void markMappingRuns(const std::vector<RunResults>& runs, std::vector<FrameEvaluation>& frames) {
  if (runs.size() < 2) return;
  std::set<std::string> mapping;
  for (const FrameEvaluation& frame : frames)
    if (frame.frame_class == FrameClass::map_image) mapping.insert(frame.run);
  for (FrameEvaluation& frame : frames)
    if (mapping.count(frame.run) && frame.frame_class == FrameClass::new_image)
      frame.frame_class = FrameClass::map_run;
}

void addReliability(const std::vector<FrameEvaluation>& frames, Summary& summary) {
  auto& bins = summary.reliability;
  bins.resize(kReliabilityBins);
  for (int i = 0; i < kReliabilityBins; ++i) {
    bins[i].lowest = static_cast<double>(i) / kReliabilityBins;
    bins[i].highest = static_cast<double>(i + 1) / kReliabilityBins;
  }
  std::size_t answers = 0;
  for (const FrameEvaluation& frame : frames) {
    if (!frame.best_error) continue;
    const double p = frame.probability, correct = frame.first_correct == 1 ? 1 : 0;
    ReliabilityBin& bin = bins[std::clamp(static_cast<int>(p * kReliabilityBins), 0, kReliabilityBins - 1)];
    ++bin.n;
    bin.mean_probability += p;
    bin.correct += correct;
    summary.brier += (p - correct) * (p - correct);
    ++answers;
  }
  for (ReliabilityBin& bin : bins) {
    if (bin.n == 0) continue;
    bin.mean_probability /= static_cast<double>(bin.n);
    bin.correct /= static_cast<double>(bin.n);
    if (bin.n >= kReliableCount)
      summary.largest_deviation = std::max(summary.largest_deviation, bin.deviation());
  }
  if (answers > 0) summary.brier /= static_cast<double>(answers);
}

/** Answers only above the largest probability that was ever wrong. */
void addRecall(const std::vector<FrameEvaluation>& frames, Summary& summary) {
  for (const FrameEvaluation& frame : frames)
    if (frame.best_error && frame.first_correct != 1)
      summary.threshold = std::max(summary.threshold, frame.probability);
  const auto answered = std::count_if(frames.begin(), frames.end(), [&](const FrameEvaluation& frame) {
    return frame.first_correct == 1 && frame.probability > summary.threshold;
  });
  if (!frames.empty()) summary.recall = static_cast<double>(answered) / static_cast<double>(frames.size());
}

/** The number of images of the run that it has not come to. */
std::size_t imagesWithout(const RunResults& run) {
  std::set<std::string> done;
  for (const ResultRow& row : run.rows) done.insert(row.frame);
  return static_cast<std::size_t>(std::count_if(
      run.images.begin(), run.images.end(), [&](const auto& image) { return done.count(image.first) == 0; }));
}

}  // namespace

PoseError poseError(const Eigen::Isometry3d& T_w_c, const Eigen::Isometry3d& T_w_c_true) {
  const Eigen::Matrix3d R = T_w_c.linear() * T_w_c_true.linear().transpose();  // rotation in world axes
  PoseError error;
  error.translation = (T_w_c.translation() - T_w_c_true.translation()).norm();
  error.rotation_deg = rotationAngle(R) / kDegree;
  error.heading_deg = std::abs(logSO3(R).z()) / kDegree;
  return error;
}

const char* toString(FrameClass frame_class) {
  constexpr const char* kNames[] = {"unknown", "map", "mapping run", "new"};
  return kNames[static_cast<int>(frame_class)];
}

std::vector<ModelPose> modelPosesOf(const Map& map) {
  const auto images = map.meta.find(kImagesKey);
  const ImageSizes sizes = images == map.meta.end() ? ImageSizes() : imageSizes(images->second);
  std::vector<ModelPose> poses;
  if (!hasGivenPose(map)) return poses;
  for (const LocalModel& model : map.models) {
    const auto size = sizes.find(model.name);
    if (model.T_w_m && model.part == 0)
      poses.push_back({model.name, model.stamp, *model.T_w_m, size == sizes.end() ? 0 : size->second});
  }
  return poses;
}

std::vector<ModelPose> modelPosesOf(const Trajectory& run) {
  std::vector<ModelPose> models;
  MapBuilder rule;
  for (const StampedPose& pose : run.poses())
    if (rule.accept(pose.T_w_c)) models.push_back({"", pose.stamp, pose.T_w_c});
  return models;
}

std::vector<RunResults> readRuns(const std::filesystem::path& folder, const Remark& remark) {
  namespace fs = std::filesystem;
  std::vector<fs::path> folders;
  if (fs::is_directory(folder) && !isResultsFolder(folder))
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      if (isResultsFolder(entry.path())) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  const bool single = folders.empty();
  if (single) folders = {fs::absolute(folder / "").lexically_normal().parent_path()};
  std::vector<RunResults> runs;
  for (const fs::path& run : folders) {
    const std::string name = run.filename().string();
    runs.push_back({single ? "" : name, readHypotheses(run, remark), {}, name, {}});
    runs.back().covariances = readCovariances(run, remark);
    runs.back().shares = readShares(run, remark);
    if (auto provenance = Provenance::read(run)) {
      runs.back().images = std::move(provenance->images);
      runs.back().as_drive = provenance->params_ini.find("\nsequence = 1\n") != std::string::npos;
    }
    if (const std::size_t undone = imagesWithout(runs.back()); remark && undone > 0)
      remark(fmt::format("{}: the run was not finished: {} of {} without a result", run.string(),
                         counted(undone, "image"), runs.back().images.size()));
    if (fs::exists(run / kTiming)) runs.back().timing = readTiming(run, remark);
  }
  return runs;
}

std::vector<PosePair> sureAnswers(const std::vector<RunResults>& runs, const PlaceTruth& truth,
                                  const std::vector<ModelPose>& models, double tolerance) {
  const WorldPoses world_poses(models, {});
  std::vector<PosePair> pairs;
  for (const RunResults& run : runs) {
    const PlaceTruth of_run = truthOf(run, truth);
    for (const FrameRows& frame : groupByFrame(run.rows, of_run.poses())) {
      const ResultRow& first = *frame.rows.front();
      if (first.state != AnswerState::sure || first.rank != 1) continue;
      const auto true_pose = of_run.poses().at(frame.stamp, tolerance);
      const auto estimated = world_poses.of(first);
      if (true_pose && estimated) pairs.push_back({frame.stamp, *estimated, *true_pose});
    }
  }
  return pairs;
}

void moveWorld(const Eigen::Isometry3d& T_new_old, std::vector<RunResults>& runs) {
  Matrix6d turn = Matrix6d::Zero();  // both halves of a perturbation are in the axes of the world
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = T_new_old.linear();
  for (RunResults& run : runs) {
    for (ResultRow& row : run.rows) {
      if (!row.part.empty()) continue;
      if (row.T_w_c) row.T_w_c = T_new_old * *row.T_w_c;
      if (row.P_w_c) row.P_w_c = turn * *row.P_w_c * turn.transpose();
    }
    for (auto& [frame, P] : run.covariances) P = turn * P * turn.transpose();
  }
}

Evaluation evaluate(const std::vector<RunResults>& runs, const PlaceTruth& truth,
                    const std::vector<ModelPose>& models, const EvaluationParams& params, double tolerance,
                    const TrueModelPoses& true_models) {
  Evaluation evaluation;
  Judge judge(truth, models, params, true_models);
  for (const RunResults& run : runs) {
    const PlaceTruth of_run = truthOf(run, truth);
    for (const FrameRows& frame : groupByFrame(run.rows, of_run.poses())) {
      if (const auto pose = of_run.poses().at(frame.stamp, tolerance))
        evaluation.frames.push_back(judge.judge(run, frame, *pose, of_run));
      else
        evaluation.without_truth.push_back(frame.name);
    }
  }
  markMappingRuns(runs, evaluation.frames);
  return evaluation;
}

Evaluation evaluate(const std::vector<ResultRow>& rows, const Trajectory& truth,
                    const std::vector<ModelPose>& models, const EvaluationParams& params, double tolerance) {
  return evaluate({{"", rows, {}}}, PlaceTruth(truth), models, params, tolerance);
}

Summary summarize(const std::string& name, const std::vector<FrameEvaluation>& frames) {
  Summary summary;
  summary.name = name;
  std::vector<double> mm, deg, heading_deg, index, local_mm, local_deg, nees;
  for (const FrameEvaluation& frame : frames) {
    ++summary.total;
    summary.none += frame.hypotheses == 0;
    summary.wrong += frame.hypotheses > 0 && frame.first_correct == 0;
    summary.best_correct += frame.first_correct == 1;
    const bool judged = frame.best_error || frame.hypotheses == 0;  // otherwise the true pose is unknown
    const bool sure = judged && frame.state == AnswerState::sure;
    const bool doubtful = judged && frame.state == AnswerState::doubtful;
    summary.sure += sure;
    summary.doubtful += doubtful;
    summary.unknown += frame.state == AnswerState::unknown;
    summary.sure_correct += sure && frame.first_correct == 1;
    summary.doubtful_correct += doubtful && frame.first_correct == 1;
    if (frame.state == AnswerState::sure && frame.local_error) {
      ++summary.local;
      summary.local_correct += frame.locally_correct;
      local_mm.push_back(1000 * frame.local_error->translation);
      local_deg.push_back(frame.local_error->rotation_deg);
    }
    if (frame.nees) nees.push_back(*frame.nees);
    summary.unsure += frame.hypotheses == 0 || frame.probability < kUnsure;
    if (frame.first_correct == 0) continue;
    ++summary.correct;
    mm.push_back(1000 * frame.first_correct_error.translation);
    deg.push_back(frame.first_correct_error.rotation_deg);
    heading_deg.push_back(frame.first_correct_error.heading_deg);
    index.push_back(frame.first_correct);
  }
  summary.translation_mm = Sample(std::move(mm)), summary.rotation_deg = Sample(std::move(deg));
  summary.heading_deg = Sample(std::move(heading_deg)), summary.index = Sample(std::move(index));
  summary.local_translation_mm = Sample(std::move(local_mm));
  summary.local_rotation_deg = Sample(std::move(local_deg));
  summary.nees = Sample(std::move(nees));
  addReliability(frames, summary);
  addRecall(frames, summary);
  return summary;
}

}  // namespace facetloc
