// SPDX-License-Identifier: BSD-3-Clause
//
// How well trajectories are found from depth images alone, against the true ones.
//
//   facetloc_simulate office -o office1 --seed 1 --width 320 --runs map; ...
//   score_mapping [--GROUP.PARAMETER VALUE] RECORDING...
//   score_mapping --gaps 4 [--seed N] RECORDING...
//
// Each RECORDING is a depth sequence with groundtruth.txt, such as office1/map. The yardstick is generalized
// ICP from image to image. With --gaps, the pieces of recordings from which some seconds are missing, each
// aligned separately.
#include "cli/app.h"
#include "evaluation/alignment.h"
#include "evaluation/trajectory_errors.h"
#include "gicp_odometry.h"
#include "programs.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/mapping/trajectory_estimation.h>
#include <facetloc/segmentation/view_builder.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace facetloc;
constexpr double kPoseTolerance = 0.02;  // [s]
constexpr double kMillimetres = 1000, kPercent = 100;
constexpr double kGap = 3;                       // length of a gap [s]
constexpr double kFoldedDeg = 5, kFolded = 0.3;  // errors within a folded piece [m]

using Frames = std::vector<std::size_t>;

Frames allOf(const DepthSequence& sequence) {
  Frames frames(sequence.frames().size());
  std::iota(frames.begin(), frames.end(), std::size_t{0});
  return frames;
}

/** The frames outside of n gaps at random times. */
Frames outsideGaps(const DepthSequence& sequence, int n, unsigned seed) {
  const std::vector<FrameFile>& frames = sequence.frames();
  const double begin = frames.front().stamp, left = frames.back().stamp - begin - n * kGap;
  if (left <= 0) throw std::invalid_argument("the recording is too short for its gaps");
  std::mt19937 random(seed);
  std::vector<double> gaps;
  for (int i = 0; i < n; ++i) gaps.push_back(left * random() / double(std::mt19937::max()));
  std::sort(gaps.begin(), gaps.end());
  for (int i = 0; i < n; ++i) gaps[i] += begin + i * kGap;
  Frames kept;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (std::none_of(gaps.begin(), gaps.end(),
                     [&](double gap) { return frames[i].stamp > gap && frames[i].stamp < gap + kGap; }))
      kept.push_back(i);
  return kept;
}

/** An estimated trajectory, and its cost. */
struct Found {
  std::vector<StampedPose> poses;
  int breaks = 0;
  double ms_per_image = 0;
};

Found byGicp(const DepthSequence& sequence) {
  Found found;
  benchmarks::GicpOdometry odometry;
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < sequence.frames().size(); ++i)
    found.poses.push_back({sequence.frames()[i].stamp, odometry.add(sequence.load(i, kWorkingWidth))});
  found.ms_per_image =
      benchmarks::milliseconds(start) / static_cast<double>(std::max<std::size_t>(1, found.poses.size()));
  found.breaks = odometry.breaks();
  return found;
}

struct Estimated {
  CameraTrajectory trajectory;
  double seconds = 0;
};

Estimated estimated(const DepthSequence& sequence, const Frames& frames, const MappingParams& params,
                    bool with_mounting, int threads) {
  Camera camera;
  if (sequence.camera()) camera = sequence.camera()->camera;
  if (!with_mounting) camera.mounting.reset();
  ViewBuilder builder(camera);
  TrajectoryEstimation estimation(params);
  estimation.setNumberOfThreads(threads);
  const auto start = std::chrono::steady_clock::now();
  for (const std::size_t i : frames)
    estimation.add(builder.build(sequence.load(i, kWorkingWidth)), sequence.frames()[i].stamp);
  estimation.improve();
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
  return {estimation.trajectory(), time.count()};
}

Found largestPiece(const Estimated& estimated) {
  const CameraTrajectory& trajectory = estimated.trajectory;
  const std::vector<int> parts = trajectory.parts();
  Found found;
  for (const TrajectoryPose& pose : trajectory.images)
    if (trajectory.keyframes[pose.keyframe].part == parts.front())
      found.poses.push_back({pose.stamp, pose.T_w_c});
  found.breaks = static_cast<int>(parts.size()) - 1;
  found.ms_per_image =
      1000 * estimated.seconds / static_cast<double>(std::max<std::size_t>(1, trajectory.images.size()));
  return found;
}

/** Worst error within a piece. */
struct PieceError {
  double rotation_deg = 0, translation = 0;
  bool isFolded() const { return rotation_deg > kFoldedDeg || translation > kFolded; }
};

PieceError errorOf(const std::vector<PosePair>& piece) {
  PieceError worst;
  if (piece.size() < kLeastPairs) return worst;
  const Eigen::Isometry3d T = robustlyAligned(piece).T_true_estimated;
  for (const PosePair& pair : piece) {
    worst.rotation_deg = std::max(worst.rotation_deg, angleAfter(T, pair) / kDegree);
    worst.translation = std::max(worst.translation, distanceAfter(T, pair));
  }
  return worst;
}

