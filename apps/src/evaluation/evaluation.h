// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "evaluation/alignment.h"
#include "evaluation/frame_truth.h"
#include "evaluation/sample.h"
#include "outputs/provenance.h"

#include <facetloc/features/local_model.h>
#include <facetloc/features/params.h>
#include <facetloc/io/results.h>
#include <facetloc/io/trajectory.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

constexpr double kVisiblePixels = 150;      ///< size of a true plane that counts as seen [px at 320x240]
constexpr double kSolvablePosition = 0.05;  ///< largest standard deviation by shared planes [m]
constexpr double kSolvableRotationDeg = 3;  ///< largest standard deviation of the orientation

constexpr double kCoveredDistance = 1.0;    ///< largest distance of a local model that covers an image [m]
constexpr double kCoveredRotationDeg = 20;  ///< largest angle of a local model that covers an image

/** \brief When a hypothesis is correct. */
struct EvaluationParams {
  static constexpr const char* kTitle = "Limits of a correct pose";
  double max_translation = 0.2;
  double max_rotation_deg = 2;

  template <class Self, class Visitor>
  static void describe(Self& p, Visitor&& visit) {
    visit("max_translation", p.max_translation, 0.0, 1e6,
          "Maximum position error of a correct hypothesis [m].", kForUsers);
    visit("max_rotation_deg", p.max_rotation_deg, 0.0, 180.0,
          "Maximum orientation error of a correct hypothesis [deg].", kForUsers);
  }
};

/** \brief The difference of a pose from the true one. */
struct PoseError {
  double translation = 0;   ///< [m]
  double rotation_deg = 0;  ///< angle of the relative rotation
  double heading_deg = 0;   ///< its part about the world's z axis
};
PoseError poseError(const Eigen::Isometry3d& T_w_c, const Eigen::Isometry3d& T_w_c_true);

/** \brief Where a local model of the map was taken. */
struct ModelPose {
  std::string name;  ///< may be empty
  double stamp = 0;  ///< [s]
  Eigen::Isometry3d T_w_m = Eigen::Isometry3d::Identity();
  std::uintmax_t image_size = 0;  ///< size of its image's file [bytes]; 0 if unknown
};
/** \brief Poses of those local models of a map that have one. */
std::vector<ModelPose> modelPosesOf(const Map& map);
/** \brief The local models that the paper's rule makes of a run. */
std::vector<ModelPose> modelPosesOf(const Trajectory& run);

/** \brief A map image is itself one of the local models: of the same name or stamp, and at the same true pose
 * or from a file of the same name and size, for the poses of a map need not be the true ones. The other
 * images of the mapping run are no news either, if there are further runs. */
enum class FrameClass { unknown, map_image, map_run, new_image };
const char* toString(FrameClass frame_class);

/** \brief How far the most similar local model is away. */
struct NearestModel {
  std::string name;
  double distance = 0;  ///< [m]
  double angle_deg = 0;
};

/** \brief The evaluation of one image. */
struct FrameEvaluation {
  std::string run;  ///< may be empty
  std::string name;
  double stamp = 0;
  Eigen::Isometry3d T_w_c = Eigen::Isometry3d::Identity();  ///< the true pose
  FrameClass frame_class = FrameClass::unknown;
  bool unmapped = false;         ///< the map has nothing there; then neither covered nor solvable
  bool covered = false;          ///< a local model is close enough to the true pose
  std::optional<bool> solvable;  ///< shares enough true planes with a covering local model; empty if unknown
  std::optional<int> visible_planes;  ///< true planes in view, where they are known
  int hypotheses = 0;
  int first_correct = 0;  ///< rank of the first correct hypothesis; 0 = none is
  PoseError first_correct_error;
  AnswerState state = AnswerState::unknown;
  double probability = 0;               ///< probability of rank 1
  std::optional<PoseError> best_error;  ///< error of rank 1; empty if its true pose is unknown
  std::optional<double> nees;  ///< e^T P^-1 e of rank 1, if it is correct and its covariance is known
  std::optional<PoseError> local_error;  ///< the same in its local model; empty if its true pose is unknown
  bool locally_correct = false;          ///< is that one within the limits?
  int closest = 0;          ///< rank of the hypothesis with the least error; 0 = no hypothesis has a pose
  PoseError closest_error;  ///< its error, as multiples of the limits of "correct"
  std::optional<NearestModel> nearest;
  std::string reason;  ///< why there is no hypothesis
};

/** \brief Frames of several places may be put together into one evaluation. */
struct Evaluation {
  std::vector<FrameEvaluation> frames;     ///< those with a true pose
  std::vector<std::string> without_truth;  ///< names of the others
};

