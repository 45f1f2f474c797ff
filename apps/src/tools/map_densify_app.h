// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cli/app.h"

#include <facetloc/mapping/densified_map.h>

namespace facetloc {

/** \brief facetloc_map densify: local models of places where no image of a map was taken. */
class MapDensifyApp : public App {
public:
  MapDensifyApp();

private:
  void addOptions(CommandLine& line) override;
  int execute(const CommandLine& line, const Console& console) override;

  std::string map_;
  std::string output_;
  bool overwrite_ = false;
  DensifyParams params_;
  ViewParams view_;
};

}  // namespace facetloc
