// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/features/answer_state.h>
#include <facetloc/features/pose.h>
#include <facetloc/io/atomic_file.h>

#include <Eigen/Geometry>

#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace facetloc {

/** \brief One line of RESULTS/hypotheses.csv, as resultColumns() describes it. rank 1 = best; rank 0 = no
 * hypothesis, with a reason. */
struct ResultRow {
  std::string frame;
  int rank = 0;
  std::string model;
  double probability = 0;
  double score = 0;
  Eigen::Isometry3d T_m_c = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Isometry3d> T_w_c;
  std::optional<Matrix6d> P_w_c;  ///< its covariance, of rank 1; in covariances.csv instead of hypotheses.csv
  double sd_rot_deg = 0;
  double sd_trans_m = 0;
  std::string reason;
  AnswerState state = AnswerState::unknown;
  std::string part;
  std::optional<double> not_in_map;      ///< empty without probabilities, and in older results
  std::map<std::string, double> maps{};  ///< probability of each of several maps, at rank 1; not in files
  std::optional<ViewShares> shares{};    ///< shares of rank 1; in shares.csv instead of hypotheses.csv
  std::optional<NextLook>
      next_look{};  ///< motion that would make it sure, in the row of rank 1 or 0; in the stream only
};

/** \brief A column of hypotheses.csv, or the seven of a pose. Files, messages between processes,
 * the stream and the tests of documents follow from it. */
struct ResultColumn {
  using Value =
      std::variant<std::string ResultRow::*, int ResultRow::*, double ResultRow::*, AnswerState ResultRow::*,
                   Eigen::Isometry3d ResultRow::*, std::optional<Eigen::Isometry3d> ResultRow::*,
                   std::optional<double> ResultRow::*>;
  const char* name;  ///< also of the stream
  Value value;
  const char* text;  ///< description for documents
  const char* unit = "";
  bool has_always = false;  ///< else it is empty in a row without a hypothesis
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();

  /** \brief Names in the file: the name, or w_tx ... w_qw of T_w_c. */
  std::vector<std::string> names() const;
};
/** \brief Columns in the order of the file. */
const std::vector<ResultColumn>& resultColumns();

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

/** \brief A frame by its name in the results, with its stamp [s]. */
struct ResultFrame {
  std::string name;
  double stamp = 0;
};

/** \brief Writes a results folder: hypotheses.csv, poses_tum.txt (the sure poses in the world; those
 * in the frame of another part of the map in poses_tum.part-NAME.txt),
 * covariances.csv and shares.csv (of rank 1, whatever its state), timing.csv (all atomically, frames in
 * the given order) and params.ini. */
void writeResults(const std::filesystem::path& folder, const std::vector<FrameResult>& frames,
                  const std::string& params_ini);
/** \brief A results folder that grows while a run goes on: a frame is in all files when append() returns. Of
 * a program that is killed, only the frame that it was writing is lost: a frame counts when its line of
 * timing.csv, the last to be written, is whole. */
class ResultsWriter {
public:
  /** \brief Begins anew, in the place of older results, or goes on with them: the frames of kept that are
   * whole there stay, byte for byte and in this order, the others go. Throws IoError. */
  ResultsWriter(const std::filesystem::path& folder, const std::string& params_ini,
                const std::vector<ResultFrame>& kept = {});
  /** \brief Throws IoError, std::invalid_argument for values that are not finite. */
  void append(const FrameResult& frame);

private:
  struct Text;

  friend void writeResults(const std::filesystem::path& folder, const std::vector<FrameResult>& frames,
                           const std::string& params_ini);
  ResultsWriter(const std::filesystem::path& folder, const std::string& params_ini, const Text& begin);

  void addPoses(const std::string& part, const std::string& lines);

  std::filesystem::path folder_;
  GrowingFile timing_, covariances_, shares_, hypotheses_;
  std::map<std::string, GrowingFile> poses_;  // keyed by file
};
/** \brief Is there a hypotheses.csv in it? */
bool isResultsFolder(const std::filesystem::path& folder);
/** \brief Receives remarks on a file that is read nevertheless. */
using Remark = std::function<void(const std::string&)>;
/** \brief Reads hypotheses.csv (columns by name). Throws IoError with the line for malformed files and for
 * values that are impossible. \param remark If there is one, a last line that a killed program has left torn
 * is left out, and remarked. */
std::vector<ResultRow> readHypotheses(const std::filesystem::path& folder, const Remark& remark = {});
/** \brief Reads covariances.csv by frame; empty if the file does not exist. */
std::map<std::string, Matrix6d> readCovariances(const std::filesystem::path& folder,
                                                const Remark& remark = {});
/** \brief Reads shares.csv by frame; empty if the file does not exist. */
std::map<std::string, ViewShares> readShares(const std::filesystem::path& folder, const Remark& remark = {});
/** \brief Reads timing.csv; empty if the file does not exist. */
std::vector<TimingRow> readTiming(const std::filesystem::path& folder, const Remark& remark = {});
/** \brief The frames that are whole, by name and without their stamps, be it that the program that wrote them
 * was killed. Throws IoError. */
std::map<std::string, FrameResult> readResults(const std::filesystem::path& folder);

/** \brief One line of RESULTS/starts.csv: the answer at one image of a drive to a camera that started at an
 * earlier one.
 */
struct StartAnswer {
  std::string start, frame;  ///< names of the images
  AnswerState state = AnswerState::unknown;
  double probability = 0;                  ///< probability of the first place
  std::optional<Eigen::Isometry3d> T_w_c;  ///< empty without a pose in the world
};
/** \brief Writes starts.csv, atomically. */
void writeStarts(const std::filesystem::path& folder, const std::vector<StartAnswer>& answers);
/** \brief Reads starts.csv, as readHypotheses() does; empty if there is no such file. */
std::vector<StartAnswer> readStarts(const std::filesystem::path& folder, const Remark& remark = {});

}  // namespace facetloc