/** \brief The answers of facetloc_localize to the images of one run. */
struct RunResults {
  std::string name;  ///< may be empty
  std::vector<ResultRow> rows;
  std::vector<TimingRow> timing;                  ///< may be empty
  std::string folder{};                           ///< named after the run whose truth is meant; may be empty
  ImageSizes images{};                            ///< that were localized; may be empty
  std::map<std::string, Matrix6d> covariances{};  ///< world poses of rank 1, keyed by image; may be empty
  bool as_drive = false;                          ///< localized as a sequence
  std::map<std::string, ViewShares> shares{};     ///< keyed by image; may be empty
};
/** \brief Reads a results folder, or a folder of results folders, one per run; these are named by their
 * folders and in the order of their names. Throws IoError. */
std::vector<RunResults> readRuns(const std::filesystem::path& folder, const Remark& remark = {});

/** \brief True poses of the images that local models were made of, by the names of the models. */
using TrueModelPoses = std::map<std::string, Eigen::Isometry3d>;

/** \brief The sure answers of all runs with their true poses, to align the results by. */
std::vector<PosePair> sureAnswers(const std::vector<RunResults>& runs, const PlaceTruth& truth,
                                  const std::vector<ModelPose>& models, double tolerance = 0.02);
/** \brief Expresses all world poses of results, and their covariances, in another world. */
void moveWorld(const Eigen::Isometry3d& T_new_old, std::vector<RunResults>& runs);

/** \brief Judges every frame of one or several runs in the same map.
 *
 * The stamp of a frame is its name if all names of its run are numbers, else its index, which the true poses
 * must then be numbered by: 0, 1, 2, ... Hypotheses without a world pose get it from their model's pose in
 * models, where it is known, or from true_models. Of several runs those with a map image are mapping runs.
 * \param models may be empty: frames are then of unknown class. \param tolerance [s] largest distance in time
 * of a frame and its true pose. Throws IoError for images without time stamps. */
Evaluation evaluate(const std::vector<RunResults>& runs, const PlaceTruth& truth,
                    const std::vector<ModelPose>& models, const EvaluationParams& params,
                    double tolerance = 0.02, const TrueModelPoses& true_models = {});
/** \brief The same for a single run of which only the poses are known. */
Evaluation evaluate(const std::vector<ResultRow>& rows, const Trajectory& truth,
                    const std::vector<ModelPose>& models, const EvaluationParams& params,
                    double tolerance = 0.02);

constexpr double kMarkedShare = 0.99;  ///< whose bound Fig. 6 marks

/** \brief Probabilities of one range, and how often they were right. */
struct ReliabilityBin {
  double lowest = 0;
  double highest = 0;
  std::size_t n = 0;
  double mean_probability = 0;
  double correct = 0;  ///< share

  /** \brief How far the probability is from the truth. */
  double deviation() const { return std::abs(mean_probability - correct); }
};

constexpr double kUnsure = 0.5;             ///< below, rank 1 is more likely wrong than right
constexpr std::size_t kReliableCount = 20;  ///< images from which on the share of a bin says something

/** \brief The figures of a set of frames. */
struct Summary {
  std::string name;
  std::size_t total = 0;
  std::size_t none = 0;                                     ///< no hypothesis
  std::size_t wrong = 0;                                    ///< no correct hypothesis
  std::size_t correct = 0;                                  ///< at least one
  std::size_t best_correct = 0;                             ///< rank 1 is
  Sample translation_mm, rotation_deg, heading_deg, index;  ///< first correct hypotheses
  double threshold = 0;                                     ///< the largest probability of a wrong rank 1
  double recall = 0;  ///< share of all frames whose rank 1 is correct and more probable than that
  double brier = 0;   ///< mean squared difference of the probability of rank 1 and its truth
  std::size_t sure = 0, doubtful = 0, unknown = 0;     ///< as the results say of themselves
  std::size_t sure_correct = 0, doubtful_correct = 0;  ///< covered frames whose rank 1 is
  std::size_t unsure = 0;  ///< no hypothesis, or rank 1 with a probability below kUnsure
  std::vector<ReliabilityBin> reliability;
  double largest_deviation = 0;  ///< largest deviation among bins with at least kReliableCount images
  std::size_t local = 0;         ///< sure answers whose error relative to the local model is known
  std::size_t local_correct = 0;
  Sample local_translation_mm, local_rotation_deg;
  Sample nees;  ///< correct poses of rank 1 with a covariance; 6 on average if consistent
};
Summary summarize(const std::string& name, const std::vector<FrameEvaluation>& frames);

}  // namespace facetloc