void printPiecesHeader() {
  std::printf("%-40s %5s %6s %6s %8s | %6s %6s | %8s %9s | %6s\n", "", "seed", "images", "pieces", "largest",
              "folded", "images", "worst", "", "time");
}

void printPieces(const std::string& name, unsigned seed, const Estimated& estimated,
                 const Trajectory& truth) {
  const CameraTrajectory& trajectory = estimated.trajectory;
  std::map<int, std::vector<PosePair>> pieces;
  for (const TrajectoryPose& pose : trajectory.images)
    if (const auto true_pose = truth.at(pose.stamp, kPoseTolerance))
      pieces[trajectory.keyframes[pose.keyframe].part].push_back({pose.stamp, pose.T_w_c, *true_pose});
  std::size_t folded = 0, folded_images = 0, largest = 0;
  PieceError worst;
  for (const auto& [ignored, piece] : pieces) {
    const PieceError error = errorOf(piece);
    worst.rotation_deg = std::max(worst.rotation_deg, error.rotation_deg);
    worst.translation = std::max(worst.translation, error.translation);
    largest = std::max(largest, piece.size());
    if (!error.isFolded()) continue;
    ++folded;
    folded_images += piece.size();
  }
  std::printf("%-40s %5u %6zu %6zu %8zu | %6zu %6zu | %4.1f deg %6.0f mm | %4.0f s\n", name.c_str(), seed,
              trajectory.images.size(), pieces.size(), largest, folded, folded_images, worst.rotation_deg,
              kMillimetres * worst.translation, estimated.seconds);
  std::fflush(stdout);
}

void printHeader() {
  std::printf("%-44s %6s %8s | %9s %8s %9s | %8s %9s | %6s %9s\n", "", "images", "way", "ATE RMSE", "of way",
              "max.", "over 1 m", "", "breaks", "per image");
}

void print(const std::string& name, const Found& found, const TrajectoryErrors& e) {
  double share = 0, turn = 0;
  for (const RelativeErrors& r : e.relative)
    if (r.over == kOverMetre) {
      share = r.translationShare();
      turn = r.rotationPerMetre();
    }
  std::printf("%-44s %6zu %6.1f m | %6.0f mm %6.2f %% %6.0f mm | %6.2f %% %5.2f deg | %6d %6.0f ms\n",
              name.c_str(), found.poses.size(), e.length(), kMillimetres * e.absolute.rmse,
              kPercent * e.share(), kMillimetres * e.absolute.max, kPercent * share, turn, found.breaks,
              found.ms_per_image);
  std::fflush(stdout);
}

class ScoreMappingApp : public App {
public:
  ScoreMappingApp()
      : App("score_mapping", "RECORDING... [options]",
            "Finds the trajectory of each recording from its depth images and compares it with the true "
            "one.") {}

private:
  void addOptions(CommandLine& line) override {
    line.addArguments("RECORDING", recordings_);
    line.addSwitch("without-mounting", without_mounting_, "Take every camera for one in the hand.");
    line.addOption("gaps", gaps_, "N", "Score the pieces of each recording without N gaps of 3 s.");
    line.addOption("seed", seed_, "N", "Seed of the times of the gaps.");
    line.addParams(mapping_, "mapping");
  }

  int execute(const CommandLine&, const Console&) override {
    if (gaps_ > 0) {
      scorePieces();
      return kOk;
    }
    printHeader();
    for (const std::string& name : recordings_) {
      const DepthSequence sequence = DepthSequence::open(name);
      judge(name + " planes", largestPiece(found(sequence, allOf(sequence))), sequence);
      judge(name + " gicp", byGicp(sequence), sequence);
    }
    return kOk;
  }

  Estimated found(const DepthSequence& sequence, const Frames& frames) const {
    return estimated(sequence, frames, mapping_, !without_mounting_, threads());
  }

  void scorePieces() const {
    printPiecesHeader();
    for (const std::string& name : recordings_) {
      const DepthSequence sequence = DepthSequence::open(name);
      const Frames frames = outsideGaps(sequence, gaps_, static_cast<unsigned>(seed_));
      printPieces(name, static_cast<unsigned>(seed_), found(sequence, frames), sequence.groundTruth());
    }
  }

  static void judge(const std::string& name, const Found& found, const DepthSequence& sequence) {
    print(name, found, trajectoryErrors(Trajectory(found.poses), sequence.groundTruth(), kPoseTolerance));
  }

  std::vector<std::string> recordings_;
  bool without_mounting_ = false;
  int gaps_ = 0, seed_ = 1;
  MappingParams mapping_;
};

}  // namespace

int main(int argc, char** argv) { return facetloc::benchmarks::runProgram<ScoreMappingApp>(argc, argv); }
