// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/offscreen_display.h"
#include "drawing/pictures.h"
#include "tool_runner.h"

#include <optional>

namespace facetloc::test {
namespace {

/** Sets a variable of the environment for the life of the object. */
class Environment {
public:
  Environment(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    value ? setenv(name, value, 1) : unsetenv(name);
  }
  ~Environment() { before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST(OffscreenDisplay, LeavesTheEnvironmentAsItWas) {
  const Environment display("DISPLAY", ":9999");  // no server there
  {
    const OffscreenDisplay offscreen;
    if (!offscreen.available()) GTEST_SKIP() << offscreen.problem();
    EXPECT_STRNE(std::getenv("DISPLAY"), ":9999");
  }
  EXPECT_STREQ(std::getenv("DISPLAY"), ":9999");
}

TEST(OffscreenDisplay, NamesTheCauseOfFailure) {
  const Environment display("DISPLAY", nullptr), path("PATH", "/nonexistent");
  const OffscreenDisplay offscreen;
  EXPECT_FALSE(offscreen.available());
  EXPECT_THAT(offscreen.problem(), HasSubstr("xvfb"));
}

TEST(Runs, LookTheSameEachTime) {
  const Environment display("DISPLAY", nullptr);
  const OffscreenDisplay offscreen;
  if (!offscreen.available()) GTEST_SKIP() << offscreen.problem();
  const TemporaryFolder folder;
  const Eigen::Isometry3d start = Eigen::Isometry3d::Identity(), end(Eigen::Translation3d(2, 1, 0));
  const PlanView above(Eigen::Vector3d::UnitZ());
  drawRuns(folder / "a.png", above, {{"walk", {start, end}}, {"nothing", {}}});
  drawRuns(folder / "b.png", above, {{"walk", {start, end}}, {"nothing", {}}});
  const std::string a = contentOf(folder / "a.png");
  EXPECT_EQ(a.substr(1, 3), "PNG");
  EXPECT_EQ(a, contentOf(folder / "b.png"));
}

}  // namespace
}  // namespace facetloc::test
