// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tool_runner.h"

#include <memory>

namespace facetloc::test {

constexpr int kFrames = 12;
constexpr auto kReplace =
    std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing;

/** \brief Runs facetloc_map. */
ToolRun runMap(const std::vector<std::string>& arguments);

/** \brief One simulated room for the tests of all tools (defined in test_tools.cpp); each test writes to a
 * folder of its own. */
class Tools : public InAFolder {
protected:
  static void SetUpTestSuite();
  static void TearDownTestSuite() { room_.reset(); }

  static std::string map_run() { return *room_ / "map"; }
  static std::string query() { return *room_ / "query"; }
  static std::string map() { return *room_ / "map.flmap"; }
  static std::string firstImage() { return filesOf(query() + "/depth").front().string(); }

  /** A folder of good images, one corrupt among them. */
  std::string withOneCorruptImage() const;
  /** Those of the other run, under the names that are there. */
  static void giveOtherImages(const std::string& input);

private:
  static std::unique_ptr<TemporaryFolder> room_;
};

}  // namespace facetloc::test
