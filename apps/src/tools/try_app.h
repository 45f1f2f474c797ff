// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <filesystem>
#include <string>
#include <vector>

namespace facetloc {

/** \brief facetloc try: from a recording to a report, by the other tools one after the other. */
class TryApp : public App {
public:
  TryApp();

private:
  struct Stage;

  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;
  bool showsWork() const override { return true; }  // stage by stage
  std::vector<Stage> stages(const CommandLine& line, const Console& console) const;
  void runStage(const Stage& stage, std::size_t number, std::size_t of, const Console& console) const;
  std::string in(const std::string& name) const { return (std::filesystem::path(folder_) / name).string(); }

  std::string recording_, later_;
  std::string folder_;
  std::string camera_, depth_scale_, poses_are_;
  bool without_poses_ = false;
  bool open_ = false;
};

}  // namespace facetloc
