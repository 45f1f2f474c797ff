// SPDX-License-Identifier: BSD-3-Clause
// A day of a robot that the example supervises: its map, a crash, hands that carry it, the dark, a room that
// is not in its map.
#include "base/text.h"
#include "live_tool.h"

#include <facetloc/io/depth_sequence.h>
#include <facetloc/testing/places.h>

#include <cmath>
#include <fmt/format.h>
#include <map>

namespace facetloc::test {
namespace {

constexpr double kMorning = 100;  // [s] when the day begins; an image each 0.1 s

/** A line of the supervisor about an image. */
struct Command {
  double stamp;
  std::string word, what;
};

std::vector<std::string> linesWith(const std::string& text, const std::string& begin) {
  std::vector<std::string> lines;
  for (const std::string& line : linesIn(text))
    if (line.compare(0, begin.size(), begin) == 0) lines.push_back(line);
  return lines;
}

/** Commands since the last start of facetloc_live. */
std::vector<Command> commandsOf(const std::string& out) {
  std::vector<Command> commands;
  for (const std::string& line : linesIn(out)) {
    if (line.compare(0, 5, "start") == 0) commands.clear();
    std::istringstream words(line);
    Command c;
    if (!(words >> c.stamp >> c.word)) continue;
    std::getline(words, c.what);
    commands.push_back(c);
  }
  return commands;
}

/** The views of the robot, image by image, and its poses, as far as they are in its map. */
class Day {
public:
  Day(const fs::path& folder, const DepthSequence& camera) : folder_(folder) {
    fs::create_directories(folder / "depth");
    writeCameraFile(folder / "camera.ini", *camera.camera());
  }
  void see(const DepthSequence& sequence, std::size_t from, std::size_t to, bool is_mapped = true) {
    for (std::size_t i = from; i < to; ++i) {
      if (is_mapped) truth_[n_] = *sequence.groundTruth().at(sequence.frames()[i].stamp);
      write(sequence.load(i), sequence.camera()->depth_scale);
    }
  }
  void seeNothing(DepthImage image, int images) {
    image.depth.assign(image.depth.size(), 0.f);
    for (int i = 0; i < images; ++i) write(image, 1000);
  }
  double now() const { return kMorning + 0.1 * n_; }
  const Eigen::Isometry3d* truthAt(double stamp) const {
    const auto found = truth_.find(static_cast<int>(std::lround((stamp - kMorning) / 0.1)));
    return found == truth_.end() ? nullptr : &found->second;
  }

private:
  void write(const DepthImage& image, double depth_scale) {
    writeDepthPng(folder_ / "depth" / fmt::format("{:.6f}.png", now()), image, depth_scale);
    ++n_;
  }
  fs::path folder_;
  int n_ = 0;
  std::map<int, Eigen::Isometry3d> truth_;
};

TEST_F(LiveTool, IsSupervisedForADay) {
  setenv("FACETLOC_LIVE", kLiveTool, 1);
  const std::string map = folder_ / "own.flmap";
  const auto supervise = [&](const std::string& device, const char* speed) {
    return std::vector<std::string>{"/usr/bin/env", "python3", kSupervise,     map, "--device", device,
                                    "--speed",      speed,     "--every-frame"};
  };
  const ToolRun mapping = ok(Process(supervise(sequence(), "0")).wait());
  ASSERT_TRUE(fs::exists(map));
  EXPECT_GE(linesWith(mapping.out, "").size(), 40u);

  ok(runTool<simulateApp>(
      {"room", "-o", folder_ / "other", "--seed", "6", "--frames", "20", "--width", "320", "--runs", "map"}));
  const DepthSequence room = DepthSequence::open(sequence()),
                      other = DepthSequence::open(folder_ / "other/map");
  Day day(folder_ / "day", room);
  day.see(room, 0, 15);
  day.see(room, 30, 40);  // carried there
  const double dark = day.now();
  day.seeNothing(room.load(0), 30);
  day.see(other, 0, 20, false);
  const double back = day.now();
  day.see(room, 10, 30);

  Process running(supervise(folder_ / "day", "1"));
  ASSERT_TRUE(eventually([&] { return running.out().find(" go ") != std::string::npos; })) << running.err();
  const std::string first = linesWith(running.out(), "start").at(0);
  EXPECT_THAT(first, HasSubstr(" --near=")) << "where it was in the evening";
  kill(std::stoi(first.substr(6)), SIGKILL);
  const ToolRun run = ok(running.wait());
  const auto starts = linesWith(run.out, "start");
  ASSERT_EQ(starts.size(), 2u);
  EXPECT_THAT(starts[1], HasSubstr(" --near="));

  // The world of a map that was made live begins at its first image.
  const Eigen::Isometry3d begin = *room.groundTruth().at(room.frames()[0].stamp);
  const Eigen::Vector3d axis = begin.linear().col(2);
  const Eigen::Matrix2d R = Eigen::Rotation2Dd(-std::atan2(axis.y(), axis.x())).toRotationMatrix();
  std::map<std::string, int> early, dark_or_other, late;
  for (const Command& c : commandsOf(run.out)) {
    const double settled = 1.5;  // [s] after the latest change
    if (c.stamp < dark) ++early[c.word];
    if (c.stamp > dark + settled && c.stamp < back - 0.05) ++dark_or_other[c.word];
    if (c.stamp > back - 0.05) ++late[c.word];
    if (c.word != "go") continue;
    const Eigen::Isometry3d* truth = day.truthAt(c.stamp);
    if (!truth) continue;
    double x = 0, y = 0;
    std::istringstream(c.what) >> x >> y;
    const Eigen::Vector2d expected = R * (truth->translation() - begin.translation()).head<2>();
    EXPECT_LT((Eigen::Vector2d(x, y) - expected).norm(), 0.1) << c.stamp;
  }
  EXPECT_GE(early["go"], 20);
  EXPECT_EQ(dark_or_other["go"], 0);
  EXPECT_GE(dark_or_other["stop"], 30);
  EXPECT_GE(late["go"], 15) << run.out;
}

TEST_F(LiveTool, TheSupervisorGivesUpARunThatCannotStart) {
  setenv("FACETLOC_LIVE", kLiveTool, 1);
  const std::vector<std::string> command = {"/usr/bin/env", "python3", kSupervise, map(), "--no-such-option"};
  EXPECT_EQ(Process(command).wait().code, kUsage);
}

}  // namespace
}  // namespace facetloc::test
