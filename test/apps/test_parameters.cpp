// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/localization_options.h"
#include "tool_runner.h"

#include <facetloc/localization/localization_params.h>
#include <facetloc/testing/places.h>

namespace facetloc::test {
namespace {

std::string withoutComments(const std::string& path) {
  std::ifstream in(path);
  std::string text;
  for (std::string line; std::getline(in, line);)
    if (!line.empty() && line.front() != '#') text += line + "\n";
  return text;
}

TEST(Calibration, ThatShipsIsTheOneThatIsBuiltIn) {
  EXPECT_EQ(withoutComments(kCalibration), toIni(Calibration{}, "calibration"));
}

TEST(Calibration, OutOfItsRangeIsRefused) {
  GlobalLocalizationParams params;
  EXPECT_NO_THROW(params.validate());
  params.calibration.score.match_probability = 2;
  EXPECT_THROW(params.validate(), std::invalid_argument);
  EXPECT_THROW(checked(params), std::invalid_argument);
}

TEST(Calibration, IsReadFromAFileOfParametersAndNotOffered) {
  const std::string help = runTool<localizeApp>({"--help-all"}).out;
  EXPECT_THAT(help, Not(HasSubstr("--calibration")));
  const auto users = help.find("For users:"), experts = help.find("--ekf.iterations");
  ASSERT_NE(users, std::string::npos);
  EXPECT_LT(users, experts) << "those for users come first";
  const auto map_incomplete = help.find("--probability.map_incomplete");
  EXPECT_TRUE(users < map_incomplete && map_incomplete < experts);

  CommandLine line("tool", "", "");
  GlobalLocalizationParams params;
  addLocalizationOptions(line, params);
  const TemporaryFolder folder;
  const std::string path = folder / "own.ini";
  std::ofstream(path) << "[calibration.score]\ncoplanar_weight = 0\n";
  std::ostringstream out;
  ASSERT_TRUE(line.parse({"--params", path}, out));
  EXPECT_EQ(params.calibration.score.coplanar_weight, 0);
  EXPECT_EQ(params.calibration.score.parallel_weight, ScoreCalibration{}.parallel_weight);
}

}  // namespace
}  // namespace facetloc::test
