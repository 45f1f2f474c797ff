// SPDX-License-Identifier: BSD-3-Clause
#include "inputs/localization_options.h"
#include "tool_runner.h"

#include <facetloc/localization/localization_params.h>
#include <facetloc/testing/places.h>

#include <gtest/gtest.h>

#include <cmath>

namespace facetloc::test {
namespace {

std::string withoutComments(const std::string& path) {
  std::string text;
  for (const std::string& line : linesIn(contentOf(path)))
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

TEST(StartPose, LooksTowardsItsHeading) {
  const auto start = startPose("1,2,1.2,90", {});
  ASSERT_TRUE(start);
  EXPECT_TRUE(start->T.translation().isApprox(Eigen::Vector3d(1, 2, 1.2)));
  EXPECT_TRUE(start->T.linear().col(2).isApprox(Eigen::Vector3d::UnitY(), 1e-9)) << "the optical axis";
  EXPECT_TRUE(start->T.linear().col(1).isApprox(-Eigen::Vector3d::UnitZ(), 1e-9)) << "down in the image";
  EXPECT_NEAR(largestTranslationStd(start->P), 1, 1e-9);
  EXPECT_NEAR(largestRotationStd(start->P), 30 * kDegree, 1e-9);
}

TEST(StartPose, IsMountedAsTheCamera) {
  CameraMounting mounting;
  mounting.height = 1.2, mounting.tilt_deg = 20, mounting.pan_deg = 35;
  const auto start = startPose("0,0,1.2,0,0.3,5", mounting);
  ASSERT_TRUE(start);
  const Eigen::Vector3d axis = start->T.linear().col(2);
  EXPECT_NEAR(std::atan2(axis.y(), axis.x()), 0, 1e-9) << "whatever its pan";
  EXPECT_NEAR(axis.z(), -std::sin(20 * kDegree), 1e-9);
  EXPECT_NEAR(largestTranslationStd(start->P), 0.3, 1e-9);
}

TEST(StartPose, RefusesInvalidText) {
  EXPECT_FALSE(startPose("", {}));
  for (const char* text : {"1", "1,2,3", "1,2,3,4,5,6,7", "a,2,3,4", "1,2,3,nan", "1,2,3,4,0", "1,2,3,4,-1",
                           "1,2,3,4,1,0", "1,2,3,4,1,181", "1,2,3,4,1e200", "1,2,,4", "1;2;3;4"})
    EXPECT_THROW(startPose(text, {}), UsageError) << text;
}

}  // namespace
}  // namespace facetloc::test
