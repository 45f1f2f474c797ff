// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/answer_state.h>
#include <facetloc/features/pose.h>
#include <facetloc/io/growing_file.h>

#include <Eigen/Geometry>

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

/** \brief One line of RESULTS/hypotheses.csv. rank 1 = best; rank 0 = no hypothesis, with a
 * reason. */
struct ResultRow {
  std::string frame;
  int rank = 0;
  std::string model;  ///< name of the local model
  double probability = 0;
  double score = 0;
  Eigen::Isometry3d T_m_c = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Isometry3d> T_w_c;  ///< in the frame of the part; empty columns where there is none
  std::optional<Matrix6d> P_w_c;  ///< its covariance, of rank 1; in covariances.csv instead of hypotheses.csv
  double sd_rot_deg = 0;          ///< largest standard deviation of the orientation over directions [deg]
  double sd_trans_m = 0;          ///< largest standard deviation of the position over directions [m]
  std::string reason;             ///< remarks such as "depth-assisted"; why there is no hypothesis
  AnswerState state = AnswerState::unknown;  ///< of the frame, the same in all its rows
  std::string part;                          ///< of the map, that the model belongs to; empty for the world
};

/** \brief One line of RESULTS/timing.csv. */
struct TimingRow {
  std::string frame;
  double segment_ms = 0;
  double features_ms = 0;
  double localize_ms = 0;
  int models = 0;

  /** \brief All together [ms]; 0 for an image that failed. */
  double sum() const { return segment_ms + features_ms + localize_ms; }
};

/** \brief The results of one frame, as they are written. */
struct FrameResult {
  double stamp = 0;
  std::vector<ResultRow> rows;  ///< at least one
  TimingRow timing;
};

/** \brief Writes a results folder: hypotheses.csv, poses_tum.txt (the sure poses in the world),
 * covariances.csv (of the poses T_w_c of rank 1, whatever their state), timing.csv (all atomically, frames in
 * the given order) and params.ini. */
void writeResults(const std::filesystem::path& folder, const std::vector<FrameResult>& frames,
                  const std::string& params_ini);
/** \brief A results folder that grows while a run goes on: a frame is in all files when append() returns. */
class ResultsWriter {
public:
  /** \brief Begins anew, in the place of older results. Throws IoError. */
  ResultsWriter(const std::filesystem::path& folder, const std::string& params_ini);
  /** \brief Throws IoError, std::invalid_argument for values that are not finite. */
  void append(const FrameResult& frame);

private:
  GrowingFile timing_, poses_, covariances_, hypotheses_;
};
/** \brief Is there a hypotheses.csv in it? */
bool isResultsFolder(const std::filesystem::path& folder);
/** \brief Receives what is worth to be said of a file that is read nevertheless. */
using Remark = std::function<void(const std::string&)>;
/** \brief Reads hypotheses.csv (columns by name); results of older versions, which have no column of the
 * state, get the one by kMinProbability, and without one of the part all is in the world. Throws IoError with
 * the line for malformed files and for values that are impossible. \param remark If there is one, a last line
 * that a killed program has left torn is left out, and remarked.
 */
std::vector<ResultRow> readHypotheses(const std::filesystem::path& folder, const Remark& remark = {});
/** \brief Reads covariances.csv, alike, by frame; empty if there is no such file. */
std::map<std::string, Matrix6d> readCovariances(const std::filesystem::path& folder,
                                                const Remark& remark = {});
/** \brief Reads timing.csv, alike. */
std::vector<TimingRow> readTiming(const std::filesystem::path& folder, const Remark& remark = {});

/** \brief One line of RESULTS/starts.csv: what a camera that wakes up at one image of a drive says at a later
 * one.
 */
struct StartAnswer {
  std::string start, frame;  ///< names of the images
  AnswerState state = AnswerState::unknown;
  double probability = 0;                  ///< of the first place
  std::optional<Eigen::Isometry3d> T_w_c;  ///< empty columns where there is none in the world
};
/** \brief Writes starts.csv, atomically. */
void writeStarts(const std::filesystem::path& folder, const std::vector<StartAnswer>& answers);
/** \brief Reads starts.csv, as readHypotheses() does; empty if there is no such file. */
std::vector<StartAnswer> readStarts(const std::filesystem::path& folder, const Remark& remark = {});

}  // namespace facetloc
