// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "process.h"
#include "tool_runner.h"

#include <cstddef>
#include <memory>

namespace facetloc::test {

/** \brief The command of facetloc_live. \param display of the process; empty = it has none. */
std::vector<std::string> liveCommand(const std::vector<std::string>& arguments, const std::string& display);

/** \brief facetloc_live as a process. */
class LiveProcess : public Process {
public:
  explicit LiveProcess(const std::vector<std::string>& arguments, const std::string& display = "")
      : Process(liveCommand(arguments, display)) {}
};

ToolRun runLive(const std::vector<std::string>& arguments);

std::vector<std::string> linesOf(const std::string& path);

/** \brief The names in a folder, sorted. */
std::vector<std::string> namesIn(const std::string& folder);

/** \brief Invariants of a results folder, be it of a run that ended or of one that was killed. */
void expectWholeResults(const std::string& folder, std::size_t least_frames);

/** \brief One simulated room and its map for all tests of the live tool (defined in test_live_app.cpp). */
class LiveTool : public InAFolder {
protected:
  static void SetUpTestSuite();
  static void TearDownTestSuite() { room_.reset(); }

  static std::string map() { return *room_ / "map.flmap"; }
  static std::string sequence() { return *room_ / "map"; }

  /** The first images of the sequence as a folder of PCD files. */
  std::string writeClouds(std::size_t n) const;
  /** The first images of the sequence as a folder of PCLZF files. */
  std::string writePclzf(std::size_t n) const;

private:
  static std::unique_ptr<TemporaryFolder> room_;
};

}  // namespace facetloc::test
