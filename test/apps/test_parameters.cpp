// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/evaluation.h"
#include "inputs/localization_options.h"
#include "tool_runner.h"
#include "tools/localize_app.h"

#include <facetloc/localization/localization_params.h>
#include <facetloc/localization/localizer_params.h>
#include <facetloc/mapping/map_builder.h>
#include <facetloc/mapping/map_session.h>
#include <facetloc/mapping/mapping_params.h>
#include <facetloc/registration/pose_prior.h>
#include <facetloc/segmentation/view_builder.h>
#include <facetloc/simulation/simulated_camera.h>
#include <facetloc/simulation/simulated_drive.h>
#include <facetloc/simulation/simulated_odometry.h>
#include <facetloc/testing/places.h>

#include <map>

namespace facetloc::test {
namespace {

/** Flag of each parameter, by the title of its group and its name: is it for users? A group that
 * several structs have counts once. */
using Parameters = std::map<std::string, bool>;

template <class... Params>
Parameters parametersOf(const Params&... params) {
  Parameters all;
  const auto note = [&all](const ParamInfo& info, const auto&, auto, auto) {
    const std::string field = info.name.substr(info.name.rfind('.') + 1);
    all[std::string(info.group) + ": " + field] = info.audience == Audience::users;
  };
  (forEachParam(params, note), ...);
  return all;
}

Parameters allParameters() {
  return parametersOf(ViewParams{}, SensorNoise{}, GlobalLocalizationParams{}, LocalizerParams{},
                      OdometryError{}, MappingParams{}, MapBuilderParams{}, MapSessionParams{},
                      EvaluationParams{}, SimulatedNoise{}, DriveParams{}, PaceParams{},
                      WheelOdometryParams{});
}

// A parameter is a value that somebody has a reason to set. Values fitted together are the calibration, all
// others constants.
TEST(Parameters, AreAFew) {
  const Parameters all = allParameters();
  std::size_t for_users = 0;
  for (const auto& [name, is_for_users] : all) for_users += is_for_users;
  EXPECT_LE(all.size(), 120u);
  EXPECT_GE(for_users, 25u);
  EXPECT_LE(for_users, 35u);
}

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
  const std::string help = runTool<LocalizeApp>({"--help-all"}).out;
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
