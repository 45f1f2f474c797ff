// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <facetloc/io/results.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <string>

namespace facetloc {

/** \brief The finished frames of a run that is not over: RESULTS/partial.txt, one line per frame, flushed
 * each time.
 *
 * Values are kept to the last bit, so that an interrupted and resumed run gives the same results as one in
 * one go. A line that a killed run left half written is ignored. */
class ResultsJournal {
public:
  explicit ResultsJournal(const std::filesystem::path& folder);

  bool exists() const;
  /** \brief The frames so far, by name. Throws IoError if the journal cannot be read. */
  std::map<std::string, FrameResult> read() const;

  /** \brief Opens for writing, beginning with the frames of an earlier run. */
  void begin(const std::map<std::string, FrameResult>& earlier);
  /** \brief Appends a frame; thread-safe. Throws IoError, for example if the disk is full. */
  void append(const std::string& frame, const FrameResult& result);
  /** \brief Closes and removes it: the results are written. */
  void remove();

private:
  std::filesystem::path path_;
  std::ofstream out_;
  std::mutex mutex_;
};

}  // namespace facetloc
