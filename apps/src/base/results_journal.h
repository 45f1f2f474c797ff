// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/growing_file.h>
#include <facetloc/io/results.h>

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace facetloc {

constexpr const char* kPartial = "partial.txt";  ///< the journal of the first rank

/** \brief The finished frames of a run that is not over: RESULTS/partial.txt, one line per frame, flushed
 * each time. Other ranks than the first have a file of their own, such as partial.2.txt, so that nothing is
 * lost with any of them.
 *
 * Values are kept to the last bit, so that an interrupted and resumed run gives the same results as one in
 * one go. A line that a killed run left half written, or that was damaged since, is ignored: its frame is
 * done again. */
class ResultsJournal {
public:
  explicit ResultsJournal(const std::filesystem::path& folder, int rank = 0);

  /** \brief Has any rank written one? */
  bool exists() const;
  /** \brief The frames of all ranks so far, by name. Throws IoError if a file cannot be read. */
  std::map<std::string, FrameResult> read() const;

  /** \brief Opens this rank's file for writing, beginning with the frames of an earlier run. The first rank
   * removes those of others: it begins before them. */
  void begin(const std::map<std::string, FrameResult>& earlier);
  /** \brief Appends a frame; thread-safe. Throws WriteError, for example if the disk is full. */
  void append(const std::string& frame, const FrameResult& result);
  /** \brief Closes it and removes the files of all ranks: the results are written. */
  void remove();

private:
  std::vector<std::filesystem::path> files() const;

  std::filesystem::path folder_;
  std::filesystem::path path_;
  int rank_;
  std::optional<GrowingFile> out_;
  std::mutex mutex_;
};

}  // namespace facetloc
